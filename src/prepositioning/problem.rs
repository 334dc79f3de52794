//! What is minimized on one level: the energy of the cloth and its contacts.

use super::hessian::Hessian;
use crate::contact::{BodyContact, SelfContact};
use crate::energy::{Energy, GRAVITY, Terms};
use crate::geometry::Vector3;
use crate::minimize::{CHUNK, Problem};
use rayon::prelude::*;

/// Cloth of one level against the body and itself.
pub struct Relaxation<'a> {
    pub energy: Energy,
    pub body: BodyContact<'a>,
    pub cloth: SelfContact,
    /// Energies of the last evaluation.
    pub terms: Terms,
    diagonal: Vec<f64>,
    /// For minimizers of second order alone.
    pub hessian: Option<Hessian>,
}

impl<'a> Relaxation<'a> {
    pub fn new(energy: Energy, body: BodyContact<'a>, cloth: SelfContact) -> Self {
        let mut problem = Self { energy, body, cloth, terms: Terms::default(), diagonal: Vec::new(), hessian: None };
        problem.update_diagonal();
        problem
    }

    /// To be called after a stiffness was changed.
    pub fn update_diagonal(&mut self) {
        let contact = self.body.diagonal();
        self.diagonal = self.energy.diagonal();
        self.diagonal.iter_mut().for_each(|d| *d += contact);
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
        let chunks = gradient.par_chunks(CHUNK).zip(masses.par_chunks(CHUNK));
        let parts: Vec<(f64, f64)> = chunks
            .map(|(gradient, masses)| {
                // Squares: of the roots only two are asked for.
                let squares = gradient.iter().zip(masses).map(|(g, m)| g.norm_squared() / (m * GRAVITY).powi(2));
                squares.fold((0.0, 0.0_f64), |(sum, max), square| (sum + square, max.max(square)))
            })
            .collect();
        let (sum, max) = parts.into_iter().fold((0.0, 0.0_f64), |a, b| (a.0 + b.0, a.1.max(b.1)));
        Self { rms: (sum / masses.len() as f64).sqrt(), max: max.sqrt() }
    }
}

impl Problem for Relaxation<'_> {
    fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        self.terms = self.energy.evaluate(points, gradient);
        self.terms.total() + self.body.evaluate(points, gradient) + self.cloth.evaluate(points, gradient)
    }

    fn curvature(&mut self, points: &[Vector3], direction: &[Vector3]) -> f64 {
        self.energy.curvature(points, direction)
            + self.body.curvature(points, direction)
            + self.cloth.curvature(points, direction)
    }

    fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    fn limit(&mut self, points: &[Vector3], moves: &mut [Vector3]) -> bool {
        self.cloth.limit(points, moves) > 0
    }
}
