//! In-plane elasticity: springs along the edges, coupled within each triangle.
//!
//! The strain of a spring is `e = l/L - 1` (Le Thanh and Gagalowicz 2007, equation 2). Three of them
//! are a triangle's whole in-plane strain: with the unit vector `n` along an edge on the panel,
//! `e = nᵀ ε n`, so that `ε = M⁻¹ e` and the elastic energy of the fabric becomes
//!
//! ```text
//!     E = ½ eᵀ K e,    K = A M⁻ᵀ C M⁻¹                                   (theory, equation 3)
//! ```
//!
//! with the rest area `A` and the fabric's matrix `C`. Independent springs, the paper's, are the case
//! of a diagonal `K`; they cannot give warp, weft and shear stiffnesses of their own at once, nor the
//! same cloth on every mesh. They are kept for comparison.

use crate::garment::Level;
use crate::geometry::{Vector2, Vector3};
use crate::pattern::{Cut, Fabric};
use nalgebra::{Matrix3, matrix};
use rayon::prelude::*;

/// Springs shorter than this share of their rest length are treated as that long where the energy
/// divides by the length: a collapsed edge has no direction, and a near-zero one would ruin the
/// conditioning silently.
pub(super) const SHORTEST: f64 = 1e-3;

/// Which springs stand for the membrane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Membrane {
    /// Coupled within each triangle: the fabric's own stiffnesses on any mesh.
    #[default]
    Coupled,
    /// Independent, as in the paper.
    Springs,
}

/// Energy of independent springs on equilateral triangles over the membrane's, for a strain along one
/// of them: that spring's own and two sixteenths of the others'.
const SPRING_SHARE: f64 = 1.0 + 2.0 / 16.0;

/// Three coupled springs.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    pub particles: [u32; 3],
    /// `1/L` of the edges opposite to each corner, 1/m.
    pub(super) inverse_rest: [f64; 3],
    /// `K`, J: (00, 11, 22, 12, 02, 01).
    pub(super) stiffness: [f64; 6],
}

/// The three edges of a triangle now: opposite to each corner, from the next corner to the one after.
struct Edges {
    unit: [Vector3; 3],
    strain: [f64; 3],
    /// `1/l`, guarded, 1/m.
    inverse_length: [f64; 3],
}

impl Triangle {
    /// A triangle of fabric with the given rest corners, m. Its warp runs along the panel's y. Where
    /// an edge is eased into a seam, `eased` gives its length over its length on the panel.
    pub fn new(particles: [u32; 3], rest: [Vector2; 3], eased: [f64; 3], fabric: &Fabric, membrane: Membrane) -> Self {
        let edges: [Vector2; 3] = std::array::from_fn(|k| rest[(k + 2) % 3] - rest[(k + 1) % 3]);
        let area = 0.5 * crate::geometry::cross(edges[0], edges[1]).abs();
        let row = |edge: Vector2| {
            let n = edge.normalize();
            [n.x * n.x, n.y * n.y, n.x * n.y]
        };
        let [a, b, c] = edges.map(row);
        let edges_of_strain = matrix![a[0], a[1], a[2]; b[0], b[1], b[2]; c[0], c[1], c[2]];
        let fabric_matrix = fabric.membrane_matrix();
        let k = match membrane {
            Membrane::Coupled => {
                let strain_of_edges = edges_of_strain.try_inverse().unwrap_or_else(Matrix3::zeros);
                strain_of_edges.transpose() * fabric_matrix * strain_of_edges * area
            }
            Membrane::Springs => {
                let along = (edges_of_strain * fabric_matrix * edges_of_strain.transpose()).diagonal();
                Matrix3::from_diagonal(&(along * (area / SPRING_SHARE)))
            }
        };
        Self {
            particles,
            inverse_rest: std::array::from_fn(|k| 1.0 / (edges[k].norm() * eased[k])),
            stiffness: [k[(0, 0)], k[(1, 1)], k[(2, 2)], k[(1, 2)], k[(0, 2)], k[(0, 1)]],
        }
    }

    #[inline]
    fn edges(&self, [a, b, c]: [Vector3; 3]) -> Edges {
        let spans = [c - b, a - c, b - a];
        let lengths = spans.map(|s| s.norm());
        let stretch: [f64; 3] = std::array::from_fn(|k| lengths[k] * self.inverse_rest[k]);
        let inverse_length: [f64; 3] = std::array::from_fn(|k| {
            let collapsed = stretch[k] < SHORTEST;
            1.0 / if collapsed { SHORTEST / self.inverse_rest[k] } else { lengths[k] }
        });
        Edges {
            unit: std::array::from_fn(|k| spans[k] * inverse_length[k]),
            strain: stretch.map(|stretch| stretch - 1.0),
            inverse_length,
        }
    }

