//! The door for other optimizers: any [`Problem`] as argmin sees one.
//!
//! Our own loop works in place and is several times faster on large garments; argmin's solvers are
//! for comparison, and for trying what we have not. Points become one flat vector `x₀ y₀ z₀ x₁ …`:
//!
//! ```
//! use argmin::core::{Executor, State};
//! use argmin::solver::linesearch::MoreThuenteLineSearch;
//! use argmin::solver::quasinewton::LBFGS;
//! use toile::geometry::Vector3;
//! use toile::minimize::{ArgminDoor, Problem, flattened};
//!
//! /// Springs from the points to the origin.
//! struct Springs([f64; 2]);
//!
//! impl Problem for Springs {
//!     fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
//!         gradient.iter_mut().zip(points).zip(self.0).for_each(|((g, p), k)| *g = p * k);
//!         points.iter().zip(self.0).map(|(p, k)| 0.5 * k * p.norm_squared()).sum()
//!     }
//!     fn curvature(&mut self, _: &[Vector3], direction: &[Vector3]) -> f64 {
//!         direction.iter().zip(self.0).map(|(d, k)| k * d.norm_squared()).sum()
//!     }
//!     fn diagonal(&self) -> &[f64] {
//!         &self.0
//!     }
//! }
//!
//! let door = ArgminDoor::new(Springs([1.0, 500.0]));
//! let start = flattened(&[Vector3::new(1.0, 2.0, 3.0), Vector3::new(-1.0, 0.5, 0.0)]);
//! let solver: LBFGS<_, Vec<f64>, Vec<f64>, f64> = LBFGS::new(MoreThuenteLineSearch::new(), 7);
//! let run = Executor::new(door, solver).configure(|state| state.param(start).max_iters(50)).run().unwrap();
//! assert!(run.state().get_best_cost() < 1e-12);
//! ```
//!
//! For a [`Relaxation`](crate::prepositioning::Relaxation) one thing is lost: argmin does not ask
//! [`Problem::limit`], so that nothing keeps cloth from passing through cloth in a long step, and the
//! near pairs stay those that were found last.

use super::Problem;
use crate::geometry::Vector3;
use argmin::core::{CostFunction, Error, Gradient};
use std::cell::RefCell;

/// A problem for argmin: `Param` is the points one after the other, `Gradient` likewise.
pub struct ArgminDoor<P> {
    inner: RefCell<Inner<P>>,
}

struct Inner<P> {
    problem: P,
    /// Where the problem was evaluated last; solvers ask for value and gradient one by one.
    points: Vec<Vector3>,
    gradient: Vec<Vector3>,
    value: f64,
    evaluations: usize,
    budget: usize,
}

impl<P: Problem> ArgminDoor<P> {
    pub fn new(problem: P) -> Self {
        Self::with_budget(problem, usize::MAX)
    }

    /// A door at which each evaluation beyond `budget` is an error, which ends a solver's run.
    pub fn with_budget(problem: P, budget: usize) -> Self {
        let (points, gradient) = (Vec::new(), Vec::new());
        Self { inner: RefCell::new(Inner { problem, points, gradient, value: f64::NAN, evaluations: 0, budget }) }
    }

    /// Is no evaluation left?
    pub fn is_spent(&self) -> bool {
        let inner = self.inner.borrow();
        inner.evaluations >= inner.budget
    }

    /// What `look` makes of the problem.
    pub fn with_problem<R>(&self, look: impl FnOnce(&mut P) -> R) -> R {
        look(&mut self.inner.borrow_mut().problem)
    }

    /// Evaluations of the problem so far; value and gradient at the same points count as one.
    pub fn evaluations(&self) -> usize {
        self.inner.borrow().evaluations
    }

    pub fn into_problem(self) -> P {
        self.inner.into_inner().problem
    }
}

impl<P: Problem> Inner<P> {
    fn evaluate(&mut self, flat: &[f64]) -> Result<(), Error> {
        let points = unflattened(flat);
        if points != self.points {
            if self.evaluations >= self.budget {
                return Err(Error::msg("the evaluations are used up"));
            }
            self.gradient.resize(points.len(), Vector3::zeros());
            self.value = self.problem.evaluate(&points, &mut self.gradient);
            self.points = points;
            self.evaluations += 1;
        }
        Ok(())
    }
}

impl<P: Problem> CostFunction for ArgminDoor<P> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, flat: &Vec<f64>) -> Result<f64, Error> {
        let mut inner = self.inner.borrow_mut();
        inner.evaluate(flat)?;
        Ok(inner.value)
    }
}

impl<P: Problem> Gradient for ArgminDoor<P> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, flat: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let mut inner = self.inner.borrow_mut();
        inner.evaluate(flat)?;
        Ok(flattened(&inner.gradient))
    }
}

impl<P: Problem> CostFunction for &ArgminDoor<P> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, flat: &Vec<f64>) -> Result<f64, Error> {
        (**self).cost(flat)
    }
}

impl<P: Problem> Gradient for &ArgminDoor<P> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, flat: &Vec<f64>) -> Result<Vec<f64>, Error> {
        (**self).gradient(flat)
    }
}

/// `x₀ y₀ z₀ x₁ …` of points.
pub fn flattened(points: &[Vector3]) -> Vec<f64> {
    points.iter().flat_map(|p| [p.x, p.y, p.z]).collect()
}

/// Points of `x₀ y₀ z₀ x₁ …`.
pub fn unflattened(flat: &[f64]) -> Vec<Vector3> {
    flat.as_chunks::<3>().0.iter().map(|&c| Vector3::from(c)).collect()
}
