//! The color of a place on a surface under the lights of the scene.
//!
//! Cloth and body alike are matte: Lambert's law, with a faint brightening at grazing angles, where fibres catch
//! light. The color is albedo times the sum of a key light with shadow, a weak fill light from the other side, and
//! the sky and ground as far as they are seen. Light that bounces between the walls of a fold is estimated from how
//! open the place is and from its color (J. Jimenez et al., "Practical real-time strategies for accurate indirect
//! occlusion", SIGGRAPH courses 2016).

use nalgebra::Vector3;

use super::ambient::{BothSides, Openness};
use super::color::{Color, luminance};
use super::key_light::KeyLight;
use super::raster::{Fragment, Primitive, Raster};
use super::scene::{Lighting, Mesh, unit_or_zero};
use crate::geometry::coverage::Corner;

/// How strong the lights are; 1 shows a white surface that faces the light as white.
struct Rig {
    key: Color,
    fill: f32,
    sky: Color,
    ground: Color,
    sheen: f32,
    /// Up to here light is shown as it is; what is brighter is compressed towards white without ever clipping.
    shoulder: f32,
}

impl Rig {
    /// Warm lamp, slightly cool sky, warm floor: hue as well as brightness tells which way a fold faces.
    const STUDIO: Self = Self {
        key: Color::new(0.86, 0.82, 0.76),
        fill: 0.08,
        sky: Color::new(0.44, 0.46, 0.50),
        ground: Color::new(0.24, 0.22, 0.20),
        sheen: 0.12,
        shoulder: 0.62,
    };

    /// Neutral throughout, so that the hue of a color that carries a meaning is kept.
    const EVEN: Self = Self {
        key: Color::new(0.34, 0.34, 0.34),
        fill: 0.12,
        sky: Color::new(0.84, 0.84, 0.84),
        ground: Color::new(0.58, 0.58, 0.58),
        sheen: 0.0,
        shoulder: 0.85,
    };

    fn new(lighting: Lighting) -> Self {
        match lighting {
            Lighting::Studio => Self::STUDIO,
            Lighting::Even => Self::EVEN,
        }
    }
}

/// The wrong side of the fabric: this part of the albedo, and this part of its saturation.
const WRONG_SIDE_BRIGHTNESS: f32 = 0.72;
const WRONG_SIDE_SATURATION: f32 = 0.6;

/// Part of the light on one side of the fabric that comes out on the other. Keeps the inside of sleeves and skirts
/// from going black; a closed body has no light inside and is not changed.
const TRANSLUCENCY: f32 = 0.3;

/// Albedo of a seam line, relative to the fabric around it.
const LINE_BRIGHTNESS: f32 = 0.38;

/// Exponent of the sheen: it is seen within about 40° of the silhouette.
const SHEEN_EXPONENT: i32 = 4;

/// Shades the fragments of one view.
pub(super) struct Shader<'a> {
    pub(super) mesh: &'a Mesh,
    /// One per vertex.
    pub(super) openness: &'a [BothSides],
    pub(super) key_light: &'a KeyLight,
    /// Unit vector.
    pub(super) toward_fill: Vector3<f32>,
    /// m, around the mesh's origin.
    pub(super) eye: Vector3<f32>,
    pub(super) lighting: Lighting,
}

/// A place on a surface, on the side that is seen.
struct Place {
    point: Vector3<f32>,
    /// Unit, on the side of the viewer as far as smooth normals allow.
    normal: Vector3<f32>,
    openness: Openness,
    albedo: Color,
}

