//! Vectors of many points: sums and differences in parallel, sums of numbers in a fixed order.

use super::{CHUNK, LEAST_CHUNKS};
use crate::geometry::Vector3;
use rayon::prelude::*;

/// `sum = points + moves`.
pub fn add(points: &[Vector3], moves: &[Vector3], sum: &mut [Vector3]) {
    combine(points, moves, sum, |p, m| p + m);
}

/// `difference = a - b`.
pub fn subtract(a: &[Vector3], b: &[Vector3], difference: &mut [Vector3]) {
    combine(a, b, difference, |a, b| a - b);
}

fn combine(a: &[Vector3], b: &[Vector3], to: &mut [Vector3], of: impl Fn(&Vector3, &Vector3) -> Vector3 + Sync) {
    let chunks = to.par_chunks_mut(CHUNK).zip(a.par_chunks(CHUNK)).zip(b.par_chunks(CHUNK));
    chunks.with_min_len(LEAST_CHUNKS).for_each(|((to, a), b)| {
        for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
            *to = of(a, b);
        }
    });
}

/// `to += factor * by`; returns `with · to` of the new `to`, in the same sweep.
pub fn add_scaled(to: &mut [Vector3], by: &[Vector3], factor: f64, with: &[Vector3]) -> f64 {
    let chunks = to.par_chunks_mut(CHUNK).zip(by.par_chunks(CHUNK)).zip(with.par_chunks(CHUNK));
    let sums: Vec<f64> = chunks
        .with_min_len(LEAST_CHUNKS)
        .map(|((to, by), with)| {
            let mut sum = 0.0;
            for ((to, by), with) in to.iter_mut().zip(by).zip(with) {
                *to += by * factor;
                sum += with.dot(to);
            }
            sum
        })
        .collect();
    sums.iter().sum()
}

/// `to = factor * of / diagonal`, point by point; returns `with · to`.
pub fn divide(of: &[Vector3], diagonal: &[f64], factor: f64, to: &mut [Vector3], with: &[Vector3]) -> f64 {
    let chunks = to.par_chunks_mut(CHUNK).zip(of.par_chunks(CHUNK));
    let chunks = chunks.zip(diagonal.par_chunks(CHUNK)).zip(with.par_chunks(CHUNK));
    let sums: Vec<f64> = chunks
        .with_min_len(LEAST_CHUNKS)
        .map(|(((to, of), diagonal), with)| {
            let mut sum = 0.0;
            for (((to, of), d), with) in to.iter_mut().zip(of).zip(diagonal).zip(with) {
                *to = of * (factor / d);
                sum += with.dot(to);
            }
            sum
        })
        .collect();
    sums.iter().sum()
}

/// `moves = step * direction`, none longer than `largest`; tells whether any was shortened.
pub fn capped(direction: &[Vector3], step: f64, largest: f64, moves: &mut [Vector3]) -> bool {
    let chunks = moves.par_chunks_mut(CHUNK).zip(direction.par_chunks(CHUNK)).with_min_len(LEAST_CHUNKS);
    let chunks = chunks.map(|(moves, direction)| {
        let mut shortened = false;
        for (m, d) in moves.iter_mut().zip(direction) {
            *m = d * step;
            let length = m.norm();
            if length > largest {
                *m *= largest / length;
                shortened = true;
            }
        }
        shortened
    });
    chunks.reduce(|| false, |a, b| a || b)
}
