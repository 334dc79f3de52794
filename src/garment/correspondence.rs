//! Fine particles on coarse triangles.
//!
//! Each point of a level is located on the next coarser one: a triangle of the same panel and three
//! barycentric weights (Le Thanh and Gagalowicz 2007, section 4). Curved outlines leave some points
//! outside every coarse triangle. The paper takes the triangle with the nearest centroid, which is
//! the wrong one at a curved rim; we take the triangle that is nearest, and extrapolate from it.

use super::level::{Level, PanelRange};
use crate::geometry::{BoxTree, Vector2, Vector3, barycentric, closest_on_triangle};

/// A triangle and three barycentric weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    pub triangle: u32,
    /// Sum to one; some are negative where the point is outside.
    pub weights: [f64; 3],
}

/// For each point of a finer level its place on a coarser one.
#[derive(Clone, Debug)]
pub struct Correspondence {
    /// One per point of the finer level.
    pub locations: Vec<Location>,
}

impl Correspondence {
    pub fn new(coarse: &Level, fine: &Level) -> Self {
        let mut locations = Vec::with_capacity(fine.rest.len());
        for (coarse_panel, fine_panel) in coarse.panels.iter().zip(&fine.panels) {
            let locator = Locator::new(coarse, coarse_panel);
            locations.extend(fine.rest[fine_panel.points.clone()].iter().map(|&p| locator.locate(p)));
        }
        Self { locations }
    }

    /// Positions of the finer level's particles on the surface of the coarser level, m, world: what
    /// is affine on the coarse panels is kept. A sewn particle comes to the mean of its points.
    pub fn prolong(&self, coarse: &Level, fine: &Level, positions: &[Vector3]) -> Vec<Vector3> {
        self.mean_of_points(coarse, fine, positions, |weights| weights)
    }

    /// The same without extrapolation: what lies outside the coarse triangles comes to their rim.
    pub fn prolong_within(&self, coarse: &Level, fine: &Level, positions: &[Vector3]) -> Vec<Vector3> {
        self.mean_of_points(coarse, fine, positions, |weights| {
            let inner = weights.map(|w| w.max(0.0));
            let sum: f64 = inner.iter().sum();
            inner.map(|w| w / sum)
        })
    }

    fn mean_of_points(
        &self,
        coarse: &Level,
        fine: &Level,
        positions: &[Vector3],
        weights: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Vec<Vector3> {
        let mut sums = vec![(Vector3::zeros(), 0.0); fine.particle_count];
        for (location, &particle) in self.locations.iter().zip(&fine.particle_of) {
            let corners = coarse.particles(location.triangle as usize).map(|p| positions[p as usize]);
            let [a, b, c] = weights(location.weights);
            let sum = &mut sums[particle as usize];
            sum.0 += corners[0] * a + corners[1] * b + corners[2] * c;
            sum.1 += 1.0;
        }
        sums.into_iter().map(|(sum, count)| sum / count).collect()
    }
}

/// Finds points on the triangles of one panel.
struct Locator<'a> {
    level: &'a Level,
    panel: &'a PanelRange,
    tree: BoxTree,
}

fn lifted(p: Vector2) -> Vector3 {
    Vector3::new(p.x, p.y, 0.0)
}

impl<'a> Locator<'a> {
    fn new(level: &'a Level, panel: &'a PanelRange) -> Self {
        let corners = panel.triangles.clone().map(|t| level.rest_corners(t).map(lifted));
        Self { level, panel, tree: BoxTree::of_triangles(corners, 0.0) }
    }

    fn corners(&self, index: u32) -> [Vector2; 3] {
        self.level.rest_corners(self.panel.triangles.start + index as usize)
    }

