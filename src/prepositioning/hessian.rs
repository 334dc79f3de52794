//! Second derivatives of what is minimized on a level.

use super::problem::Relaxation;
use crate::contact::{BodyContact, PairHessian};
use crate::energy::{GRAVITY, Model, Tangent};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::{BlockMatrix, CHUNK, SecondOrder};
use crate::pattern::Cut;
use nalgebra::{Matrix3, SVector};
use rayon::prelude::*;

/// The Hessian of a level, at the state for which it was prepared last.
pub struct Hessian {
    tangent: Tangent,
    /// Membrane and contact with the body.
    blocks: BlockMatrix,
    /// Contact of the cloth with itself.
    pairs: Vec<PairHessian>,
    /// Only what is certainly positive.
    definite: bool,
    near: BlockMatrix,
    points: Vec<Vector3>,
}

impl Hessian {
    pub fn new<'a>(level: &Level, cut: impl Into<Cut<'a>>, model: Model) -> Self {
        let tangent = Tangent::new(level, cut, model);
        let zeros = || BlockMatrix::zeros(tangent.pattern().clone());
        Self { blocks: zeros(), near: zeros(), pairs: Vec::new(), definite: false, points: Vec::new(), tangent }
    }

    fn fill_blocks(&mut self, body: &BodyContact, definite: bool) {
        let Self { tangent, blocks, points, .. } = self;
        blocks.fill(|row, columns, blocks| {
            tangent.add_membrane(points, row, definite, columns, blocks);
            let [pressing, curved] = body.hessian_of(row, points[row]);
            blocks[own(columns, row)] += if definite { pressing } else { pressing + curved };
        });
        self.definite = definite;
    }
}

/// Place of a row's own block.
fn own(columns: &[u32], row: usize) -> usize {
    columns.binary_search(&(row as u32)).expect("rows have their diagonal")
}

/// Length over which a particle's weight is the stiffness that keeps free particles from moving without bound, m.
const LEASH: f64 = 0.1;

impl Relaxation<'_> {
    fn hessian(&self) -> &Hessian {
        self.hessian.as_ref().expect("a minimizer of second order is given a problem with a Hessian")
    }
}

impl SecondOrder for Relaxation<'_> {
    fn linearize(&mut self, points: &[Vector3]) {
        let Relaxation { energy, body, cloth, hessian, .. } = self;
        let hessian = hessian.as_mut().expect("a minimizer of second order is given a problem with a Hessian");
        hessian.points.clear();
        hessian.points.extend_from_slice(points);
        hessian.fill_blocks(body, false);
        let Hessian { tangent, pairs, near, .. } = hessian;
        *pairs = cloth.hessians(points);
        let coupled: Vec<[u32; 4]> = pairs.iter().map(|pair| pair.particles).collect();
        *near = BlockMatrix::zeros(tangent.pattern().with_groups(&coupled));
        let mut pairs_at: Vec<(u32, u32)> =
            (0..4 * coupled.len() as u32).map(|slot| (coupled[slot as usize / 4][slot as usize % 4], slot)).collect();
        pairs_at.sort_unstable();
        let mut bounds = vec![Matrix3::zeros(); points.len()];
        body.add_middles(points, &mut bounds);
        near.fill(|row, columns, blocks| {
            tangent.add_membrane(points, row, true, columns, blocks);
            tangent.add_near_bending(row, columns, blocks);
            let leash = energy.masses()[row] * GRAVITY / LEASH;
            let alone = body.hessian_of(row, points[row])[0] + bounds[row] + Matrix3::identity() * leash;
            blocks[own(columns, row)] += alone;
            let first = pairs_at.partition_point(|at| (at.0 as usize) < row);
            for &(_, slot) in pairs_at[first..].iter().take_while(|at| at.0 as usize == row) {
                let pair = &pairs[slot as usize / 4];
                let mine = pair.pressing[slot as usize % 4];
                for (q, pressing) in pair.particles.iter().zip(pair.pressing) {
                    let within = columns.binary_search(q).expect("pairs are in the pattern");
                    blocks[within] += mine * pressing.transpose();
                }
            }
        });
    }

    fn keep_definite_part(&mut self) {
        let Relaxation { body, hessian, .. } = self;
        hessian.as_mut().expect("what was linearized has a Hessian").fill_blocks(body, true);
    }

    fn hessian_times(&self, direction: &[Vector3], product: &mut [Vector3]) {
        let Hessian { tangent, blocks, pairs, definite, points, .. } = self.hessian();
        product.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, product)| {
            for (k, product) in product.iter_mut().enumerate() {
                let row = chunk * CHUNK + k;
                *product = blocks.row_times(row, direction) + tangent.bending_times(row, direction);
            }
        });
        for pair in pairs {
            if *definite {
                let moved = pair.particles.iter().zip(pair.pressing);
                let rate: f64 = moved.clone().map(|(&p, pressing)| pressing.dot(&direction[p as usize])).sum();
                moved.for_each(|(&p, pressing)| product[p as usize] += pressing * rate);
            } else {
                let mut moved = SVector::<f64, 12>::zeros();
                for (k, &p) in pair.particles.iter().enumerate() {
                    moved.fixed_rows_mut::<3>(3 * k).copy_from(&direction[p as usize]);
                }
                let pull = pair.block * moved;
                for (k, &p) in pair.particles.iter().enumerate() {
                    product[p as usize] += pull.fixed_rows::<3>(3 * k);
                }
            }
        }
        self.body.middles_times(points, direction, product);
        for hold in &self.energy.holds {
            hold.hessian_times(points, direction, product);
        }
    }

    fn near_matrix(&self) -> &BlockMatrix {
        &self.hessian().near
    }
}