impl Shader<'_> {
    /// Linear light of a fragment.
    pub(super) fn color(&self, raster: &Raster, fragment: &Fragment) -> Color {
        let place = match fragment.primitive {
            Primitive::Triangle(triangle) => {
                let weights = triangle_weights(raster.corners(triangle), fragment.x, fragment.y);
                self.on_triangle(triangle, weights)
            }
            Primitive::Line(line) => {
                let weights = line_weights(raster.ends(line), fragment.x, fragment.y);
                self.on_line(line, weights)
            }
        };
        let rig = Rig::new(self.lighting);
        let light = self.light(&rig, &place, grain(fragment.x, fragment.y));
        light.map(|channel| compress(channel, rig.shoulder))
    }

    fn on_triangle(&self, triangle: usize, weights: [f32; 3]) -> Place {
        let vertices = self.mesh.triangles[triangle];
        let face = self.mesh.face_normal(vertices);
        let colors = self.mesh.corner_colors[triangle];
        let albedo = colors[0] * weights[0] + colors[1] * weights[1] + colors[2] * weights[2];
        self.place(&vertices, &weights, face, albedo)
    }

    fn on_line(&self, line: usize, weights: [f32; 2]) -> Place {
        let vertices = self.mesh.lines[line];
        let normals = vertices.map(|vertex| self.mesh.normals[vertex as usize]);
        let albedo = self.mesh.line_colors[line] * LINE_BRIGHTNESS;
        self.place(&vertices, &weights, unit_or_zero(normals[0] + normals[1]), albedo)
    }

    /// Blends the vertices and picks the side that faces the eye.
    fn place(&self, vertices: &[u32], weights: &[f32], face: Vector3<f32>, albedo: Color) -> Place {
        let mut point = Vector3::zeros();
        let mut normal = Vector3::zeros();
        for (&vertex, &weight) in vertices.iter().zip(weights) {
            point += self.mesh.positions[vertex as usize] * weight;
            normal += self.mesh.normals[vertex as usize] * weight;
        }
        let is_right_side = face.dot(&(self.eye - point)) >= 0.0;
        let side = usize::from(!is_right_side);
        let mut openness = Openness::default();
        for (&vertex, &weight) in vertices.iter().zip(weights) {
            let [here, behind] = [side, 1 - side].map(|side| self.openness[vertex as usize][side]);
            openness.sky += (here.sky + TRANSLUCENCY * behind.sky) * weight;
            openness.ground += (here.ground + TRANSLUCENCY * behind.ground) * weight;
        }
        let normal = normal.try_normalize(1.0e-6).unwrap_or(face);
        Place {
            point,
            normal: if is_right_side { normal } else { -normal },
            openness,
            albedo: if is_right_side { albedo } else { wrong_side(albedo) },
        }
    }

    fn light(&self, rig: &Rig, place: &Place, turn: f32) -> Color {
        let facing_key = place.normal.dot(&self.key_light.toward_light()).max(0.0);
        let key = if facing_key > 0.0 {
            facing_key * self.key_light.visibility(&place.point, &place.normal, turn)
        } else {
            0.0
        };
        let open = (place.openness.sky + place.openness.ground).min(1.0);
        let fill = rig.fill * open * place.normal.dot(&self.toward_fill).max(0.0);
        let around = rig.sky * place.openness.sky + rig.ground * place.openness.ground;
        let bounced = around.component_mul(&place.albedo.map(|albedo| bounce_gain(open, albedo)));
        let to_eye = unit_or_zero(self.eye - place.point);
        let grazing = (1.0 - place.normal.dot(&to_eye)).clamp(0.0, 1.0);
        let sheen = rig.sheen * grazing.powi(SHEEN_EXPONENT) * place.openness.sky;
        let matte = rig.key * key + Color::repeat(fill) + bounced;
        place.albedo.component_mul(&matte) + rig.sky * sheen
    }
}

fn wrong_side(albedo: Color) -> Color {
    let grey = Color::repeat(luminance(albedo));
    grey.lerp(&albedo, WRONG_SIDE_SATURATION) * WRONG_SIDE_BRIGHTNESS
}

/// How much brighter than by direct light alone a place is that is `open` to this part, by light from its own walls
/// of the same albedo: the cubic of Jimenez et al. over its argument.
fn bounce_gain(open: f32, albedo: f32) -> f32 {
    let a = 2.0404 * albedo - 0.3324;
    let b = -4.7951 * albedo + 0.6417;
    let c = 2.7552 * albedo + 0.6903;
    ((open * a + b) * open + c).max(1.0)
}

