//! The key light: one broad lamp from far away, with a shadow that is sharp near its cause and soft far from it.
//!
//! The width of the penumbra is estimated from the blockers around a point and then filtered over (R. Fernando,
//! "Percentage-closer soft shadows", SIGGRAPH sketches 2005). Comparisons follow the plane of the receiver, so that
//! wide filters do not make a tilted surface shade itself.

use nalgebra::Vector3;

use super::depth_map::{DepthMap, Window};
use super::scene::Mesh;

/// Texels across the shadow map: 1 mm each for a standing body, less than the clearance of cloth.
const MAP_SIZE: usize = 2048;

/// Penumbra radius per distance between blocker and receiver: a lamp that is seen under 2 × 3°.
const SOFTNESS: f32 = 0.055;

/// Widest penumbra radius, m. Wider, the sixteen samples would show as grain.
const WIDEST: f32 = 0.022;

/// Narrowest filter radius, texels; hides the steps of the map.
const NARROWEST_IN_TEXELS: f32 = 1.5;

/// A blocker must be farther from the receiver's plane than this, m: more than facets differ from the round surface
/// they stand for, less than the clearance of cloth, so that a hem throws its shadow on the body.
const BIAS: f32 = 0.0012;

/// Steepest plane, height per distance, that the comparison follows; steeper ones get a tenth of the light and less.
const STEEPEST: f32 = 10.0;

/// Points on the disk that is searched for blockers and on the one that is filtered over.
const SEARCH_COUNT: usize = 8;
const FILTER_COUNT: usize = 12;

pub(super) struct KeyLight {
    window: Window,
    map: DepthMap,
}

impl KeyLight {
    /// The lamp in a direction (unit vector).
    pub(super) fn new(mesh: &Mesh, toward_light: Vector3<f32>) -> Self {
        let window = Window::new(mesh, toward_light, MAP_SIZE);
        Self { window, map: window.top(mesh) }
    }

    pub(super) fn toward_light(&self) -> Vector3<f32> {
        self.window.toward_light
    }

    /// How much of the lamp is seen from a point (m, around the mesh's origin) of a surface with a unit normal that
    /// faces the lamp, 0 to 1. `turn` (radians) rotates the sampling points; neighbours with different turns hide
    /// the pattern.
    pub(super) fn visibility(&self, point: &Vector3<f32>, normal: &Vector3<f32>, turn: f32) -> f32 {
        let texel = self.window.texel();
        let receiver = Receiver::new(&self.window, point, normal);
        let Some(blocker) = self.mean_blocker(&receiver, WIDEST / texel, turn) else {
            return 1.0;
        };
        let penumbra = (SOFTNESS * (blocker - receiver.place.z)).min(WIDEST) / texel;
        let radius = penumbra.max(NARROWEST_IN_TEXELS);
        let mut light = 0.0;
        for offset in disk::<FILTER_COUNT>(radius, turn) {
            let [x, y] = receiver.beside(offset);
            light += self.map.fraction(x, y, |height, texel| !receiver.is_under(height, offset, texel));
        }
        light / FILTER_COUNT as f32
    }

    /// Mean height of what is above the receiver within a radius (texels), m.
    fn mean_blocker(&self, receiver: &Receiver, radius: f32, turn: f32) -> Option<f32> {
        let mut sum = 0.0;
        let mut count = 0.0;
        for offset in disk::<SEARCH_COUNT>(radius, turn) {
            let [x, y] = receiver.beside(offset);
            let (height, texel) = self.map.texel_at(x, y);
            if receiver.is_under(height, offset, texel) {
                sum += height;
                count += 1.0;
            }
        }
        (count > 0.0).then(|| sum / count)
    }
}

/// A point to be lit and the plane through it, in map coordinates.
struct Receiver {
    place: Vector3<f32>,
    /// Height of the plane per texel right and down, m.
    slope: [f32; 2],
    /// Height above the plane from which on a blocker counts, m.
    bias: f32,
}

