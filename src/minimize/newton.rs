//! Newton's method for the last mile, where first-order methods crawl.
//!
//! A step solves `H p = -g` by conjugate gradients, preconditioned by the Cholesky factor of a nearby
//! definite matrix that lives on the edges of the mesh. Where `H` has directions of negative
//! curvature, which cloth that buckles nearly always has far from its rest, its definite part is taken;
//! near the rest the whole of it, and convergence is quadratic.
//!
//! A full step along a curved valley overshoots: turning cloth stretches to second order. Chords, steps
//! with the old factor, lead back to the floor of the valley at a fraction of a step's price (Shamanskii
//! 1967); step and chords are accepted together, and only if they lower the value. Where cloth buckles the definite part
//! makes too much of the curvature, and steps are too short: one that met hardly any is gone along twice as far.

use super::{BlockMatrix, Cholesky, Iterate, Problem, Settings, Termination, dot};
use crate::geometry::Vector3;

/// A problem whose second derivatives are known.
pub trait SecondOrder: Problem {
    /// Prepares the near matrix and the Hessian at `points`, where the problem was evaluated last.
    fn linearize(&mut self, points: &[Vector3]);

    /// Reduces the Hessian that was prepared to what of it is certainly positive.
    fn keep_definite_part(&mut self);

    /// The prepared Hessian times a direction.
    fn hessian_times(&self, direction: &[Vector3], product: &mut [Vector3]);

    /// A positive definite matrix near the Hessian, with few entries.
    fn near_matrix(&self) -> &BlockMatrix;
}

/// Iterations for one linear system, at most; with a good near matrix it takes 3 to 10.
const MOST_ITERATIONS: usize = 40;
/// A system is solved when its residual has fallen by this factor, in the norm of the near matrix.
const SOLVED: f64 = 3e-2;
/// Chords after a step, at most.
const MOST_CHORDS: usize = 4;
/// Chords are not expected to lower the value faster than the last by more than this factor.
const BEST_PACE: f64 = 1.5;
/// How often a step is cut to a quarter before the method gives up.
const MOST_CUTS: usize = 12;
/// Share of the promised descent that an accepted step has to bring (Armijo).
const LEAST_DESCENT: f64 = 1e-4;
/// The farthest that a point moves in one step, in largest moves of the settings: those suit methods
/// that know nothing of what is far away. A step so long is walked in parts.
const STRIDE: f64 = 10.0;
/// A step that lowered the value by more than this share of what its slope promises is tried at twice its length: the
/// curvature that it was made for would leave a half.
const HARDLY_CURVED: f64 = 0.7;
/// Value differences below this share are rounding; there the gradient decides.
const ROUNDING: f64 = 1e-13;
/// After the whole Hessian was found indefinite, so many steps take its definite part, at most: twice
/// as many each time.
const MOST_CAUTION: usize = 8;

/// Working memory of the method.
pub struct Newton {
    gradient: Vec<Vector3>,
    step: Vec<Vector3>,
    trial: Vec<Vector3>,
    trial_gradient: Vec<Vector3>,
    chord: Vec<Vector3>,
    chord_gradient: Vec<Vector3>,
    linear: Linear,
    /// Steps that still take the definite part.
    caution: usize,
    last_caution: usize,
}

/// Working memory of the linear systems.
struct Linear {
    residual: Vec<Vector3>,
    preconditioned: Vec<Vector3>,
    direction: Vec<Vector3>,
    product: Vec<Vector3>,
}

/// What became of a step.
struct Walked {
    value: f64,
    evaluations: usize,
    accepted: bool,
}

impl Newton {
    pub fn new(point_count: usize) -> Self {
        let zeros = || vec![Vector3::zeros(); point_count];
        let linear = Linear { residual: zeros(), preconditioned: zeros(), direction: zeros(), product: zeros() };
        Self {
            gradient: zeros(),
            step: zeros(),
            trial: zeros(),
            trial_gradient: zeros(),
            chord: zeros(),
            chord_gradient: zeros(),
            linear,
            caution: 0,
            last_caution: 1,
        }
    }

