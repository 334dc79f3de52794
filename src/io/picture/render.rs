//! From a scene to a picture.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::ambient::{self, BothSides};
use super::camera::{Axes, Camera, View};
use super::color::Color;
use super::image::{Canvas, Image};
use super::key_light::KeyLight;
use super::raster::Raster;
use super::scene::{Lighting, Mesh, Scene};
use super::shade::Shader;
use super::studio::{Floor, backdrop, smooth_step};
use crate::geometry::coverage::Rect;

/// Renders one view of a scene.
///
/// `size` is width and height in pixels, each brought into 1 to [`MAX_SIDE`](super::MAX_SIDE). The same input gives
/// the same bytes on any number of threads. Triangles that reach behind the camera are left out whole, and what comes
/// after triangles that together cover the picture a hundred times is left out too, so that no mesh takes forever.
pub fn render(scene: &Scene, view: &View, size: [u32; 2]) -> Image {
    let mut canvas = backdrop(size);
    let whole = Rect { x0: 0, y0: 0, x1: i64::from(canvas.width), y1: i64::from(canvas.height) };
    Stage::new(scene).draw(view, &mut canvas, whole, 0.0);
    canvas.to_image()
}

/// Direction of the lamps as the viewer sees them: to the right, up, toward the viewer.
const KEY_DIRECTION: [f64; 3] = [-0.62, 0.72, 0.62];
const FILL_DIRECTION: [f64; 3] = [0.85, 0.15, 0.5];

/// Width of a seam line per height of the picture.
const LINE_WIDTH: f64 = 1.0 / 640.0;

/// Narrowest seam line, pixels; thinner ones are lost.
const NARROWEST_LINE: f64 = 1.0;

/// Enough to hide the borders that single axes of the ambient light leave, too few to fill folds.
const SMOOTHING_PASSES: usize = 4;

/// A scene with all that does not depend on the view.
pub(super) struct Stage {
    mesh: Mesh,
    openness: Vec<BothSides>,
    floor: Option<Floor>,
    lighting: Lighting,
}

impl Stage {
    pub(super) fn new(scene: &Scene) -> Self {
        let mesh = Mesh::new(&scene.surfaces);
        let floor = scene.floor.and_then(|height| Floor::new(&mesh, height));
        let mut openness = ambient::openness(&mesh, &mesh.positions, &mesh.normals);
        ambient::smooth(&mesh, &mut openness, SMOOTHING_PASSES);
        Self { mesh, openness, floor, lighting: scene.lighting }
    }

    /// Draws one view over a part of the canvas, which has the background on it already. Within `fade` pixels of the
    /// border of the part everything dissolves into the background.
    pub(super) fn draw(&self, view: &View, canvas: &mut Canvas, part: Rect, fade: f64) {
        let size = [part.x1 - part.x0, part.y1 - part.y0].map(|side| side.max(1) as u32);
        let camera = Camera::new(view, size, &self.mesh.origin);
        let axes = Axes::new(view.azimuth, view.elevation);
        let toward = |[right, up, near]: [f64; 3]| -> Vector3<f32> {
            let direction = axes.right * right + axes.up * up + axes.toward_eye * near;
            direction.normalize().cast()
        };
        let key_light = KeyLight::new(&self.mesh, toward(KEY_DIRECTION));
        let shader = Shader {
            mesh: &self.mesh,
            openness: &self.openness,
            key_light: &key_light,
            toward_fill: toward(FILL_DIRECTION),
            eye: camera.eye.cast(),
            lighting: self.lighting,
        };
        let line_width = (f64::from(size[1]) * LINE_WIDTH).max(NARROWEST_LINE);
        let raster = Raster::new(&self.mesh, &camera, size, line_width);
        if let Some(floor) = &self.floor {
            floor.darken(&camera, canvas, part);
        }
        compose(&raster, &shader, canvas, part, fade);
    }
}

