//! Symmetric sparse matrices of 3 × 3 blocks, one row of blocks per point.

use super::CHUNK;
use crate::geometry::Vector3;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Which blocks of a matrix may differ from zero: every diagonal one, and `(i, j)` together with `(j, i)`.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Where each row starts in `columns`; one more than rows.
    starts: Vec<u32>,
    /// Ascending within a row.
    columns: Vec<u32>,
}

/// A symmetric matrix; both triangles are stored.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    pattern: Pattern,
    /// One per column of the pattern.
    blocks: Vec<Matrix3<f64>>,
}

impl Pattern {
    /// The diagonal and the pairs of all points that share a triangle.
    pub fn of_triangles(point_count: usize, triangles: impl Iterator<Item = [u32; 3]> + Clone) -> Self {
        let mut counts = vec![1u32; point_count + 1];
        counts[0] = 0;
        for p in triangles.clone().flatten() {
            counts[p as usize + 1] += 2;
        }
        for i in 0..point_count {
            counts[i + 1] += counts[i];
        }
        let mut next = counts.clone();
        let mut all = vec![0u32; counts[point_count] as usize];
        let mut put = |row: u32, column: u32| {
            all[next[row as usize] as usize] = column;
            next[row as usize] += 1;
        };
        (0..point_count as u32).for_each(|p| put(p, p));
        for [a, b, c] in triangles {
            for (row, one, other) in [(a, b, c), (b, c, a), (c, a, b)] {
                put(row, one);
                put(row, other);
            }
        }
        let mut pattern = Self { starts: vec![0], columns: Vec::with_capacity(7 * point_count) };
        for row in 0..point_count {
            let columns = &mut all[counts[row] as usize..counts[row + 1] as usize];
            columns.sort_unstable();
            let mut last = None;
            for &column in columns.iter() {
                if last != Some(column) {
                    pattern.columns.push(column);
                }
                last = Some(column);
            }
            pattern.starts.push(pattern.columns.len() as u32);
        }
        pattern
    }

    /// The same with all pairs within each of some groups of points.
    pub fn with_groups(&self, groups: &[[u32; 4]]) -> Self {
        let mut added: Vec<(u32, u32)> = Vec::with_capacity(12 * groups.len());
        for group in groups {
            for &row in group {
                added.extend(group.iter().filter(|&&column| column != row).map(|&column| (row, column)));
            }
        }
        added.sort_unstable();
        added.dedup();
        let mut pattern = Self { starts: vec![0], columns: Vec::with_capacity(self.columns.len() + added.len()) };
        let mut next = added.iter().peekable();
        for row in 0..self.rows() {
            let first = pattern.columns.len();
            pattern.columns.extend_from_slice(self.row(row));
            let own = pattern.columns.len();
            while let Some(&&(_, column)) = next.peek().filter(|(r, _)| *r as usize == row) {
                if pattern.columns[first..own].binary_search(&column).is_err() {
                    pattern.columns.push(column);
                }
                next.next();
            }
            pattern.columns[first..].sort_unstable();
            pattern.starts.push(pattern.columns.len() as u32);
        }
        pattern
    }

    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns of a row, ascending.
    pub fn row(&self, row: usize) -> &[u32] {
        &self.columns[self.range(row)]
    }

    fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }
}

impl BlockMatrix {
    pub fn zeros(pattern: Pattern) -> Self {
        Self { blocks: vec![Matrix3::zeros(); pattern.columns.len()], pattern }
    }

    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Computes all blocks anew, row by row, in parallel: `fill` gets a row, its columns and its blocks, which are zero.
    pub fn fill(&mut self, fill: impl Fn(usize, &[u32], &mut [Matrix3<f64>]) + Sync) {
        let (pattern, rows) = (&self.pattern, self.pattern.rows());
        let mut chunks = Vec::with_capacity(rows.div_ceil(CHUNK));
        let mut rest = &mut self.blocks[..];
        for first in (0..rows).step_by(CHUNK) {
            let last = (first + CHUNK).min(rows);
            let (chunk, after) = rest.split_at_mut((pattern.starts[last] - pattern.starts[first]) as usize);
            chunks.push((first..last, chunk));
            rest = after;
        }
        chunks.into_par_iter().for_each(|(rows, blocks)| {
            blocks.fill(Matrix3::zeros());
            let offset = pattern.starts[rows.start] as usize;
            for row in rows {
                let range = pattern.range(row);
                fill(row, &pattern.columns[range.clone()], &mut blocks[range.start - offset..range.end - offset]);
            }
        });
    }

    /// Blocks of a row, in the order of its columns.
    pub fn row(&self, row: usize) -> &[Matrix3<f64>] {
        &self.blocks[self.pattern.range(row)]
    }

    /// The block on the diagonal.
    pub fn own_block(&self, row: usize) -> Matrix3<f64> {
        let within = self.pattern.row(row).binary_search(&(row as u32)).expect("rows have their diagonal");
        self.row(row)[within]
    }

    /// Row of the matrix times a vector.
    #[inline]
    pub fn row_times(&self, row: usize, vector: &[Vector3]) -> Vector3 {
        let range = self.pattern.range(row);
        let mut sum = Vector3::zeros();
        for (&column, block) in self.pattern.columns[range.clone()].iter().zip(&self.blocks[range]) {
            sum += block * vector[column as usize];
        }
        sum
    }
}
