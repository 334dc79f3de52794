//! Nodes in space, in layers from the feet up.

use crate::geometry::Vector3;
use std::ops::Range;

/// A regular grid of nodes. A layer has one height; in it x runs faster than z.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// World position of node 0, m.
    pub origin: Vector3,
    /// Side of a cell, m.
    pub cell: f64,
    /// Nodes along x, y, z.
    pub extent: [usize; 3],
}

impl Grid {
    /// Nodes in a layer.
    pub fn layer(&self) -> usize {
        self.extent[0] * self.extent[2]
    }

    pub fn position(&self, [x, y, z]: [usize; 3]) -> Vector3 {
        self.origin + Vector3::new(x as f64, y as f64, z as f64) * self.cell
    }

    /// The nodes along an axis that lie in `low..high`, m, as far as the grid has them.
    pub fn nodes(&self, axis: usize, low: f64, high: f64) -> Range<usize> {
        // Casts round towards zero and stop there; functions that round are calls.
        let at = |c: f64| (c - self.origin[axis]) / self.cell;
        let low = at(low);
        let first = low as usize;
        let first = first + usize::from((first as f64) < low);
        first..((at(high) + 1.0) as usize).min(self.extent[axis])
    }
}

/// For each slab of `layers` layers, which boxes reach into it, ascending.
pub fn by_slab(grid: &Grid, layers: usize, boxes: impl Iterator<Item = [f64; 2]>) -> Vec<Vec<u32>> {
    let mut slabs = vec![Vec::new(); grid.extent[1].div_ceil(layers)];
    for ([low, high], index) in boxes.zip(0..) {
        let nodes = grid.nodes(1, low, high);
        if !nodes.is_empty() {
            slabs[nodes.start / layers..=(nodes.end - 1) / layers].iter_mut().for_each(|slab| slab.push(index));
        }
    }
    slabs
}
