//! What is known of distances from the body while the cloth moves little.

use crate::garment::Level;
use crate::geometry::Vector3;
use rayon::prelude::*;

/// Lower bounds of how far the particles and triangles of a level are from the body, m: who moves comes nearer by no more
/// than its move. Clearing the body moves few particles by more than a hair; the others need not be measured again.
pub struct DistanceBounds {
    /// Of particles outside the body; negative where nothing is known.
    pub particles: Vec<f64>,
    /// Of triangles that do not cross the body: there are twice as many, and a bound need not be sharp.
    pub triangles: Vec<f32>,
    /// Where the bounds hold.
    places: Vec<Vector3>,
}

/// Nothing is known of a distance.
const UNKNOWN: f64 = f64::NEG_INFINITY;

impl DistanceBounds {
    /// Nothing is known yet.
    pub fn unknown(level: &Level, positions: &[Vector3]) -> Self {
        Self {
            particles: vec![UNKNOWN; positions.len()],
            triangles: vec![f32::NEG_INFINITY; level.triangles.len()],
            places: positions.to_vec(),
        }
    }

    /// The cloth has moved.
    pub fn follow(&mut self, level: &Level, positions: &[Vector3]) {
        let moves: Vec<f64> = self
            .places
            .par_iter_mut()
            .zip(positions)
            .zip(&mut self.particles)
            .with_min_len(PARTICLES_ALONE)
            .map(|((place, &position), bound)| {
                let by = (position - std::mem::replace(place, position)).norm();
                *bound -= by;
                by
            })
            .collect();
        self.triangles.par_iter_mut().enumerate().with_min_len(PARTICLES_ALONE).for_each(|(t, bound)| {
            let by = level.particles(t).map(|p| moves[p as usize]).into_iter().fold(0.0, f64::max);
            if by > 0.0 {
                *bound = below(f64::from(*bound) - by);
            }
        });
    }
}

/// The next smaller single: of what is a bound nothing may be rounded up.
pub fn below(bound: f64) -> f32 {
    (bound as f32).next_down()
}

/// To a thread at least: what is done for each is cheap.
const PARTICLES_ALONE: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::shapes;

    #[test]
    fn bounds_fall_by_what_was_moved_and_by_the_farthest_corner_of_a_triangle() {
        let level = Garment::build(&shapes::tube(0.2, 0.3), &[0.1]).unwrap().levels.remove(0);
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        let mut bounds = DistanceBounds::unknown(&level, &positions);
        bounds.particles.fill(0.01);
        bounds.triangles.fill(below(0.01));
        let moved = level.particles(0)[1];
        positions[moved as usize].y += 0.004;
        bounds.follow(&level, &positions);
        bounds.follow(&level, &positions);
        for (p, &bound) in bounds.particles.iter().enumerate() {
            assert_eq!(bound, if p as u32 == moved { 0.01 - 0.004 } else { 0.01 });
        }
        for (t, &bound) in bounds.triangles.iter().enumerate() {
            let (bound, wanted) =
                (f64::from(bound), if level.particles(t).contains(&moved) { 0.01 - 0.004 } else { 0.01 });
            assert!(bound <= wanted && bound > wanted - 1e-8, "{bound}");
        }
    }
}
