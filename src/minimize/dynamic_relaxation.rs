//! Dynamic relaxation: the points move like masses, and are stopped whenever they are fastest.
//!
//! After Underwood (1983) and Barnes (1999). The masses are no real ones: each is as large as the
//! stiffness at its point asks for, so that a time step of one is as long as stability allows. Steps are
//! those of leapfrog. At a peak of the kinetic energy the value is near its lowest for this swing; all
//! velocities are set to zero there, and the next swing begins ("kinetic damping").
//!
//! Each step costs one evaluation and needs no curvature. Between two stops a step may raise the value:
//! unlike the other minimizers this one promises only that what is gained is not given away, since value
//! and kinetic energy together do not grow. Where they do, the masses are too small: the step is
//! taken back and the masses are doubled. Moves that caps or limits shorten lose their momentum.
//!
//! Velocities and masses outlive a run, since a swing takes longer than the corrections of the problem
//! between two runs are apart.

use super::vectors::{add, capped};
use super::{CHUNK, Iterate, LEAST_CHUNKS, Problem, Settings, Termination};
use crate::geometry::Vector3;
use rayon::prelude::*;

/// Masses over the diagonal of the Hessian, at first and at least. A lattice of springs is stable from a half
/// on, but there its stiffest swings turn around in each step and do not die down; with twice that a stop
/// damps them at once, and soft swings take only √2 times as long.
const FIRST_MASS: f64 = 1.0;
/// The sum of value and kinetic energy may grow by this share of either before masses are doubled: rounding.
const ROUNDING: f64 = 1e-12;
/// Masses fall by this factor at each stop, to no less than the first: what was unstable may have been a
/// moment's stiff contact.
const LIGHTENING: f64 = 0.95;
/// How often masses are doubled without an accepted step in between, before the run is given up.
const MOST_DOUBLINGS: usize = 40;

/// A run's working memory and its state.
pub struct DynamicRelaxation {
    gradient: Vec<Vector3>,
    trial_gradient: Vec<Vector3>,
    /// Per step; the time step is one.
    velocities: Vec<Vector3>,
    moves: Vec<Vector3>,
    trial: Vec<Vector3>,
    /// Masses over the diagonal.
    mass: f64,
    /// Does the next step start from rest?
    resting: bool,
    /// Of the last step.
    kinetic: f64,
}

impl DynamicRelaxation {
    pub fn new(point_count: usize) -> Self {
        let zeros = || vec![Vector3::zeros(); point_count];
        Self {
            gradient: zeros(),
            trial_gradient: zeros(),
            velocities: zeros(),
            moves: zeros(),
            trial: zeros(),
            mass: FIRST_MASS,
            resting: true,
            kinetic: 0.0,
        }
    }

    /// Lowers `problem` from `points`, in place; like
    /// [`ConjugateGradient::run`](super::ConjugateGradient::run), but that steps may raise the value
    /// between two stops, and that `restart_after` has no meaning here. `done` is asked after each step.
    pub fn run(
        &mut self,
        problem: &mut impl Problem,
        points: &mut Vec<Vector3>,
        settings: &Settings,
        mut done: impl FnMut(&Iterate) -> bool,
    ) -> (Termination, f64, usize) {
        let mut value = problem.evaluate(points, &mut self.gradient);
        let mut evaluations = 1;
        let mut total = value + self.kinetic;
        let mut doublings = 0;
        loop {
            if done(&Iterate { points, gradient: &self.gradient, value, evaluations }) {
                return (Termination::Converged, value, evaluations);
            }
            loop {
                if evaluations >= settings.evaluations {
                    return (Termination::Budget, value, evaluations);
                }
                // From rest only half a step's velocity is gained.
                let gain = if self.resting { 0.5 } else { 1.0 };
                accelerate(&mut self.velocities, &self.gradient, problem.diagonal(), gain / self.mass);
                let shortened = capped(&self.velocities, 1.0, settings.largest_move, &mut self.moves);
                if problem.limit(points, &mut self.moves) || shortened {
                    self.velocities.copy_from_slice(&self.moves);
                }
                let kinetic = self.mass * energy(&self.velocities, problem.diagonal());
                if kinetic == 0.0 {
                    return (Termination::Stalled, value, evaluations);
                }
                add(points, &self.moves, &mut self.trial);
                let trial_value = problem.evaluate(&self.trial, &mut self.trial_gradient);
                evaluations += 1;
                // Not `>`, which what is not a number would pass.
                let stable = trial_value <= total + ROUNDING * total.abs().max(kinetic);
                if !stable {
                    self.stop();
                    total = value;
                    self.mass *= 2.0;
                    doublings += 1;
                    if doublings > MOST_DOUBLINGS {
                        return (Termination::Stalled, value, evaluations);
                    }
                    continue;
                }
                doublings = 0;
                let past_the_peak = kinetic < self.kinetic;
                // Of both ends of the step over the peak the lower is kept.
                if !past_the_peak || trial_value <= value {
                    value = trial_value;
                    std::mem::swap(points, &mut self.trial);
                    std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
                }
                if past_the_peak {
                    self.stop();
                    self.mass = (self.mass * LIGHTENING).max(FIRST_MASS);
                    total = value;
                } else {
                    self.resting = false;
                    self.kinetic = kinetic;
                }
                break;
            }
        }
    }

