//! What holds a garment that hangs from its waist: a band that goes along with the body.
//!
//! The fit keeps waist lines from sinking, as buttons would (theory, equation 12), and then leaves them to friction. A
//! simulator that starts there lets a skirt slip down the hips. Here each particle of the waist line has a ledge, where
//! it was at the hand-off, from which it cannot sink:
//!
//! ```text
//!     u · (x - a) ≥ 0,    a = c + R (x₀ - c₀),    u = R y                                   (theory, equation 29)
//! ```
//!
//! `R` and `c` are the rigid motion that comes nearest to that of the skin beside the waist line (Kabsch 1976): a band is
//! stiff, and skin that a leg lifts or folds moves it no more than on the average. Like the body's contact it acts on
//! velocities and is no spring: what hung in balance hangs on in it, at any step. Particles may rise, and move along the
//! band.

use super::surface::{Place, Surface};
use crate::geometry::Vector3;
use nalgebra::Matrix3;

/// Skin farther away than this is not beside the waist line, m.
const BESIDE: f64 = 0.12;
/// A particle that is below its ledge, as the body pushed it there, regains it at this speed, m/s.
const RECOVERY: f64 = 0.05;
/// Skin whose extent across its longest direction is a smaller share of it has no turn about that.
const FLAT: f64 = 1e-3;
/// Rounds of the singular value decomposition; it takes some ten.
const SVD_ROUNDS: usize = 100;

/// The waist line of one garment.
pub struct Waistband {
    particles: Vec<u32>,
    /// Places of the skin beside them, as far as there is some.
    skin: Vec<Place>,
    /// Where particles and skin were at the hand-off, m, world.
    start: Vec<Vector3>,
    skin_start: Vec<Vector3>,
    /// At the end of the step.
    up: Vector3,
    /// The least velocity along `up`, m/s, one per particle.
    least: Vec<f64>,
}

/// Moves `x` to `center + turn (x - from)`.
struct Rigid {
    turn: Matrix3<f64>,
    from: Vector3,
    center: Vector3,
}

impl Rigid {
    fn of(&self, x: Vector3) -> Vector3 {
        self.center + self.turn * (x - self.from)
    }
}

impl Waistband {
    /// Of particles at `positions`, m, where a fit left them on the surface. None if there is no skin beside them.
    pub fn new(surface: &Surface, positions: &[Vector3], particles: &[u32]) -> Option<Self> {
        let start: Vec<Vector3> = particles.iter().map(|&p| positions[p as usize]).collect();
        let skin: Vec<Place> = start.iter().filter_map(|x| surface.nearest(*x, BESIDE)).collect();
        (!skin.is_empty()).then(|| Self {
            particles: particles.to_vec(),
            skin_start: skin.iter().map(|place| place.point).collect(),
            skin,
            least: vec![f64::NEG_INFINITY; start.len()],
            start,
            up: Vector3::y(),
        })
    }

    /// Looks where the ledges will be after `step`, s, for particles that are now at `positions`, m.
    pub fn look(&mut self, surface: &Surface, positions: &[Vector3], step: f64) {
        let (now, then) = (self.motion(surface, 0.0), self.motion(surface, step));
        self.up = then.turn * Vector3::y();
        for ((&p, start), least) in self.particles.iter().zip(&self.start).zip(&mut self.least) {
            let (ledge_now, ledge) = (now.of(*start), then.of(*start));
            let needed = self.up.dot(&(ledge - positions[p as usize])) / step;
            *least = needed.min(self.up.dot(&(ledge - ledge_now)) / step + RECOVERY);
        }
    }

    /// Changes velocities, m/s, that lead below the ledges.
    pub fn hold(&self, velocities: &mut [Vector3]) {
        for (&p, least) in self.particles.iter().zip(&self.least) {
            let velocity = &mut velocities[p as usize];
            *velocity += self.up * (least - self.up.dot(velocity)).max(0.0);
        }
    }

    /// How the skin will have moved since the hand-off in so many seconds from now.
    fn motion(&self, surface: &Surface, ahead: f64) -> Rigid {
        let at = |place: &Place| surface.carried(place.point, place).point + surface.velocity(place) * ahead;
        let skin: Vec<Vector3> = self.skin.iter().map(at).collect();
        let mean = |points: &[Vector3]| points.iter().sum::<Vector3>() / points.len() as f64;
        let (from, center) = (mean(&self.skin_start), mean(&skin));
        let pairs = self.skin_start.iter().zip(&skin);
        let covariance = pairs.map(|(a, b)| (b - center) * (a - from).transpose()).sum();
        Rigid { turn: nearest_turn(covariance), from, center }
    }
}

