//! A start that is a little off, the same on every level.

use crate::Error;
use crate::geometry::Vector3;

/// A smooth random displacement of all space, of which cloth takes part: the same start, disturbed the
/// same way, for whatever levels a run has. It brings nothing through anything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perturbation {
    pub seed: u64,
    /// The farthest that a point is moved, m.
    pub amplitude: f64,
}

/// Above this, m, the displacement would no longer be one to one: its slope is 2π times amplitude over
/// the shortest wave.
pub const LARGEST_AMPLITUDE: f64 = 0.01;
/// Lengths of the waves, m: from a hand's breadth to a garment's.
const WAVES: [f64; 8] = [0.1, 0.13, 0.16, 0.2, 0.26, 0.32, 0.4, 0.5];

impl Perturbation {
    pub fn check(&self) -> Result<(), Error> {
        if (0.0..=LARGEST_AMPLITUDE).contains(&self.amplitude) {
            return Ok(());
        }
        Err(Error::new(
            format!("A perturbation of {} mm would fold the cloth.", self.amplitude * 1e3),
            format!("Give one of at most {} mm.", LARGEST_AMPLITUDE * 1e3),
        ))
    }

    /// Moves all positions, m, world.
    pub fn disturb(&self, positions: &mut [Vector3]) {
        let mut random = Random(self.seed);
        let share = self.amplitude / WAVES.len() as f64;
        let waves = WAVES.map(|length| {
            let along = random.direction() * (std::f64::consts::TAU / length);
            (along, random.direction() * share, std::f64::consts::TAU * random.unit())
        });
        for p in positions {
            *p += waves.iter().map(|(along, by, phase)| by * (along.dot(p) + phase).sin()).sum::<Vector3>();
        }
    }
}

/// Steele, Lea and Flood (2014), "SplitMix".
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From zero to one.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> Vector3 {
        loop {
            let v = Vector3::from_fn(|_, _| 2.0 * self.unit() - 1.0);
            // Points of the ball only, so that no direction is likelier.
            if v.norm_squared() <= 1.0 && v.norm() > 1e-3 {
                return v.normalize();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disturbance_is_as_large_as_asked_for_smooth_and_of_its_seed() {
        let start: Vec<Vector3> =
            (0..5000).map(|k| Vector3::new(1e-3 * f64::from(k % 100), 1e-3 * f64::from(k / 100), 0.3)).collect();
        let disturbed = |seed| {
            let mut positions = start.clone();
            Perturbation { seed, amplitude: LARGEST_AMPLITUDE }.disturb(&mut positions);
            positions
        };
        let (one, again, other) = (disturbed(1), disturbed(1), disturbed(2));
        assert!(one == again && one != other);
        let farthest = one.iter().zip(&start).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(farthest > 0.1 * LARGEST_AMPLITUDE && farthest <= LARGEST_AMPLITUDE, "{farthest}");
        // One to one: neighbours a millimetre apart stay apart.
        assert!(one.chunks(100).flat_map(|row| row.windows(2)).all(|w| (w[1] - w[0]).norm() > 3e-4));
        assert!(Perturbation { seed: 0, amplitude: 0.02 }.check().is_err());
    }
}
