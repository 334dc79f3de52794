//! From a coarser level to the next finer one, without new intersections.
//!
//! Barycentric prolongation lays the fine cloth on the coarse surface, which is free of
//! intersections. Only where a curved outline reaches beyond the coarse triangles are positions
//! extrapolated, and there they may cross other cloth. Such particles are taken back onto the coarse
//! surface: first safe, then smooth as the level is relaxed.

use crate::assess::cloth_intersections;
use crate::garment::Garment;
use crate::geometry::Vector3;

/// How often particles around what still intersects are taken back.
const MOST_ROUNDS: usize = 4;

/// Positions of level `level` from those of the level before it.
pub fn prolong(garment: &Garment, level: usize, positions: &[Vector3]) -> Vec<Vector3> {
    let (coarse, fine) = (&garment.levels[level - 1], &garment.levels[level]);
    let correspondence = &garment.correspondences[level - 1];
    let mut prolonged = correspondence.prolong(coarse, fine, positions);
    for _ in 0..MOST_ROUNDS {
        let crossing = cloth_intersections(fine, &prolonged);
        if crossing.is_empty() {
            break;
        }
        let mut taken_back = vec![false; fine.particle_count];
        for t in crossing.into_iter().flatten() {
            for p in fine.particles(t as usize) {
                taken_back[p as usize] = true;
            }
        }
        let safe = correspondence.prolong_within(coarse, fine, positions);
        for (p, safe) in safe.into_iter().enumerate() {
            if taken_back[p] {
                prolonged[p] = safe;
            }
        }
    }
    prolonged
}