/// Shades tile by tile and lays the result over the canvas.
fn compose(raster: &Raster, shader: &Shader, canvas: &mut Canvas, part: Rect, fade: f64) {
    let shaded: Vec<_> =
        (0..raster.tile_count()).into_par_iter().map(|tile| shade_tile(raster, shader, tile)).collect();
    for covered in shaded.iter().flatten() {
        let [x, y] = [covered.x + part.x0, covered.y + part.y0];
        if x < part.x1 && y < part.y1 {
            let area = covered.area * presence(x, y, part, fade);
            canvas.blend(x, y, covered.color, area);
        }
    }
}

/// 0 at the border of a part to 1 from `fade` pixels inside on.
fn presence(x: i64, y: i64, part: Rect, fade: f64) -> f32 {
    let to_border = (x - part.x0).min(part.x1 - 1 - x).min(y - part.y0).min(part.y1 - 1 - y);
    if fade > 0.0 { smooth_step((to_border as f64 / fade) as f32) } else { 1.0 }
}

/// A pixel with something in it.
struct Covered {
    x: i64,
    y: i64,
    /// Mean over the covered part of the pixel.
    color: Color,
    /// 0 to 1.
    area: f32,
}

fn shade_tile(raster: &Raster, shader: &Shader, tile: usize) -> Vec<Covered> {
    let mut pixels = Vec::new();
    if raster.is_empty(tile) {
        return pixels;
    }
    let samples = raster.tile(tile);
    let rect = raster.tile_rect(tile);
    for y in rect.y0..rect.y1 {
        for x in rect.x0..rect.x1 {
            let mut sum = Color::zeros();
            let mut area = 0.0;
            samples.for_each_fragment(x, y, |fragment| {
                sum += shader.color(raster, &fragment) * fragment.area;
                area += fragment.area;
            });
            if area > 0.0 {
                let color = sum / area;
                pixels.push(Covered { x, y, color, area });
            }
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::super::scene::{Coloring, Surface};
    use super::*;
    use nalgebra::Point3;

    const GREY: Color = Color::new(0.5, 0.5, 0.5);

    fn view(height: f64) -> View {
        View { azimuth: 0.0, elevation: 0.0, target: Point3::origin(), distance: 10.0, height }
    }

    fn scene<'a>(positions: &'a [Point3<f64>], triangles: &'a [[u32; 3]], color: Color) -> Scene<'a> {
        Scene {
            surfaces: vec![Surface { positions, triangles, coloring: Coloring::Constant(color), lines: &[] }],
            ..Scene::default()
        }
    }

    fn pixel(image: &Image, x: u32, y: u32) -> [u8; 3] {
        image.pixels[(y * image.width + x) as usize]
    }

    /// A vertical half cylinder whose axis is the y axis, bulging towards the viewer.
    fn half_pipe(turn: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..=32_u32 {
            let (sin, cos) = (turn + std::f64::consts::PI * f64::from(i) / 32.0).sin_cos();
            positions.push(Point3::new(-cos, -1.0, sin));
            positions.push(Point3::new(-cos, 1.0, sin));
            if i < 32 {
                let k = 2 * i;
                triangles.push([k, k + 2, k + 1]);
                triangles.push([k + 2, k + 3, k + 1]);
            }
        }
        (positions, triangles)
    }

    #[test]
    fn a_triangle_has_its_color_inside_and_the_background_outside() {
        let positions = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0));
        let red = Color::new(0.6, 0.05, 0.05);
        let image = render(&scene(&positions, &[[0, 1, 2]], red), &view(4.0), [64, 64]);
        let empty = render(&Scene::default(), &view(4.0), [64, 64]);
        let [r, g, b] = pixel(&image, 24, 40);
        assert!(r > 150 && g < 90 && b < 90, "{r} {g} {b}");
        for [x, y] in [[45, 20], [10, 40], [24, 50]] {
            assert_eq!(pixel(&image, x, y), pixel(&empty, x, y));
        }
    }

    #[test]
    fn the_wrong_side_of_the_fabric_is_darker() {
        let positions = [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]].map(|[x, y]| Point3::new(x, y, 0.0));
        let right = render(&scene(&positions, &[[0, 1, 2]], GREY), &view(2.0), [9, 9]);
        let wrong = render(&scene(&positions, &[[0, 2, 1]], GREY), &view(2.0), [9, 9]);
        assert!(pixel(&right, 4, 4)[0] > pixel(&wrong, 4, 4)[0] + 10);
    }

    #[test]
    fn the_light_comes_from_the_upper_left_of_the_viewer_wherever_he_stands() {
        let (positions, triangles) = half_pipe(0.0);
        let front = render(&scene(&positions, &triangles, GREY), &view(2.0), [80, 80]);
        assert!(pixel(&front, 20, 40)[0] > pixel(&front, 60, 40)[0] + 10);
        let (positions, triangles) = half_pipe(std::f64::consts::PI);
        let behind = View { azimuth: std::f64::consts::PI, ..view(2.0) };
        let back = render(&scene(&positions, &triangles, GREY), &behind, [80, 80]);
        for (front, back) in front.pixels.iter().zip(&back.pixels) {
            for channel in 0..3 {
                assert!(front[channel].abs_diff(back[channel]) <= 3, "{front:?} {back:?}");
            }
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bytes() {
        let (positions, triangles) = half_pipe(0.3);
        let mut scene = scene(&positions, &triangles, GREY);
        scene.floor = Some(-1.0);
        let on_threads = |count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
            pool.install(|| render(&scene, &view(3.0), [150, 100]).to_png())
        };
        let alone = on_threads(1);
        assert_eq!(alone, on_threads(2));
        assert_eq!(alone, on_threads(5));
    }

    #[test]
    fn an_exploded_garment_takes_no_hour() {
        // Vertices all over the picture (a linear congruential generator), triangles between any three of them.
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let positions: Vec<_> = (0..30_000).map(|_| Point3::new(random(), random(), random())).collect();
        let triangles: Vec<_> = (0..30_000).map(|i| [i, (i + 1) % 30_000, (i + 2) % 30_000]).collect();
        let image = render(&scene(&positions, &triangles, GREY), &view(1.0), [160, 160]);
        assert_eq!(image.pixels.len(), 160 * 160);
    }

    #[test]
    fn odd_scenes_and_views_give_pictures() {
        let point = [Point3::new(0.0, 0.0, 0.0); 3];
        let far = [Point3::new(1e6, 0.0, 0.0), Point3::new(-1e6, 0.0, 0.0), Point3::new(0.0, 1e-9, 9.9)];
        let huge = [Point3::new(f64::MAX, 0.0, 0.0), Point3::origin(), Point3::new(0.0, f64::MIN, 0.0)];
        let sliver = [Point3::new(0.0, 0.0, 0.0), Point3::new(1.0, 0.0, 0.0), Point3::new(2.0, 1e-15, 0.0)];
        let odd_view = View { height: 0.0, distance: -f64::MAX, elevation: f64::MAX, ..view(1.0) };
        let no_view = View { azimuth: f64::NAN, height: f64::INFINITY, ..view(f64::NAN) };
        for positions in [&[][..], &point, &far, &huge, &sliver] {
            for view in [view(1.0), odd_view, no_view] {
                let mut scene = scene(positions, &[[0, 1, 2], [0, 0, 0], [7, 8, 9]], GREY);
                scene.floor = Some(0.0);
                scene.surfaces[0].lines = &[[0, 1], [0, 0], [5, 1]];
                assert_eq!(render(&scene, &view, [33, 7]).pixels.len(), 33 * 7);
                scene.floor = Some(f64::MAX);
                assert_eq!(render(&scene, &view, [0, 0]).pixels.len(), 1);
            }
        }
    }
}
