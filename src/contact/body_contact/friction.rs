//! Friction with the body: Coulomb's, as a spring that holds so much and no more (theory, equation 10).

use super::correction::Turns;
use crate::geometry::Vector3;
use nalgebra::Matrix3;

/// Tangential stiffness of a sticking sample over its normal one. Softer than the normal one, as the
/// tangential direction is the one in which cloth has to settle.
pub const STICKING: f64 = 0.3;

/// Where a sample sticks, and how fast.
#[derive(Clone, Copy, Debug)]
pub struct Anchor {
    point: Vector3,
    normal: Vector3,
    /// The most it pulls, N; none while the sample is loose.
    limit: f32,
    turns: Turns,
}

impl Anchor {
    /// Of a sample that has come to touch.
    pub fn at(point: Vector3, normal: Vector3) -> Self {
        Self { point, normal, limit: 0.0, turns: Turns::default() }
    }

    /// The most it pulls, N.
    #[inline]
    fn limit(&self) -> f64 {
        f64::from(self.limit)
    }

    /// Energy and gradient of a sample that is `stiffness` bound, N/m: quadratic up to the limit,
    /// linear beyond.
    #[inline]
    pub fn pull(&self, position: Vector3, stiffness: f64) -> (f64, Vector3) {
        let span = tangential(position - self.point, self.normal);
        let (length, limit) = (span.norm(), self.limit());
        if length * stiffness <= limit {
            (0.5 * stiffness * length * length, span * stiffness)
        } else {
            (limit * (length - 0.5 * limit / stiffness), span * (limit / length))
        }
    }

    /// Its Hessian.
    #[inline]
    pub fn hessian(&self, position: Vector3, stiffness: f64) -> Matrix3<f64> {
        let span = tangential(position - self.point, self.normal);
        let (length, limit) = (span.norm(), self.limit());
        let plane = Matrix3::identity() - self.normal * self.normal.transpose();
        if length * stiffness <= limit {
            plane * stiffness
        } else {
            (plane - span * span.transpose() / (length * length)) * (limit / length)
        }
    }

    /// Learns where the sample is touched now, the normal and the most that friction holds there, N, and is dragged after a
    /// sample that is beyond the reach of its pull. What sticks keeps the normal that it has stuck with: in a crease of the
    /// body normals differ from one place to the next, and another plane to stick in leads to another place.
    pub fn follow(&mut self, position: Vector3, touch: Option<(Vector3, f64)>, stiffness: f64) {
        let (normal, limit) = touch.unwrap_or((self.normal, 0.0));
        if self.limit == 0.0 {
            (self.point, self.normal) = (position, normal);
        }
        self.limit = (self.limit() + self.turns.rein(limit - self.limit())) as f32;
        let span = tangential(position - self.point, self.normal);
        let slip = span.norm() - self.limit() / stiffness;
        if slip > 0.0 {
            self.point += span.normalize() * slip;
            self.normal = normal;
        }
    }
}

#[inline]
fn tangential(v: Vector3, normal: Vector3) -> Vector3 {
    v - normal * normal.dot(&v)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STIFFNESS: f64 = 100.0;

    #[test]
    fn an_anchor_holds_small_pulls_and_is_dragged_by_large_ones() {
        let mut anchor = Anchor::at(Vector3::zeros(), Vector3::y());
        anchor.follow(Vector3::zeros(), Some((Vector3::y(), 0.2)), STIFFNESS);
        let reach = 0.2 / STIFFNESS;
        for (distance, slip) in [(0.5 * reach, 0.0), (3.0 * reach, 2.0 * reach)] {
            let mut anchor = anchor;
            anchor.follow(Vector3::x() * distance, Some((Vector3::y(), 0.2)), STIFFNESS);
            assert!((anchor.point - Vector3::x() * slip).norm() < 1e-9);
        }
    }

    #[test]
    fn who_was_loose_sticks_where_it_touches_again() {
        let mut anchor = Anchor::at(Vector3::zeros(), Vector3::y());
        anchor.follow(Vector3::zeros(), Some((Vector3::y(), 0.2)), STIFFNESS);
        anchor.follow(Vector3::zeros(), None, STIFFNESS);
        let away = Vector3::x();
        assert_eq!(anchor.pull(away, STIFFNESS), (0.0, Vector3::zeros()));
        anchor.follow(away, Some((Vector3::y(), 0.2)), STIFFNESS);
        assert_eq!(anchor.pull(away, STIFFNESS), (0.0, Vector3::zeros()));
        assert!(anchor.pull(away * 1.001, STIFFNESS).1.x > 0.09);
    }

    /// A particle in an armpit went to and fro by half a millimetre, from where one side is nearer to where the other is.
    #[test]
    fn who_sticks_in_a_crease_sticks_in_one_plane() {
        let mut anchor = Anchor::at(Vector3::zeros(), Vector3::y());
        anchor.follow(Vector3::zeros(), Some((Vector3::y(), 0.2)), STIFFNESS);
        let (inside, beyond) = (Vector3::x() * 1e-3, Vector3::x() * 3e-3);
        let pull = anchor.pull(inside, STIFFNESS);
        anchor.follow(inside, Some((Vector3::x(), 0.2)), STIFFNESS);
        assert_eq!(anchor.pull(inside, STIFFNESS), pull);
        anchor.follow(beyond, Some((Vector3::z(), 0.2)), STIFFNESS);
        assert_eq!(anchor.pull(beyond + Vector3::z(), STIFFNESS), anchor.pull(beyond, STIFFNESS));
    }

    /// A sample at the border of contact was loose after one run and touched after the next, with a new anchor each time.
    #[test]
    fn who_is_loose_every_other_time_is_held_by_a_limit_that_settles() {
        let mut anchor = Anchor::at(Vector3::zeros(), Vector3::y());
        let mut change = |touch: Option<(Vector3, f64)>| {
            let before = anchor.limit();
            anchor.follow(Vector3::zeros(), touch, STIFFNESS);
            (anchor.limit() - before).abs()
        };
        for _ in 0..30 {
            change(Some((Vector3::y(), 0.2)));
            change(None);
        }
        assert!(change(Some((Vector3::y(), 0.2))) < 1e-6);
    }
}