    #[inline]
    fn times_stiffness(&self, e: [f64; 3]) -> [f64; 3] {
        let [k00, k11, k22, k12, k02, k01] = self.stiffness;
        [
            k00 * e[0] + k01 * e[1] + k02 * e[2],
            k01 * e[0] + k11 * e[1] + k12 * e[2],
            k02 * e[0] + k12 * e[1] + k22 * e[2],
        ]
    }

    /// Energy, J, and its gradient at the three corners, N.
    #[inline]
    pub fn evaluate(&self, corners: [Vector3; 3]) -> (f64, [Vector3; 3]) {
        let edges = self.edges(corners);
        let stress = self.times_stiffness(edges.strain);
        let energy = 0.5 * (0..3).map(|k| stress[k] * edges.strain[k]).sum::<f64>();
        // Tension of each edge times its direction; the edge pulls its second end forward.
        let pull: [Vector3; 3] = std::array::from_fn(|k| edges.unit[k] * (stress[k] * self.inverse_rest[k]));
        (energy, [pull[1] - pull[2], pull[2] - pull[0], pull[0] - pull[1]])
    }

    /// `dᵀ H d` without what buckling would make negative, J/m² times the direction's unit squared.
    #[inline]
    pub fn curvature(&self, corners: [Vector3; 3], [da, db, dc]: [Vector3; 3]) -> f64 {
        let edges = self.edges(corners);
        let stress = self.times_stiffness(edges.strain);
        let spans = [dc - db, da - dc, db - da];
        let along: [f64; 3] = std::array::from_fn(|k| edges.unit[k].dot(&spans[k]));
        let rate: [f64; 3] = std::array::from_fn(|k| along[k] * self.inverse_rest[k]);
        let stretching: f64 = (0..3).map(|k| self.times_stiffness(rate)[k] * rate[k]).sum();
        let turning: f64 = (0..3)
            .map(|k| {
                let across = (spans[k].norm_squared() - along[k] * along[k]).max(0.0);
                (stress[k] * self.inverse_rest[k]).max(0.0) * edges.inverse_length[k] * across
            })
            .sum();
        stretching + turning
    }

    /// The blocks of the Hessian, N/m, that couple a corner with the three corners. `definite` leaves out
    /// what pushing edges would make negative.
    pub fn hessian_row(&self, corners: [Vector3; 3], corner: usize, definite: bool) -> [Matrix3<f64>; 3] {
        let edges = self.edges(corners);
        let stress = self.times_stiffness(edges.strain);
        let [k00, k11, k22, k12, k02, k01] = self.stiffness;
        let coupling = [[k00, k01, k02], [k01, k11, k12], [k02, k12, k22]];
        let mut row = [Matrix3::zeros(); 3];
        // An edge runs from the corner after its own to the one after that: the two edges at a corner,
        // with the sense in which it is their end.
        for (k, sense) in [((corner + 1) % 3, 1.0), ((corner + 2) % 3, -1.0)] {
            let mut along = [Vector3::zeros(); 3];
            for l in 0..3 {
                let pull = edges.unit[l] * (coupling[k][l] * self.inverse_rest[k] * self.inverse_rest[l] * sense);
                along[(l + 2) % 3] += pull;
                along[(l + 1) % 3] -= pull;
            }
            for (block, along) in row.iter_mut().zip(along) {
                *block += edges.unit[k] * along.transpose();
            }
            let tension = stress[k] * self.inverse_rest[k] * edges.inverse_length[k];
            let turning = if definite { tension.max(0.0) } else { tension };
            let across = (Matrix3::identity() - edges.unit[k] * edges.unit[k].transpose()) * (turning * sense);
            row[(k + 2) % 3] += across;
            row[(k + 1) % 3] -= across;
        }
        row
    }

    /// Stiffness that each corner feels, N/m: half the trace of its block of the Hessian at rest, over
    /// the two directions in the plane.
    pub fn diagonal(&self) -> [f64; 3] {
        let [k00, k11, k22, ..] = self.stiffness;
        let springs: [f64; 3] = std::array::from_fn(|k| [k00, k11, k22][k] * self.inverse_rest[k].powi(2));
        [springs[1] + springs[2], springs[2] + springs[0], springs[0] + springs[1]].map(|s| 0.5 * s)
    }
}

