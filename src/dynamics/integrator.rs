//! Carrying positions and velocities over one step.
//!
//! An integrator knows forces alone; contact and limits then change the velocities that it found (`mod.rs`), so that
//! all of them treat the body in the same way.

use super::forces::Forces;
use super::implicit::Implicit;
use super::settings::{Integrator, Settings};
use crate::geometry::Vector3;
use crate::minimize::CHUNK;
use rayon::prelude::*;

/// Where cloth is, m, and how it moves, m/s; one per particle.
#[derive(Clone, Debug, PartialEq)]
pub struct Movement {
    pub positions: Vec<Vector3>,
    pub velocities: Vec<Vector3>,
}

/// An integrator with its working memory.
pub struct Stepper {
    integrator: Integrator,
    implicit: Option<Implicit>,
    implicit_step: f64,
    tolerance: f64,
    /// What the error of the last step suggests for the next, s.
    suggested: Option<f64>,
    /// One per stage: rates of positions and of velocities.
    stages: Vec<[Vec<Vector3>; 2]>,
    at: Movement,
    pub evaluations: usize,
}

/// Tableau of an explicit Runge-Kutta method: for each stage the shares of the stages before.
type Tableau = &'static [&'static [f64]];

const EULER: Tableau = &[&[]];
const MIDPOINT: Tableau = &[&[], &[0.5]];
const CLASSICAL: Tableau = &[&[], &[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]];
const CLASSICAL_WEIGHTS: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];
/// Fehlberg, *Low-order classical Runge-Kutta formulas with stepsize control* (1969), table III.
const FEHLBERG: Tableau = &[
    &[],
    &[1.0 / 4.0],
    &[3.0 / 32.0, 9.0 / 32.0],
    &[1932.0 / 2197.0, -7200.0 / 2197.0, 7296.0 / 2197.0],
    &[439.0 / 216.0, -8.0, 3680.0 / 513.0, -845.0 / 4104.0],
    &[-8.0 / 27.0, 2.0, -3544.0 / 2565.0, 1859.0 / 4104.0, -11.0 / 40.0],
];
const FEHLBERG_WEIGHTS: [f64; 6] = [16.0 / 135.0, 0.0, 6656.0 / 12825.0, 28561.0 / 56430.0, -9.0 / 50.0, 2.0 / 55.0];
/// The fifth order's weights less the fourth's.
const FEHLBERG_ERROR: [f64; 6] = [1.0 / 360.0, 0.0, -128.0 / 4275.0, -2197.0 / 75240.0, 1.0 / 50.0, 2.0 / 55.0];
/// A step is chosen shorter than its error allows.
const CAUTION: f64 = 0.9;
/// Steps do not change by more than this from one to the next.
const CHANGE: [f64; 2] = [0.2, 2.0];
/// A step that was refused so often is taken as it is.
const MOST_REFUSALS: usize = 12;
/// Steps of higher order over those of the symplectic method, which keeps the energy of the fastest vibrations up to its
/// limit: they are stable for longer ones, but take that energy away, or add to it (the midpoint rule).
const STRETCH_CLASSICAL: f64 = 0.8;
const STRETCH_MIDPOINT: f64 = 0.5;
/// The longest step of Fehlberg's method over the symplectic one.
const STRETCH_FEHLBERG: f64 = 0.8;

impl Stepper {
    pub fn new(settings: &Settings, implicit: Option<Implicit>, particles: usize) -> Self {
        let zeros = || vec![Vector3::zeros(); particles];
        let stages = match settings.integrator {
            Integrator::SymplecticEuler | Integrator::Implicit => 1,
            Integrator::Midpoint => MIDPOINT.len(),
            Integrator::RungeKutta4 => CLASSICAL.len(),
            Integrator::RungeKuttaFehlberg => FEHLBERG.len(),
        };
        Self {
            integrator: settings.integrator,
            implicit,
            implicit_step: settings.implicit_step,
            tolerance: settings.tolerance,
            suggested: None,
            stages: (0..stages).map(|_| [zeros(), zeros()]).collect(),
            at: Movement { positions: zeros(), velocities: zeros() },
            evaluations: 0,
        }
    }

    /// The step that this integrator would take, s.
    pub fn step(&self, forces: &Forces) -> f64 {
        let stable = forces.pace.step;
        match self.integrator {
            Integrator::SymplecticEuler => stable,
            Integrator::Midpoint => STRETCH_MIDPOINT * stable,
            Integrator::RungeKutta4 => STRETCH_CLASSICAL * stable,
            Integrator::RungeKuttaFehlberg => self.suggested.unwrap_or(stable),
            Integrator::Implicit => self.implicit_step,
        }
    }

    /// Are the moves of a step its new velocities times its length?
    pub fn moves_by_new_velocities(&self) -> bool {
        matches!(self.integrator, Integrator::SymplecticEuler | Integrator::Implicit)
    }

    /// Forgets what the last steps suggested: what follows depends on the movement alone.
    pub fn forget(&mut self) {
        self.suggested = None;
    }

