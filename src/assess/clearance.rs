//! How near the cloth comes to the body: its particles, and whatever lies between them.

use crate::body::Body;
use crate::garment::Level;
use crate::geometry::Vector3;
use rayon::prelude::*;

/// Distances of the cloth from the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// The least of a particle, m, negative inside the body.
    pub least: f64,
    /// Particles inside the body.
    pub inside: usize,
    /// Particles nearer than the clearance asked for, less [`CLEARANCE_TOLERANCE`].
    pub too_near: usize,
    /// The least distance of any point of the cloth, m: by exact distances of triangles, zero where some cross.
    pub least_of_cloth: f64,
    /// Triangles nearer than the clearance asked for, less [`CLEARANCE_TOLERANCE`].
    pub triangles_too_near: usize,
}

/// How far below its clearance cloth may be and count as clear, m.
pub const CLEARANCE_TOLERANCE: f64 = 1e-4;
/// How far beyond the clearance distances are measured, m.
const REACH: f64 = 0.005;

impl Clearance {
    /// Of cloth that was asked to keep `clearance`, m.
    pub fn of(level: &Level, positions: &[Vector3], body: &Body, clearance: f64) -> Self {
        // Only what is near the body decides; the distances of the rest are not worth an exact query.
        let reach = clearance.max(0.0) + REACH;
        let distances: Vec<f64> = positions
            .par_iter()
            .with_min_len(256)
            .map(|&p| {
                let near = body.nearest(p, reach).map_or(reach, |n| n.distance);
                if !body.contains(p) {
                    return near;
                }
                -body.nearest(p, f64::INFINITY).map_or(0.0, |n| n.distance)
            })
            .collect();
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let target = clearance - CLEARANCE_TOLERANCE;
        // The triangles of the nearest particle come at least as near as it does.
        let near = near_triangles(level, positions, body, clearance.max(least));
        Self {
            least,
            inside: distances.iter().filter(|&&d| d < 0.0).count(),
            too_near: distances.iter().filter(|&&d| d < target).count(),
            least_of_cloth: near.iter().map(|&(_, distance)| distance).fold(reach, f64::min),
            triangles_too_near: near.iter().filter(|&&(_, distance)| distance < target).count(),
        }
    }
}

/// Triangles of the cloth that are no farther from the body's skin than `within`, m, in order, with their distances; zero
/// for those that cross it.
pub fn near_triangles(level: &Level, positions: &[Vector3], body: &Body, within: f64) -> Vec<(u32, f64)> {
    let corners = |t: usize| level.particles(t).map(|p| positions[p as usize]);
    (0..level.triangles.len())
        .into_par_iter()
        .with_min_len(512)
        .filter_map(|t| Some((t as u32, body.distance_to_triangle(corners(t), within)?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::PanelRange;
    use crate::geometry::Vector2;

    /// One triangle, level, above a ball of one metre that stands on the floor.
    fn above(corners: [[f64; 2]; 3], heights: [f64; 3]) -> (Level, Vec<Vector3>) {
        let level = Level {
            resolution: 1.0,
            particle_count: 3,
            panels: vec![PanelRange { points: 0..3, triangles: 0..1 }],
            rest: vec![Vector2::zeros(); 3],
            particle_of: vec![0, 1, 2],
            triangles: vec![[0, 1, 2]],
            stitches: vec![],
            hinges: vec![],
            seams: vec![],
            segments: vec![],
            eased: vec![],
        };
        let positions = (0..3).map(|k| Vector3::new(corners[k][0], heights[k], corners[k][1])).collect();
        (level, positions)
    }

    #[test]
    fn clearances_count_who_is_inside_and_who_is_too_near() {
        let body = crate::body::shapes::ball();
        let (level, positions) = above([[0.0, 0.0]; 3], [1.1, 1.00095, 0.98]);
        let clearance = Clearance::of(&level, &positions, &body, 0.001);
        assert_eq!((clearance.inside, clearance.too_near), (1, 1), "{clearance:?}");
        assert!((clearance.least + 0.02).abs() < 1e-4);
        assert_eq!((clearance.least_of_cloth, clearance.triangles_too_near), (0.0, 1), "{clearance:?}");
    }

    #[test]
    fn what_lies_between_particles_counts() {
        let body = crate::body::shapes::ball();
        // The corners are 10 cm from the top of the ball, which sags 10.1 mm there; the middle of the triangle does not.
        let corner = |angle: f64| [0.1 * angle.sin(), 0.1 * angle.cos()];
        let (level, positions) = above([0.0, 2.1, 4.2].map(corner), [1.002; 3]);
        let measured = |clearance: f64| Clearance::of(&level, &positions, &body, clearance);
        assert_eq!((measured(0.003).too_near, measured(0.003).triangles_too_near), (0, 1));
        assert_eq!(measured(0.0019).triangles_too_near, 0);
        for clearance in [0.0, 0.001, 0.003] {
            let found = measured(clearance);
            assert!((found.least_of_cloth - 0.002).abs() < 1e-4 || clearance < 0.002, "{found:?}");
            assert!(found.least > 0.009 || found.least == clearance + REACH, "{found:?}");
        }
        // Beside the ball nothing is measured.
        let far = above([[3.0, 0.0], [3.1, 0.0], [3.0, 0.1]], [1.0; 3]);
        assert_eq!(Clearance::of(&far.0, &far.1, &body, 0.001).least_of_cloth, 0.001 + REACH);
    }
}
