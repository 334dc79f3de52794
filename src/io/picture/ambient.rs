//! Light from all around: for each vertex and each side of the fabric, how much of the sky and of the ground it sees.
//!
//! The sphere of directions is sampled by a fixed set of axes; a depth map along each of them tells which vertices are
//! in the open from either end. Summed with the cosine law that is ambient occlusion at the scale of limbs and folds,
//! without noise and independent of the view, so one bake serves all the views of a picture. Folds narrower than a
//! few texels (about 1 cm for a standing body) are left to the key light.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::depth_map::{DepthMap, Window};
use super::scene::Mesh;

/// Axes, each of which looks both ways. Fewer show as bands on smooth shapes; the time grows with their number.
const AXIS_COUNT: usize = 24;

/// Texels across a depth map. 320 give 6 mm for a standing body, about the spacing of the vertices that are lit.
const MAP_SIZE: usize = 320;

/// Axes that are held in memory at a time: 2 maps each, 1.6 MB.
const AXES_AT_A_TIME: usize = 8;

/// Points are lifted off their own surface by this many texels before the comparison. More than the diagonal of a
/// texel: below it flat cloth shades itself.
const LIFT_IN_TEXELS: f32 = 1.6;

/// Vertices handled by one task.
const CHUNK: usize = 1024;

/// What one side of the fabric sees of its surroundings; 1 for a side that faces an empty sky or an empty ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Openness {
    pub(super) sky: f32,
    pub(super) ground: f32,
}

/// The openness of a point on the side its normal points to, then on the other side.
pub(super) type BothSides = [Openness; 2];

/// The openness of points (m, around the mesh's origin) with unit normals, in the shade of the mesh.
pub(super) fn openness(mesh: &Mesh, points: &[Vector3<f32>], normals: &[Vector3<f32>]) -> Vec<BothSides> {
    let mut sums = vec![BothSides::default(); points.len()];
    for axes in axes().chunks(AXES_AT_A_TIME) {
        let lookouts: Vec<_> = axes.par_iter().map(|&axis| Lookout::new(mesh, axis)).collect();
        let chunks = sums.par_chunks_mut(CHUNK).zip(points.par_chunks(CHUNK)).zip(normals.par_chunks(CHUNK));
        chunks.for_each(|((sums, points), normals)| {
            for ((sum, point), normal) in sums.iter_mut().zip(points).zip(normals) {
                for lookout in &lookouts {
                    lookout.add(point, normal, sum);
                }
            }
        });
    }
    sums
}

/// Evens out the openness of neighbouring vertices, which softens the borders that single axes leave.
///
/// Each pass replaces a vertex by the mean of itself and the corners of its triangles.
pub(super) fn smooth(mesh: &Mesh, openness: &mut [BothSides], passes: usize) {
    let add = |sum: &mut BothSides, part: &BothSides, weight: f32| {
        for (sum, part) in sum.iter_mut().zip(part) {
            sum.sky += part.sky * weight;
            sum.ground += part.ground * weight;
        }
    };
    for _ in 0..passes {
        let mut sums = vec![BothSides::default(); openness.len()];
        let mut counts = vec![0.0_f32; openness.len()];
        for triangle in &mesh.triangles {
            let mut mean = BothSides::default();
            triangle.iter().for_each(|&vertex| add(&mut mean, &openness[vertex as usize], 1.0 / 3.0));
            for &vertex in triangle {
                add(&mut sums[vertex as usize], &mean, 1.0);
                counts[vertex as usize] += 1.0;
            }
        }
        for ((old, sum), count) in openness.iter_mut().zip(&sums).zip(&counts) {
            if *count > 0.0 {
                *old = BothSides::default();
                add(old, sum, 1.0 / count);
            }
        }
    }
}

/// Evenly spread directions of the upper half sphere: a spiral with the golden angle, equal steps in height being
/// equal areas (Archimedes).
fn axes() -> Vec<Vector3<f32>> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let axis = |index: usize| {
        let height = (index as f64 + 0.5) / AXIS_COUNT as f64;
        let (sin, cos) = (golden_angle * index as f64).sin_cos();
        let radius = (1.0 - height * height).sqrt();
        Vector3::new(radius * cos, height, radius * sin).cast()
    };
    (0..AXIS_COUNT).map(axis).collect()
}

