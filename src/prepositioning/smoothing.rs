//! Cloth that crosses cloth is smoothed there: what cuts through something is pulled out of it.

use crate::assess::ClothCrossings;
use crate::garment::Level;
use crate::geometry::{EdgeTable, Vector3};

/// Rounds of smoothing, at most.
const MOST_ROUNDS: usize = 12;

/// The particles on an edge with each particle of a level.
pub struct Neighbours(Vec<Vec<u32>>);

impl Neighbours {
    pub fn of(level: &Level) -> Self {
        let mut neighbours = vec![Vec::new(); level.particle_count];
        for edge in EdgeTable::new(&level.particle_triangles()).edges {
            let [a, b] = edge.ends;
            neighbours[a as usize].push(b);
            neighbours[b as usize].push(a);
        }
        Self(neighbours)
    }

    /// The particles of crossing triangles and of `rings` rings around them, ascending.
    pub fn around(&self, level: &Level, crossing: &[[u32; 2]], rings: usize) -> Vec<u32> {
        let mut region: Vec<u32> = crossing.iter().flatten().flat_map(|&t| level.particles(t as usize)).collect();
        for _ in 0..rings {
            let ring: Vec<u32> = region.iter().flat_map(|&p| &self.0[p as usize]).copied().collect();
            region.extend(ring);
            region.sort_unstable();
            region.dedup();
        }
        region.sort_unstable();
        region.dedup();
        region
    }

    fn mean(&self, particle: u32, positions: &[Vector3]) -> Vector3 {
        let of = &self.0[particle as usize];
        of.iter().map(|&p| positions[p as usize]).sum::<Vector3>() / of.len() as f64
    }
}

/// Moves particles around crossing triangles to the middles of their neighbours, m, until nothing crosses or the rounds are
/// used up. `crossings` are those at `positions`, and are kept so.
pub fn smooth(level: &Level, neighbours: &Neighbours, crossings: &mut ClothCrossings, positions: &mut [Vector3]) {
    for _ in 0..MOST_ROUNDS {
        if crossings.pairs().is_empty() {
            break;
        }
        let region = neighbours.around(level, crossings.pairs(), 1);
        let moved: Vec<Vector3> = region.iter().map(|&p| neighbours.mean(p, positions)).collect();
        region.iter().zip(moved).for_each(|(&p, to)| positions[p as usize] = to);
        crossings.update(positions, &region);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::geometry::Vector2;
    use crate::pattern::shapes::two_rectangles;

    /// Two sheets a centimetre apart, of which a particle in the middle of the lower one sticks through the upper one.
    #[test]
    fn what_sticks_through_is_pulled_out_and_the_rest_stays() {
        let mut pattern = two_rectangles(0.2, 0.2);
        pattern.seams.clear();
        let level = Garment::build(&pattern, &[0.02]).unwrap().levels.remove(0);
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        // Not one particle right above another, through which nothing passes.
        for (panel, aside) in level.panels.iter().zip([Vector3::zeros(), Vector3::new(0.007, 0.01, 0.004)]) {
            for k in panel.points.clone() {
                let rest = level.rest[k];
                positions[level.particle_of[k] as usize] = Vector3::new(rest.x, 0.0, rest.y) + aside;
            }
        }
        let flat = positions.clone();
        let off_center = |k: &usize| (level.rest[*k] - Vector2::new(0.1, 0.1)).norm();
        let center = level.panels[0].points.clone().min_by(|a, b| off_center(a).total_cmp(&off_center(b))).unwrap();
        positions[level.particle_of[center] as usize].y = 0.03;
        let mut crossings = ClothCrossings::new(&level, &positions);
        assert!(!crossings.pairs().is_empty());
        smooth(&level, &Neighbours::of(&level), &mut crossings, &mut positions);
        assert!(crossings.pairs().is_empty());
        assert!(ClothCrossings::new(&level, &positions).pairs().is_empty());
        let moved = positions.iter().zip(&flat).filter(|(p, q)| p != q).count();
        assert!((1..40).contains(&moved), "{moved}");
    }
}
