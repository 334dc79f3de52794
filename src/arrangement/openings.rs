//! The openings that a garment will have once it is sewn: hems, cuffs, necklines.
//!
//! A part of the body comes out of each of them. A trouser leg whose panels start beside the ankle closes beside it,
//! though no stitch has the body in its way. What tells is that a panel's part of the hem does not face the ankle.

use crate::body::{Body, DistanceField};
use crate::garment::Level;
use crate::geometry::{EdgeTable, UnionFind, Vector3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// The part of an opening that runs along one panel.
pub struct Arc {
    pub panel: usize,
    /// How many particles of the open level it has.
    pub particles: usize,
    /// The middle of the particles, and how far they are from it at most; as placed, m.
    pub middle: Vector3,
    pub reach: f64,
}

/// The parts of the openings that run along at least two panels: those of one lie flat until it is sewn to a tube.
/// `panel_of` tells the panel of each particle of the open level, `positions` where it is, m.
pub fn arcs(open: &Level, panel_of: &[usize], positions: &[Vector3]) -> Vec<Arc> {
    let mut sewn = UnionFind::new(open.particle_count);
    open.stitches.iter().for_each(|&[a, b]| sewn.union(a, b));
    // Rims that are sewn together have the same ends.
    let mut rims: BTreeMap<[u32; 2], Vec<[u32; 2]>> = BTreeMap::new();
    for edge in EdgeTable::new(&open.particle_triangles()).edges.iter().filter(|edge| edge.triangles.len() == 1) {
        let [a, b] = edge.ends.map(|p| sewn.find(p));
        rims.entry([a.min(b), a.max(b)]).or_default().push(edge.ends);
    }
    rims.retain(|[a, b], edges| edges.len() == 1 && a != b);
    let mut lines = UnionFind::new(open.particle_count);
    rims.keys().for_each(|&[a, b]| lines.union(a, b));
    let mut openings: BTreeMap<u32, BTreeMap<usize, BTreeSet<u32>>> = BTreeMap::new();
    for (&[a, _], edges) in &rims {
        let panels = openings.entry(lines.find(a)).or_default();
        panels.entry(panel_of[edges[0][0] as usize]).or_default().extend(edges[0]);
    }
    let arc = |(panel, particles): (usize, BTreeSet<u32>)| {
        let at = || particles.iter().map(|&p| positions[p as usize]);
        let middle = at().sum::<Vector3>() / particles.len() as f64;
        let reach = at().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        Arc { panel, particles: particles.len(), middle, reach }
    };
    openings.into_values().filter(|panels| panels.len() > 1).flatten().map(arc).collect()
}

/// Points along the middle of limbs, trunk and head.
pub struct Core {
    points: Vec<Vector3>,
}

/// Distance between nodes among which the points are sought, m: three across an ankle.
const SPACING: f64 = 0.02;
/// The points are at least this deep in the body, m.
const DEPTH: f64 = 0.008;
/// Half of the directions in which the outermost points are sought.
const DIRECTIONS: usize = 8;

impl Core {
    /// Nodes of a grid that are deeper in the body than their neighbours along two axes.
    pub fn new(body: &Body, field: &DistanceField) -> Self {
        let (low, high) = body.bounds();
        let count = ((high - low) / SPACING).map(|n| n.ceil() as usize + 1);
        let place = |x: usize, y: usize, z: usize| low + Vector3::new(x as f64, y as f64, z as f64) * SPACING;
        let of_layer = |y: usize| {
            let mut points = Vec::new();
            for (z, x) in (0..count.z).flat_map(|z| (0..count.x).map(move |x| (z, x))) {
                let point = place(x, y, z);
                let distance = field.distance(point);
                let is_deepest = |axis: usize| {
                    let by = Vector3::from_fn(|k, _| if k == axis { SPACING } else { 0.0 });
                    field.distance(point - by) >= distance && field.distance(point + by) >= distance
                };
                if distance < -DEPTH && (0..3).filter(|&axis| is_deepest(axis)).count() > 1 {
                    points.push(point);
                }
            }
            points
        };
        Self { points: (0..count.y).into_par_iter().flat_map_iter(of_layer).collect() }
    }

    /// How far the ray from `from` along `direction`, of length one, passes beside what it should meet, m: the core that
    /// is ahead within `reach`, together with all between. Two legs in one hem may have it between them.
    pub fn aside(&self, from: Vector3, direction: Vector3, reach: f64) -> f64 {
        let across = direction.cross(&if direction.y.abs() < 0.9 { Vector3::y() } else { Vector3::x() }).normalize();
        let up = direction.cross(&across);
        let mut nearest = f64::INFINITY;
        // By direction: how far the points are that way, at least and at most.
        let mut least = [f64::INFINITY; DIRECTIONS];
        let mut most = [f64::NEG_INFINITY; DIRECTIONS];
        let ways: [(f64, f64); DIRECTIONS] =
            std::array::from_fn(|k| (std::f64::consts::PI * k as f64 / DIRECTIONS as f64).sin_cos());
        for point in &self.points {
            let to = point - from;
            if to.dot(&direction) < 0.0 {
                continue;
            }
            let (x, y) = (to.dot(&across), to.dot(&up));
            let squared = x * x + y * y;
            nearest = nearest.min(squared);
            if squared < reach * reach {
                for (k, (sin, cos)) in ways.iter().enumerate() {
                    let far = x * cos + y * sin;
                    least[k] = least[k].min(far);
                    most[k] = most[k].max(far);
                }
            }
        }
        let nearest = nearest.sqrt();
        if nearest >= reach {
            return nearest;
        }
        least.iter().zip(&most).map(|(least, most)| least.max(-most)).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::shapes;

    #[test]
    fn two_rectangles_that_are_sewn_at_one_side_have_one_opening_around_both() {
        let pattern = shapes::two_rectangles(0.2, 0.3);
        let open = Garment::build(&pattern, &[0.03]).unwrap().open;
        let mut panel_of = vec![0; open.particle_count];
        panel_of[open.panels[1].points.clone()].fill(1);
        let positions: Vec<Vector3> = open.rest.iter().map(|p| Vector3::new(p.x, p.y, 0.0)).collect();
        let found = arcs(&open, &panel_of, &positions);
        assert_eq!(found.iter().map(|arc| arc.panel).collect::<Vec<_>>(), [0, 1]);
        for arc in found {
            // Three sides: eleven particles along the seam are no part of it but for its ends.
            let whole = open.panels[arc.panel].points.len();
            assert!(arc.particles > 20 && arc.particles < whole, "{} of {whole}", arc.particles);
            assert!((arc.reach - 0.5 * 0.2f64.hypot(0.3)).abs() < 0.06, "{}", arc.reach);
        }
    }

    #[test]
    fn a_ray_should_meet_the_core_or_pass_between_its_parts() {
        // Two balls of 10 cm, 30 cm apart: their cores are crosses that end 8 mm below the skin.
        let [left, right] = [-0.15, 0.15].map(|x| crate::body::shapes::sphere(Vector3::new(x, 0.0, 0.0), 0.05, 16));
        let count = left.0.len() as u32;
        let positions = [left.0, right.0].concat();
        let triangles = [left.1, right.1.iter().map(|t| t.map(|v| v + count)).collect()].concat();
        let body = Body::new(positions, triangles).unwrap().0;
        let core = Core::new(&body, &DistanceField::new(&body, 0.01, 0.04));
        assert!(!core.points.is_empty() && core.points.iter().all(|p| (p.x.abs() - 0.15).abs() < 0.043));
        let aside = |x: f64, reach: f64| core.aside(Vector3::new(x, 0.0, 1.0), -Vector3::z(), reach);
        assert!(aside(0.15, 0.1) < 0.02 && aside(0.0, 0.3) < 0.02);
        for x in [0.24, 0.4] {
            let (least, most) = (x - 0.15 - 0.043, x - 0.15 - 0.02);
            assert!((least..most).contains(&aside(x, 0.1)), "{}", aside(x, 0.1));
        }
        assert!(core.aside(Vector3::new(0.15, 0.0, 1.0), Vector3::z(), 0.1) > 1.0, "what lies behind does not count");
    }
}