/// The rotation `R` for which `tr(Rᵀ C)` is largest; none at all if points on a line leave it open.
fn nearest_turn(covariance: Matrix3<f64>) -> Matrix3<f64> {
    let Some(svd) = covariance.try_svd(true, true, f64::EPSILON, SVD_ROUNDS) else { return Matrix3::identity() };
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    // In descending order: what is least determined, across the ring of a waist, is what may have to be mirrored.
    let values = svd.singular_values;
    if values[1].is_nan() || values[1] <= FLAT * FLAT * values[0] {
        return Matrix3::identity();
    }
    let side = (u.determinant() * v_t.determinant()).signum();
    u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, side)) * v_t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shapes;
    use crate::dynamics::settings::BroadPhase;
    use nalgebra::Rotation3;

    /// A ring of particles around a ball, a millimetre off it, at the height of its middle.
    fn ring() -> (Surface, Vec<Vector3>) {
        let (positions, triangles) = shapes::sphere(Vector3::new(0.0, 1.0, 0.0), 0.15, 24);
        let on = |k: u32| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 40.0).sin_cos();
            Vector3::new(0.151 * sin, 1.0, 0.151 * cos)
        };
        (Surface::new(&positions, &triangles, BroadPhase::Tree), (0..40).map(on).collect())
    }

    const STEP: f64 = 1e-3;

    #[test]
    fn it_goes_along_with_a_body_that_turns_bends_and_jumps() {
        let (mut surface, start) = ring();
        let mut band = Waistband::new(&surface, &start, &(0..40).collect::<Vec<u32>>()).unwrap();
        let mut x = start.clone();
        let turn = Rotation3::from_euler_angles(0.6, 1.1, -0.4);
        let (center, shift) = (Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.3, 0.2, -0.1));
        let moved = |p: &Vector3, share: f64| center + turn.powf(share) * (p - center) + shift * share;
        let body = surface.positions().to_vec();
        let (frames, steps) = (20, 40);
        for frame in 1..=frames {
            let share = f64::from(frame) / f64::from(frames);
            let end: Vec<Vector3> = body.iter().map(|p| moved(p, share)).collect();
            surface.move_to(&end, f64::from(steps) * STEP);
            for step in 1..=steps {
                // It is carried by the skin, and gravity has pulled at it for a while.
                let mut v: Vec<Vector3> =
                    band.skin.iter().map(|place| surface.velocity(place) - Vector3::y() * 0.2).collect();
                band.look(&surface, &x, STEP);
                band.hold(&mut v);
                x.iter_mut().zip(&v).for_each(|(x, v)| *x += v * STEP);
                surface.advance(f64::from(step) / f64::from(steps));
            }
        }
        let up = turn * Vector3::y();
        for (p, x0) in x.iter().zip(&start) {
            let height = up.dot(&(p - moved(x0, 1.0)));
            assert!(height > -1e-4, "{height} m below the ledge");
        }
    }

    #[test]
    fn what_is_on_its_ledge_is_held_exactly_and_may_rise() {
        let (surface, start) = ring();
        let mut band = Waistband::new(&surface, &start, &[3, 7]).unwrap();
        let mut v = vec![Vector3::new(0.1, -0.3, 0.0); 40];
        v[7].y = 0.4;
        band.look(&surface, &start, STEP);
        band.hold(&mut v);
        assert!((v[3] - Vector3::new(0.1, 0.0, 0.0)).norm() < 1e-9, "{}", v[3]);
        assert_eq!((v[7].y, v[5].y), (0.4, -0.3));
    }

    #[test]
    fn a_line_of_skin_turns_nothing_and_no_skin_holds_nothing() {
        let along = Vector3::new(1.0, 2.0, 0.5);
        assert_eq!(nearest_turn(along * along.transpose()), Matrix3::identity());
        assert_eq!(nearest_turn(Matrix3::zeros()), Matrix3::identity());
        assert_eq!(nearest_turn(Matrix3::repeat(f64::NAN)), Matrix3::identity());
        let (surface, start) = ring();
        assert!(Waistband::new(&surface, &[start[0] * 9.0], &[0]).is_none());
    }
}