/// The triangles of a level.
pub fn triangles(level: &Level, cut: Cut, membrane: Membrane) -> Vec<Triangle> {
    let mut eased = vec![[1.0; 3]; level.triangles.len()];
    for edge in &level.eased {
        eased[edge.triangle as usize][edge.tip as usize] = edge.ratio;
    }
    let panel_of = level.panel_of_triangle();
    (0..level.triangles.len())
        .into_par_iter()
        .map(|t| {
            let fabric = cut.of_panel(panel_of[t] as usize);
            Triangle::new(level.particles(t), level.rest_corners(t), eased[t], fabric, membrane)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const REST: [[f64; 2]; 3] = [[0.0, 0.0], [0.012, 0.001], [0.004, 0.009]];

    fn triangle() -> Triangle {
        let fabric = Fabric {
            shear: 25.0,
            stretch: crate::pattern::Directional { warp: 500.0, weft: 250.0 },
            ..Fabric::default()
        };
        Triangle::new([0, 1, 2], REST.map(Vector2::from), [1.0; 3], &fabric, Membrane::Coupled)
    }

    fn lifted(map: impl Fn(Vector2) -> Vector3) -> [Vector3; 3] {
        REST.map(|p| map(Vector2::from(p)))
    }

    #[test]
    fn a_uniform_strain_costs_what_the_fabric_says() {
        let area = 0.5 * crate::geometry::cross(Vector2::from(REST[1]), Vector2::from(REST[2]));
        let fabric = Fabric {
            shear: 25.0,
            stretch: crate::pattern::Directional { warp: 500.0, weft: 250.0 },
            ..Fabric::default()
        };
        let c = fabric.membrane_matrix();
        let small = 1e-6;
        for (strain, expected) in [
            (Vector3::new(small, 0.0, 0.0), c[(0, 0)]),
            (Vector3::new(0.0, small, 0.0), c[(1, 1)]),
            (Vector3::new(0.0, 0.0, small), c[(2, 2)]),
        ] {
            let corners = lifted(|p| Vector3::new(p.x + strain.x * p.x + strain.z * p.y, p.y + strain.y * p.y, 0.0));
            let energy = triangle().evaluate(corners).0;
            assert!((energy / (0.5 * area * small * small * expected) - 1.0).abs() < 1e-4);
        }
    }

    proptest! {
        #[test]
        fn the_gradient_is_the_derivative(moves in proptest::array::uniform9(-0.004..0.004f64)) {
            let t = triangle();
            let mut corners = lifted(|p| Vector3::new(p.x, p.y, 0.0));
            for (k, m) in moves.iter().enumerate() {
                corners[k / 3][k % 3] += m;
            }
            let (_, gradient) = t.evaluate(corners);
            let step = 1e-8;
            for k in 0..9 {
                let mut at = [corners, corners];
                at[0][k / 3][k % 3] += step;
                at[1][k / 3][k % 3] -= step;
                let slope = (t.evaluate(at[0]).0 - t.evaluate(at[1]).0) / (2.0 * step);
                prop_assert!((slope - gradient[k / 3][k % 3]).abs() < 1e-5 * (1.0 + slope.abs()));
            }
        }

        #[test]
        fn moving_rigidly_costs_nothing(axis in proptest::array::uniform3(-3.0..3.0f64), shift in proptest::array::uniform3(-1.0..1.0f64)) {
            let turn = nalgebra::Rotation3::new(Vector3::from(axis));
            let corners = lifted(|p| turn * Vector3::new(p.x, p.y, 0.0) + Vector3::from(shift));
            prop_assert!(triangle().evaluate(corners).0 < 1e-20);
        }

        #[test]
        fn the_curvature_bounds_the_second_derivative(moves in proptest::array::uniform9(-0.003..0.003f64), along in proptest::array::uniform9(-1.0..1.0f64)) {
            let t = triangle();
            let mut corners = lifted(|p| Vector3::new(p.x, p.y, 0.0));
            let mut direction = [Vector3::zeros(); 3];
            for k in 0..9 {
                corners[k / 3][k % 3] += moves[k];
                direction[k / 3][k % 3] = along[k];
            }
            let slope = |s: f64| {
                let at: [Vector3; 3] = std::array::from_fn(|k| corners[k] + direction[k] * s);
                let (_, gradient) = t.evaluate(at);
                (0..3).map(|k| gradient[k].dot(&direction[k])).sum::<f64>()
            };
            let step = 1e-7;
            let second = (slope(step) - slope(-step)) / (2.0 * step);
            let bound = t.curvature(corners, direction);
            prop_assert!(second <= bound * (1.0 + 1e-4) + 1e-3);
        }
    }
}
