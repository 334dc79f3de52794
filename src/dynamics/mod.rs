//! Explicit dynamics: cloth that starts from a fitted garment and is moved through time.
//!
//! The particles, the energies and the contact of cloth with cloth are those of the fit; a step adds what only moving
//! things have:
//!
//! ```text
//!     velocities and moves by an integrator        integrator.rs, implicit.rs; forces in forces.rs, step in stability.rs
//!     velocities of waist lines and on the floor   waistband.rs, floor.rs
//!     velocities against the moving body           response.rs, surface.rs, broad_phase.rs (Kaynar Kabul 2004), depth_maps.rs
//!     edges stretched to their limit               super_elasticity.rs (Vassilev and Spanlang 2001)
//!     moves that lead through no cloth             contact::SelfContact
//!     what is in the body is put back              response.rs
//! ```
//!
//! What single panels do not run into stands in collisions.rs.
//!
//! A frame depends on the positions, the velocities, the body, and the little that contact remembers of each particle
//! (`Remembered`): all else is forgotten at its start, so that a simulation that was stopped between two frames goes on
//! with the same bytes.
//!
//! Not promised: that layers which a body squeezes together do not cross. The body wins.

mod broad_phase;
mod collisions;
mod depth_maps;
mod floor;
mod forces;
mod implicit;
mod integrator;
mod response;
mod rest;
mod settings;
mod sewing;
mod stability;
mod super_elasticity;
mod surface;
mod waistband;

pub use collisions::{Collide, Collisions};
pub use depth_maps::{Maps, Unsure};
pub use forces::Forces;
pub use integrator::Movement;
pub use response::{Met, Remembered};
pub use rest::{Resting, come_to_rest};
pub use settings::{BroadPhase, Integrator, MOVING_CLEARANCE, Settings};
pub use sewing::{Sewing, sew};
pub use stability::Pace;
pub use super_elasticity::SuperElasticity;
pub use surface::{Looked, Place, Surface};

use crate::energy::Model;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::CHUNK;
use crate::pattern::{Cut, Fabric};
use floor::Floor;
use implicit::Implicit;
use integrator::{Stepper, for_all};
use rayon::prelude::*;
use response::{Middles, Response};
use waistband::Waistband;

/// Cloth of one level that moves about a body.
pub struct Simulation {
    pub movement: Movement,
    forces: Forces,
    stepper: Stepper,
    elastic: SuperElasticity,
    response: Response,
    waistbands: Vec<Waistband>,
    floor: Option<Floor>,
    middles: Middles,
    /// Of the last step, J, while cloth settles.
    kinetic_energy: Option<f64>,
    velocities: Vec<Vector3>,
    moves: Vec<Vector3>,
    dampened: Vec<Vector3>,
}

/// What a frame, or any number of steps, was like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Course {
    pub steps: usize,
    pub evaluations: usize,
    /// Simulated, s.
    pub elapsed: f64,
    /// s.
    pub shortest_step: f64,
    /// m/s, of any particle at the end of any step.
    pub largest_speed: f64,
    /// Root mean square of all speeds at the end, m/s.
    pub rms_speed: f64,
    /// At the end.
    pub largest_strain: f64,
    /// Of the last step; the deepest of all steps.
    pub met: Met,
}

