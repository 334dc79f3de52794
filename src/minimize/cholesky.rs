//! Sparse Cholesky factors of block matrices, by faer, in single precision.
//!
//! They serve as preconditioners, which need no more than single precision, at half the time and memory. The matrix is
//! scaled to a diagonal of ones before, so that soft bending is not rounded away beside stiff stretching.

use super::block_matrix::{BlockMatrix, Pattern};
use super::dissection::nested_dissection;
use crate::geometry::Vector3;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

/// What is added to the diagonal, as a share of it, where rounding has left a matrix without a factor; ten times as much
/// each time, as often as [`MOST_SHIFTS`].
const LEAST_SHIFT: f32 = 1e-5;
const MOST_SHIFTS: i32 = 3;

/// A factorization `S M S = L Lᵀ`, about, and the memory to renew it for matrices of the same pattern.
pub struct Cholesky {
    symbolic: SymbolicCholesky<u32>,
    /// Lower triangle of the matrix, by columns.
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f32>,
    /// Diagonal of `S`: one over the roots of the matrix's own.
    scale: Vec<Vector3>,
    factor: Vec<f32>,
    work: MemBuffer,
    right: Vec<f32>,
}

impl Cholesky {
    /// Analyses a pattern. `places` tell where the points lie.
    pub fn new(pattern: &Pattern, places: &[Vector3]) -> Self {
        let count = 3 * pattern.rows();
        let (mut starts, mut rows) = (vec![0u32], Vec::new());
        for point in 0..pattern.rows() {
            let below = || pattern.row(point).iter().filter(|&&q| q as usize > point);
            for within in 0..3 {
                rows.extend((within..3).map(|r| (3 * point + r) as u32));
                rows.extend(below().flat_map(|&q| (0..3).map(move |r| 3 * q + r)));
                starts.push(rows.len() as u32);
            }
        }
        let order: Vec<u32> =
            nested_dissection(pattern, places).into_iter().flat_map(|p| (0..3).map(move |k| 3 * p + k)).collect();
        let mut place = vec![0; count];
        order.iter().enumerate().for_each(|(at, &row)| place[row as usize] = at as u32);
        let lower = SymbolicSparseColMatRef::new_checked(count, count, &starts, None, &rows);
        let order = PermRef::new_checked(&order, &place, count);
        let symbolic =
            factorize_symbolic_cholesky(lower, Side::Lower, SymmetricOrdering::Custom(order), Default::default())
                .expect("memory for the structure of a factor");
        let numeric = symbolic.factorize_numeric_llt_scratch::<f32>(Par::Seq, Spec::default());
        let solve = symbolic.solve_in_place_scratch::<f32>(1, Par::Seq);
        Self {
            values: vec![0.0; rows.len()],
            scale: vec![Vector3::zeros(); pattern.rows()],
            factor: vec![0.0; symbolic.len_val()],
            work: MemBuffer::new(numeric.or(solve)),
            right: vec![0.0; count],
            symbolic,
            starts,
            rows,
        }
    }

    /// Numbers that the factor has.
    pub fn size(&self) -> usize {
        self.factor.len()
    }

    /// Factors a matrix of the pattern, or one near it whose diagonal is slightly larger. Returns whether that is positive
    /// definite; if not, there is no factor to solve with.
    pub fn factorize(&mut self, matrix: &BlockMatrix) -> bool {
        for (point, scale) in self.scale.iter_mut().enumerate() {
            let own = matrix.own_block(point).diagonal();
            if own.min() <= 0.0 {
                return false;
            }
            *scale = own.map(|d| d.sqrt().recip());
        }
        let shifts = (0..MOST_SHIFTS).map(|times| LEAST_SHIFT * 10_f32.powi(times));
        std::iter::once(0.0).chain(shifts).any(|shift| {
            self.set_values(matrix, 1.0 + shift);
            self.factorize_values()
        })
    }

    fn set_values(&mut self, matrix: &BlockMatrix, diagonal: f32) {
        let mut at = 0;
        for point in 0..self.scale.len() {
            // The matrix is symmetric: a row of blocks is the column.
            let blocks = matrix.pattern().row(point).iter().zip(matrix.row(point));
            let below = || blocks.clone().filter(|(q, _)| **q as usize >= point);
            for within in 0..3 {
                for (q, block) in below() {
                    let own = *q as usize == point;
                    let (mine, scale) = (self.scale[point][within], self.scale[*q as usize]);
                    for r in if own { within } else { 0 }..3 {
                        self.values[at] = (block[(within, r)] * mine * scale[r]) as f32;
                        if own && r == within {
                            self.values[at] = diagonal;
                        }
                        at += 1;
                    }
                }
            }
        }
    }