    /// Lowers `problem` from `points`, in place; `done` is asked before each step. A step that was begun is finished: its
    /// factor was dearer than the evaluations that it may spend beyond those of the settings. Returns why the run ended,
    /// the last value, and the evaluations spent.
    pub fn run(
        &mut self,
        problem: &mut impl SecondOrder,
        points: &mut Vec<Vector3>,
        settings: &Settings,
        mut done: impl FnMut(&Iterate) -> bool,
    ) -> (Termination, f64, usize) {
        let mut value = problem.evaluate(points, &mut self.gradient);
        let mut evaluations = 1;
        loop {
            if done(&Iterate { points, gradient: &self.gradient, value, evaluations }) {
                return (Termination::Converged, value, evaluations);
            }
            if evaluations >= settings.evaluations {
                return (Termination::Budget, value, evaluations);
            }
            let Some(mut factor) = self.find_step(problem, points) else {
                return (Termination::Stalled, value, evaluations);
            };
            let left = settings.evaluations - evaluations;
            let walked = self.walk(problem, &mut factor, points, value, settings.largest_move, left);
            evaluations += walked.evaluations;
            if !walked.accepted {
                // The problem's last evaluation is to be that of the points.
                problem.evaluate(points, &mut self.gradient);
                return (Termination::Stalled, value, evaluations + 1);
            }
            value = walked.value;
            std::mem::swap(points, &mut self.trial);
            std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        }
    }

    /// Newton's step from the points; none where the near matrix has no factor.
    fn find_step(&mut self, problem: &mut impl SecondOrder, points: &[Vector3]) -> Option<Cholesky> {
        let definite = self.caution > 0;
        self.caution = self.caution.saturating_sub(1);
        problem.linearize(points);
        if definite {
            problem.keep_definite_part();
        }
        let mut factor = Cholesky::new(problem.near_matrix().pattern(), points);
        if !factor.factorize(problem.near_matrix()) {
            return None;
        }
        let positive = self.linear.solve(problem, &mut factor, &self.gradient, &mut self.step);
        if definite {
            return Some(factor);
        }
        if positive {
            self.last_caution = 1;
        } else {
            self.last_caution = (2 * self.last_caution).min(MOST_CAUTION);
            self.caution = self.last_caution;
            problem.keep_definite_part();
            self.linear.solve(problem, &mut factor, &self.gradient, &mut self.step);
        }
        Some(factor)
    }

    /// Goes along the step, and on by chords, until the value is lower; the new points are in `trial`.
    fn walk(
        &mut self,
        problem: &mut impl SecondOrder,
        factor: &mut Cholesky,
        points: &[Vector3],
        value: f64,
        largest_move: f64,
        most_evaluations: usize,
    ) -> Walked {
        let slope = dot(&self.gradient, &self.step);
        let longest = longest(&self.step);
        let mut scale = (STRIDE * largest_move / longest).min(1.0);
        let mut evaluations = 0;
        for _ in 0..=MOST_CUTS {
            self.trial.copy_from_slice(points);
            advance(problem, &mut self.trial, &self.step, scale, largest_move);
            let mut trial_value = problem.evaluate(&self.trial, &mut self.trial_gradient);
            evaluations += 1;
            for left in (0..MOST_CHORDS).rev() {
                if trial_value < value + LEAST_DESCENT * scale * slope {
                    break;
                }
                let (chord_value, lower) = self.chord(problem, factor, trial_value, largest_move);
                evaluations += 1;
                if !lower {
                    break;
                }
                let fallen = trial_value - chord_value;
                trial_value = chord_value;
                std::mem::swap(&mut self.trial, &mut self.chord);
                std::mem::swap(&mut self.trial_gradient, &mut self.chord_gradient);
                if trial_value - value > BEST_PACE * left as f64 * fallen {
                    break;
                }
            }
            let enough = trial_value < value + LEAST_DESCENT * scale * slope;
            // Near the bottom rounding hides the descent, but not that the gradient has become small.
            let level = (trial_value - value).abs() <= ROUNDING * value.abs()
                && dot(&self.trial_gradient, &self.step).abs() < -slope;
            if enough && evaluations == 1 {
                let left = most_evaluations.saturating_sub(evaluations);
                let (trial_value, spent) = self.go_on(problem, points, value, trial_value, largest_move, left);
                return Walked { value: trial_value, evaluations: evaluations + spent, accepted: true };
            }
            if enough || level {
                return Walked { value: trial_value, evaluations, accepted: true };
            }
            scale *= 0.25;
        }
        Walked { value, evaluations, accepted: false }
    }

