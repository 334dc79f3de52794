//! Exact intersections of triangles, of the cloth with the body and with itself.

use crate::body::Body;
use crate::garment::Level;
use crate::geometry::{BoxTree, Vector3, triangles_intersect};
use rayon::prelude::*;

/// Pairs of a cloth triangle and a body triangle that cross, in order.
pub fn body_intersections(level: &Level, positions: &[Vector3], body: &Body) -> Vec<[u32; 2]> {
    let corners = |t: usize| level.particles(t).map(|p| positions[p as usize]);
    (0..level.triangles.len())
        .into_par_iter()
        .with_min_len(512)
        .flat_map_iter(|t| {
            let [a, b, c] = corners(t);
            let mut met = Vec::new();
            body.for_each_meeting(a.inf(&b).inf(&c), a.sup(&b).sup(&c), |u| {
                if triangles_intersect([a, b, c], body.corners(u)) {
                    met.push([t as u32, u]);
                }
            });
            met.sort_unstable();
            met
        })
        .collect()
}

/// Pairs of cloth triangles that cross, in order. Triangles that share a particle, within a panel or
/// over a seam, are no pair.
pub fn cloth_intersections(level: &Level, positions: &[Vector3]) -> Vec<[u32; 2]> {
    let triangles = level.particle_triangles();
    let corners = |t: usize| triangles[t].map(|p| positions[p as usize]);
    let tree = BoxTree::of_triangles((0..triangles.len()).map(corners), 0.0);
    (0..triangles.len())
        .into_par_iter()
        .with_min_len(512)
        .flat_map_iter(|t| {
            let [a, b, c] = corners(t);
            let mut met = Vec::new();
            tree.for_each_meeting(a.inf(&b).inf(&c), a.sup(&b).sup(&c), |u| {
                let apart = |p: &u32| !triangles[u as usize].contains(p);
                if u as usize > t
                    && triangles[t].iter().all(apart)
                    && triangles_intersect([a, b, c], corners(u as usize))
                {
                    met.push([t as u32, u]);
                }
            });
            met.sort_unstable();
            met
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::PanelRange;
    use crate::geometry::Vector2;

    /// Two triangles of two panels, not sewn.
    fn two_triangles() -> Level {
        Level {
            resolution: 1.0,
            particle_count: 6,
            panels: vec![PanelRange { points: 0..3, triangles: 0..1 }, PanelRange { points: 3..6, triangles: 1..2 }],
            rest: vec![Vector2::zeros(); 6],
            particle_of: (0..6).collect(),
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            stitches: vec![],
            hinges: vec![],
            seams: vec![],
            segments: vec![],
            eased: vec![],
        }
    }

    #[test]
    fn crossing_panels_are_found_unless_they_are_sewn_at_a_corner() {
        let mut level = two_triangles();
        let mut positions: Vec<Vector3> =
            [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0.2, 0.2, -1.], [0.2, 0.3, 1.], [0.3, 0.2, 1.]]
                .map(Vector3::from)
                .to_vec();
        assert_eq!(cloth_intersections(&level, &positions), [[0, 1]]);
        level.particle_of[3] = 0;
        assert!(cloth_intersections(&level, &positions).is_empty());
        level.particle_of[3] = 3;
        positions[3].z = 0.5;
        assert!(cloth_intersections(&level, &positions).is_empty());
    }

    #[test]
    fn a_triangle_that_dips_into_the_body_is_found() {
        let body = crate::body::shapes::ball();
        let level = two_triangles();
        let lifted = |y: f64| -> Vec<Vector3> {
            let flat = [[0.05, 0.05], [-0.05, 0.05], [0.0, -0.05]];
            (0..6).map(|k| Vector3::new(flat[k % 3][0], y + (k / 3) as f64, flat[k % 3][1])).collect()
        };
        assert!(!body_intersections(&level, &lifted(0.998), &body).is_empty());
        assert!(body_intersections(&level, &lifted(1.002), &body).is_empty());
    }
}
