//! One minimizer or another, chosen by name.

use super::{ArgminLbfgs, ConjugateGradient, DynamicRelaxation, Iterate, Lbfgs, Problem, Settings, Termination};
use crate::geometry::Vector3;

/// The minimizers there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// Conjugate gradients, and where the rest is near Newton's method. That needs a problem of second
    /// order, so that a [`Minimizer`] alone does the first part; whoever has such a problem takes over.
    #[default]
    Newton,
    ConjugateGradient,
    Lbfgs,
    DynamicRelaxation,
    /// argmin's, as an independent rival.
    ArgminLbfgs,
}

impl Method {
    pub const ALL: [Method; 5] =
        [Method::Newton, Method::ConjugateGradient, Method::Lbfgs, Method::DynamicRelaxation, Method::ArgminLbfgs];
}

/// A minimizer of the method asked for.
pub struct Minimizer {
    working: Working,
    curvatures: usize,
    /// Lent out between runs by those that have nothing to spare.
    spare: Vec<Vector3>,
}

enum Working {
    ConjugateGradient(ConjugateGradient),
    Lbfgs(Lbfgs),
    DynamicRelaxation(DynamicRelaxation),
    ArgminLbfgs(ArgminLbfgs),
}

impl Minimizer {
    pub fn new(method: Method, point_count: usize) -> Self {
        let working = match method {
            Method::Newton | Method::ConjugateGradient => {
                Working::ConjugateGradient(ConjugateGradient::new(point_count))
            }
            Method::Lbfgs => Working::Lbfgs(Lbfgs::new(point_count)),
            Method::DynamicRelaxation => Working::DynamicRelaxation(DynamicRelaxation::new(point_count)),
            Method::ArgminLbfgs => Working::ArgminLbfgs(ArgminLbfgs::new(point_count)),
        };
        Self { working, curvatures: 0, spare: Vec::new() }
    }

    /// L-BFGS that remembers so many steps.
    pub fn lbfgs(point_count: usize, memory: usize) -> Self {
        let working = Working::Lbfgs(Lbfgs::with_memory(point_count, memory));
        Self { working, curvatures: 0, spare: Vec::new() }
    }

    /// Forgets all, and works on so many points from now on; on none it needs no memory.
    pub fn resize(&mut self, point_count: usize) {
        self.working = match &self.working {
            Working::ConjugateGradient(_) => Working::ConjugateGradient(ConjugateGradient::new(point_count)),
            Working::Lbfgs(minimizer) => Working::Lbfgs(Lbfgs::with_memory(point_count, minimizer.memory())),
            Working::DynamicRelaxation(_) => Working::DynamicRelaxation(DynamicRelaxation::new(point_count)),
            Working::ArgminLbfgs(_) => Working::ArgminLbfgs(ArgminLbfgs::new(point_count)),
        };
        self.spare = Vec::new();
    }

    /// Memory for so many points that no run needs before it begins, of any content.
    pub fn spare(&mut self, point_count: usize) -> &mut [Vector3] {
        let spare = match &mut self.working {
            Working::ConjugateGradient(minimizer) => minimizer.spare(),
            _ => &mut self.spare,
        };
        spare.resize(point_count, Vector3::zeros());
        spare
    }

    /// Curvatures asked of problems in all runs so far. They are no evaluations, but cost about half of one.
    pub fn curvatures(&self) -> usize {
        self.curvatures
    }

    /// Lowers `problem` from `points`, in place. `done` is asked after each accepted step whether the
    /// goal is reached. Returns why the run ended, the last value, and the evaluations spent.
    pub fn run(
        &mut self,
        problem: &mut impl Problem,
        points: &mut Vec<Vector3>,
        settings: &Settings,
        done: impl FnMut(&Iterate) -> bool,
    ) -> (Termination, f64, usize) {
        let mut problem = Counted { problem, curvatures: 0 };
        let ended = match &mut self.working {
            Working::ConjugateGradient(minimizer) => minimizer.run(&mut problem, points, settings, done),
            Working::Lbfgs(minimizer) => minimizer.run(&mut problem, points, settings, done),
            Working::DynamicRelaxation(minimizer) => minimizer.run(&mut problem, points, settings, done),
            Working::ArgminLbfgs(minimizer) => minimizer.run(&mut problem, points, settings, done),
        };
        self.curvatures += problem.curvatures;
        ended
    }
}

/// A problem, and how often it was asked for a curvature.
struct Counted<'p, P> {
    problem: &'p mut P,
    curvatures: usize,
}

impl<P: Problem> Problem for Counted<'_, P> {
    fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        self.problem.evaluate(points, gradient)
    }

    fn curvature(&mut self, points: &[Vector3], direction: &[Vector3]) -> f64 {
        self.curvatures += 1;
        self.problem.curvature(points, direction)
    }

    fn diagonal(&self) -> &[f64] {
        self.problem.diagonal()
    }

    fn limit(&mut self, points: &[Vector3], moves: &mut [Vector3]) -> bool {
        self.problem.limit(points, moves)
    }
}

#[cfg(test)]
mod tests {
    use super::super::chain::{Chain, settings};
    use super::*;

    #[test]
    fn all_methods_find_the_same_minimum() {
        let small = |i: &Iterate| i.gradient.iter().all(|g| g.norm() < 1e-5);
        let found = Method::ALL.map(|method| {
            let mut points = vec![Vector3::zeros(); 40];
            let mut minimizer = Minimizer::new(method, 40);
            let run = minimizer.run(&mut Chain::new(40, 0.0), &mut points, &settings(2000, 0.5), small);
            assert_eq!(run.0, Termination::Converged, "{method:?}");
            points
        });
        for points in &found[1..] {
            assert!(points.iter().zip(&found[0]).all(|(p, q)| (p - q).norm() < 1e-4));
        }
    }

    #[test]
    fn curvatures_are_counted_by_those_who_ask_for_them() {
        let asked = Method::ALL.map(|method| {
            let mut minimizer = Minimizer::new(method, 10);
            minimizer.run(&mut Chain::new(10, 0.0), &mut vec![Vector3::zeros(); 10], &settings(9, 1.0), |_| false);
            minimizer.curvatures()
        });
        assert!(asked[0] >= 8 && asked[1] == asked[0] && asked[2] == 1 && asked[3..] == [0, 0], "{asked:?}");
    }
}
