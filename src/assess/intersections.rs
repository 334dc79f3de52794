//! Exact intersections of triangles, of the cloth with the body and with itself.

use crate::body::Body;
use crate::garment::Level;
use crate::geometry::{RunTree, Vector3, segment_meets_triangle, triangles_intersect};
use rayon::prelude::*;

/// Pairs of a cloth triangle and a body triangle that cross, in order.
pub fn body_intersections(level: &Level, positions: &[Vector3], body: &Body) -> Vec<[u32; 2]> {
    let corners = |t: usize| level.particles(t).map(|p| positions[p as usize]);
    (0..level.triangles.len())
        .into_par_iter()
        .with_min_len(512)
        .flat_map_iter(|t| crossed(corners(t), body).into_iter().map(move |u| [t as u32, u]))
        .collect()
}

/// The triangles of a body that a triangle crosses, hidden ones as well, in order.
pub fn crossed(corners: [Vector3; 3], body: &Body) -> Vec<u32> {
    let ([a, b, c], mut met) = (corners, Vec::new());
    body.for_each_meeting(a.inf(&b).inf(&c), a.sup(&b).sup(&c), |u| {
        if triangles_intersect(corners, body.corners(u)) {
            met.push(u);
        }
    });
    met.sort_unstable();
    met
}

/// Pairs of cloth triangles that cross, in order. Triangles that share one particle, within a panel or over a seam, cross
/// where the side of one that lies opposite to it passes through the other; triangles that share two have no such side.
pub fn cloth_intersections(level: &Level, positions: &[Vector3]) -> Vec<[u32; 2]> {
    ClothCrossings::new(level, positions).pairs
}

/// The pairs of [`cloth_intersections`], kept up to date where particles move.
pub struct ClothCrossings {
    triangles: Vec<[u32; 3]>,
    /// Boxes around the triangles where they are.
    tree: RunTree,
    pairs: Vec<[u32; 2]>,
}

impl ClothCrossings {
    pub fn new(level: &Level, positions: &[Vector3]) -> Self {
        let triangles = level.particle_triangles();
        let tree = RunTree::new(triangles.iter().map(|t| around(t, positions)));
        let mut pairs = tree.collect_pairs(|t, u, found| {
            if cross(&triangles, t, u, positions) {
                found.push([t, u]);
            }
        });
        pairs.sort_unstable();
        Self { triangles, tree, pairs }
    }

    /// Crossing pairs, the smaller index first, in order.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// To be called when the particles `moved`, and no others, have new positions.
    pub fn update(&mut self, positions: &[Vector3], moved: &[u32]) {
        let mut has_moved = vec![false; positions.len()];
        moved.iter().for_each(|&p| has_moved[p as usize] = true);
        let touched: Vec<bool> = self.triangles.iter().map(|t| t.iter().any(|&p| has_moved[p as usize])).collect();
        let (triangles, is_touched) = (&self.triangles, |t: u32| touched[t as usize]);
        let moved: Vec<u32> = (0..triangles.len() as u32).filter(|&t| is_touched(t)).collect();
        self.tree.update(moved.iter().map(|&t| (t, around(&triangles[t as usize], positions))));
        self.pairs.retain(|&[t, u]| !is_touched(t) && !is_touched(u));
        for &t in &moved {
            self.tree.for_each_meeting(t, |u| {
                // Two that moved are asked about once.
                if (u > t || !is_touched(u)) && cross(triangles, t, u, positions) {
                    self.pairs.push([t.min(u), t.max(u)]);
                }
            });
        }
        self.pairs.sort_unstable();
    }
}

