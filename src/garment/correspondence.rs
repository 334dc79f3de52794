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
