//! L-BFGS, written in place (Liu and Nocedal 1989).
//!
//! The last few steps and the changes of the gradient along them make up a guess of the inverse Hessian,
//! which starts from the diagonal preconditioner. A first step, from the gradient alone, has the length
//! that the exact curvature gives; later ones are tried in full and halved until the value does not rise,
//! so that accepted steps never raise it. A step that was shortened by caps or limits still tells of the
//! curvature, and is kept like any other; a step along which the gradient did not grow is not.
//!
//! A run starts without memory. One that outlived its run needed half as many evaluations again on a tee at
//! 20 mm, though little changes between two runs: the curvature of a buckling garment is soon out of date. So
//! did the exact curvature in place of full steps, which cost a sweep more for each.

use super::vectors::{add, add_scaled, capped, divide, subtract};
use super::{Iterate, MOST_HALVINGS, Problem, Settings, Termination, dot};
use crate::geometry::Vector3;

/// Steps that are remembered unless it is said otherwise. More need fewer evaluations, but soon fall out of the
/// processor's cache.
const MEMORY: usize = 5;
/// A step is remembered if the gradient grew along it by this share of what its length allows, at least.
const LEAST_GROWTH: f64 = 1e-10;

/// A run's working memory and its state.
pub struct Lbfgs {
    gradient: Vec<Vector3>,
    trial_gradient: Vec<Vector3>,
    direction: Vec<Vector3>,
    moves: Vec<Vector3>,
    trial: Vec<Vector3>,
    /// Oldest first.
    memory: Vec<Pair>,
    /// Steps that are remembered.
    most: usize,
}

/// A step, the change of the gradient along it, and their product.
struct Pair {
    step: Vec<Vector3>,
    change: Vec<Vector3>,
    product: f64,
}

impl Lbfgs {
    pub fn new(point_count: usize) -> Self {
        Self::with_memory(point_count, MEMORY)
    }

    /// Remembers `most` steps.
    pub fn with_memory(point_count: usize, most: usize) -> Self {
        let zeros = || vec![Vector3::zeros(); point_count];
        Self {
            gradient: zeros(),
            trial_gradient: zeros(),
            direction: zeros(),
            moves: zeros(),
            trial: zeros(),
            memory: Vec::new(),
            most,
        }
    }

    /// Steps that it remembers at most.
    pub fn memory(&self) -> usize {
        self.most
    }

    /// Lowers `problem` from `points`, in place; like
    /// [`ConjugateGradient::run`](super::ConjugateGradient::run), but that `restart_after` has no meaning here.
    pub fn run(
        &mut self,
        problem: &mut impl Problem,
        points: &mut Vec<Vector3>,
        settings: &Settings,
        mut done: impl FnMut(&Iterate) -> bool,
    ) -> (Termination, f64, usize) {
        self.memory.clear();
        let mut value = problem.evaluate(points, &mut self.gradient);
        let mut evaluations = 1;
        loop {
            if done(&Iterate { points, gradient: &self.gradient, value, evaluations }) {
                return (Termination::Converged, value, evaluations);
            }
            let mut slope = self.aim(problem.diagonal());
            // Rounding may have spoilt the memory.
            if slope.is_nan() || slope >= 0.0 {
                self.memory.clear();
                slope = self.aim(problem.diagonal());
            }
            if slope.is_nan() || slope >= 0.0 {
                return (Termination::Stalled, value, evaluations);
            }
            let mut step = 1.0;
            if self.memory.is_empty() {
                let curvature = problem.curvature(points, &self.direction);
                step = if curvature > 0.0 { -slope / curvature } else { 1.0 };
            }
            let mut halvings = 0;
            loop {
                if evaluations >= settings.evaluations {
                    return (Termination::Budget, value, evaluations);
                }
                capped(&self.direction, step, settings.largest_move, &mut self.moves);
                problem.limit(points, &mut self.moves);
                add(points, &self.moves, &mut self.trial);
                let trial_value = problem.evaluate(&self.trial, &mut self.trial_gradient);
                evaluations += 1;
                // Equal values are accepted: near the bottom rounding hides the descent.
                if trial_value <= value {
                    value = trial_value;
                    self.remember();
                    std::mem::swap(points, &mut self.trial);
                    std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
                    break;
                }
                step *= 0.5;
                halvings += 1;
                if halvings > MOST_HALVINGS {
                    if self.memory.is_empty() {
                        return (Termination::Stalled, value, evaluations);
                    }
                    self.memory.clear();
                    break;
                }
            }
        }
    }