    /// Goes on from `trial`, the end of a whole step that led to `trial_value`, along the same direction, twice as far each
    /// time, while the value falls as if there were hardly any curvature. Returns the value that is reached and the
    /// evaluations spent.
    fn go_on(
        &mut self,
        problem: &mut impl SecondOrder,
        points: &[Vector3],
        value: f64,
        mut trial_value: f64,
        largest_move: f64,
        most_evaluations: usize,
    ) -> (f64, usize) {
        let slope = dot(&self.gradient, &self.step);
        let farthest = STRIDE * largest_move / longest(&self.step);
        let (mut scale, mut spent) = (1.0, 0);
        while spent < most_evaluations && trial_value < value + HARDLY_CURVED * scale * slope && 2.0 * scale <= farthest
        {
            scale *= 2.0;
            self.chord.copy_from_slice(points);
            advance(problem, &mut self.chord, &self.step, scale, largest_move);
            let chord_value = problem.evaluate(&self.chord, &mut self.chord_gradient);
            spent += 1;
            if chord_value >= trial_value {
                break;
            }
            trial_value = chord_value;
            std::mem::swap(&mut self.trial, &mut self.chord);
            std::mem::swap(&mut self.trial_gradient, &mut self.chord_gradient);
        }
        (trial_value, spent)
    }

    /// A step from `trial` with the old factor, as long as the curvature along it says. Its points come to
    /// `chord`; tells their value and whether it is lower.
    fn chord(
        &mut self,
        problem: &mut impl SecondOrder,
        factor: &mut Cholesky,
        trial_value: f64,
        largest_move: f64,
    ) -> (f64, bool) {
        let direction = &mut self.linear.direction;
        factor.solve(&self.trial_gradient, direction);
        direction.iter_mut().for_each(|d| *d = -*d);
        let slope = dot(&self.trial_gradient, direction);
        let curvature = problem.curvature(&self.trial, direction);
        if slope >= 0.0 || curvature <= 0.0 {
            return (trial_value, false);
        }
        let scale = (-slope / curvature).min(largest_move / longest(direction));
        self.chord.copy_from_slice(&self.trial);
        advance(problem, &mut self.chord, direction, scale, largest_move);
        let value = problem.evaluate(&self.chord, &mut self.chord_gradient);
        (value, value < trial_value)
    }
}

impl Linear {
    /// `step ≈ -H⁻¹ gradient`. Tells whether all curvatures met were positive; where one was not, the step
    /// is what was found before, or the preconditioned gradient.
    fn solve(
        &mut self,
        problem: &impl SecondOrder,
        factor: &mut Cholesky,
        gradient: &[Vector3],
        step: &mut [Vector3],
    ) -> bool {
        let Self { residual, preconditioned, direction, product } = self;
        step.fill(Vector3::zeros());
        residual.copy_from_slice(gradient);
        factor.solve(residual, preconditioned);
        direction.iter_mut().zip(preconditioned.iter()).for_each(|(d, z)| *d = -z);
        let first = dot(residual, preconditioned);
        let mut rest = first;
        for iteration in 0..MOST_ITERATIONS {
            problem.hessian_times(direction, product);
            let curvature = dot(direction, product);
            if curvature <= 0.0 {
                if iteration == 0 {
                    step.copy_from_slice(direction);
                }
                return false;
            }
            let along = rest / curvature;
            step.iter_mut().zip(direction.iter()).for_each(|(s, d)| *s += d * along);
            residual.iter_mut().zip(product.iter()).for_each(|(r, p)| *r += p * along);
            factor.solve(residual, preconditioned);
            let next = dot(residual, preconditioned);
            if next <= SOLVED * SOLVED * first {
                break;
            }
            let beta = next / rest;
            rest = next;
            direction.iter_mut().zip(preconditioned.iter()).for_each(|(d, z)| *d = *d * beta - z);
        }
        true
    }
}