    fn factorize_values(&mut self) -> bool {
        let count = self.right.len();
        let lower = SymbolicSparseColMatRef::new_checked(count, count, &self.starts, None, &self.rows);
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                SparseColMatRef::new(lower, &self.values),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.work),
                Spec::default(),
            )
            .is_ok()
    }

    /// `M⁻¹ right`, to single precision.
    pub fn solve(&mut self, right: &[Vector3], solution: &mut [Vector3]) {
        // Forces of any unit are brought into the range of single precision.
        let largest = right.iter().zip(&self.scale).map(|(r, s)| r.component_mul(s).amax()).fold(0.0, f64::max);
        let unit = if largest > 0.0 { largest } else { 1.0 };
        for ((row, right), scale) in self.right.chunks_exact_mut(3).zip(right).zip(&self.scale) {
            (0..3).for_each(|k| row[k] = (right[k] * scale[k] / unit) as f32);
        }
        let count = self.right.len();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut self.right, count, 1),
            Par::Seq,
            MemStack::new(&mut self.work),
        );
        for ((solution, row), scale) in solution.iter_mut().zip(self.right.chunks_exact(3)).zip(&self.scale) {
            (0..3).for_each(|k| solution[k] = f64::from(row[k]) * scale[k] * unit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector, Matrix3};

    /// A grid of points with a definite matrix of its triangles, and the same matrix dense.
    fn grid(side: u32) -> (BlockMatrix, Vec<Vector3>, DMatrix<f64>) {
        let at = |i: u32, j: u32| j * side + i;
        let triangles: Vec<[u32; 3]> = (0..side - 1)
            .flat_map(|j| (0..side - 1).map(move |i| (i, j)))
            .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]])
            .collect();
        let count = (side * side) as usize;
        let pattern = Pattern::of_triangles(count, triangles.into_iter()).with_groups(&[[0, 1, 7, side * side - 1]]);
        let mut matrix = BlockMatrix::zeros(pattern);
        matrix.fill(|row, columns, blocks| {
            for (&column, block) in columns.iter().zip(blocks) {
                let (i, j) = (row.min(column as usize) as f64, row.max(column as usize) as f64);
                let shear = 0.1 * (i + 2.0 * j).sin();
                let coupling = Matrix3::new(-1.0, shear, 0.0, shear, -0.5, 0.2, 0.0, 0.2, -0.7);
                *block = if row == column as usize { Matrix3::identity() * 12.0 } else { coupling };
            }
        });
        let mut dense = DMatrix::zeros(3 * count, 3 * count);
        for row in 0..count {
            for (&column, block) in matrix.pattern().row(row).iter().zip(matrix.row(row)) {
                dense.fixed_view_mut::<3, 3>(3 * row, 3 * column as usize).copy_from(block);
            }
        }
        let places = (0..side * side).map(|p| Vector3::new(f64::from(p % side), f64::from(p / side), 0.0)).collect();
        (matrix, places, dense)
    }

    #[test]
    fn solves_what_a_dense_factor_solves() {
        for side in [3, 14] {
            let (matrix, places, dense) = grid(side);
            let right: Vec<Vector3> =
                (0..places.len()).map(|k| Vector3::new((k as f64).sin(), 1.0, 0.3 * k as f64)).collect();
            let mut factor = Cholesky::new(matrix.pattern(), &places);
            assert!(factor.factorize(&matrix));
            let mut solution = vec![Vector3::zeros(); right.len()];
            factor.solve(&right, &mut solution);
            let flat = DVector::from_iterator(3 * right.len(), right.iter().flat_map(|r| r.iter().copied()));
            let expected = dense.cholesky().unwrap().solve(&flat);
            for (k, x) in solution.iter().flat_map(|s| s.iter()).enumerate() {
                assert!((x - expected[k]).abs() < 1e-6 * expected.amax(), "{x} is not {}", expected[k]);
            }
        }
    }

    #[test]
    fn single_precision_bears_any_unit_and_soft_beside_stiff() {
        let (mut matrix, places, _) = grid(9);
        // Points softer by a factor of 10¹² than their neighbours.
        matrix.fill(|row, columns, blocks| {
            let own = columns.binary_search(&(row as u32)).unwrap();
            blocks[own] = Matrix3::identity() * if row % 2 == 0 { 1e12 } else { 1.0 };
        });
        let mut factor = Cholesky::new(matrix.pattern(), &places);
        assert!(factor.factorize(&matrix));
        for unit in [0.0, 1e-60, 1.0, 1e60] {
            let right = vec![Vector3::new(unit, -unit, 0.5 * unit); places.len()];
            let mut solution = vec![Vector3::repeat(f64::NAN); places.len()];
            factor.solve(&right, &mut solution);
            for (row, (x, r)) in solution.iter().zip(&right).enumerate() {
                let error = matrix.own_block(row) * x - r;
                assert!(error.norm() <= 1e-6 * r.norm(), "{x} is off by {error} of {r}");
            }
        }
    }

    #[test]
    fn what_rounding_has_made_singular_has_a_factor_near_it() {
        let (mut matrix, places, _) = grid(5);
        matrix.fill(|row, columns, blocks| {
            for (&column, block) in columns.iter().zip(blocks) {
                // Hardly definite: every row's own entry is by 10⁻¹² larger than what the others sum up to.
                let own = (columns.len() - 1) as f64 * (1.0 + 1e-12);
                *block = Matrix3::identity() * if column as usize == row { own } else { -1.0 };
            }
        });
        let mut factor = Cholesky::new(matrix.pattern(), &places);
        assert!(factor.factorize(&matrix));
        let right: Vec<Vector3> = (0..25).map(|k| Vector3::repeat(if k % 2 == 0 { 12.0 } else { -13.0 })).collect();
        let mut solution = vec![Vector3::zeros(); 25];
        factor.solve(&right, &mut solution);
        assert!(solution.iter().all(|x| x.norm().is_finite()));
    }

    #[test]
    fn what_is_not_definite_has_no_factor() {
        let (mut matrix, places, _) = grid(5);
        matrix.fill(|row, columns, blocks| {
            let own = columns.binary_search(&(row as u32)).unwrap();
            blocks[own] = Matrix3::identity() * if row == 12 { -1.0 } else { 1.0 };
        });
        assert!(!Cholesky::new(matrix.pattern(), &places).factorize(&matrix));
    }

    #[test]
    fn a_dissection_names_every_point_once() {
        let (matrix, places, _) = grid(14);
        let mut order = nested_dissection(matrix.pattern(), &places);
        order.sort_unstable();
        assert!(order.iter().enumerate().all(|(k, &p)| k == p as usize) && order.len() == 196);
    }
}
