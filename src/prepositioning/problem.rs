//! What is minimized on one level: the energy of the cloth and its contacts.

use crate::contact::{BodyContact, SelfContact};
use crate::energy::{Energy, GRAVITY, Terms};
use crate::geometry::Vector3;
use crate::minimize::Problem;

/// Cloth of one level against the body and itself.
pub struct Relaxation<'a> {
    pub energy: Energy,
    pub body: BodyContact<'a>,
    pub cloth: SelfContact,
    /// Energies of the last evaluation.
    pub terms: Terms,
    diagonal: Vec<f64>,
}

impl<'a> Relaxation<'a> {
    pub fn new(energy: Energy, body: BodyContact<'a>, cloth: SelfContact) -> Self {
        let mut problem = Self { energy, body, cloth, terms: Terms::default(), diagonal: Vec::new() };
        problem.update_diagonal();
        problem
    }

    /// To be called after a stiffness was changed.
    pub fn update_diagonal(&mut self) {
        self.energy.update_diagonal();
        let contact = self.body.diagonal();
        self.diagonal = self.energy.diagonal().iter().map(|d| d + contact).collect();
    }
}

/// How far a state is from equilibrium, in particle weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    pub rms: f64,
    pub max: f64,
}

impl Residual {
    /// Lengths of the gradient, N, one per particle, over the weights of the particles, whose masses are in kg.
    pub fn of(gradient: &[Vector3], masses: &[f64]) -> Self {
        let weights = gradient.iter().zip(masses).map(|(g, m)| g.norm() / (m * GRAVITY));
        let (sum, max) = weights.fold((0.0, 0.0_f64), |(sum, max), w| (sum + w * w, max.max(w)));
        Self { rms: (sum / masses.len() as f64).sqrt(), max }
    }
}

impl Problem for Relaxation<'_> {
    fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        self.terms = self.energy.evaluate(points, gradient);
        self.terms.total() + self.body.evaluate(points, gradient) + self.cloth.evaluate(points, gradient)
    }

    fn curvature(&mut self, points: &[Vector3], direction: &[Vector3]) -> f64 {
        self.energy.curvature(points, direction)
            + self.body.curvature(direction)
            + self.cloth.curvature(points, direction)
    }

    fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    fn limit(&mut self, points: &[Vector3], moves: &mut [Vector3]) -> bool {
        self.cloth.limit(points, moves) > 0
    }
}
