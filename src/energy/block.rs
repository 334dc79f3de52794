//! Many triangles, or springs, at a time: what [`Triangle`] and [`CrossSpring`] compute, step by step over
//! a block.
//!
//! Each step is a plain loop that the compiler turns into vector instructions; written triangle by
//! triangle the same arithmetic stays scalar, and waits for one root and one quotient after the
//! other.

use super::bending::CrossSpring;
use super::lanes::Lanes;
use super::membrane::{SHORTEST, Triangle};

/// Triangles of a block: what lies between two steps, 5 kB, is to stay in the innermost cache, and a
/// patch should not have many lanes left over.
const BLOCK: usize = 32;
/// Numbers that lie side by side where several belong to a triangle, so that memory is read in order.
const FOUR: usize = 4;

/// One number for each triangle, or spring.
type Row = [f64; BLOCK];

/// Some triangles, laid out in the order in which they are read.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// Places of the corners.
    corners: [[u32; 3]; BLOCK],
    /// `1/L` of the edges opposite to each corner, 1/m.
    inverse_rest: [Row; 3],
    /// `K`, J: (00, 11, 22, 12, 02, 01), of four triangles after four.
    stiffness: [[Lanes; 6]; BLOCK / FOUR],
}

/// What one step leaves for the next: by edge, then by triangle. Springs have one edge.
pub struct Steps {
    span: [[Lanes; BLOCK]; 3],
    moved: [[Lanes; BLOCK]; 3],
    strain: [Row; 3],
    /// `1/l`, guarded, 1/m.
    inverse_length: [Row; 3],
    along: [Row; 3],
    across: [Row; 3],
    /// Tensions over lengths, N/m.
    pulls: [Row; 3],
    results: Row,
}

impl Default for Steps {
    fn default() -> Self {
        let (vectors, rows) = ([[Lanes::ZERO; BLOCK]; 3], [[0.0; BLOCK]; 3]);
        Self {
            span: vectors,
            moved: vectors,
            strain: rows,
            inverse_length: rows,
            along: rows,
            across: rows,
            pulls: rows,
            results: [0.0; BLOCK],
        }
    }
}

impl TriangleBlock {
    /// Triangles with the places of their corners, in blocks. What is left over of the last one has no
    /// stiffness and no extent.
    pub fn all(triangles: &[([u32; 3], &Triangle)]) -> Vec<Self> {
        triangles.chunks(BLOCK).map(Self::new).collect()
    }

    fn new(triangles: &[([u32; 3], &Triangle)]) -> Self {
        let mut block = Self {
            corners: [[0; 3]; BLOCK],
            inverse_rest: [[1.0; BLOCK]; 3],
            stiffness: [[Lanes::ZERO; 6]; BLOCK / FOUR],
        };
        for (t, (places, triangle)) in triangles.iter().enumerate() {
            block.corners[t] = *places;
            (0..3).for_each(|k| block.inverse_rest[k][t] = triangle.inverse_rest[k]);
            (0..6).for_each(|k| block.stiffness[t / FOUR][k].0[t % FOUR] = triangle.stiffness[k]);
        }
        block
    }

    #[inline(always)]
    fn spans(&self, vectors: &[Lanes], span: &mut [[Lanes; BLOCK]; 3]) {
        for (t, &[a, b, c]) in self.corners.iter().enumerate() {
            let (a, b, c) = (vectors[a as usize], vectors[b as usize], vectors[c as usize]);
            span[0][t] = c - b;
            span[1][t] = a - c;
            span[2][t] = b - a;
        }
    }

    /// Spans, strains and lengths.
    #[inline(always)]
    fn edges(&self, positions: &[Lanes], steps: &mut Steps) {
        self.spans(positions, &mut steps.span);
        for k in 0..3 {
            strains(&steps.span[k], &self.inverse_rest[k], &mut steps.strain[k], &mut steps.inverse_length[k]);
        }
    }

