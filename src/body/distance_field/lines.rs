//! Which nodes are inside, by winding numbers along lines of nodes.

use super::super::Body;
use super::super::winding::crossing_sense;
use super::grid::Grid;
use std::ops::Range;

/// Where the lines along x through the nodes of some layers cross the body.
pub struct Lines {
    /// Line within the layers, z running faster than y; x of the crossing, m; its sense. By line, then by x.
    crossings: Vec<(u32, f64, i8)>,
}

impl Lines {
    /// `triangles` are those that reach into the layers.
    pub fn new(body: &Body, grid: &Grid, layers: Range<usize>, triangles: &[u32]) -> Self {
        let mut crossings = Vec::new();
        for &t in triangles {
            let corners = body.corners(t);
            let [a, b, c] = corners;
            let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
            let ys = grid.nodes(1, low.y, high.y);
            let zs = grid.nodes(2, low.z, high.z);
            let normal = (b - a).cross(&(c - a));
            for y in ys.start.max(layers.start)..ys.end.min(layers.end) {
                for z in zs.clone() {
                    let point = grid.position([0, y, z]);
                    let sense = crossing_sense(point, corners);
                    if sense != 0 {
                        let x = a.x - ((point.y - a.y) * normal.y + (point.z - a.z) * normal.z) / normal.x;
                        // Of a sliver seen on edge the division is worth nothing, its extent is.
                        let x = if x.is_nan() { a.x } else { x.clamp(low.x, high.x) };
                        let line = (y - layers.start) * grid.extent[2] + z;
                        crossings.push((line as u32, x, sense as i8));
                    }
                }
            }
        }
        crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        Self { crossings }
    }

    /// Calls `visit` with the range of nodes of each stretch inside the body, counted within the layers.
    pub fn for_each_inside(&self, grid: &Grid, mut visit: impl FnMut(Range<usize>)) {
        let to_node = |x: f64| ((x - grid.origin.x) / grid.cell).ceil() as usize;
        for line in self.crossings.chunk_by(|a, b| a.0 == b.0) {
            let (mut winding, mut entry) = (0, 0);
            for &(number, x, sense) in line {
                // A surface that faces -x is entered.
                let before = winding;
                winding -= i32::from(sense);
                let first = number as usize * grid.extent[0];
                if before <= 0 && winding > 0 {
                    entry = to_node(x);
                } else if before > 0 && winding <= 0 {
                    visit(first + entry..first + to_node(x));
                }
            }
        }
    }
}
