//! Minimizers of smooth functions of many points in space. Nothing here has heard of cloth.

mod argmin_door;
mod argmin_lbfgs;
mod block_matrix;
#[cfg(test)]
mod chain;
mod cholesky;
mod conjugate_gradient;
mod dissection;
mod dynamic_relaxation;
mod lbfgs;
mod method;
mod newton;
mod vectors;

pub use argmin_door::{ArgminDoor, flattened, unflattened};
pub use argmin_lbfgs::ArgminLbfgs;
pub use block_matrix::{BlockMatrix, Pattern};
pub use cholesky::Cholesky;
pub use conjugate_gradient::{ConjugateGradient, Settings};
pub use dynamic_relaxation::DynamicRelaxation;
pub use lbfgs::Lbfgs;
pub use method::{Method, Minimizer};
pub use newton::{Newton, SecondOrder};

use crate::geometry::Vector3;

/// A function of points to be minimized.
pub trait Problem {
    /// The value at `points`; its gradient goes to `gradient`, one vector per point.
    fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64;

    /// Curvature along a direction, `dᵀ H d`, at the points of the last evaluation. It may leave out
    /// what is negative: too large a curvature makes a step short, never wrong.
    fn curvature(&mut self, points: &[Vector3], direction: &[Vector3]) -> f64;

    /// An estimate of each point's diagonal of the Hessian, positive.
    fn diagonal(&self) -> &[f64];

    /// Shortens moves that the problem does not allow. Returns whether any was shortened.
    fn limit(&mut self, points: &[Vector3], moves: &mut [Vector3]) -> bool {
        let _ = (points, moves);
        false
    }
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// The observer found the goal reached.
    Converged,
    /// The evaluations that were granted are used up.
    Budget,
    /// No step along any descent direction lowers the value any more: rounding is reached.
    Stalled,
}

/// What an observer of a run sees after each accepted step.
pub struct Iterate<'a> {
    pub points: &'a [Vector3],
    pub gradient: &'a [Vector3],
    pub value: f64,
    pub evaluations: usize,
}

/// `Σ aᵢ · bᵢ`, summed in chunks of fixed size: the same on any number of threads.
pub fn dot(a: &[Vector3], b: &[Vector3]) -> f64 {
    use rayon::prelude::*;
    let partial = |(a, b): (&[Vector3], &[Vector3])| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
    if a.len() <= CHUNK {
        return partial((a, b));
    }
    let sums: Vec<f64> = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)).with_min_len(LEAST_CHUNKS).map(partial).collect();
    sums.iter().sum()
}

/// Points to a chunk of parallel work. Sums run over chunks in order, so that this number, unlike
/// the number of threads, is part of a result's bytes.
pub const CHUNK: usize = 2048;

/// Sums and differences of vectors are so cheap that another thread is not worth waking for fewer
/// chunks than this.
const LEAST_CHUNKS: usize = 4;

/// How often a step is halved before the direction is given up: to a millionth of its length.
const MOST_HALVINGS: usize = 20;