/// The shoulder: continuous in value and slope, reaches 1 only in the limit.
fn compress(light: f32, shoulder: f32) -> f32 {
    let room = 1.0 - shoulder;
    let above = (light - shoulder).max(0.0) / room;
    light.min(shoulder) + room * above / (1.0 + above)
}

/// An angle for a place on the picture (pixels), spread evenly among neighbours: interleaved gradient noise
/// (J. Jimenez, "Next generation post processing in Call of Duty", SIGGRAPH 2014).
fn grain(x: f64, y: f64) -> f32 {
    let value = (52.982_918_9 * (0.067_110_56 * x.floor() + 0.005_837_15 * y.floor()).fract()).fract();
    (value * std::f64::consts::TAU) as f32
}

/// Barycentric weights in the world of a place on the picture, pixels. Each at least 0, together 1.
fn triangle_weights(corners: [Corner; 3], x: f64, y: f64) -> [f32; 3] {
    let offsets = corners.each_ref().map(|corner| [corner.pixels()[0] - x, corner.pixels()[1] - y]);
    let area = |i: usize, j: usize| offsets[i][0] * offsets[j][1] - offsets[i][1] * offsets[j][0];
    let areas = [area(1, 2), area(2, 0), area(0, 1)];
    let sign = (areas[0] + areas[1] + areas[2]).signum();
    let weights = [0, 1, 2].map(|i| (areas[i] * sign).max(0.0) * corners[i].depth);
    let sum = weights[0] + weights[1] + weights[2];
    // A triangle that is seen edge-on has no areas to speak of.
    if sum > f64::MIN_POSITIVE { weights.map(|weight| (weight / sum) as f32) } else { [1.0 / 3.0; 3] }
}

/// The same for a line: weights of its two ends.
fn line_weights(ends: [Corner; 2], x: f64, y: f64) -> [f32; 2] {
    let [p, q] = ends.each_ref().map(Corner::pixels);
    let along = [q[0] - p[0], q[1] - p[1]];
    let squared_length = (along[0] * along[0] + along[1] * along[1]).max(f64::MIN_POSITIVE);
    let t = (((x - p[0]) * along[0] + (y - p[1]) * along[1]) / squared_length).clamp(0.0, 1.0);
    let [a, b] = [(1.0 - t) * ends[0].depth, t * ends[1].depth];
    let second = (b / (a + b)) as f32;
    [1.0 - second, second]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_at_corners_middles_and_slivers() {
        let corners = [Corner::new(0.0, 0.0, 1.0), Corner::new(4.0, 0.0, 1.0), Corner::new(0.0, 4.0, 0.5)];
        assert_eq!(triangle_weights(corners, 4.0, 0.0), [0.0, 1.0, 0.0]);
        // Halfway on the picture is two thirds towards the nearer end in the world.
        let [a, b, c] = triangle_weights(corners, 0.0, 2.0);
        assert!((a - 2.0 / 3.0).abs() < 1e-6 && b == 0.0 && (c - 1.0 / 3.0).abs() < 1e-6);
        assert_eq!(triangle_weights([corners[0]; 3], 1.0, 1.0), [1.0 / 3.0; 3]);
        assert_eq!(line_weights([corners[0], corners[1]], 2.0, 1.0), [0.5, 0.5]);
        assert_eq!(line_weights([corners[0]; 2], 2.0, 1.0), [1.0, 0.0]);
    }

    #[test]
    fn the_shoulder_keeps_order_and_stays_below_white() {
        assert_eq!(compress(0.3, 0.6), 0.3);
        assert!(compress(1.0, 0.6) < compress(2.0, 0.6) && compress(1.0e6, 0.6) < 1.0 + f32::EPSILON);
    }

    #[test]
    fn bounced_light_brightens_white_folds_more_than_dark_ones() {
        assert!(bounce_gain(0.3, 0.8) > bounce_gain(0.3, 0.2));
        assert!((bounce_gain(1.0, 0.8) - 1.0).abs() < 0.01);
    }
}