impl Receiver {
    fn new(window: &Window, point: &Vector3<f32>, normal: &Vector3<f32>) -> Self {
        let normal = window.turn(normal);
        let steepness = normal.x.hypot(normal.y) / normal.z.max(1.0e-6);
        // Per length of the normal's shadow, so that a limit on the steepness keeps the direction.
        let scale = steepness.min(STEEPEST) / normal.x.hypot(normal.y).max(1.0e-6);
        Self {
            place: window.place(point),
            slope: [normal.x, normal.y].map(|component| -component * scale * window.texel()),
            bias: BIAS * 1.0_f32.hypot(steepness.min(STEEPEST)),
        }
    }

    /// The place on the map at an offset, texels.
    fn beside(&self, [right, down]: [f32; 2]) -> [f32; 2] {
        [self.place.x + right, self.place.y + down]
    }

    /// Whether something at a height blocks the light of the plane at an offset and a further one, texels.
    fn is_under(&self, height: f32, offset: [f32; 2], texel: [f32; 2]) -> bool {
        let [right, down] = [offset[0] + texel[0], offset[1] + texel[1]];
        height > self.place.z + self.slope[0] * right + self.slope[1] * down + self.bias
    }
}

/// Evenly spread points on a disk: a spiral with the golden angle (H. Vogel, "A better way to construct the sunflower
/// head", 1979).
fn disk<const COUNT: usize>(radius: f32, turn: f32) -> impl Iterator<Item = [f32; 2]> {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let (sin, cos) = GOLDEN_ANGLE.sin_cos();
    let (mut y, mut x) = turn.sin_cos();
    (0..COUNT).map(move |index| {
        [x, y] = [x * cos - y * sin, x * sin + y * cos];
        let r = radius * ((index as f32 + 0.5) / COUNT as f32).sqrt();
        [r * x, r * y]
    })
}

#[cfg(test)]
mod tests {
    use super::super::scene::{Coloring, MISSING_COLOR, Surface};
    use super::*;
    use nalgebra::Point3;

    /// A floor 2 m wide at height 0 and a roof over its positive-x half, 0.5 m above.
    fn shed() -> Mesh {
        let floor = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| Point3::new(x, 0.0, z));
        let roof = [[0.0, 1.0], [1.0, 1.0], [1.0, -1.0], [0.0, -1.0]].map(|[x, z]| Point3::new(x, 0.5, z));
        let level = |positions| Surface {
            positions,
            triangles: &[[0, 1, 2], [0, 2, 3]],
            coloring: Coloring::Constant(MISSING_COLOR),
            lines: &[],
        };
        Mesh::new(&[level(&floor), level(&roof)])
    }

    fn light_on_the_floor(x: f32) -> f32 {
        let light = KeyLight::new(&shed(), Vector3::y());
        light.visibility(&Vector3::new(x, -0.25, 0.1), &Vector3::y(), 0.3)
    }

    #[test]
    fn light_falls_beside_the_roof_and_not_under_it() {
        assert_eq!(light_on_the_floor(-0.3), 1.0);
        assert_eq!(light_on_the_floor(0.3), 0.0);
    }

    #[test]
    fn the_border_of_the_shadow_is_soft() {
        let light = light_on_the_floor(0.0);
        assert!((0.3..0.7).contains(&light), "{light}");
        assert!(light_on_the_floor(-0.01) > light);
        assert!(light_on_the_floor(0.01) < light);
    }

    #[test]
    fn a_tilted_surface_does_not_shade_itself() {
        let positions = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| Point3::new(x, 2.0 * x, z));
        let mesh = Mesh::new(&[Surface {
            positions: &positions,
            triangles: &[[0, 1, 2], [0, 2, 3]],
            coloring: Coloring::Constant(MISSING_COLOR),
            lines: &[],
        }]);
        let light = KeyLight::new(&mesh, Vector3::y());
        let normal = Vector3::new(-2.0, 1.0, 0.0).normalize();
        for step in -8..8 {
            let x = step as f32 * 0.11;
            assert_eq!(light.visibility(&Vector3::new(x, 2.0 * x, 0.013), &normal, 0.7), 1.0);
        }
    }
}
