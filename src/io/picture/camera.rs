//! Where the picture is seen from.
//!
//! A long lens from a few metres away, as in fashion photographs: parallels stay nearly parallel, near parts are not
//! blown up.

use nalgebra::{Point3, Vector3};

use super::scene::is_drawable;
use crate::geometry::coverage::Corner;

/// A view of the scene. Angles in radians, lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Turn around the vertical: 0 looks at the front (from +z), a quarter turn at the body's left side (from +x).
    pub azimuth: f64,
    /// Height of the eye over the horizon: 0 is level, a quarter turn looks straight down.
    pub elevation: f64,
    /// World point in the middle of the picture.
    pub target: Point3<f64>,
    /// From the eye to the target.
    pub distance: f64,
    /// What the picture shows from bottom to top, in the plane of the target that faces the eye.
    pub height: f64,
}

/// Distance of the eye in radii of what is framed: about a 135 mm lens, 12° for a standing body.
const DISTANCE_IN_RADII: f64 = 9.0;

/// Passes of the framing loop; each leaves a hundredth of the error of the one before.
const FRAMING_PASSES: usize = 4;

impl View {
    /// The view from a direction with all `points` (m, world) just inside a picture of `aspect` (width / height).
    ///
    /// Without a single drawable point it frames one metre around the origin.
    pub fn framing(points: &[Point3<f64>], azimuth: f64, elevation: f64, aspect: f64) -> Self {
        let (view, extent) = View::centered(points, azimuth, elevation);
        let aspect = if aspect > 0.0 { aspect } else { 1.0 };
        Self { height: extent[1].max(extent[0] / aspect), ..view }
    }

    /// The view from a direction with the middle of all `points` in its middle, as high as they are; and their
    /// extent across and up as it appears in the plane of the target, m.
    pub(super) fn centered(points: &[Point3<f64>], azimuth: f64, elevation: f64) -> (Self, [f64; 2]) {
        let points: Vec<_> = points.iter().filter(|p| is_drawable(p)).copied().collect();
        let (target, radius) = middle(&points);
        let mut view = Self { azimuth, elevation, target, distance: radius * DISTANCE_IN_RADII, height: 2.0 * radius };
        let mut extent = [view.height; 2];
        for _ in 0..FRAMING_PASSES {
            let [x, y] = view.bounds(&points);
            let axes = Axes::new(azimuth, elevation);
            view.target += axes.right * middle_of(x) + axes.up * middle_of(y);
            extent = [x[1] - x[0], y[1] - y[0]].map(|side| side.max(radius * 1.0e-3));
        }
        view.height = extent[1];
        (view, extent)
    }

    /// Low and high ends of the points in the plane of the target, m: across, then up.
    fn bounds(&self, points: &[Point3<f64>]) -> [[f64; 2]; 2] {
        let axes = Axes::new(self.azimuth, self.elevation);
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for point in points {
            let offset = point - self.target;
            let scale = self.distance / (self.distance - offset.dot(&axes.toward_eye));
            for (bound, axis) in bounds.iter_mut().zip([axes.right, axes.up]) {
                let place = offset.dot(&axis) * scale;
                *bound = [bound[0].min(place), bound[1].max(place)];
            }
        }
        if points.is_empty() { [[-0.5, 0.5]; 2] } else { bounds }
    }
}

fn middle_of([low, high]: [f64; 2]) -> f64 {
    0.5 * (low + high)
}

/// Middle of the bounding box and the radius that reaches every point, m.
fn middle(points: &[Point3<f64>]) -> (Point3<f64>, f64) {
    let Some(&first) = points.first() else {
        return (Point3::origin(), 1.0);
    };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let center = nalgebra::center(&low, &high);
    let radius = points.iter().map(|p| (p - center).norm()).fold(0.0, f64::max);
    (center, radius.max(1.0e-3))
}

/// The camera's own directions in the world, each of unit length.
pub(super) struct Axes {
    pub(super) right: Vector3<f64>,
    pub(super) up: Vector3<f64>,
    pub(super) toward_eye: Vector3<f64>,
}

impl Axes {
    ///        y   toward_eye
    ///        |  /            azimuth turns toward_eye from z to x,
    ///        | / elevation   elevation lifts it to y
    ///        |/______ x
    ///       /
    ///      z
    pub(super) fn new(azimuth: f64, elevation: f64) -> Self {
        let right = Vector3::new(azimuth.cos(), 0.0, -azimuth.sin());
        let level = Vector3::new(azimuth.sin(), 0.0, azimuth.cos());
        let toward_eye = level * elevation.cos() + Vector3::y() * elevation.sin();
        Self { right, up: toward_eye.cross(&right), toward_eye }
    }
}

