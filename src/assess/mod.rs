//! How good a state is: seams, strain, clearance, intersections. Nothing here changes anything.

mod clearance;
mod gate;
mod intersections;
mod layers;
mod strain;
mod tight;

pub use clearance::{CLEARANCE_TOLERANCE, Clearance, near_triangles};
pub use gate::{Check, LARGEST_SEAM_GAP, LARGEST_STRAIN_MEAN, LARGEST_STRAIN_P99, hand_off};
pub use intersections::{ClothCrossings, body_intersections, cloth_intersections, crossed};
pub use layers::Layers;
pub use strain::{Strain, gather_allowance, principal_stretches};
pub use tight::{Tight, tight_places};

use crate::body::Body;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::pattern::Pattern;
use std::collections::BTreeMap;

/// What was measured on a state of one level.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// Of all triangles.
    pub strain: Strain,
    /// The same, less what unequal seams impose on the triangles that touch them.
    pub strain_less_gathers: Strain,
    pub seams: SeamGaps,
    pub clearance: Clearance,
    pub intersections: Intersections,
}

/// Distances between points that are to be sewn together, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeamGaps {
    pub pairs: usize,
    pub largest: f64,
    pub mean: f64,
}

/// Triangles that cross each other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Intersections {
    /// Pairs of a cloth and a body triangle.
    pub body_pairs: usize,
    /// Pairs of cloth triangles.
    pub cloth_pairs: usize,
    /// Cloth triangles in any of these pairs, ascending.
    pub triangles: Vec<u32>,
    /// Pairs by the panels they belong to, which are named in order; a panel and the body share the
    /// key `(panel, None)`.
    pub by_panels: BTreeMap<(usize, Option<usize>), usize>,
}

/// Measures the state `positions` of a level; `clearance` is what was asked for, m.
pub fn assess(pattern: &Pattern, level: &Level, positions: &[Vector3], body: &Body, clearance: f64) -> Assessment {
    assess_knowing(pattern, level, positions, body, clearance, false)
}

/// The same where it may be known already that no cloth crosses cloth: then that is not searched again.
pub(crate) fn assess_knowing(
    pattern: &Pattern,
    level: &Level,
    positions: &[Vector3],
    body: &Body,
    clearance: f64,
    uncrossed: bool,
) -> Assessment {
    let allowance = strain::gather_allowance(pattern, level);
    let strains = || {
        rayon::join(
            || Strain::of(level, positions, &vec![0.0; level.triangles.len()]),
            || Strain::of(level, positions, &allowance),
        )
    };
    let contacts = || {
        rayon::join(
            || Clearance::of(level, positions, body, clearance),
            || Intersections::knowing(level, positions, body, uncrossed),
        )
    };
    let ((strain, strain_less_gathers), (clearance, intersections)) = rayon::join(strains, contacts);
    Assessment { strain, strain_less_gathers, seams: seam_gaps(level, positions), clearance, intersections }
}

fn seam_gaps(level: &Level, positions: &[Vector3]) -> SeamGaps {
    let at = |point: u32| positions[level.particle_of[point as usize] as usize];
    let gaps: Vec<f64> = level
        .seams
        .iter()
        .flat_map(|[a, b]| a.iter().zip(b).filter(|(a, b)| a != b).map(|(&a, &b)| (at(a) - at(b)).norm()))
        .collect();
    let mean = gaps.iter().sum::<f64>() / gaps.len().max(1) as f64;
    SeamGaps { pairs: gaps.len(), largest: gaps.iter().copied().fold(0.0, f64::max), mean }
}

impl Intersections {
    pub fn of(level: &Level, positions: &[Vector3], body: &Body) -> Self {
        Self::knowing(level, positions, body, false)
    }