fn around(triangle: &[u32; 3], positions: &[Vector3]) -> (Vector3, Vector3) {
    let [a, b, c] = triangle.map(|p| positions[p as usize]);
    (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
}

fn cross(triangles: &[[u32; 3]], t: u32, u: u32, positions: &[Vector3]) -> bool {
    let (one, other) = (triangles[t as usize], triangles[u as usize]);
    let at = |p: u32| positions[p as usize];
    let opposite = |one: [u32; 3], shared: usize| [one[(shared + 1) % 3], one[(shared + 2) % 3]].map(at);
    let mut shared = (0..3).filter_map(|k| Some((k, other.iter().position(|&p| p == one[k])?)));
    match (shared.next(), shared.next()) {
        (None, _) => triangles_intersect(one.map(at), other.map(at)),
        (Some((k, l)), None) => {
            let (one_side, other_side) = (opposite(one, k), opposite(other, l));
            !lie_apart(at(one[k]), one_side, other_side)
                && (segment_meets_triangle(one_side, other.map(at)) || segment_meets_triangle(other_side, one.map(at)))
        }
        (Some(_), Some(_)) => false,
    }
}

/// Does a plane through the corner that two triangles share part the sides opposite to it for certain? Most triangles around a
/// particle lie so, on this side of it and on that.
fn lie_apart(corner: Vector3, one: [Vector3; 2], other: [Vector3; 2]) -> bool {
    /// Far above what rounding makes of differences and their products.
    const CERTAIN: f64 = 1e-10;
    let ([a, b], [c, d]) = (one.map(|p| p - corner), other.map(|p| p - corner));
    let normal = a + b - c - d;
    let least = CERTAIN * normal.norm_squared();
    normal.dot(&a) > least && normal.dot(&b) > least && normal.dot(&c) < -least && normal.dot(&d) < -least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::{Garment, PanelRange};
    use crate::geometry::Vector2;
    use crate::pattern::shapes;
    use proptest::prelude::*;

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
    fn crossing_panels_are_found() {
        let level = two_triangles();
        let mut positions: Vec<Vector3> =
            [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0.2, 0.2, -1.], [0.2, 0.3, 1.], [0.3, 0.2, 1.]]
                .map(Vector3::from)
                .to_vec();
        assert_eq!(cloth_intersections(&level, &positions), [[0, 1]]);
        positions[3].z = 0.5;
        assert!(cloth_intersections(&level, &positions).is_empty());
    }

    /// A side seam of trousers went through the triangle next but one: both triangles at the edge shared a corner with it.
    #[test]
    fn triangles_that_share_a_corner_cross_where_the_side_opposite_to_it_does() {
        let mut level = two_triangles();
        level.particle_of[3] = 0;
        let mut positions: Vec<Vector3> =
            [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [9., 9., 9.], [0.2, 0.3, 1.], [0.3, 0.2, -1.]]
                .map(Vector3::from)
                .to_vec();
        assert_eq!(cloth_intersections(&level, &positions), [[0, 1]]);
        positions[5].z = 0.5;
        assert!(cloth_intersections(&level, &positions).is_empty());
        // Hinged at two corners they fold, however far.
        positions[5].z = -1.0;
        level.particle_of[4] = 1;
        assert!(cloth_intersections(&level, &positions).is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        #[test]
        fn what_the_tree_finds_is_what_looking_at_every_pair_finds(seed in 0.0..100.0f64, rough in 0.01..0.04f64, every in 1..30usize) {
            let level = Garment::build(&shapes::tube(0.3, 0.2), &[0.03]).unwrap().levels.remove(0);
            let wave = |k: usize, step: f64| (k as f64 * step + seed).sin() * rough;
            let crumpled = |k: usize, turn: usize| {
                let noise = Vector3::new(wave(k, 12.9898), wave(k, 78.233), wave(k + turn, 37.719));
                Vector3::new(level.rest[k].x, level.rest[k].y, 0.0) + noise
            };
            let mut positions: Vec<Vector3> = (0..level.particle_count).map(|k| crumpled(k, 0)).collect();
            let plainly = |positions: &[Vector3]| -> Vec<[u32; 2]> {
                let (triangles, n) = (level.particle_triangles(), level.triangles.len() as u32);
                let pairs = (0..n).flat_map(|t| (t + 1..n).map(move |u| [t, u]));
                pairs.filter(|&[t, u]| cross(&triangles, t, u, positions)).collect()
            };
            let mut crossings = ClothCrossings::new(&level, &positions);
            prop_assert!(rough < 0.02 || !crossings.pairs().is_empty());
            prop_assert_eq!(crossings.pairs(), plainly(&positions));
            let moved: Vec<u32> = (0..positions.len() as u32).step_by(every).collect();
            moved.iter().for_each(|&p| positions[p as usize] = crumpled(p as usize, 5));
            crossings.update(&positions, &moved);
            prop_assert_eq!(crossings.pairs(), plainly(&positions));
        }
    }

    proptest! {
        #[test]
        fn what_lies_apart_does_not_cross(places in proptest::array::uniform4(proptest::array::uniform3(-1.0..1.0f64)), flat in 0.0..1.0f64) {
            let corner = Vector3::new(1.1, -0.4, 1.7);
            let [a, b, c, d] = places.map(|[x, y, z]| corner + Vector3::new(x, y, flat * z) * 0.01);
            let meet = segment_meets_triangle([a, b], [corner, c, d]) || segment_meets_triangle([c, d], [corner, a, b]);
            prop_assert!(!(meet && lie_apart(corner, [a, b], [c, d])));
        }
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