/// A view brought onto a grid of pixels.
pub(super) struct Camera {
    axes: Axes,
    /// m, around the mesh's origin.
    pub(super) eye: Vector3<f64>,
    /// Pixels for a slope of one.
    focal: f64,
    /// Pixel coordinates of the middle of the picture.
    middle: [f64; 2],
}

/// Nearest depth that is drawn, m; nothing has to be seen from closer.
const NEAR: f64 = 0.01;

impl Camera {
    /// The camera for a picture of `size` pixels, in coordinates around `origin` (world, m).
    pub(super) fn new(view: &View, size: [u32; 2], origin: &Point3<f64>) -> Self {
        let axes = Axes::new(view.azimuth, view.elevation);
        let distance = view.distance.max(NEAR);
        Self {
            eye: view.target - origin + axes.toward_eye * distance,
            axes,
            focal: f64::from(size[1]) * distance / view.height.max(1.0e-9),
            middle: size.map(|side| f64::from(side) / 2.0),
        }
    }

    /// Where a point (m, around the origin) appears. The depth of the corner is the inverse of that of the point, 1/m:
    /// linear over the picture (not over the world), and greater when nearer.
    pub(super) fn project(&self, point: &Vector3<f32>) -> Corner {
        let ray = point.cast::<f64>() - self.eye;
        let depth = -ray.dot(&self.axes.toward_eye);
        if depth < NEAR {
            return Corner::OUTSIDE;
        }
        Corner::new(
            self.middle[0] + self.focal * ray.dot(&self.axes.right) / depth,
            self.middle[1] - self.focal * ray.dot(&self.axes.up) / depth,
            1.0 / depth,
        )
    }

    /// Direction from the eye through a place on the picture (pixels); not of unit length.
    pub(super) fn ray(&self, x: f64, y: f64) -> Vector3<f64> {
        self.axes.right * ((x - self.middle[0]) / self.focal)
            - self.axes.up * ((y - self.middle[1]) / self.focal)
            - self.axes.toward_eye
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn cube() -> Vec<Point3<f64>> {
        (0..8).map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1) + 1.0, f64::from(i >> 2) * 3.0)).collect()
    }

    #[test]
    fn left_side_of_the_body_is_at_the_right_of_the_front_view() {
        let view = View::framing(&cube(), 0.0, 0.0, 1.0);
        let camera = Camera::new(&view, [100, 100], &Point3::origin());
        let left_side = camera.project(&Vector3::new(1.0, 1.5, 0.0));
        let right_side = camera.project(&Vector3::new(0.0, 1.5, 0.0));
        assert!(left_side.pixels()[0] > right_side.pixels()[0]);
        let top = camera.project(&Vector3::new(0.0, 2.0, 0.0));
        assert!(top.pixels()[1] < left_side.pixels()[1]);
        let nearer = camera.project(&Vector3::new(1.0, 1.5, 3.0));
        assert!(nearer.depth > left_side.depth);
    }

    #[test]
    fn framing_touches_the_border_and_does_not_cross_it() {
        for (azimuth, elevation, size) in [(0.0, 0.0, [300, 200]), (0.7, 0.3, [100, 400]), (-2.0, 1.0, [99, 99])] {
            let aspect = f64::from(size[0]) / f64::from(size[1]);
            let view = View::framing(&cube(), azimuth, elevation, aspect);
            let camera = Camera::new(&view, size, &Point3::origin());
            let [mut across, mut up] = [0.0_f64; 2];
            for point in cube() {
                let [x, y] = camera.project(&point.coords.cast()).pixels();
                across = across.max((x / f64::from(size[0]) - 0.5).abs());
                up = up.max((y / f64::from(size[1]) - 0.5).abs());
            }
            assert!((across.max(up) - 0.5).abs() < 1e-3, "{across} {up}");
        }
    }

    #[test]
    fn a_ray_goes_through_the_point_it_was_projected_from() {
        let view = View::framing(&cube(), 0.7, 0.3, 1.5);
        let camera = Camera::new(&view, [300, 200], &Point3::origin());
        let point = Vector3::new(0.3_f32, 1.2, 2.0);
        let place = camera.project(&point);
        let [x, y] = place.pixels();
        let found = camera.eye + camera.ray(x, y) / place.depth;
        // Half a 256th of a pixel, which is about 25 mm here.
        assert!((found - point.cast()).norm() < 1e-4);
    }

    #[test]
    fn behind_the_camera_is_outside() {
        let view = View::framing(&cube(), FRAC_PI_2, 0.0, 1.0);
        let camera = Camera::new(&view, [10, 10], &Point3::origin());
        assert!(camera.project(&Vector3::new(1.0e4, 0.0, 0.0)).is_outside());
    }

    #[test]
    fn framing_nothing_is_still_a_view() {
        let view = View::framing(&[Point3::new(f64::NAN, 0.0, 0.0)], 0.0, 0.0, f64::NAN);
        assert!(view.height > 0.0 && view.distance > 0.0);
    }
}
