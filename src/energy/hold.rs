//! Anchors that keep a part of a garment up while it is put on, and let go by schedule.

use crate::geometry::Vector3;

/// Keeps particles from sinking, on the average: `E = ½ k max(0, y₀ - ȳ)²` with their mean height `ȳ`
/// (theory, equation 12). They may move among themselves, and upwards.
#[derive(Clone, Debug)]
pub struct Hold {
    pub particles: Vec<u32>,
    /// `y₀`, m.
    pub height: f64,
    /// `k`, N/m.
    pub stiffness: f64,
}

impl Hold {
    /// How far the particles are too low, m, not negative.
    fn sunk(&self, positions: &[Vector3]) -> f64 {
        (self.height - self.mean(positions)).max(0.0)
    }

    fn mean(&self, vectors: &[Vector3]) -> f64 {
        self.particles.iter().map(|&p| vectors[p as usize].y).sum::<f64>() / self.particles.len() as f64
    }

    /// Adds the gradient, N, and returns the energy, J.
    pub fn evaluate(&self, positions: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let sunk = self.sunk(positions);
        let pull = self.stiffness * sunk / self.particles.len() as f64;
        for &p in &self.particles {
            gradient[p as usize].y -= pull;
        }
        0.5 * self.stiffness * sunk * sunk
    }

    /// Adds the Hessian times a direction.
    pub fn hessian_times(&self, positions: &[Vector3], direction: &[Vector3], product: &mut [Vector3]) {
        if self.sunk(positions) > 0.0 {
            let pull = self.stiffness * self.mean(direction) / self.particles.len() as f64;
            self.particles.iter().for_each(|&p| product[p as usize].y += pull);
        }
    }

    /// `dᵀ H d`.
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3]) -> f64 {
        if self.sunk(positions) > 0.0 { self.stiffness * self.mean(direction).powi(2) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sunken_particles_are_pulled_up_and_risen_ones_left_alone() {
        let hold = Hold { particles: vec![0, 2], height: 1.0, stiffness: 10.0 };
        let at = |y: f64| vec![Vector3::new(0.0, y, 0.0), Vector3::zeros(), Vector3::new(0.0, 0.9, 0.0)];
        let mut gradient = vec![Vector3::zeros(); 3];
        assert!(hold.evaluate(&at(0.9), &mut gradient) > 0.0);
        assert!(gradient[0].y < 0.0 && gradient[1] == Vector3::zeros());
        let energy = |y: f64| hold.evaluate(&at(y), &mut [Vector3::zeros(); 3]);
        assert!(((energy(0.9 + 1e-6) - energy(0.9 - 1e-6)) / 2e-6 - gradient[0].y).abs() < 1e-6);
        assert_eq!(energy(1.2), 0.0);
    }
}
