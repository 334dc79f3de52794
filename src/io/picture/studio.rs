//! The room around the body: a seamless background, and a floor that shows only as a soft shadow under the feet.

use nalgebra::Vector3;

use super::ambient;
use super::camera::Camera;
use super::color::{Color, color_from_srgb};
use super::image::Canvas;
use super::scene::Mesh;
use crate::geometry::coverage::Rect;

/// Background in the middle of the picture and in its corners, sRGB. Neutral, so that it takes no side in colors.
const BACKDROP_MIDDLE: u32 = 0xf4f3f1;
const BACKDROP_CORNER: u32 = 0xd9d8d6;

/// A canvas with the background on it: a soft round glow, a little above the middle.
pub(super) fn backdrop(size: [u32; 2]) -> Canvas {
    let mut canvas = Canvas::new(size);
    let [middle, corner] = [BACKDROP_MIDDLE, BACKDROP_CORNER].map(color_from_srgb);
    let [width, height] = [canvas.width, canvas.height];
    for (index, pixel) in canvas.pixels.iter_mut().enumerate() {
        let x = (index as u32 % width) as f32 / width as f32 - 0.5;
        let y = (index as u32 / width) as f32 / height as f32 - 0.42;
        // 1 at the farthest corner.
        let distance = (x * x / 0.25 + y * y / 0.34).sqrt() / std::f32::consts::SQRT_2;
        *pixel = middle.lerp(&corner, smooth_step(distance));
    }
    canvas
}

/// 0 up to 0, 1 from 1 on, level at both.
pub(super) fn smooth_step(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Half the edge of the lit part of the floor, m: shadows are faint beyond an arm's length.
const REACH: f32 = 1.3;

/// Squares along an edge of the floor; 3 cm each, the softness of a shadow under a foot.
const SQUARES: usize = 86;

/// How dark the darkest floor is, relative to the background.
const DARKEST: f32 = 0.2;

/// Part of the width of a view over which the shadow fades out at its sides, so that views can stand side by side.
const SIDE_FADE: f32 = 0.12;

/// A level floor around the middle of the mesh, and how open it is to the sky.
pub(super) struct Floor {
    /// m, around the mesh's origin.
    height: f32,
    /// 0 to 1 for each corner of the squares, rows in z of points in x.
    openness: Vec<f32>,
}

impl Floor {
    /// The floor at a height (m, world); none when it is nowhere near the mesh.
    pub(super) fn new(mesh: &Mesh, height: f64) -> Option<Self> {
        let height = height - mesh.origin.y;
        if height.abs() > 2.0 * f64::from(mesh.radius) {
            return None;
        }
        let height = height as f32;
        let points: Vec<_> =
            (0..=SQUARES).flat_map(|row| (0..=SQUARES).map(move |column| corner(column, row, height))).collect();
        let normals = vec![Vector3::y(); points.len()];
        let openness = ambient::openness(mesh, &points, &normals);
        Some(Self { height, openness: openness.iter().map(|[upper, _]| upper.sky.min(1.0)).collect() })
    }

    /// Darkens the background of a part of the canvas where the floor is in shadow.
    pub(super) fn darken(&self, camera: &Camera, canvas: &mut Canvas, part: Rect) {
        let width = (part.x1 - part.x0) as f32;
        for y in part.y0.max(0)..part.y1.min(i64::from(canvas.height)) {
            for x in part.x0.max(0)..part.x1.min(i64::from(canvas.width)) {
                let in_part = [x - part.x0, y - part.y0].map(|pixel| pixel as f64 + 0.5);
                let from_side = (in_part[0] as f32).min(width - in_part[0] as f32) / width;
                let fade = smooth_step(from_side / SIDE_FADE);
                if let Some(point) = self.seen_at(camera, in_part) {
                    // The square leaves the dark under the feet and takes the faint streaks of far limbs away.
                    let shadow = (1.0 - self.openness_at(point[0], point[1])).powi(2);
                    canvas.blend(x, y, Color::zeros(), (1.0 - DARKEST) * shadow * fade);
                }
            }
        }
    }

    /// The point of the floor (x and z, m) that is seen at a place on the picture.
    fn seen_at(&self, camera: &Camera, [x, y]: [f64; 2]) -> Option<[f32; 2]> {
        let ray = camera.ray(x, y);
        let depth = (f64::from(self.height) - camera.eye.y) / ray.y;
        let point = camera.eye + ray * depth;
        let is_on_floor = depth > 0.0 && point.x.abs().max(point.z.abs()) < f64::from(REACH);
        is_on_floor.then(|| [point.x as f32, point.z as f32])
    }

    /// Between the corners of the squares; fades to 1 towards the rim.
    fn openness_at(&self, x: f32, z: f32) -> f32 {
        let place = |v: f32| ((v / REACH + 1.0) * 0.5 * SQUARES as f32).clamp(0.0, SQUARES as f32 - 0.001);
        let [column, row] = [place(x), place(z)];
        let [right, down] = [column.fract(), row.fract()];
        let index = row as usize * (SQUARES + 1) + column as usize;
        let mix = |index: usize| self.openness[index] * (1.0 - right) + self.openness[index + 1] * right;
        let open = mix(index) * (1.0 - down) + mix(index + SQUARES + 1) * down;
        let fade = smooth_step(1.5 * (1.0 - x.hypot(z) / REACH));
        1.0 - (1.0 - open) * fade
    }
}

/// A corner of the squares, m.
fn corner(column: usize, row: usize, height: f32) -> Vector3<f32> {
    let place = |index: usize| (2.0 * index as f32 / SQUARES as f32 - 1.0) * REACH;
    Vector3::new(place(column), height, place(row))
}

#[cfg(test)]
mod tests {
    use super::super::scene::{Coloring, MISSING_COLOR, Surface};
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn the_floor_is_dark_under_a_plate_and_bright_far_from_it() {
        let positions = [[-0.2, 0.2], [0.2, 0.2], [0.2, -0.2], [-0.2, -0.2]].map(|[x, z]| Point3::new(x, 0.05, z));
        let mesh = Mesh::new(&[Surface {
            positions: &positions,
            triangles: &[[0, 1, 2], [0, 2, 3]],
            coloring: Coloring::Constant(MISSING_COLOR),
            lines: &[],
        }]);
        let floor = Floor::new(&mesh, 0.0).unwrap();
        assert!(floor.openness_at(0.0, 0.0) < 0.15);
        assert!(floor.openness_at(0.8, 0.0) > 0.97);
        assert_eq!(floor.openness_at(REACH, 0.0), 1.0);
        assert!(Floor::new(&mesh, 100.0).is_none());
        assert!(Floor::new(&mesh, f64::MAX).is_none());
    }

    #[test]
    fn the_background_is_brightest_near_the_middle() {
        let canvas = backdrop([90, 60]);
        assert!(canvas.pixels[25 * 90 + 45].x > canvas.pixels[0].x);
        assert!(canvas.pixels.iter().all(|pixel| pixel.x > 0.5 && pixel.x < 1.0));
    }
}