    /// New velocities and the moves that lead to new positions, for a step of at most `step`, s; returns the step taken.
    pub fn advance(
        &mut self,
        forces: &mut Forces,
        movement: &Movement,
        step: f64,
        velocities: &mut [Vector3],
        moves: &mut [Vector3],
    ) -> f64 {
        match self.integrator {
            Integrator::SymplecticEuler => {
                self.evaluate(forces, movement, EULER, step);
                let rates = &self.stages[0][1];
                for_all(velocities, |p, v| *v = movement.velocities[p] + rates[p] * step);
                for_all(moves, |p, m| *m = velocities[p] * step);
                step
            }
            Integrator::Midpoint => {
                self.evaluate(forces, movement, MIDPOINT, step);
                self.sum(movement, &[0.0, 1.0], step, velocities, moves);
                step
            }
            Integrator::RungeKutta4 => {
                self.evaluate(forces, movement, CLASSICAL, step);
                self.sum(movement, &CLASSICAL_WEIGHTS, step, velocities, moves);
                step
            }
            Integrator::RungeKuttaFehlberg => {
                let mut step = step;
                for _ in 0..MOST_REFUSALS {
                    self.evaluate(forces, movement, FEHLBERG, step);
                    let error = self.error(step);
                    let factor = CAUTION * (self.tolerance / error.max(f64::MIN_POSITIVE)).powf(0.2);
                    let next = step * factor.clamp(CHANGE[0], CHANGE[1]);
                    self.suggested = Some(next.min(STRETCH_FEHLBERG * forces.pace.step));
                    if error <= self.tolerance {
                        break;
                    }
                    step = next;
                }
                self.sum(movement, &FEHLBERG_WEIGHTS, step, velocities, moves);
                step
            }
            Integrator::Implicit => {
                let rates = &mut self.stages[0][1];
                forces.accelerations(&movement.positions, &movement.velocities, rates);
                self.evaluations += 1;
                let implicit = self.implicit.as_mut().expect("an implicit integrator has its matrix");
                implicit.velocities(forces, movement, rates, step, velocities);
                for_all(moves, |p, m| *m = velocities[p] * step);
                step
            }
        }
    }

    /// Rates at all stages.
    fn evaluate(&mut self, forces: &mut Forces, movement: &Movement, tableau: Tableau, step: f64) {
        for (stage, shares) in tableau.iter().enumerate() {
            let (before, now) = self.stages.split_at_mut(stage);
            let Movement { positions, velocities } = &mut self.at;
            let at = |of: usize, from: &[Vector3], p: usize| {
                let moved: Vector3 = before.iter().zip(*shares).map(|(rates, share)| rates[of][p] * *share).sum();
                from[p] + moved * step
            };
            for_all(positions, |p, x| *x = at(0, &movement.positions, p));
            for_all(velocities, |p, v| *v = at(1, &movement.velocities, p));
            let [of_positions, of_velocities] = &mut now[0];
            of_positions.copy_from_slice(velocities);
            forces.accelerations(positions, velocities, of_velocities);
            self.evaluations += 1;
        }
    }

    fn sum(&self, movement: &Movement, weights: &[f64], step: f64, velocities: &mut [Vector3], moves: &mut [Vector3]) {
        let rate =
            |of: usize, p: usize| -> Vector3 { self.stages.iter().zip(weights).map(|(s, w)| s[of][p] * *w).sum() };
        for_all(velocities, |p, v| *v = movement.velocities[p] + rate(1, p) * step);
        for_all(moves, |p, m| *m = rate(0, p) * step);
    }

    /// The largest difference between the positions of fourth and of fifth order, m.
    fn error(&self, step: f64) -> f64 {
        let count = self.at.positions.len();
        let of = |p: usize| -> f64 {
            let error: Vector3 = self.stages.iter().zip(FEHLBERG_ERROR).map(|(s, w)| s[0][p] * w).sum();
            error.norm() * step
        };
        (0..count).into_par_iter().map(of).reduce(|| 0.0, f64::max)
    }
}

/// Waking a thread takes as long as so many sums.
const FEW: usize = 12_000;

/// Calls `set` with every index and element.
pub fn for_all(values: &mut [Vector3], set: impl Fn(usize, &mut Vector3) + Sync) {
    if values.len() < FEW {
        return values.iter_mut().enumerate().for_each(|(k, value)| set(k, value));
    }
    values.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, values)| {
        values.iter_mut().enumerate().for_each(|(k, value)| set(chunk * CHUNK + k, value));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_a_step_sum_to_one_and_stages_are_within_it() {
        for weights in [&CLASSICAL_WEIGHTS[..], &FEHLBERG_WEIGHTS[..]] {
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        }
        assert!(FEHLBERG_ERROR.iter().sum::<f64>().abs() < 1e-15);
        let fractions: Vec<f64> = FEHLBERG.iter().map(|shares| shares.iter().sum()).collect();
        for (ours, exact) in fractions.iter().zip([0.0, 0.25, 0.375, 12.0 / 13.0, 1.0, 0.5]) {
            assert!((ours - exact).abs() < 1e-14, "{fractions:?}");
        }
    }
}
