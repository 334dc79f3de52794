//! Nonlinear conjugate gradients, written in place.
//!
//! Polak and Ribière's formula, cut off at zero so that it restarts by itself (Gilbert and Nocedal
//! 1992), a diagonal preconditioner, and a step from the exact curvature along the direction (Le
//! Thanh and Gagalowicz 2007, section 3) instead of a line search. A step that raises the value is
//! taken back and halved, so accepted steps never raise it. Moves are capped point by point; a
//! capped step has left the direction, and the next one starts afresh.

use super::vectors::add;
use super::{CHUNK, Iterate, LEAST_CHUNKS, Problem, Termination};
use crate::geometry::Vector3;
use rayon::prelude::*;

/// How a run of conjugate gradients proceeds.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Evaluations of value and gradient that may be spent.
    pub evaluations: usize,
    /// The farthest that a point may move in one step, in the unit of the points.
    pub largest_move: f64,
    /// Steps after which the direction is the gradient again.
    pub restart_after: usize,
}

/// A run's working memory and its state.
pub struct ConjugateGradient {
    gradient: Vec<Vector3>,
    direction: Vec<Vector3>,
    trial: Vec<Vector3>,
    /// The moves that lead to the trial, until it is evaluated.
    trial_gradient: Vec<Vector3>,
}

impl ConjugateGradient {
    pub fn new(point_count: usize) -> Self {
        let zeros = || vec![Vector3::zeros(); point_count];
        Self { gradient: zeros(), direction: zeros(), trial: zeros(), trial_gradient: zeros() }
    }

    /// What is first written in a run, and not read before.
    pub fn spare(&mut self) -> &mut Vec<Vector3> {
        &mut self.trial_gradient
    }

    /// Lowers `problem` from `points`, in place. `done` is asked after each accepted step whether the
    /// goal is reached. Returns why the run ended, the last value, and the evaluations spent.
    pub fn run(
        &mut self,
        problem: &mut impl Problem,
        points: &mut Vec<Vector3>,
        settings: &Settings,
        mut done: impl FnMut(&Iterate) -> bool,
    ) -> (Termination, f64, usize) {
        let mut value = problem.evaluate(points, &mut self.gradient);
        let mut evaluations = 1;
        let mut since_restart = 0;
        let mut along = Along::default();
        loop {
            if done(&Iterate { points, gradient: &self.gradient, value, evaluations }) {
                return (Termination::Converged, value, evaluations);
            }
            if since_restart == 0 || along.slope >= 0.0 {
                along = steepest(&self.gradient, problem.diagonal(), &mut self.direction);
                since_restart = 0;
            }
            if along.slope >= 0.0 {
                return (Termination::Stalled, value, evaluations);
            }
            let curvature = problem.curvature(points, &self.direction);
            let mut step = if curvature > 0.0 { -along.slope / curvature } else { 1.0 };
            let mut halvings = 0;
            let shortened = loop {
                if evaluations >= settings.evaluations {
                    return (Termination::Budget, value, evaluations);
                }
                let moves = &mut self.trial_gradient;
                let capped = move_on(points, &self.direction, step, settings.largest_move, moves, &mut self.trial);
                let limited = problem.limit(points, moves);
                if limited {
                    add(points, moves, &mut self.trial);
                }
                let trial_value = problem.evaluate(&self.trial, &mut self.trial_gradient);
                evaluations += 1;
                // Equal values are accepted: near the bottom rounding hides the descent.
                if trial_value <= value {
                    value = trial_value;
                    std::mem::swap(points, &mut self.trial);
                    break capped || limited;
                }
                step *= 0.5;
                halvings += 1;
                if halvings > MOST_HALVINGS {
                    if since_restart == 0 {
                        return (Termination::Stalled, value, evaluations);
                    }
                    self.trial_gradient.copy_from_slice(&self.gradient);
                    break true;
                }
            };
            since_restart += 1;
            if shortened || since_restart >= settings.restart_after || halvings > 0 {
                since_restart = 0;
                std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
                continue;
            }
            along = self.advance(problem.diagonal(), along.gz);
        }
    }

    /// The next direction: `d ← -z + β d` with `z = g / diagonal` and `β = max(0, z·(g - g_old)) / (g_old·z_old)`.
    fn advance(&mut self, diagonal: &[f64], gz_old: f64) -> Along {
        let (new, old) = (&self.trial_gradient, &self.gradient);
        let chunks = new.par_chunks(CHUNK).zip(old.par_chunks(CHUNK)).zip(diagonal.par_chunks(CHUNK));
        let sums = chunks.with_min_len(LEAST_CHUNKS).map(|((new, old), diagonal)| {
            let mut sums = (0.0, 0.0);
            for ((new, old), d) in new.iter().zip(old).zip(diagonal) {
                let inverse = 1.0 / d;
                sums.0 += new.norm_squared() * inverse;
                sums.1 += new.dot(old) * inverse;
            }
            sums
        });
        let (gz, mixed) = in_order(sums);
        let beta = if gz_old > 0.0 { ((gz - mixed) / gz_old).max(0.0) } else { 0.0 };
        let chunks = self.direction.par_chunks_mut(CHUNK).zip(new.par_chunks(CHUNK)).zip(diagonal.par_chunks(CHUNK));
        let slopes = chunks.with_min_len(LEAST_CHUNKS).map(|((direction, new), diagonal)| {
            let mut slope = 0.0;
            for ((direction, new), d) in direction.iter_mut().zip(new).zip(diagonal) {
                *direction = *direction * beta - new * (1.0 / d);
                slope += direction.dot(new);
            }
            (slope, 0.0)
        });
        let (slope, _) = in_order(slopes);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        Along { gz, slope }
    }
}

