//! Stitches: what draws sewn particles together before their seam is closed.
//!
//! A spring of no rest length has no strain, so stitches get a term of their own. Each pulls from a
//! length that is shortened step by step while the seams close,
//!
//! ```text
//!     E = ½ k s²                 with the lag  s = max(0, l - r)  up to a limit S
//!     E = k S (s - ½ S)          beyond, a constant pull                 (theory, equation 6)
//! ```
//!
//! so that all seams close at one pace, along straight lines, and none pulls so hard that cloth is
//! torn through cloth.

use crate::geometry::Vector3;

/// Lag at which a stitch stops pulling harder, m.
const LARGEST_LAG: f64 = 0.02;

/// All stitches of a level.
#[derive(Clone, Debug, Default)]
pub struct Stitches {
    pub pairs: Vec<[u32; 2]>,
    /// `r`, the length from which each pulls, m.
    pub lengths: Vec<f64>,
    /// `k`, N/m.
    pub stiffness: f64,
}

impl Stitches {
    pub fn new(pairs: Vec<[u32; 2]>) -> Self {
        let lengths = vec![0.0; pairs.len()];
        Self { pairs, lengths, stiffness: 0.0 }
    }

    /// Gap of each stitch, m.
    pub fn gaps(&self, positions: &[Vector3]) -> Vec<f64> {
        self.pairs.iter().map(|&[a, b]| (positions[b as usize] - positions[a as usize]).norm()).collect()
    }

    /// Adds the gradient, N, and returns the energy, J.
    pub fn evaluate(&self, positions: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let mut energy = 0.0;
        for (&[a, b], rest) in self.pairs.iter().zip(&self.lengths) {
            let span = positions[b as usize] - positions[a as usize];
            let length = span.norm();
            let lag = length - rest;
            if lag > 0.0 {
                let pulling = lag.min(LARGEST_LAG);
                energy += self.stiffness * pulling * (lag - 0.5 * pulling);
                let pull = span * (self.stiffness * pulling / length);
                gradient[a as usize] -= pull;
                gradient[b as usize] += pull;
            }
        }
        energy
    }

    /// A bound on `dᵀ H d`.
    pub fn curvature(&self, direction: &[Vector3]) -> f64 {
        let rate = |&[a, b]: &[u32; 2]| (direction[b as usize] - direction[a as usize]).norm_squared();
        self.stiffness * self.pairs.iter().map(rate).sum::<f64>()
    }

    /// Adds to each particle's diagonal, N/m.
    pub fn add_diagonal(&self, diagonal: &mut [f64]) {
        for &p in self.pairs.iter().flatten() {
            diagonal[p as usize] += self.stiffness;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_the_derivative_short_and_long() {
        let stitches = Stitches { pairs: vec![[0, 1]], lengths: vec![0.1], stiffness: 50.0 };
        for length in [0.09, 0.105, 0.119, 0.3] {
            let positions = |x: f64| vec![Vector3::zeros(), Vector3::new(0.6, 0.8, 0.0) * (length + x)];
            let mut gradient = vec![Vector3::zeros(); 2];
            stitches.evaluate(&positions(0.0), &mut gradient);
            let energy = |x: f64| stitches.evaluate(&positions(x), &mut [Vector3::zeros(); 2]);
            let slope = (energy(1e-6) - energy(-1e-6)) / 2e-6;
            let along = gradient[1].dot(&Vector3::new(0.6, 0.8, 0.0));
            assert!((slope - along).abs() < 1e-6 && (gradient[0] + gradient[1]).norm() < 1e-12);
        }
    }
}
