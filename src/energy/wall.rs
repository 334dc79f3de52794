//! Planes that push points of the cloth to their other side.

use crate::geometry::Vector3;

/// `E = ½ k max(0, (q - x)·n)²`: the point `x` of the cloth, the mean of two particles, is to come to the side of the
/// plane through `q` to which the unit vector `n` points (theory, equation 21). With one particle named twice it is that
/// particle.
#[derive(Clone, Copy, Debug)]
pub struct Wall {
    pub particles: [u32; 2],
    /// `q`, m, world.
    pub point: Vector3,
    /// `n`.
    pub normal: Vector3,
    /// `k`, N/m.
    pub stiffness: f64,
}

impl Wall {
    fn mean(&self, vectors: &[Vector3]) -> Vector3 {
        (vectors[self.particles[0] as usize] + vectors[self.particles[1] as usize]) * 0.5
    }

    /// How far the point is behind the plane, m, not negative.
    fn behind(&self, positions: &[Vector3]) -> f64 {
        (self.point - self.mean(positions)).dot(&self.normal).max(0.0)
    }

    /// Adds the gradient, N, and returns the energy, J.
    pub fn evaluate(&self, positions: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let behind = self.behind(positions);
        for p in self.particles {
            gradient[p as usize] -= self.normal * (0.5 * self.stiffness * behind);
        }
        0.5 * self.stiffness * behind * behind
    }

    /// `dᵀ H d`.
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3]) -> f64 {
        let pushes = self.behind(positions) > 0.0;
        if pushes { self.stiffness * self.normal.dot(&self.mean(direction)).powi(2) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_behind_is_pushed_and_what_is_in_front_is_left_alone() {
        let normal = Vector3::new(0.6, 0.8, 0.0);
        let wall = Wall { particles: [0, 1], point: Vector3::new(0.1, 0.0, 0.2), normal, stiffness: 30.0 };
        let at = |by: f64| vec![Vector3::new(-0.2, 0.1, 0.0), Vector3::new(0.1 + by, -0.1, 0.1)];
        let energy = |by: f64| wall.evaluate(&at(by), &mut [Vector3::zeros(); 2]);
        let mut gradient = vec![Vector3::zeros(); 2];
        assert!(wall.evaluate(&at(0.0), &mut gradient) > 0.0);
        let step = 1e-6;
        assert!(((energy(step) - energy(-step)) / (2.0 * step) - gradient[1].x).abs() < 1e-7);
        let along = [Vector3::zeros(), Vector3::x()];
        let second = (energy(1e-4) - 2.0 * energy(0.0) + energy(-1e-4)) / 1e-8;
        assert!((wall.curvature(&at(0.0), &along) / second - 1.0).abs() < 1e-5);
        assert_eq!((energy(2.0), wall.curvature(&at(2.0), &along)), (0.0, 0.0));
    }

    #[test]
    fn a_particle_named_twice_is_pushed_once() {
        let wall = Wall { particles: [0, 0], point: Vector3::zeros(), normal: Vector3::y(), stiffness: 10.0 };
        let mut gradient = vec![Vector3::zeros()];
        let energy = wall.evaluate(&[Vector3::new(0.0, -0.1, 0.0)], &mut gradient);
        assert!((energy - 0.05).abs() < 1e-15 && (gradient[0] + Vector3::y()).norm() < 1e-15);
        assert!((wall.curvature(&[Vector3::new(0.0, -0.1, 0.0)], &[Vector3::y()]) - 10.0).abs() < 1e-15);
    }
}