impl Simulation {
    /// Cloth that rests at `positions`, one per particle, m, world. Edges that are stretched beyond the fabric's limit
    /// there may stay so.
    pub fn new<'a>(
        level: &Level,
        cut: impl Into<Cut<'a>>,
        fabric: &Fabric,
        model: Model,
        settings: &Settings,
        positions: Vec<Vector3>,
    ) -> Self {
        let (count, cut) = (level.particle_count, cut.into());
        assert_eq!(positions.len(), count, "a position for each particle");
        let implicit =
            (settings.integrator == Integrator::Implicit).then(|| Implicit::new(level, cut, model, settings.drag));
        Self {
            forces: Forces::new(level, cut, fabric, model, settings, &positions),
            stepper: Stepper::new(settings, implicit, count),
            elastic: SuperElasticity::new(level, settings.stretch_limit, &positions),
            middles: Middles::new(level),
            kinetic_energy: None,
            response: Response::new(count, settings.clearance, fabric.friction, settings.restitution)
                .without(settings.collisions.free_of_body(level)),
            waistbands: Vec::new(),
            floor: settings.floor.map(|height| Floor {
                height,
                clearance: settings.clearance,
                friction: fabric.friction,
                restitution: settings.restitution,
            }),
            movement: Movement { positions, velocities: vec![Vector3::zeros(); count] },
            velocities: vec![Vector3::zeros(); count],
            moves: vec![Vector3::zeros(); count],
            dampened: vec![Vector3::zeros(); count],
        }
    }

    /// Holds some particles where they are.
    pub fn pin(&mut self, particles: &[u32]) {
        particles.iter().for_each(|&p| self.forces.pace.inertia[p as usize] = PINNED);
    }

    /// Largest strain of all edges.
    pub fn largest_strain(&self) -> f64 {
        self.elastic.largest_strain(&self.movement.positions)
    }

    /// The edge of the largest strain, by its ends, with the strain.
    pub fn most_stretched(&self) -> Option<([u32; 2], f64)> {
        self.elastic.most_stretched(&self.movement.positions)
    }

    /// Which particles the last step left between two skins that leave them no room, one for each: where limbs press each
    /// other, or the body passes through itself.
    pub fn pinched(&self) -> Vec<bool> {
        self.response.pinched()
    }

    pub fn forces(&mut self) -> &mut Forces {
        &mut self.forces
    }

    /// The step that the integrator would take, s.
    pub fn step_length(&self) -> f64 {
        self.stepper.step(&self.forces)
    }

    /// Starts from a fit on a body that is now where the surface is: what is held out farther than the clearance there is
    /// held so on.
    pub fn take_over(&mut self, surface: &Surface) {
        let mut gradient = vec![Vector3::zeros(); self.movement.positions.len()];
        self.forces.look_afresh(&self.movement.positions);
        self.forces.gradient(&self.movement.positions, &mut gradient);
        self.response.take_over(surface, &self.movement.positions, &gradient);
    }

    /// Keeps the waist line of a garment, its particles where they are now, from sinking along the surface, on which a fit
    /// has left them. A simulation that is gone on with has to hold it before it takes over where that stopped.
    pub fn hold_waist(&mut self, surface: &Surface, particles: &[u32]) {
        self.waistbands.extend(Waistband::new(surface, &self.movement.positions, particles));
    }

    /// What contact remembers: with the movement all that a later frame depends on.
    pub fn remembered(&self) -> Remembered {
        self.response.remembered()
    }

    pub fn remember(&mut self, remembered: &Remembered) {
        self.response.remember(remembered);
    }

    /// Forgets all that is not a function of the movement and of what is remembered.
    pub fn look_afresh(&mut self) {
        self.forces.look_afresh(&self.movement.positions);
        self.response.look_afresh();
        self.stepper.forget();
    }

    /// Moves on by `duration`, s, in which the body moves to the end of its frame.
    pub fn frame(&mut self, surface: &mut Surface, duration: f64) -> Course {
        self.look_afresh();
        self.run(surface, duration, |_| false)
    }

    /// Moves on by `duration`, s, in equal steps where the integrator leaves them equal, or until `done` says of a step
    /// that it was the last.
    pub fn run(&mut self, surface: &mut Surface, duration: f64, done: impl FnMut(&Course) -> bool + Send) -> Course {
        // Parallel work that is begun outside the pool wakes a thread and waits for it, each time.
        rayon::scope(|_| self.steps(surface, duration, done))
    }

    /// Lets cloth that a fit left nearly in balance find it, for `duration`, s, on a body that stands still: whenever
    /// the kinetic energy has passed a peak, all stand still (kinetic damping, Cundall 1976), and none is fast. What
    /// would have swung through the first frames of a shot does not begin to.
    pub fn settle(&mut self, surface: &mut Surface, duration: f64) -> Course {
        self.look_afresh();
        self.kinetic_energy = Some(0.0);
        let course = self.run(surface, duration, |_| false);
        self.kinetic_energy = None;
        self.movement.velocities.fill(Vector3::zeros());
        course
    }

    /// While cloth settles: stops all if the kinetic energy has passed a peak, and lets none be fast.
    fn slow_down(&mut self) {
        let Self { movement, forces, kinetic_energy: Some(last), .. } = self else { return };
        for_all(&mut movement.velocities, |_, v| *v *= (SETTLING_SPEED / v.norm()).min(1.0));
        let energy = kinetic_energy(&movement.velocities, &forces.pace.inertia);
        *last = if energy < *last {
            movement.velocities.fill(Vector3::zeros());
            0.0
        } else {
            energy
        };
    }

    fn steps(&mut self, surface: &mut Surface, duration: f64, mut done: impl FnMut(&Course) -> bool) -> Course {
        let before = self.stepper.evaluations;
        let mut course = Course { shortest_step: f64::INFINITY, ..Course::default() };
        let mut elapsed = 0.0;
        while elapsed < duration {
            let left = duration - elapsed;
            let wanted = left / (left / self.step_length()).ceil().max(1.0);
            let (step, met) = self.step(surface, wanted, (elapsed, duration));
            if course.steps % LOOK_BETWEEN == LOOK_BETWEEN / 2 {
                self.response.look_between(surface, &self.movement.positions, &self.middles);
            }
            elapsed = if duration - elapsed - step < SLIVER * duration { duration } else { elapsed + step };
            self.slow_down();
            let squared = self.movement.velocities.iter().map(|v| v.norm_squared());
            let largest = squared.fold(0.0, f64::max).sqrt();
            course.steps += 1;
            course.elapsed = elapsed;
            course.shortest_step = course.shortest_step.min(step);
            course.largest_speed = course.largest_speed.max(largest);
            course.met = Met { deepest: course.met.deepest.max(met.deepest), ..met };
            course.rms_speed = rms(&self.movement.velocities);
            if done(&course) {
                break;
            }
        }
        course.evaluations = self.stepper.evaluations - before;
        course.largest_strain = self.elastic.largest_strain(&self.movement.positions);
        course
    }

    /// One step of at most `step`, s, at a time within a frame of some duration; returns the step taken.
    fn step(&mut self, surface: &mut Surface, step: f64, (elapsed, duration): (f64, f64)) -> (f64, Met) {
        let Self {
            movement, forces, stepper, elastic, response, waistbands, floor, velocities, moves, dampened, ..
        } = self;
        let step = stepper.advance(forces, movement, step, velocities, moves);
        // Mean velocities over the step, which limits and contact act upon; what they change stays in the new ones.
        let mean = moves;
        for_all(mean, |_, m| *m /= step);
        forces.dampen(velocities, step, dampened);
        // Methods of higher order know where they are going: what viscosity takes away there would unsettle them.
        if stepper.moves_by_new_velocities() {
            for_all(mean, |p, m| *m += dampened[p] - velocities[p]);
        }
        for_all(velocities, |p, v| *v = dampened[p] - mean[p]);
        // The body has the last word.
        for band in &mut *waistbands {
            band.look(surface, &movement.positions, step);
            band.hold(mean);
        }
        if let Some(floor) = floor {
            floor.respond(&movement.positions, mean, step);
        }
        let met = response.respond(surface, &movement.positions, mean, step);
        // After friction: what limbs drag apart slips.
        let hold = |p: usize, velocity: &mut Vector3| response.hold(p, velocity);
        elastic.limit(&movement.positions, mean, &forces.pace.inertia, step, hold);
        waistbands.iter().for_each(|band| band.hold(mean));
        if let Some(floor) = floor {
            floor.hold_off(&movement.positions, mean, step);
        }
        response.hold_off(mean);
        for_all(mean, |_, m| *m *= step);
        if forces.limit(&movement.positions, mean) {
            // Neither does cloth that is drawn along by cloth tear its neighbours.
            for_all(mean, |_, m| *m /= step);
            elastic.limit(&movement.positions, mean, &forces.pace.inertia, step, hold);
            for_all(mean, |_, m| *m *= step);
        }
        for_all(velocities, |p, v| *v += mean[p] / step);
        for_all(&mut movement.positions, |p, x| *x += mean[p]);
        movement.velocities.copy_from_slice(velocities);
        surface.advance((elapsed + step) / duration);
        let back = response.put_back(surface, &mut movement.positions, &mut movement.velocities, step);
        (step, Met { interfering: back.interfering, deepest: back.deepest, ..met })
    }
}

