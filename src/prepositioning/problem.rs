//! What is minimized on one level: the energy of the cloth and its contacts.

use crate::contact::{BodyContact, SelfContact};
use crate::energy::{Energy, Terms};
use crate::geometry::Vector3;
use crate::minimize::Problem;

/// Cloth of one level against the body and itself.
pub struct Relaxation<'a> {
    pub energy: Energy,
    pub body: BodyContact<'a>,
    pub cloth: Option<SelfContact>,
    /// Energies of the last evaluation.
    pub terms: Terms,
    diagonal: Vec<f64>,
    since_rebuild: usize,
    pub truncations: usize,
}

impl<'a> Relaxation<'a> {
    pub fn new(energy: Energy, body: BodyContact<'a>, cloth: Option<SelfContact>) -> Self {
        let mut problem = Self { energy, body, cloth, terms: Terms::default(), diagonal: Vec::new(), since_rebuild: 0, truncations: 0 };
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

impl Problem for Relaxation<'_> {
    fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        self.terms = self.energy.evaluate(points, gradient);
        let cloth = self.cloth.as_ref().map_or(0.0, |c| c.evaluate(points, gradient));
        self.terms.total() + self.body.evaluate(points, gradient) + cloth
    }

    fn curvature(&mut self, points: &[Vector3], direction: &[Vector3]) -> f64 {
        let cloth = self.cloth.as_ref().map_or(0.0, |c| c.curvature(points, direction));
        self.energy.curvature(points, direction) + self.body.curvature(direction) + cloth
    }

    fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    fn limit(&mut self, points: &[Vector3], moves: &mut [Vector3]) -> bool {
        let Some(cloth) = &mut self.cloth else { return false };
        self.since_rebuild += 1;
        let exceeding = cloth.exceeding(points, moves);
        if exceeding == 0 {
            return false;
        }
        if exceeding > points.len() / 100 || self.since_rebuild > 10 {
            cloth.rebuild(points);
            self.since_rebuild = 0;
        }
        let cut = cloth.truncate(points, moves);
        self.truncations += cut;
        cut > points.len() / 100
    }
}
