//! From a coarser level to the next finer one, without new intersections.
//!
//! Barycentric prolongation lays the fine cloth on the coarse surface, which is free of
//! intersections. Where a curved outline reaches beyond the coarse triangles positions are
//! extrapolated, and where a fine triangle lies across a sharp coarse fold it cuts the fold short:
//! there the fine cloth may cross other cloth. Such particles are first taken back onto the coarse
//! surface; what still crosses is smoothed, which pulls the cutting corners out.

use super::smoothing::{Neighbours, smooth};
use crate::assess::ClothCrossings;
use crate::garment::Garment;
use crate::geometry::Vector3;

/// Rounds in which particles around what intersects are taken back, one ring more in each.
const TAKING_BACK: usize = 3;

/// Positions of level `level` from those of the level before it, m, world, and how many pairs of triangles cross there.
pub fn prolong(garment: &Garment, level: usize, positions: &[Vector3]) -> (Vec<Vector3>, usize) {
    let (coarse, fine) = (&garment.levels[level - 1], &garment.levels[level]);
    let correspondence = &garment.correspondences[level - 1];
    let mut prolonged = correspondence.prolong(coarse, fine, positions);
    let mut crossings = ClothCrossings::new(fine, &prolonged);
    if crossings.pairs().is_empty() {
        return (prolonged, 0);
    }
    let neighbours = Neighbours::of(fine);
    let safe = correspondence.prolong_within(coarse, fine, positions);
    for rings in 0..TAKING_BACK {
        let region = neighbours.around(fine, crossings.pairs(), rings);
        region.iter().for_each(|&p| prolonged[p as usize] = safe[p as usize]);
        crossings.update(&prolonged, &region);
        if crossings.pairs().is_empty() {
            return (prolonged, 0);
        }
    }
    smooth(fine, &neighbours, &mut crossings, &mut prolonged);
    (prolonged, crossings.pairs().len())
}