/// The most that a particle moves at while cloth settles, m/s.
const SETTLING_SPEED: f64 = 0.15;
/// Steps from one look at the cloth between the particles to the next.
const LOOK_BETWEEN: usize = 64;
/// Inertia of what is held, kg: no force moves it by what shows in an f64.
const PINNED: f64 = 1e18;
/// What is left of a frame is no step of its own if it is a smaller share.
const SLIVER: f64 = 1e-9;

/// Root mean square of lengths.
fn rms(vectors: &[Vector3]) -> f64 {
    let chunks = vectors.par_chunks(CHUNK).map(|chunk| chunk.iter().map(|v| v.norm_squared()).sum());
    (sum(chunks) / vectors.len().max(1) as f64).sqrt()
}

/// J, of velocities, m/s, and inertia, kg.
fn kinetic_energy(velocities: &[Vector3], inertia: &[f64]) -> f64 {
    let chunks = velocities.par_chunks(CHUNK).zip(inertia.par_chunks(CHUNK));
    sum(chunks.map(|(v, m)| v.iter().zip(m).map(|(v, m)| 0.5 * m * v.norm_squared()).sum()))
}

/// Sums over chunks of a fixed size are added up in their order, so that threads change nothing.
fn sum(chunks: impl IndexedParallelIterator<Item = f64>) -> f64 {
    chunks.collect::<Vec<f64>>().iter().sum()
}

#[cfg(test)]
mod tests;