/// The mesh as seen from both ends of an axis that points up.
struct Lookout {
    window: Window,
    top: DepthMap,
    bottom: DepthMap,
    /// m.
    lift: f32,
}

impl Lookout {
    fn new(mesh: &Mesh, axis: Vector3<f32>) -> Self {
        let window = Window::new(mesh, axis, MAP_SIZE);
        let [top, bottom] = window.top_and_bottom(mesh);
        Self { window, top, bottom, lift: LIFT_IN_TEXELS * window.texel() }
    }

    /// Adds what the two sides of a point see at the two ends of the axis: one side sees one end.
    fn add(&self, point: &Vector3<f32>, normal: &Vector3<f32>, sum: &mut BothSides) {
        // The mean of the cosine over a half sphere is 1/2, and every axis falls in the half sphere of a side once.
        let cosine = normal.dot(&self.window.toward_light);
        let weight = cosine.abs() * 2.0 / AXIS_COUNT as f32;
        let [upper, lower] = if cosine > 0.0 { [0, 1] } else { [1, 0] };
        let lift = normal * (self.lift * cosine.signum());
        let place = self.window.place(&(point + lift));
        sum[upper].sky += weight * self.top.fraction(place.x, place.y, |height, _| height <= place.z);
        let place = self.window.place(&(point - lift));
        sum[lower].ground += weight * self.bottom.fraction(place.x, place.y, |height, _| height >= place.z);
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene::{Coloring, MISSING_COLOR, Surface};
    use super::*;
    use nalgebra::Point3;

    fn square(height: f64) -> Vec<Point3<f64>> {
        [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| Point3::new(x, height, z)).to_vec()
    }

    fn level(positions: &[Point3<f64>]) -> Surface<'_> {
        Surface {
            positions,
            triangles: &[[0, 1, 2], [0, 2, 3]],
            coloring: Coloring::Constant(MISSING_COLOR),
            lines: &[],
        }
    }

    #[test]
    fn an_open_square_sees_the_whole_sky_above_and_the_whole_ground_below() {
        let positions = square(0.0);
        let mesh = Mesh::new(&[level(&positions)]);
        let [upper, lower] = openness(&mesh, &[Vector3::zeros()], &[Vector3::y()])[0];
        assert!((upper.sky - 1.0).abs() < 0.02 && upper.ground == 0.0, "{upper:?}");
        assert!((lower.ground - 1.0).abs() < 0.02 && lower.sky == 0.0, "{lower:?}");
    }

    #[test]
    fn smoothing_keeps_what_is_even_and_evens_the_rest() {
        let positions = square(0.0);
        let mesh = Mesh::new(&[level(&positions)]);
        let of = |sky| [Openness { sky, ground: 0.2 }; 2];
        let mut even = vec![of(0.5); 4];
        smooth(&mesh, &mut even, 3);
        assert!(even.iter().all(|sides| (sides[0].sky - 0.5).abs() < 1e-6 && (sides[1].ground - 0.2).abs() < 1e-6));
        let mut spot = vec![of(1.0), of(0.0), of(0.0), of(0.0)];
        smooth(&mesh, &mut spot, 3);
        assert!(spot.iter().all(|sides| (0.15..0.45).contains(&sides[0].sky)), "{spot:?}");
    }

    #[test]
    fn under_a_roof_it_is_dark() {
        let [floor, roof] = [square(0.0), square(0.2)];
        let mesh = Mesh::new(&[level(&floor), level(&roof)]);
        let middle = Vector3::new(0.0, -0.1, 0.0);
        let [upper, lower] = openness(&mesh, &[middle], &[Vector3::y()])[0];
        assert!(upper.sky < 0.1, "{upper:?}");
        assert!(lower.ground > 0.95, "{lower:?}");
    }

    #[test]
    fn a_wall_sees_half_of_each() {
        let [floor, roof] = [square(0.0), square(0.2)];
        let mesh = Mesh::new(&[level(&floor), level(&roof)]);
        let sides = openness(&mesh, &[Vector3::new(1.4, 0.1, 0.0)], &[Vector3::x()])[0];
        assert!((sides[0].sky - 0.5).abs() < 0.05, "{sides:?}");
        assert!((sides[0].ground - 0.5).abs() < 0.05, "{sides:?}");
    }
}