    /// Adds twice the energy of triangles, J, to sums by lane, and the gradient, N, to the forces at the
    /// corners.
    #[inline(always)]
    pub fn evaluate(&self, positions: &[Lanes], forces: &mut [Lanes], steps: &mut Steps, energy: &mut Lanes) {
        self.edges(positions, steps);
        let Steps { span, strain, inverse_length, pulls, .. } = steps;
        for (n, stiffness) in self.stiffness.iter().enumerate() {
            let (strain, inverse_rest) = (four(strain, n), four(&self.inverse_rest, n));
            let (stress, inverse) = (product(stiffness, strain), four(inverse_length, n));
            *energy += stress[0] * strain[0] + stress[1] * strain[1] + stress[2] * strain[2];
            set_four(&mut pulls[0], n, stress[0] * inverse_rest[0] * inverse[0]);
            set_four(&mut pulls[1], n, stress[1] * inverse_rest[1] * inverse[1]);
            set_four(&mut pulls[2], n, stress[2] * inverse_rest[2] * inverse[2]);
        }
        for t in 0..BLOCK {
            let [a, b, c] = self.corners[t];
            let p = span[0][t] * Lanes::splat(pulls[0][t]);
            let q = span[1][t] * Lanes::splat(pulls[1][t]);
            let r = span[2][t] * Lanes::splat(pulls[2][t]);
            forces[a as usize] += q - r;
            forces[b as usize] += r - p;
            forces[c as usize] += p - q;
        }
    }

    /// Adds `dᵀ H d` of triangles, without what buckling would make negative, to sums by lane.
    #[inline(always)]
    pub fn curvature(&self, positions: &[Lanes], direction: &[Lanes], steps: &mut Steps, sum: &mut Lanes) {
        self.edges(positions, steps);
        let Steps { span, moved, strain, inverse_length, along, across, .. } = steps;
        self.spans(direction, moved);
        for k in 0..3 {
            rates(&span[k], &moved[k], &inverse_length[k], &mut along[k], &mut across[k]);
        }
        for (n, stiffness) in self.stiffness.iter().enumerate() {
            let (inverse_rest, inverse) = (four(&self.inverse_rest, n), four(inverse_length, n));
            let (along, across) = (four(along, n), four(across, n));
            let stress = product(stiffness, four(strain, n));
            let rate = [along[0] * inverse_rest[0], along[1] * inverse_rest[1], along[2] * inverse_rest[2]];
            let pull = product(stiffness, rate);
            *sum += pull[0] * rate[0] + pull[1] * rate[1] + pull[2] * rate[2];
            *sum += (stress[0] * inverse_rest[0]).positive() * inverse[0] * across[0]
                + (stress[1] * inverse_rest[1]).positive() * inverse[1] * across[1]
                + (stress[2] * inverse_rest[2]).positive() * inverse[2] * across[2];
        }
    }
}

/// Some springs.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct SpringBlock {
    /// Places of the ends.
    ends: [[u32; 2]; BLOCK],
    /// `1/L`, 1/m.
    inverse_rest: Row,
    /// J.
    stiffness: Row,
}

impl SpringBlock {
    /// Springs with the places of their ends, in blocks. What is left over of the last one has no
    /// stiffness and no extent.
    pub fn all(springs: &[([u32; 2], &CrossSpring)]) -> Vec<Self> {
        springs.chunks(BLOCK).map(Self::new).collect()
    }

    fn new(springs: &[([u32; 2], &CrossSpring)]) -> Self {
        let mut block = Self { ends: [[0; 2]; BLOCK], inverse_rest: [1.0; BLOCK], stiffness: [0.0; BLOCK] };
        for (s, (places, spring)) in springs.iter().enumerate() {
            block.ends[s] = *places;
            block.inverse_rest[s] = spring.inverse_rest;
            block.stiffness[s] = spring.stiffness;
        }
        block
    }

    #[inline(always)]
    fn spans(&self, vectors: &[Lanes], span: &mut [Lanes; BLOCK]) {
        for (s, &[a, b]) in self.ends.iter().enumerate() {
            span[s] = vectors[b as usize] - vectors[a as usize];
        }
    }

