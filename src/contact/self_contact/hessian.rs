//! Second derivatives of what near pairs cost.

use super::pairs::Kind;
use super::repulsion::repulsion;
use super::{ActivePair, SelfContact};
use crate::geometry::Vector3;
use nalgebra::SMatrix;
use rayon::prelude::*;

/// Second derivatives of a pair's energy.
pub struct PairHessian {
    pub particles: [u32; 4],
    /// All of them, N/m: three rows and columns for each particle.
    pub block: SMatrix<f64, 12, 12>,
    /// What is positive of them: the square of `Σ pressing · x`, √(N/m).
    pub pressing: [Vector3; 4],
}

/// Step of the differences, m: rounding over it and its square are both far below what matters.
const STEP: f64 = 1e-8;

impl SelfContact {
    /// The Hessians of the pairs that pushed at the last evaluation, which was at `positions`, in their
    /// order: by central differences of gradients, as a pair's sides slide along each other while it turns.
    pub fn hessians(&self, positions: &[Vector3]) -> Vec<PairHessian> {
        let hessian = |pair: &ActivePair| {
            let clearance = self.clearance_of(pair.particles);
            let at = pair.particles.map(|p| positions[p as usize]);
            let gradient = |points| gradient(pair.kind, points, clearance, self.settings.stiffness);
            let mut block = SMatrix::<f64, 12, 12>::zeros();
            for column in 0..12 {
                let moved = |by: f64| {
                    let mut moved = at;
                    moved[column / 3][column % 3] += by;
                    gradient(moved)
                };
                let (forward, back) = (moved(STEP), moved(-STEP));
                for k in 0..4 {
                    block.fixed_view_mut::<3, 1>(3 * k, column).copy_from(&((forward[k] - back[k]) / (2.0 * STEP)));
                }
            }
            let pressing = pair.weights.map(|w| pair.normal * (w * pair.curvature.sqrt()));
            PairHessian { particles: pair.particles, block: (block + block.transpose()) * 0.5, pressing }
        };
        self.active().par_iter().with_min_len(64).map(hessian).collect()
    }
}

/// Gradient of a pair's energy at its four points, N.
fn gradient(kind: Kind, points: [Vector3; 4], clearance: f64, stiffness: f64) -> [Vector3; 4] {
    let span = kind.span(points);
    let distance = span.vector.norm();
    if distance >= clearance {
        return [Vector3::zeros(); 4];
    }
    let (_, slope, _) = repulsion(distance, clearance, stiffness);
    span.weights.map(|w| span.vector * (w * slope / distance))
}
