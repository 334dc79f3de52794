//! Rigid motions of panels.

use crate::geometry::Vector3;
use nalgebra::Rotation3;

/// A turn and a shift: `x ↦ R x + t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    pub turn: Rotation3<f64>,
    /// m.
    pub shift: Vector3,
}

impl Motion {
    pub fn none() -> Self {
        Self { turn: Rotation3::identity(), shift: Vector3::zeros() }
    }

    pub fn of(&self, point: Vector3) -> Vector3 {
        self.turn * point + self.shift
    }

    /// The point that this motion brings to `point`.
    pub fn before(&self, point: Vector3) -> Vector3 {
        self.turn.inverse_transform_vector(&(point - self.shift))
    }

    /// This motion, then a turn about `center` and a shift.
    pub fn then(&self, turn: Rotation3<f64>, center: Vector3, by: Vector3) -> Self {
        Self { turn: turn * self.turn, shift: turn * (self.shift - center) + center + by }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_compose_and_invert() {
        let center = Vector3::new(0.3, 1.0, 0.2);
        let (turn, back) = (Rotation3::new(Vector3::new(0.1, 0.2, -0.1)), Rotation3::new(Vector3::z() * -0.5));
        let motion = Motion::none().then(turn, center, Vector3::new(0.1, 0.0, 0.0)).then(back, center, Vector3::y());
        let point = Vector3::new(-0.2, 0.7, 0.4);
        assert!((motion.before(motion.of(point)) - point).norm() < 1e-15);
        let once = Motion::none().then(turn, center, Vector3::new(0.1, 0.0, 0.0)).of(point);
        let twice = back * (once - center) + center + Vector3::y();
        assert!((motion.of(point) - twice).norm() < 1e-15);
    }
}