    /// As of triangles.
    #[inline(always)]
    pub fn evaluate(&self, positions: &[Lanes], forces: &mut [Lanes], steps: &mut Steps, energy: &mut Lanes) {
        let Steps { span: [span, ..], strain: [strain, ..], inverse_length: [inverse, ..], .. } = steps;
        let (pulls, results) = (&mut steps.pulls[0], &mut steps.results);
        self.spans(positions, span);
        strains(span, &self.inverse_rest, strain, inverse);
        for s in 0..BLOCK {
            let stress = self.stiffness[s] * strain[s];
            results[s] = stress * strain[s];
            pulls[s] = stress * self.inverse_rest[s] * inverse[s];
        }
        add_row(energy, results);
        for s in 0..BLOCK {
            let [a, b] = self.ends[s];
            let pull = span[s] * Lanes::splat(pulls[s]);
            forces[a as usize] -= pull;
            forces[b as usize] += pull;
        }
    }

    /// As of triangles.
    #[inline(always)]
    pub fn curvature(&self, positions: &[Lanes], direction: &[Lanes], steps: &mut Steps, sum: &mut Lanes) {
        let Steps { span: [span, ..], strain: [strain, ..], inverse_length: [inverse, ..], .. } = steps;
        let (moved, along, across) = (&mut steps.moved[0], &mut steps.along[0], &mut steps.across[0]);
        let results = &mut steps.results;
        self.spans(positions, span);
        self.spans(direction, moved);
        strains(span, &self.inverse_rest, strain, inverse);
        rates(span, moved, inverse, along, across);
        for s in 0..BLOCK {
            let (rate, tension) = (along[s] * self.inverse_rest[s], strain[s] * self.inverse_rest[s]);
            results[s] = self.stiffness[s] * (rate * rate + positive(tension) * inverse[s] * across[s]);
        }
        add_row(sum, results);
    }
}

/// The `n`-th four numbers of three rows.
#[inline(always)]
fn four(rows: &[Row; 3], n: usize) -> [Lanes; 3] {
    let row = |k: usize| Lanes(rows[k].as_chunks().0[n]);
    [row(0), row(1), row(2)]
}

#[inline(always)]
fn set_four(row: &mut Row, n: usize, value: Lanes) {
    row.as_chunks_mut().0[n] = value.0;
}

/// `K e`.
#[inline(always)]
fn product(k: &[Lanes; 6], e: [Lanes; 3]) -> [Lanes; 3] {
    [
        k[0] * e[0] + k[5] * e[1] + k[4] * e[2],
        k[5] * e[0] + k[1] * e[1] + k[3] * e[2],
        k[4] * e[0] + k[3] * e[1] + k[2] * e[2],
    ]
}

#[inline(always)]
fn strains(span: &[Lanes; BLOCK], inverse_rest: &Row, strain: &mut Row, inverse_length: &mut Row) {
    for t in 0..BLOCK {
        let length = dot(span[t], span[t]).sqrt();
        strain[t] = length * inverse_rest[t] - 1.0;
        // Collapsed edges have no direction; they pull like the shortest that has one.
        let (inverse, longest) = (1.0 / length, inverse_rest[t] * (1.0 / SHORTEST));
        inverse_length[t] = if inverse < longest { inverse } else { longest };
    }
}

/// Moves along edges, and the squares of those across them.
#[inline(always)]
fn rates(span: &[Lanes; BLOCK], moved: &[Lanes; BLOCK], inverse_length: &Row, along: &mut Row, across: &mut Row) {
    for t in 0..BLOCK {
        let forward = dot(span[t], moved[t]) * inverse_length[t];
        along[t] = forward;
        across[t] = positive(dot(moved[t], moved[t]) - forward * forward);
    }
}

/// The fourth numbers are zero; were they left out, compilers would do the last vector of a row number by number.
#[inline(always)]
fn dot(Lanes(a): Lanes, Lanes(b): Lanes) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

#[inline(always)]
fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

#[inline(always)]
fn add_row(sum: &mut Lanes, row: &Row) {
    for four in row.as_chunks().0 {
        *sum += Lanes(*four);
    }
}