fn longest(moves: &[Vector3]) -> f64 {
    moves.iter().map(|m| m.norm_squared()).fold(0.0, f64::max).sqrt()
}

/// Moves points by `scale * step`, in parts of which none moves a point farther than `largest_move`, each as
/// far as the problem allows.
fn advance(problem: &mut impl Problem, points: &mut [Vector3], step: &[Vector3], scale: f64, largest_move: f64) {
    let parts = (scale * longest(step) / largest_move).ceil().max(1.0);
    let mut moves = vec![Vector3::zeros(); points.len()];
    for _ in 0..parts as usize {
        moves.iter_mut().zip(step).for_each(|(m, s)| *m = s * (scale / parts));
        problem.limit(points, &mut moves);
        points.iter_mut().zip(&moves).for_each(|(p, m)| *p += m);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Pattern;
    use super::super::chain::settings;
    use super::*;
    use nalgebra::Matrix3;

    /// Points on springs to the origin, of unit stiffness, of which the Hessian makes [`TOO_STIFF`] times as much.
    struct Overrated {
        near: BlockMatrix,
    }

    const TOO_STIFF: f64 = 8.0;

    impl Problem for Overrated {
        fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
            gradient.copy_from_slice(points);
            0.5 * dot(points, points)
        }

        fn curvature(&mut self, _points: &[Vector3], direction: &[Vector3]) -> f64 {
            dot(direction, direction)
        }

        fn diagonal(&self) -> &[f64] {
            &[1.0; 3]
        }
    }

    impl SecondOrder for Overrated {
        fn linearize(&mut self, _points: &[Vector3]) {
            self.near.fill(|row, columns, blocks| {
                let own = columns.binary_search(&(row as u32)).unwrap();
                blocks[own] = Matrix3::identity() * TOO_STIFF;
            });
        }

        fn keep_definite_part(&mut self) {}

        fn hessian_times(&self, direction: &[Vector3], product: &mut [Vector3]) {
            product.iter_mut().zip(direction).for_each(|(p, d)| *p = d * TOO_STIFF);
        }

        fn near_matrix(&self) -> &BlockMatrix {
            &self.near
        }
    }

    /// Whole steps alone would leave seven eighths of the way each time, and never more than a stride is gone at once.
    #[test]
    fn a_step_that_met_hardly_any_curvature_is_gone_along_farther() {
        let mut problem = Overrated { near: BlockMatrix::zeros(Pattern::of_triangles(3, [[0, 1, 2]].into_iter())) };
        let mut points = vec![Vector3::new(1.0, 2.0, 3.0); 3];
        let mut before = points.clone();
        let largest_move = 0.1;
        let (termination, _, evaluations) =
            Newton::new(3).run(&mut problem, &mut points, &settings(60, largest_move), |iterate| {
                let gone = iterate.points.iter().zip(&before).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
                assert!(gone <= STRIDE * largest_move * (1.0 + 1e-12), "{gone}");
                before.copy_from_slice(iterate.points);
                iterate.points.iter().all(|p| p.norm() < 1e-9)
            });
        assert_eq!(termination, Termination::Converged);
        assert!(evaluations < 30, "{evaluations}");
    }
}