    fn stop(&mut self) {
        self.velocities.fill(Vector3::zeros());
        self.resting = true;
        self.kinetic = 0.0;
    }
}

/// `velocities -= factor * gradient / diagonal`.
fn accelerate(velocities: &mut [Vector3], gradient: &[Vector3], diagonal: &[f64], factor: f64) {
    let chunks = velocities.par_chunks_mut(CHUNK).zip(gradient.par_chunks(CHUNK)).zip(diagonal.par_chunks(CHUNK));
    chunks.with_min_len(LEAST_CHUNKS).for_each(|((velocities, gradient), diagonal)| {
        for ((v, g), d) in velocities.iter_mut().zip(gradient).zip(diagonal) {
            *v -= g * (factor / d);
        }
    });
}

/// `½ Σ dᵢ vᵢ²`, the kinetic energy for masses like the diagonal.
fn energy(velocities: &[Vector3], diagonal: &[f64]) -> f64 {
    let chunks = velocities.par_chunks(CHUNK).zip(diagonal.par_chunks(CHUNK)).with_min_len(LEAST_CHUNKS);
    let of = |(v, d): (&[Vector3], &[f64])| v.iter().zip(d).map(|(v, d)| 0.5 * d * v.norm_squared()).sum::<f64>();
    let sums: Vec<f64> = chunks.map(of).collect();
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::super::chain::{Chain, assert_budget_is_kept, assert_quadratic_is_solved, settings};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_quadratic_is_minimized_as_far_as_rounding_of_its_value_allows() {
        assert_quadratic_is_solved(400, |problem, points, settings, done| {
            DynamicRelaxation::new(points.len()).run(problem, points, settings, done)
        });
    }

    #[test]
    fn the_budget_is_kept() {
        assert_budget_is_kept(|problem, points, settings, done| {
            DynamicRelaxation::new(points.len()).run(problem, points, settings, done)
        });
    }

    #[test]
    fn too_small_masses_are_doubled_until_the_steps_are_stable() {
        let mut problem = Chain::new(20, 0.0);
        let mut minimizer = DynamicRelaxation { mass: 1e-4, ..DynamicRelaxation::new(20) };
        let mut points = vec![Vector3::zeros(); 20];
        let far = problem.evaluate(&points, &mut vec![Vector3::zeros(); 20]);
        let (_, value, _) = minimizer.run(&mut problem, &mut points, &settings(400, f64::INFINITY), |_| false);
        assert!(minimizer.mass > 0.1 && minimizer.mass < 4.0, "{}", minimizer.mass);
        assert!(value < 0.1 * far);
    }

    proptest! {
        #[test]
        fn what_a_swing_gained_is_not_given_away_and_no_point_moves_too_far(bend in 0.0..40.0f64, largest in 0.001..0.5f64, start in -2.0..2.0f64) {
            let mut points = vec![Vector3::repeat(start); 30];
            let mut before: Option<(f64, Vec<Vector3>)> = None;
            let mut problem = Chain::new(30, bend);
            let mut minimizer = DynamicRelaxation::new(30);
            // One swing after the other: where each stops is no higher than where it began.
            let first = problem.evaluate(&points, &mut vec![Vector3::zeros(); 30]);
            minimizer.run(&mut problem, &mut points, &settings(150, largest), |iterate| {
                if let Some((_, points)) = &before {
                    assert!(iterate.points.iter().zip(points).all(|(p, q)| (p - q).norm() < largest * (1.0 + 1e-12)));
                }
                assert!(iterate.value <= first + 1e-9 * first.abs(), "{} after {first}", iterate.value);
                before = Some((iterate.value, iterate.points.to_vec()));
                false
            });
        }
    }
}
