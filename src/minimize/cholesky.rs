//! Sparse Cholesky factors of block matrices, by faer.

use super::block_matrix::{BlockMatrix, Pattern};
use super::dissection::nested_dissection;
use crate::geometry::Vector3;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

/// A factorization `M = L Lᵀ`, and the memory to renew it for matrices of the same pattern.
pub struct Cholesky {
    symbolic: SymbolicCholesky<u32>,
    /// Lower triangle of the matrix, by columns.
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
    factor: Vec<f64>,
    work: MemBuffer,
    right: Vec<f64>,
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
        let numeric = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
        let solve = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        Self {
            values: vec![0.0; rows.len()],
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

    /// Factors a matrix of the pattern. Returns whether it is positive definite; if not, there is no factor to solve with.
    pub fn factorize(&mut self, matrix: &BlockMatrix) -> bool {
        let count = self.right.len();
        let mut at = 0;
        for point in 0..count / 3 {
            // The matrix is symmetric: a row of blocks is the column.
            let blocks = matrix.pattern().row(point).iter().zip(matrix.row(point));
            let below = || blocks.clone().filter(|(q, _)| **q as usize >= point);
            for within in 0..3 {
                for (q, block) in below() {
                    let first = if *q as usize == point { within } else { 0 };
                    for r in first..3 {
                        self.values[at] = block[(within, r)];
                        at += 1;
                    }
                }
            }
        }
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

    /// `M⁻¹ right`.
    pub fn solve(&mut self, right: &[Vector3], solution: &mut [Vector3]) {
        for (row, right) in self.right.chunks_exact_mut(3).zip(right) {
            row.copy_from_slice(right.as_slice());
        }
        let count = self.right.len();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut self.right, count, 1),
            Par::Seq,
            MemStack::new(&mut self.work),
        );
        for (solution, row) in solution.iter_mut().zip(self.right.chunks_exact(3)) {
            solution.copy_from_slice(row);
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
                assert!((x - expected[k]).abs() < 1e-9 * expected.amax(), "{x} is not {}", expected[k]);
            }
            for (row, r) in right.iter().enumerate() {
                assert!((matrix.row_times(row, &solution) - r).norm() < 1e-9 * expected.amax());
            }
        }
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
