//! Steps that are not bound by the fastest vibration: Baraff and Witkin, *Large steps in cloth simulation* (1998).
//!
//! ```text
//!     (M (1 + Δt drag) + Δt² K) Δv = Δt (M a - Δt K v)                  (theory, equation 28)
//! ```
//!
//! `K` is the part of the energy's Hessian that is certainly positive, so that the system can be solved by conjugate
//! gradients whatever the cloth is doing; 3 × 3 blocks of the diagonal precondition them. Pairs of cloth in contact are
//! in `K` as the springs along their normals that they are.

use super::forces::Forces;
use super::integrator::{Movement, for_all};
use crate::energy::{Model, Tangent};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::{BlockMatrix, dot};
use crate::pattern::Cut;
use nalgebra::Matrix3;

/// Iterations for one system, at most.
const MOST_ITERATIONS: usize = 200;
/// A system is solved when its residual has fallen by this factor.
const SOLVED: f64 = 1e-4;

/// The matrix of a level and room to work.
pub struct Implicit {
    tangent: Tangent,
    matrix: BlockMatrix,
    inverse_diagonal: Vec<Matrix3<f64>>,
    drag: f64,
    residual: Vec<Vector3>,
    preconditioned: Vec<Vector3>,
    direction: Vec<Vector3>,
    product: Vec<Vector3>,
    /// Iterations of all systems so far.
    pub iterations: usize,
}

impl Implicit {
    pub fn new<'a>(level: &Level, cut: impl Into<Cut<'a>>, model: Model, drag: f64) -> Self {
        let tangent = Tangent::new(level, cut, model);
        let zeros = || vec![Vector3::zeros(); level.particle_count];
        Self {
            matrix: BlockMatrix::zeros(tangent.pattern().clone()),
            inverse_diagonal: vec![Matrix3::identity(); level.particle_count],
            drag,
            residual: zeros(),
            preconditioned: zeros(),
            direction: zeros(),
            product: zeros(),
            iterations: 0,
            tangent,
        }
    }

    /// New velocities after `step`, s, where the forces now give `accelerations`.
    pub fn velocities(
        &mut self,
        forces: &Forces,
        movement: &Movement,
        accelerations: &[Vector3],
        step: f64,
        velocities: &mut [Vector3],
    ) {
        let Movement { positions, velocities: before } = movement;
        let inertia = &forces.pace.inertia;
        let Self { tangent, matrix, inverse_diagonal, residual, preconditioned, direction, product, .. } = self;
        matrix.fill(|row, columns, blocks| tangent.add_membrane(positions, row, true, columns, blocks));
        let squared = step * step;
        let mass = |p: usize| inertia[p] + step * self.drag * forces.energy.masses()[p];
        let pairs = forces.cloth().map_or_else(Vec::new, |cloth| cloth.hessians(positions));
        let times = |of: &[Vector3], product: &mut [Vector3]| {
            for_all(product, |p, out| {
                *out = (matrix.row_times(p, of) + tangent.bending_times(p, of)) * squared + of[p] * mass(p);
            });
            for pair in &pairs {
                let moved = pair.particles.iter().zip(pair.pressing);
                let rate: f64 = moved.clone().map(|(&p, pressing)| pressing.dot(&of[p as usize])).sum();
                moved.for_each(|(&p, pressing)| product[p as usize] += pressing * (rate * squared));
            }
        };
        let mut pressed = vec![Matrix3::zeros(); positions.len()];
        for pair in &pairs {
            for (&p, pressing) in pair.particles.iter().zip(pair.pressing) {
                pressed[p as usize] += pressing * pressing.transpose();
            }
        }
        for (p, inverse) in inverse_diagonal.iter_mut().enumerate() {
            let block = matrix.own_block(p) + Matrix3::identity() * tangent.bending_diagonal(p) + pressed[p];
            let block = block * squared + Matrix3::identity() * mass(p);
            *inverse = block.try_inverse().expect("a positive definite block has an inverse");
        }
        // Right-hand side, from Δv = 0.
        times(before, product);
        for_all(residual, |p, r| {
            let elastic = product[p] - before[p] * mass(p);
            *r = accelerations[p] * (step * inertia[p]) - elastic;
        });
        velocities.copy_from_slice(before);
        for_all(preconditioned, |p, z| *z = inverse_diagonal[p] * residual[p]);
        direction.copy_from_slice(preconditioned);
        let mut rho = dot(residual, preconditioned);
        let goal = rho * SOLVED * SOLVED;
        for _ in 0..MOST_ITERATIONS {
            if rho <= goal || rho == 0.0 {
                break;
            }
            times(direction, product);
            let alpha = rho / dot(direction, product);
            for_all(velocities, |p, v| *v += direction[p] * alpha);
            for_all(residual, |p, r| *r -= product[p] * alpha);
            for_all(preconditioned, |p, z| *z = inverse_diagonal[p] * residual[p]);
            let next = dot(residual, preconditioned);
            let beta = next / rho;
            for_all(direction, |p, d| *d = preconditioned[p] + *d * beta);
            rho = next;
            self.iterations += 1;
        }
    }
}
