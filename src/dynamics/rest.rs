//! How long cloth takes to come to rest.

use super::{Course, Simulation, Surface};

/// Cloth is at rest when its speeds have stayed below this, rms, m/s.
pub const RESTING_SPEED: f64 = 1e-3;
/// For so long, s: what swings stands still at its turning points.
pub const RESTING_TIME: f64 = 0.05;

/// How a simulation came to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resting {
    /// Steps until the speeds fell below the resting speed for good, or all steps if they did not.
    pub steps: usize,
    /// Simulated, s.
    pub time: f64,
    pub at_rest: bool,
    /// m/s, of any particle while it settled.
    pub settling_speed: f64,
    /// m/s, of any particle in the first tenth of a second after that.
    pub first_speed: f64,
    /// m/s, rms at the end.
    pub last_speed: f64,
}

/// How long the first moments last, s.
const FIRST: f64 = 0.1;

/// Settles for `settle` seconds, then runs until the cloth is at rest on a body that is still, or for `most` seconds.
pub fn come_to_rest(simulation: &mut Simulation, surface: &mut Surface, settle: f64, most: f64) -> Resting {
    let (mut steps, mut time, mut last, mut first_speed) = (0, 0.0, 0.0, 0.0f64);
    let mut resting_since = None::<(usize, f64)>;
    let settled = simulation.settle(surface, settle);
    simulation.look_afresh();
    simulation.run(surface, most, |course: &Course| {
        (steps, time) = (settled.steps + course.steps, settled.elapsed + course.elapsed);
        if course.elapsed <= FIRST {
            first_speed = first_speed.max(course.largest_speed);
        }
        last = course.rms_speed;
        resting_since = (last < RESTING_SPEED).then(|| resting_since.unwrap_or((steps, time)));
        resting_since.is_some_and(|(_, since)| time - since >= RESTING_TIME)
    });
    let at_rest = resting_since.is_some();
    let (steps, time) = resting_since.unwrap_or((steps, time));
    Resting { steps, time, at_rest, settling_speed: settled.largest_speed, first_speed, last_speed: last }
}
