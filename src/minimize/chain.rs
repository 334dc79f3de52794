//! A problem on which all minimizers are tried, and what all must be able to do with it.

use super::{Iterate, Problem, Settings, Termination};
use crate::geometry::Vector3;

/// A chain of springs of very different stiffness between neighbours and to places of their own.
pub struct Chain {
    stiffness: Vec<f64>,
    diagonal: Vec<f64>,
    bend: f64,
}

impl Chain {
    /// With `bend` the function is not quadratic, and not convex either.
    pub fn new(count: usize, bend: f64) -> Self {
        let stiffness: Vec<f64> = (0..count).map(|k| 10f64.powf(2.0 * (k as f64 * 1.3).sin())).collect();
        Self { diagonal: stiffness.iter().map(|k| k + 2.0).collect(), stiffness, bend }
    }

    fn place(k: usize) -> Vector3 {
        Vector3::new((k as f64).sin(), (k as f64 * 0.7).cos(), 0.1 * k as f64)
    }
}

impl Problem for Chain {
    fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let mut value = 0.0;
        for (k, p) in points.iter().enumerate() {
            let away = p - Self::place(k);
            value += 0.5 * self.stiffness[k] * away.norm_squared() + self.bend * (3.0 * p.x).cos();
            gradient[k] = away * self.stiffness[k] - Vector3::x() * (3.0 * self.bend * (3.0 * p.x).sin());
        }
        for k in 1..points.len() {
            let span = points[k] - points[k - 1];
            value += 0.5 * span.norm_squared();
            gradient[k] += span;
            gradient[k - 1] -= span;
        }
        value
    }

    fn curvature(&mut self, points: &[Vector3], direction: &[Vector3]) -> f64 {
        let own = |k: usize| {
            let bent = 9.0 * self.bend * (3.0 * points[k].x).cos() * direction[k].x.powi(2);
            self.stiffness[k] * direction[k].norm_squared() - bent
        };
        let between: f64 = direction.windows(2).map(|w| (w[1] - w[0]).norm_squared()).sum();
        (0..points.len()).map(own).sum::<f64>() + between
    }

    fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }
}

pub fn settings(evaluations: usize, largest_move: f64) -> Settings {
    Settings { evaluations, largest_move, restart_after: 100 }
}

/// How minimizers run.
type Run = fn(&mut Chain, &mut Vec<Vector3>, &Settings, &mut dyn FnMut(&Iterate) -> bool) -> (Termination, f64, usize);

/// A well preconditioned quadratic is solved in fewer evaluations than `most`.
pub fn assert_quadratic_is_solved(most: usize, run: Run) {
    let mut problem = Chain::new(60, 0.0);
    let mut points = vec![Vector3::zeros(); 60];
    // A gradient of g promises a descent of g²/2k, which must be visible beside a value of a thousand.
    let mut small = |i: &Iterate| i.gradient.iter().all(|g| g.norm() < 1e-5);
    let (termination, value, evaluations) =
        run(&mut problem, &mut points, &settings(10 * most, f64::INFINITY), &mut small);
    assert_eq!(termination, Termination::Converged);
    assert!(evaluations < most, "{evaluations} evaluations for a well preconditioned quadratic");
    let mut gradient = vec![Vector3::zeros(); 60];
    assert!((problem.evaluate(&points, &mut gradient) - value).abs() <= 1e-12 * value.abs());
    assert!(gradient.iter().all(|g| g.norm() < 2e-5));
}

/// As many evaluations are spent as were granted, and no more.
pub fn assert_budget_is_kept(run: Run) {
    for budget in [1, 2, 7] {
        let mut points = vec![Vector3::zeros(); 20];
        let (termination, _, spent) =
            run(&mut Chain::new(20, 3.0), &mut points, &settings(budget, 0.01), &mut |_| false);
        assert_eq!((termination, spent), (Termination::Budget, budget));
    }
}
