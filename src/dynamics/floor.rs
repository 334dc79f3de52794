//! The ground that cloth falls on: a half-space below a height.
//!
//! Cloth meets it as it meets the body: at its clearance, with friction and rebound. It never moves, so that the
//! velocity that keeps the clearance is exact. Cloth that a fit left below it, as fits know no floor, comes up slowly;
//! where a sole presses cloth on the floor the body wins.

use super::integrator::for_all;
use crate::geometry::Vector3;

/// What is below the floor comes up at this speed, m/s: as fast as cloth settles.
const RISE: f64 = 0.15;
/// Impacts slower than this are no impacts, m/s: gravity over a step.
const SLOWEST_IMPACT: f64 = 0.05;

/// A floor, and what cloth does on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// m, world.
    pub height: f64,
    /// Distance to be kept from it, m.
    pub clearance: f64,
    pub friction: f64,
    /// Share of the speed of an impact that is kept, 0 to 1.
    pub restitution: f64,
}

impl Floor {
    /// The least velocity upwards that keeps the clearance, or leads back to it, m/s.
    fn least(&self, position: &Vector3, step: f64) -> f64 {
        ((self.height + self.clearance - position.y) / step).min(RISE)
    }

    /// Changes velocities, m/s, of particles at `positions`, m, so that after `step`, s, they are clear of the floor.
    pub fn respond(&self, positions: &[Vector3], velocities: &mut [Vector3], step: f64) {
        for_all(velocities, |p, velocity| {
            let (least, approach) = (self.least(&positions[p], step), velocity.y);
            if approach >= least {
                return;
            }
            let rebound = if approach < -SLOWEST_IMPACT { -self.restitution * approach } else { f64::NEG_INFINITY };
            let least = least.max(rebound);
            // Neither a rebound nor the way back to the clearance presses.
            let speed = velocity.x.hypot(velocity.z);
            let grip = (self.friction * (least.min(0.0) - approach).max(0.0)).min(speed);
            if speed > 0.0 {
                velocity.x *= 1.0 - grip / speed;
                velocity.z *= 1.0 - grip / speed;
            }
            velocity.y = least;
        });
    }

    /// Takes back what has been changed since in velocities, m/s, as far as it leads into the floor.
    pub fn hold_off(&self, positions: &[Vector3], velocities: &mut [Vector3], step: f64) {
        for_all(velocities, |p, velocity| velocity.y = velocity.y.max(self.least(&positions[p], step)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1e-3;
    const GRAVITY: f64 = 9.81;

    fn floor() -> Floor {
        Floor { height: -0.1, clearance: 0.001, friction: 0.3, restitution: 0.0 }
    }

    fn fall(floor: &Floor, start: Vector3, velocity: Vector3, steps: usize) -> Vec<Vector3> {
        let (mut x, mut v) = ([start], [velocity]);
        let path = (0..steps).map(|_| {
            v[0].y -= GRAVITY * STEP;
            floor.respond(&x, &mut v, STEP);
            x[0] += v[0] * STEP;
            x[0]
        });
        path.collect()
    }

    #[test]
    fn what_falls_on_the_floor_lies_at_its_clearance() {
        let path = fall(&floor(), Vector3::new(0.0, 0.3, 0.0), Vector3::zeros(), 600);
        assert!(path.iter().all(|p| p.y > -0.099 - 1e-12) && (path[599].y + 0.099).abs() < 1e-12, "{}", path[599]);
    }

    #[test]
    fn it_slides_as_coulomb_has_it_and_rebounds_by_its_share() {
        let path = fall(&floor(), Vector3::new(0.0, -0.099, 0.0), Vector3::new(1.0, 0.0, 0.0), 1000);
        let expected = 1.0 / (2.0 * 0.3 * GRAVITY);
        assert!((path[999].x / expected - 1.0).abs() < 0.02, "slid {} m, not {expected}", path[999].x);
        let lively = Floor { restitution: 0.5, clearance: 0.0, height: 0.0, ..floor() };
        let path = fall(&lively, Vector3::new(0.0, 0.2, 0.0), Vector3::zeros(), 450);
        let height = path[250..].iter().map(|p| p.y).fold(0.0, f64::max);
        assert!((height - 0.05).abs() < 0.01, "{height}");
    }

    #[test]
    fn what_a_fit_left_below_comes_up_slowly_and_stays() {
        let path = fall(&floor(), Vector3::new(0.0, -0.13, 0.0), Vector3::zeros(), 400);
        let fastest = path.windows(2).map(|two| (two[1].y - two[0].y) / STEP).fold(0.0, f64::max);
        assert!(fastest <= RISE * (1.0 + 1e-9) && (path[399].y + 0.099).abs() < 1e-12, "{fastest} {}", path[399]);
        let mut v = [Vector3::new(1.0, -2.0, 0.0)];
        floor().hold_off(&[Vector3::new(0.0, -0.099, 0.0)], &mut v, STEP);
        assert!((v[0] - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-9, "{}", v[0]);
    }
}