    /// Makes the direction from gradient and memory; returns the slope along it.
    fn aim(&mut self, diagonal: &[f64]) -> f64 {
        let Self { gradient, direction, moves, memory, .. } = self;
        let Some(latest) = memory.last() else {
            return divide(gradient, diagonal, -1.0, direction, gradient);
        };
        // The two loops; each sweep that changes the vector also makes the next product with it.
        moves.copy_from_slice(gradient);
        let mut shares = vec![0.0; memory.len()];
        let mut product = dot(&latest.step, moves);
        for k in (0..memory.len()).rev() {
            shares[k] = product / memory[k].product;
            let next = if k > 0 { &memory[k - 1].step } else { &memory[0].change };
            product = add_scaled(moves, &memory[k].change, -shares[k], next);
        }
        let squared = divide(&latest.change, diagonal, 1.0, direction, &latest.change);
        let mut product = divide(moves, diagonal, latest.product / squared, direction, &memory[0].change);
        for k in 0..memory.len() {
            let along = product / memory[k].product;
            let next = memory.get(k + 1).map_or(&*gradient, |pair| &pair.change);
            product = add_scaled(direction, &memory[k].step, shares[k] - along, next);
        }
        direction.iter_mut().for_each(|d| *d = -*d);
        -product
    }

    /// Keeps the step from the gradient to that of the trial, in the place of the oldest.
    fn remember(&mut self) {
        let mut pair = match self.memory.len() {
            n if n >= self.most => self.memory.remove(0),
            _ => {
                let zeros = || vec![Vector3::zeros(); self.moves.len()];
                Pair { step: zeros(), change: zeros(), product: 0.0 }
            }
        };
        pair.step.copy_from_slice(&self.moves);
        subtract(&self.trial_gradient, &self.gradient, &mut pair.change);
        pair.product = dot(&pair.step, &pair.change);
        let lengths = (dot(&pair.step, &pair.step) * dot(&pair.change, &pair.change)).sqrt();
        if pair.product > LEAST_GROWTH * lengths {
            self.memory.push(pair);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::chain::{Chain, assert_budget_is_kept, assert_quadratic_is_solved, settings};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_quadratic_is_minimized_as_far_as_rounding_of_its_value_allows() {
        assert_quadratic_is_solved(120, |problem, points, settings, done| {
            Lbfgs::new(points.len()).run(problem, points, settings, done)
        });
    }

    #[test]
    fn the_budget_is_kept() {
        assert_budget_is_kept(|problem, points, settings, done| {
            Lbfgs::new(points.len()).run(problem, points, settings, done)
        });
    }

    /// The recursion must be the formula: what is made of the memory maps each change to its step.
    #[test]
    fn the_direction_satisfies_the_secant_equation_of_the_latest_step() {
        let mut problem = Chain::new(12, 0.0);
        let mut minimizer = Lbfgs::new(12);
        let mut points = vec![Vector3::zeros(); 12];
        minimizer.run(&mut problem, &mut points, &settings(8, f64::INFINITY), |_| false);
        assert_eq!(minimizer.memory.len(), MEMORY);
        let latest = minimizer.memory.last().unwrap();
        let step = latest.step.clone();
        minimizer.gradient = latest.change.clone();
        let slope = minimizer.aim(problem.diagonal());
        for (d, s) in minimizer.direction.iter().zip(&step) {
            assert!((d + s).norm() < 1e-12 * step.iter().map(|s| s.norm()).fold(0.0, f64::max));
        }
        assert!((slope - dot(&minimizer.gradient, &minimizer.direction)).abs() < 1e-12 * slope.abs());
    }

    proptest! {
        #[test]
        fn an_accepted_step_never_raises_the_value_nor_moves_too_far(bend in 0.0..40.0f64, largest in 0.001..0.5f64, start in -2.0..2.0f64) {
            let mut points = vec![Vector3::repeat(start); 30];
            let mut before: Option<(f64, Vec<Vector3>)> = None;
            Lbfgs::new(30).run(&mut Chain::new(30, bend), &mut points, &settings(150, largest), |iterate| {
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