    fn knowing(level: &Level, positions: &[Vector3], body: &Body, uncrossed: bool) -> Self {
        let of_cloth = || if uncrossed { Vec::new() } else { cloth_intersections(level, positions) };
        let (with_body, with_cloth) = rayon::join(|| body_intersections(level, positions, body), of_cloth);
        let panel_of = level.panel_of_triangle();
        let mut found = Self { body_pairs: with_body.len(), cloth_pairs: with_cloth.len(), ..Self::default() };
        for &[t, _] in &with_body {
            *found.by_panels.entry((panel_of[t as usize] as usize, None)).or_default() += 1;
            found.triangles.push(t);
        }
        for &[t, u] in &with_cloth {
            let (p, q) = (panel_of[t as usize] as usize, panel_of[u as usize] as usize);
            *found.by_panels.entry((p.min(q), Some(p.max(q)))).or_default() += 1;
            found.triangles.extend([t, u]);
        }
        found.triangles.sort_unstable();
        found.triangles.dedup();
        found
    }

    pub fn is_clean(&self) -> bool {
        self.body_pairs == 0 && self.cloth_pairs == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::shapes;

    /// Two rectangles side by side in the plane z = 0, the right one moved by `shift`.
    fn pair(sewn: bool, shift: Vector3) -> (Pattern, Level, Vec<Vector3>) {
        let pattern = shapes::two_rectangles(0.2, 0.3);
        let mut garment = Garment::build(&pattern, &[0.03]).unwrap();
        let level = if sewn { garment.levels.remove(0) } else { garment.open };
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        for (k, &p) in level.particle_of.iter().enumerate() {
            let right = level.panels[1].points.contains(&k);
            let beside = if right { Vector3::new(0.2, 0.0, 0.0) + shift } else { Vector3::zeros() };
            positions[p as usize] = Vector3::new(level.rest[k].x, level.rest[k].y, 0.0) + beside;
        }
        (pattern, level, positions)
    }

    #[test]
    fn an_open_seam_gapes_by_what_its_panels_are_apart() {
        let (_, level, positions) = pair(false, Vector3::new(0.003, 0.0, 0.004));
        let gaps = seam_gaps(&level, &positions);
        assert_eq!(gaps.pairs, 11, "a side of 0.3 m has ten steps of 0.03 m");
        assert!((gaps.largest - 0.005).abs() < 1e-12 && (gaps.mean - 0.005).abs() < 1e-12);
        let (_, level, positions) = pair(true, Vector3::zeros());
        assert_eq!(seam_gaps(&level, &positions), SeamGaps { pairs: 11, largest: 0.0, mean: 0.0 });
    }

    #[test]
    fn stretch_and_compression_are_told_apart() {
        let (pattern, level, positions) = pair(true, Vector3::zeros());
        let pulled: Vec<Vector3> = positions.iter().map(|p| Vector3::new(1.03 * p.x, 0.98 * p.y, p.z)).collect();
        let strain = Strain::of(&level, &pulled, &strain::gather_allowance(&pattern, &level));
        let found = [strain.mean, strain.p99, strain.max, strain.stretch_max, strain.compression_max];
        for (ours, exact) in found.into_iter().zip([0.025, 0.03, 0.03, 0.03, 0.02]) {
            assert!((ours - exact).abs() < 1e-12, "{strain:?}");
        }
    }

    #[test]
    fn crossing_panels_are_counted_by_their_names_and_the_body_apart() {
        let body = crate::body::shapes::ball();
        // Above the ball, the right panel turned upright and pushed through the left one.
        let (_, level, flat) = pair(false, Vector3::zeros());
        let mut positions = flat;
        for (k, p) in positions.iter_mut().enumerate() {
            *p = if level.panels[1].points.contains(&k) {
                Vector3::new(0.0101, 1.2 + 0.9 * (p.x - 0.3), p.y - 0.1502)
            } else {
                Vector3::new(p.x - 0.1, 1.2, p.y - 0.15)
            };
        }
        let found = Intersections::of(&level, &positions, &body);
        assert!(found.cloth_pairs > 5 && found.body_pairs == 0, "{found:?}");
        assert_eq!(found.by_panels.keys().collect::<Vec<_>>(), [&(0, Some(1))]);
        assert!(!found.is_clean());
        // Lowered until the left panel dips into the ball.
        positions.iter_mut().for_each(|p| p.y -= 0.201);
        let found = Intersections::of(&level, &positions, &body);
        assert!(found.by_panels.contains_key(&(0, None)) && found.by_panels.contains_key(&(1, None)), "{found:?}");
    }
}
