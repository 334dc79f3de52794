//! argmin's L-BFGS with the line search of Moré and Thuente, so that our own minimizers have a rival
//! that others wrote.
//!
//! What it is given to make it fair, and fit for cloth:
//!
//! * Coordinates are scaled by the root of the diagonal, in which its first guess of the Hessian, the
//!   identity, is our preconditioner.
//! * It knows nothing of moves that are too long or not allowed: each of its steps is shortened
//!   afterwards where that is due, and it starts afresh from there. *While* it searches along a line it
//!   may look at points that are not allowed.
//!
//! It allocates in every step, and its sums are not parallel: count evaluations rather than seconds.

use super::argmin_door::{ArgminDoor, flattened, unflattened};
use super::vectors::{add, capped};
use super::{Iterate, MOST_HALVINGS, Problem, Settings, Termination};
use crate::geometry::Vector3;
use argmin::core::{CostFunction, IterState, Problem as Operator, Solver, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;

/// Steps that are remembered, as many as our own L-BFGS does.
const MEMORY: usize = 5;

/// It keeps nothing between two runs.
#[derive(Default)]
pub struct ArgminLbfgs {
    gradient: Vec<Vector3>,
    moves: Vec<Vector3>,
    trial: Vec<Vector3>,
}

impl ArgminLbfgs {
    pub fn new(point_count: usize) -> Self {
        let zeros = || vec![Vector3::zeros(); point_count];
        Self { gradient: zeros(), moves: zeros(), trial: zeros() }
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
        let scale: Vec<f64> = problem.diagonal().iter().map(|d| d.sqrt()).collect();
        let door = ArgminDoor::with_budget(Scaled { problem, scale: &scale }, settings.evaluations);
        let mut value = f64::INFINITY;
        loop {
            // A piece: until a step has to be shortened.
            let mut solver: LBFGS<_, Vec<f64>, Vec<f64>, f64> = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY);
            let mut operator = Operator::new(&door);
            let start = IterState::new().param(flattened(&multiplied(points, &scale)));
            let mut state: IterState<Vec<f64>, Vec<f64>, (), (), (), f64> = match solver.init(&mut operator, start) {
                Ok((state, _)) => state,
                Err(_) => return (Termination::Budget, value, door.evaluations()),
            };
            value = state.get_cost();
            self.take_gradient(&state, &scale);
            if done(&Iterate { points, gradient: &self.gradient, value, evaluations: door.evaluations() }) {
                return (Termination::Converged, value, door.evaluations());
            }
            loop {
                let first = state.get_iter() == 0;
                let stepped = solver.next_iter(&mut operator, state);
                let after = stepped.ok().map(|(state, _)| state).filter(|state| {
                    // The search along the line may fail, or end where it began.
                    state.get_param().is_some() && state.get_cost() <= value
                });
                let Some(mut after) = after else {
                    if door.is_spent() {
                        return (Termination::Budget, value, door.evaluations());
                    }
                    if first {
                        return (Termination::Stalled, value, door.evaluations());
                    }
                    break;
                };
                after.increment_iter();
                let flat = after.get_param().expect("looked at above");
                self.trial = divided(&unflattened(flat), &scale);
                let step: Vec<Vector3> = self.trial.iter().zip(points.iter()).map(|(to, from)| to - from).collect();
                if step.iter().all(|s| *s == Vector3::zeros()) {
                    if first {
                        return (Termination::Stalled, value, door.evaluations());
                    }
                    break;
                }
                let mut share = 1.0;
                let mut shortened = false;
                // What was shortened is judged anew; what was not has been evaluated already.
                let accepted = loop {
                    shortened |= capped(&step, share, settings.largest_move, &mut self.moves);
                    shortened |= door.with_problem(|p| p.problem.limit(points, &mut self.moves));
                    if !shortened {
                        value = after.get_cost();
                        self.take_gradient(&after, &scale);
                        break true;
                    }
                    add(points, &self.moves, &mut self.trial);
                    match door.cost(&flattened(&multiplied(&self.trial, &scale))) {
                        Err(_) => return (Termination::Budget, value, door.evaluations()),
                        Ok(cost) if cost <= value => break true,
                        Ok(_) => share *= 0.5,
                    }
                    if share < 0.5f64.powi(MOST_HALVINGS as i32) {
                        break false;
                    }
                };
                if accepted {
                    std::mem::swap(points, &mut self.trial);
                } else if first {
                    return (Termination::Stalled, value, door.evaluations());
                }
                if shortened {
                    break;
                }
                if done(&Iterate { points, gradient: &self.gradient, value, evaluations: door.evaluations() }) {
                    return (Termination::Converged, value, door.evaluations());
                }
                state = after;
            }
        }
    }

    fn take_gradient(&mut self, state: &IterState<Vec<f64>, Vec<f64>, (), (), (), f64>, scale: &[f64]) {
        let flat = state.get_gradient().expect("the solver leaves a gradient");
        self.gradient = multiplied(&unflattened(flat), scale);
    }
}

fn multiplied(points: &[Vector3], scale: &[f64]) -> Vec<Vector3> {
    points.iter().zip(scale).map(|(p, s)| p * *s).collect()
}

fn divided(points: &[Vector3], scale: &[f64]) -> Vec<Vector3> {
    points.iter().zip(scale).map(|(p, s)| p / *s).collect()
}

/// A problem in coordinates that are `scale` times the points.
struct Scaled<'p, P> {
    problem: &'p mut P,
    scale: &'p [f64],
}

impl<P: Problem> Problem for Scaled<'_, P> {
    fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let value = self.problem.evaluate(&divided(points, self.scale), gradient);
        gradient.iter_mut().zip(self.scale).for_each(|(g, s)| *g /= *s);
        value
    }

    fn curvature(&mut self, points: &[Vector3], direction: &[Vector3]) -> f64 {
        self.problem.curvature(&divided(points, self.scale), &divided(direction, self.scale))
    }

    fn diagonal(&self) -> &[f64] {
        // Of use to nobody here: argmin asks for value and gradient alone.
        self.problem.diagonal()
    }
}

#[cfg(test)]
mod tests {
    use super::super::chain::{Chain, assert_budget_is_kept, assert_quadratic_is_solved, settings};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_quadratic_is_minimized_as_far_as_rounding_of_its_value_allows() {
        assert_quadratic_is_solved(200, |problem, points, settings, done| {
            ArgminLbfgs::new(points.len()).run(problem, points, settings, done)
        });
    }

    #[test]
    fn the_budget_is_kept() {
        assert_budget_is_kept(|problem, points, settings, done| {
            ArgminLbfgs::new(points.len()).run(problem, points, settings, done)
        });
    }

    proptest! {
        #[test]
        fn an_accepted_step_never_raises_the_value_nor_moves_too_far(bend in 0.0..40.0f64, largest in 0.001..0.5f64, start in -2.0..2.0f64) {
            let mut points = vec![Vector3::repeat(start); 30];
            let mut before: Option<(f64, Vec<Vector3>)> = None;
            ArgminLbfgs::new(30).run(&mut Chain::new(30, bend), &mut points, &settings(150, largest), |iterate| {
                if let Some((value, points)) = &before {
                    // Scaled and back again rounding may show.
                    assert!(iterate.value <= *value + 1e-9 * value.abs(), "{} after {value}", iterate.value);
                    assert!(iterate.points.iter().zip(points).all(|(p, q)| (p - q).norm() < largest * (1.0 + 1e-9)));
                }
                before = Some((iterate.value, iterate.points.to_vec()));
                false
            });
        }
    }
}