    fn locate(&self, point: Vector2) -> Location {
        let squared_distance = |index: u32| {
            let corners = self.corners(index).map(lifted);
            let [a, b, c] = closest_on_triangle(lifted(point), corners);
            (corners[0] * a + corners[1] * b + corners[2] * c - lifted(point)).norm_squared()
        };
        let (index, _) = self
            .tree
            .nearest(lifted(point), f64::INFINITY, squared_distance)
            .expect("a panel has at least one triangle");
        let triangle = self.panel.triangles.start as u32 + index;
        Location { triangle, weights: barycentric(point, self.corners(index)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::{Arc, Pattern, Shape, shapes};
    use proptest::prelude::*;

    /// Two rectangles sewn together, one with a round rim that reaches beyond coarse triangles.
    fn garment() -> (Pattern, Garment) {
        let mut pattern = shapes::two_rectangles(0.2, 0.3);
        let rim = &mut pattern.panels[0].segments[3].curve;
        rim.shape = Shape::Arc(Arc::between(rim.start, rim.end, 0.16, false, true));
        let garment = Garment::build(&pattern, &[0.06, 0.023, 0.01]).unwrap();
        (pattern, garment)
    }

    /// Where an affine map of the sewn plane brings the particles; the right panel lies beside the left.
    fn mapped(level: &Level, map: impl Fn(Vector2) -> Vector3) -> Vec<Vector3> {
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        for (k, &p) in level.particle_of.iter().enumerate() {
            let shift = if level.panels[1].points.contains(&k) { 0.2 } else { 0.0 };
            positions[p as usize] = map(level.rest[k] + Vector2::new(shift, 0.0));
        }
        positions
    }

    proptest! {
        #[test]
        fn prolongation_keeps_affine_maps(columns in proptest::array::uniform9(-2.0..2.0f64)) {
            let (_, garment) = garment();
            let [x, y, t] = [0, 3, 6].map(|k| Vector3::new(columns[k], columns[k + 1], columns[k + 2]));
            let affine = |p: Vector2| x * p.x + y * p.y + t;
            for (k, correspondence) in garment.correspondences.iter().enumerate() {
                let (coarse, fine) = (&garment.levels[k], &garment.levels[k + 1]);
                let prolonged = correspondence.prolong(coarse, fine, &mapped(coarse, affine));
                for (ours, exact) in prolonged.iter().zip(mapped(fine, affine)) {
                    prop_assert!((ours - exact).norm() < 1e-12, "{ours} is not {exact}");
                }
            }
        }
    }

    #[test]
    fn the_round_rim_is_extrapolated_unless_it_must_stay_within() {
        let (_, garment) = garment();
        let (coarse, fine) = (&garment.levels[0], &garment.levels[1]);
        let correspondence = &garment.correspondences[0];
        assert!(correspondence.locations.iter().any(|l| l.weights.iter().any(|&w| w < -0.01)));
        let flat = |p: Vector2| Vector3::new(p.x, p.y, 0.0);
        let positions = mapped(coarse, flat);
        let leftmost = |points: &[Vector3]| points.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
        let within = correspondence.prolong_within(coarse, fine, &positions);
        assert!(leftmost(&within) >= leftmost(&positions) - 1e-12);
        assert!(leftmost(&correspondence.prolong(coarse, fine, &positions)) < leftmost(&positions) - 1e-4);
    }

    #[test]
    fn a_level_prolonged_to_itself_stays_where_it_is() {
        let (_, garment) = garment();
        for level in &garment.levels {
            let positions: Vec<Vector3> =
                (0..level.particle_count).map(|k| Vector3::new(k as f64, (k as f64).sin(), (k as f64).cos())).collect();
            let same = Correspondence::new(level, level).prolong(level, level, &positions);
            assert!(same.iter().zip(&positions).all(|(a, b)| (a - b).norm() < 1e-9));
        }
    }

    #[test]
    fn welded_partners_meet_half_way_and_others_stay() {
        let (_, garment) = garment();
        let open = &garment.open;
        let positions: Vec<Vector3> =
            (0..open.particle_count).map(|k| Vector3::new(k as f64, (k as f64).sin(), 1.0)).collect();
        let welded = garment.weld(&positions);
        let first = &garment.levels[0];
        assert_eq!(open.particle_count - first.particle_count, open.stitches.len());
        let mut sewn = vec![false; open.particle_count];
        for &[a, b] in &open.stitches {
            let particle = first.particle_of[a as usize];
            assert_eq!(particle, first.particle_of[b as usize]);
            let half_way = (positions[a as usize] + positions[b as usize]) / 2.0;
            assert!((welded[particle as usize] - half_way).norm() < 1e-12);
            (sewn[a as usize], sewn[b as usize]) = (true, true);
        }
        for point in (0..open.particle_count).filter(|&p| !sewn[p]) {
            assert_eq!(welded[first.particle_of[point] as usize], positions[point]);
        }
    }
}