/// Of a gradient and the direction that was made of it.
#[derive(Clone, Copy, Default)]
struct Along {
    /// `g·g / diagonal`.
    gz: f64,
    /// `g·d`.
    slope: f64,
}

/// How often a step is halved before the direction is given up: to a millionth of its length.
const MOST_HALVINGS: usize = 20;

/// Sums of pairs, added in the order of their chunks.
fn in_order(sums: impl IndexedParallelIterator<Item = (f64, f64)>) -> (f64, f64) {
    let sums: Vec<(f64, f64)> = sums.collect();
    sums.into_iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
}

/// `d = -g / diagonal`.
fn steepest(gradient: &[Vector3], diagonal: &[f64], direction: &mut [Vector3]) -> Along {
    let chunks = direction.par_chunks_mut(CHUNK).zip(gradient.par_chunks(CHUNK)).zip(diagonal.par_chunks(CHUNK));
    let sums = chunks.with_min_len(LEAST_CHUNKS).map(|((direction, gradient), diagonal)| {
        let mut sum = 0.0;
        for ((direction, gradient), d) in direction.iter_mut().zip(gradient).zip(diagonal) {
            *direction = -gradient * (1.0 / d);
            sum -= gradient.dot(direction);
        }
        (sum, 0.0)
    });
    let (gz, _) = in_order(sums);
    Along { gz, slope: -gz }
}

/// `moves = step * direction`, none longer than `largest`, and `trial = points + moves`; tells whether
/// any was longer.
fn move_on(
    points: &[Vector3],
    direction: &[Vector3],
    step: f64,
    largest: f64,
    moves: &mut [Vector3],
    trial: &mut [Vector3],
) -> bool {
    let chunks = moves.par_chunks_mut(CHUNK).zip(trial.par_chunks_mut(CHUNK));
    let chunks = chunks.zip(direction.par_chunks(CHUNK)).zip(points.par_chunks(CHUNK)).with_min_len(LEAST_CHUNKS);
    let chunks = chunks.map(|(((moves, trial), direction), points)| {
        let mut capped = false;
        for (((m, t), d), p) in moves.iter_mut().zip(trial).zip(direction).zip(points) {
            *m = d * step;
            // Few are too long: the root is left to them.
            if m.norm_squared() > largest * largest {
                *m *= largest / m.norm();
                capped = true;
            }
            *t = p + *m;
        }
        capped
    });
    chunks.reduce(|| false, |a, b| a || b)
}

#[cfg(test)]
mod tests {
    use super::super::chain::{Chain, settings};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_quadratic_is_minimized_as_far_as_rounding_of_its_value_allows() {
        let mut problem = Chain::new(60, 0.0);
        let mut points = vec![Vector3::zeros(); 60];
        // A gradient of g promises a descent of g²/2k, which must be visible beside a value of a thousand.
        let small = |i: &Iterate| i.gradient.iter().all(|g| g.norm() < 1e-5);
        let (termination, value, evaluations) =
            ConjugateGradient::new(60).run(&mut problem, &mut points, &settings(500, f64::INFINITY), small);
        assert_eq!(termination, Termination::Converged);
        assert!(evaluations < 120, "{evaluations} evaluations for a well preconditioned quadratic");
        let mut gradient = vec![Vector3::zeros(); 60];
        assert_eq!(problem.evaluate(&points, &mut gradient), value);
        assert!(gradient.iter().all(|g| g.norm() < 1e-5));
    }

    #[test]
    fn the_minimum_stalls_or_converges_but_is_not_left() {
        let mut problem = Chain::new(10, 0.0);
        let mut points = vec![Vector3::zeros(); 10];
        let mut minimizer = ConjugateGradient::new(10);
        let (_, value, _) = minimizer.run(&mut problem, &mut points, &settings(400, f64::INFINITY), |_| false);
        let found = points.clone();
        let (_, again, spent) = minimizer.run(&mut problem, &mut points, &settings(400, f64::INFINITY), |_| false);
        assert!(again <= value && spent <= 400);
        assert!(points.iter().zip(&found).all(|(p, q)| (p - q).norm() < 1e-6));
    }

    #[test]
    fn the_budget_is_kept() {
        for budget in [1, 2, 7] {
            let mut points = vec![Vector3::zeros(); 20];
            let run =
                ConjugateGradient::new(20)
                    .run(&mut Chain::new(20, 3.0), &mut points, &settings(budget, 0.01), |_| false);
            assert_eq!((run.0, run.2), (Termination::Budget, budget));
        }
    }

    proptest! {
        #[test]
        fn an_accepted_step_never_raises_the_value_nor_moves_too_far(bend in 0.0..40.0f64, largest in 0.001..0.5f64, start in -2.0..2.0f64) {
            let mut points = vec![Vector3::repeat(start); 30];
            let mut before: Option<(f64, Vec<Vector3>)> = None;
            ConjugateGradient::new(30).run(&mut Chain::new(30, bend), &mut points, &settings(150, largest), |iterate| {
                if let Some((value, points)) = &before {
                    assert!(iterate.value <= *value, "{} after {value}", iterate.value);
                    assert!(iterate.points.iter().zip(points).all(|(p, q)| (p - q).norm() < largest * (1.0 + 1e-12)));
                }
                before = Some((iterate.value, iterate.points.to_vec()));
                false
            });
        }
    }
}
