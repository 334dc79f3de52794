//! From a coarser level to the next finer one, without new intersections.
//!
//! Barycentric prolongation lays the fine cloth on the coarse surface, which is free of
//! intersections. Where a curved outline reaches beyond the coarse triangles positions are
//! extrapolated, and where a fine triangle lies across a sharp coarse fold it cuts the fold short:
//! there the fine cloth may cross other cloth. Such particles are first taken back onto the coarse
//! surface; what still crosses is smoothed, which pulls the cutting corners out.

use crate::assess::ClothCrossings;
use crate::garment::{Garment, Level};
use crate::geometry::{EdgeTable, Vector3};

/// Rounds in which particles around what intersects are taken back, one ring more in each.
const TAKING_BACK: usize = 3;
/// Rounds in which they are smoothed after that.
const SMOOTHING: usize = 12;

/// Positions of level `level` from those of the level before it, m, world.
pub fn prolong(garment: &Garment, level: usize, positions: &[Vector3]) -> Vec<Vector3> {
    let (coarse, fine) = (&garment.levels[level - 1], &garment.levels[level]);
    let correspondence = &garment.correspondences[level - 1];
    let mut prolonged = correspondence.prolong(coarse, fine, positions);
    let mut crossings = ClothCrossings::new(fine, &prolonged);
    if crossings.pairs().is_empty() {
        return prolonged;
    }
    let neighbours = neighbours(fine);
    let safe = correspondence.prolong_within(coarse, fine, positions);
    for round in 0..TAKING_BACK + SMOOTHING {
        let taking_back = round < TAKING_BACK;
        let region = around(fine, crossings.pairs(), &neighbours, if taking_back { round } else { 1 });
        let moved: Vec<Vector3> = region
            .iter()
            .map(|&p| if taking_back { safe[p as usize] } else { mean(&neighbours[p as usize], &prolonged) })
            .collect();
        region.iter().zip(moved).for_each(|(&p, to)| prolonged[p as usize] = to);
        crossings.update(&prolonged, &region);
        if crossings.pairs().is_empty() {
            break;
        }
    }
    prolonged
}

fn mean(of: &[u32], positions: &[Vector3]) -> Vector3 {
    of.iter().map(|&p| positions[p as usize]).sum::<Vector3>() / of.len() as f64
}

/// Particles on an edge with each particle.
fn neighbours(level: &Level) -> Vec<Vec<u32>> {
    let mut neighbours = vec![Vec::new(); level.particle_count];
    for edge in EdgeTable::new(&level.particle_triangles()).edges {
        let [a, b] = edge.ends;
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(a);
    }
    neighbours
}

/// The particles of crossing triangles and of `rings` rings around them, ascending.
fn around(level: &Level, crossing: &[[u32; 2]], neighbours: &[Vec<u32>], rings: usize) -> Vec<u32> {
    let mut region: Vec<u32> = crossing.iter().flatten().flat_map(|&t| level.particles(t as usize)).collect();
    for _ in 0..rings {
        let ring: Vec<u32> = region.iter().flat_map(|&p| &neighbours[p as usize]).copied().collect();
        region.extend(ring);
        region.sort_unstable();
        region.dedup();
    }
    region.sort_unstable();
    region.dedup();
    region
}
