//! Distances that spread from the nodes near the surface, ring by ring.

use super::grid::Grid;
use crate::geometry::Vector3;
use rayon::prelude::*;

/// The nearest triangle of each node, where one is known, and its squared distance, m².
pub struct Nearest {
    pub squared: Vec<f32>,
    pub triangle: Vec<u32>,
}

/// A node that knows no triangle.
pub const UNKNOWN: u32 = u32::MAX;

/// Nodes to a piece of parallel work.
const CHUNK: usize = 1024;

impl Nearest {
    /// Nodes within `exact`, m, know their triangle. Spreads from there through the inside, and outside up to `reach`, m: a node takes the nearest of its
    /// neighbours' triangles (closest-feature propagation, as in fast marching).
    ///
    /// Each ring looks twice, first at those before it, then at itself.
    pub fn spread(
        &mut self,
        grid: &Grid,
        inside: &[bool],
        exact: f64,
        reach: f64,
        squared_distance: impl Fn(u32, Vector3) -> f64 + Sync,
    ) {
        let squared_reach = (reach * reach) as f32;
        let squared_exact = (exact * exact) as f32;
        let strides = [1, grid.layer(), grid.extent[0]];
        let around = |node: usize| strides.into_iter().flat_map(move |s| [node - s, node + s]);
        // Nodes at the border of the grid are far from the body and stay unknown.
        let [nx, ny, nz] = grid.extent;
        let inner = |node: usize| {
            let [x, y, z] = [node % nx, node / grid.layer(), node / nx % nz];
            [x, y, z].iter().zip([nx, ny, nz]).all(|(&c, n)| c >= 1 && c + 1 < n)
        };
        // In which ring each node is; those of exact distance are in the first.
        let mut ring_of: Vec<u32> =
            self.squared.iter().map(|&s| if s <= squared_exact { 0 } else { UNKNOWN }).collect();
        let mut ring: Vec<usize> = (0..ring_of.len()).filter(|&n| ring_of[n] == 0).collect();
        for number in 1.. {
            let mut next = Vec::new();
            for &node in ring.iter().filter(|&&node| inner(node)) {
                if inside[node] || self.squared[node] < squared_reach {
                    for beside in around(node) {
                        if ring_of[beside] == UNKNOWN && inner(beside) {
                            ring_of[beside] = number;
                            next.push(beside);
                        }
                    }
                }
            }
            if next.is_empty() {
                return;
            }
            for own_ring in [false, true] {
                let found: Vec<(f32, u32)> = next
                    .par_iter()
                    .with_min_len(CHUNK)
                    .map(|&node| {
                        let point = grid.position([node % nx, node / grid.layer(), node / nx % nz]);
                        let mut best = (self.squared[node], self.triangle[node]);
                        let mut seen = [UNKNOWN; 6];
                        for (k, beside) in around(node).enumerate() {
                            let triangle = self.triangle[beside];
                            let looked_at = (ring_of[beside] == number) == own_ring && triangle != UNKNOWN;
                            if looked_at && triangle != best.1 && !seen.contains(&triangle) {
                                seen[k] = triangle;
                                let squared = squared_distance(triangle, point) as f32;
                                if squared < best.0 {
                                    best = (squared, triangle);
                                }
                            }
                        }
                        best
                    })
                    .collect();
                for (&node, (squared, triangle)) in next.iter().zip(found) {
                    (self.squared[node], self.triangle[node]) = (squared, triangle);
                }
            }
            ring = next;
        }
    }
}
