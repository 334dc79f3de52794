//! The body: the closed surface to dress, and how far a point is from it.

mod alignment;
mod distance_field;
mod dressed;
mod landmarks;
pub mod mannequin;
pub mod motion;
pub mod section;
mod skin;
mod validate;
mod winding;

pub use alignment::Alignment;
pub use distance_field::{DistanceField, STEEPEST, Sample};
pub use dressed::Enclosure;
pub use landmarks::{Landmarks, Limb, Part};
pub use motion::Motion;

use crate::geometry::{BoxTree, Vector3, closest_on_triangle, triangle_distance, triangles_intersect};
use crate::{Error, Warning};
use skin::{Exposure, Skin};
pub(crate) use winding::winding_number;

/// A closed, outward-facing triangle mesh, m, y up, facing +z.
pub struct Body {
    positions: Vec<Vector3>,
    triangles: Vec<[u32; 3]>,
    tree: BoxTree,
    skin: Skin,
}

/// The point of the body's skin that is nearest to some other point.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    pub triangle: u32,
    /// m, world.
    pub point: Vector3,
    /// m, not negative; [`Body::winding_number`] tells the side.
    pub distance: f64,
}

impl Body {
    /// Checks and takes over a mesh. The warnings name what is doubtful.
    pub fn new(positions: Vec<Vector3>, triangles: Vec<[u32; 3]>) -> Result<(Self, Vec<Warning>), Error> {
        let warnings = validate::validate(&positions, &triangles)?;
        let corners = triangles.iter().map(|t| t.map(|v| positions[v as usize]));
        let (tree, skin) = rayon::join(|| BoxTree::of_triangles(corners, 0.0), || Skin::new(&positions, &triangles));
        Ok((Self { positions, triangles, tree, skin }, warnings))
    }

    /// m, world; one per vertex.
    pub fn positions(&self) -> &[Vector3] {
        &self.positions
    }

    /// Vertices of each triangle, counter-clockwise from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    pub fn corners(&self, triangle: u32) -> [Vector3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// The lowest and highest coordinates, m.
    pub fn bounds(&self) -> (Vector3, Vector3) {
        let low = self.positions.iter().fold(Vector3::repeat(f64::INFINITY), |a, p| a.inf(p));
        let high = self.positions.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
        (low, high)
    }

    /// The nearest point of the skin, if one is within `reach`, m. What lies inside another part of the body
    /// is no skin.
    pub fn nearest(&self, point: Vector3, reach: f64) -> Option<Nearest> {
        let on = |corners: [Vector3; 3]| {
            let [a, b, c] = closest_on_triangle(point, corners);
            corners[0] * a + corners[1] * b + corners[2] * c
        };
        let squared = |on: Vector3| (on - point).norm_squared();
        let best = |index: u32| match self.skin.exposure(index) {
            Exposure::Whole => Some(on(self.corners(index))),
            Exposure::Hidden => None,
            Exposure::Partly(range) => {
                let places = self.skin.pieces(range).iter().map(|&piece| on(piece));
                places.min_by(|&p, &q| squared(p).total_cmp(&squared(q)))
            }
        };
        let to = |index: u32| best(index).map_or(f64::INFINITY, squared);
        let (triangle, squared) = self.tree.nearest(point, reach, to)?;
        Some(Nearest { triangle, point: best(triangle)?, distance: squared.sqrt() })
    }

    /// How far a triangle is from the skin, m, if that is no farther than `within`; zero if it crosses it.
    pub fn distance_to_triangle(&self, triangle: [Vector3; 3], within: f64) -> Option<f64> {
        let ([a, b, c], grown) = (triangle, Vector3::repeat(within.max(0.0)));
        let mut least = f64::INFINITY;
        let mut measure = |skin: [Vector3; 3]| {
            if are_apart(skin, triangle, within.min(least)) {
                return;
            }
            let crosses = triangles_intersect(triangle, skin);
            least = least.min(if crosses { 0.0 } else { triangle_distance(triangle, skin) });
        };
        self.tree.for_each_meeting(a.inf(&b).inf(&c) - grown, a.sup(&b).sup(&c) + grown, |index| {
            match self.skin.exposure(index) {
                Exposure::Whole => measure(self.corners(index)),
                Exposure::Hidden => {}
                Exposure::Partly(range) => self.skin.pieces(range).iter().for_each(|&piece| measure(piece)),
            }
        });
        (least <= within).then_some(least)
    }

    /// The corners of all that is exposed: triangles, and pieces of those that are partly hidden.
    fn exposed(&self) -> Vec<[Vector3; 3]> {
        let mut exposed = Vec::with_capacity(self.triangles.len());
        for t in 0..self.triangles.len() as u32 {
            match self.skin.exposure(t) {
                Exposure::Whole => exposed.push(self.corners(t)),
                Exposure::Hidden => {}
                Exposure::Partly(range) => exposed.extend(self.skin.pieces(range)),
            }
        }
        exposed
    }

    /// Calls `visit` with every triangle whose box meets the box `low..high`.
    pub fn for_each_meeting(&self, low: Vector3, high: Vector3, visit: impl FnMut(u32)) {
        self.tree.for_each_meeting(low, high, visit);
    }

    /// Is the point inside? Regions that the surface covers twice, where skin passes through skin,
    /// are inside as well.
    pub fn contains(&self, point: Vector3) -> bool {
        self.winding_number(point) > 0
    }

    /// Distance to the skin, m, negative inside; exact, for when the field's accuracy is not enough.
    pub fn signed_distance(&self, point: Vector3) -> f64 {
        let distance = self.nearest(point, f64::INFINITY).map_or(f64::INFINITY, |n| n.distance);
        if self.contains(point) { -distance } else { distance }
    }
}

/// Is all of the second triangle farther above or below the plane of the first than `within`, m? Most that are asked
/// about are, and their distance need not be measured.
fn are_apart([a, b, c]: [Vector3; 3], other: [Vector3; 3], within: f64) -> bool {
    let normal = (b - a).cross(&(c - a));
    let farthest = within * normal.norm() * (1.0 + 1e-9);
    let heights = other.map(|p| (p - a).dot(&normal));
    heights.iter().all(|&h| h > farthest) || heights.iter().all(|&h| h < -farthest)
}

#[cfg(test)]
pub(crate) mod shapes {
    //! Small bodies for tests.

    use super::*;

    /// A sphere of latitude rings around `center`, outward; `rings` by `2 * rings` quads.
    pub fn sphere(center: Vector3, radius: f64, rings: u32) -> (Vec<Vector3>, Vec<[u32; 3]>) {
        let columns = 2 * rings;
        let mut positions = vec![center + Vector3::y() * radius];
        for i in 1..rings {
            let polar = std::f64::consts::PI * f64::from(i) / f64::from(rings);
            for j in 0..columns {
                let azimuth = std::f64::consts::TAU * f64::from(j) / f64::from(columns);
                let (sin, cos) = polar.sin_cos();
                positions.push(center + Vector3::new(sin * azimuth.sin(), cos, sin * azimuth.cos()) * radius);
            }
        }
        let last = positions.len() as u32;
        positions.push(center - Vector3::y() * radius);
        let at = |i: u32, j: u32| 1 + (i - 1) * columns + j % columns;
        let mut triangles = Vec::new();
        for j in 0..columns {
            triangles.push([0, at(1, j), at(1, j + 1)]);
            triangles.push([last, at(rings - 1, j + 1), at(rings - 1, j)]);
            for i in 1..rings - 1 {
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        (positions, triangles)
    }

    /// A ball of one metre diameter that stands on the floor: a plausible size for a body.
    pub fn ball() -> Body {
        let (positions, triangles) = sphere(Vector3::new(0.0, 0.5, 0.0), 0.5, 40);
        Body::new(positions, triangles).unwrap().0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_of_a_ball() {
        let ball = shapes::ball();
        let center = Vector3::new(0.0, 0.5, 0.0);
        for direction in [Vector3::x(), Vector3::new(0.3, -0.5, 0.8).normalize()] {
            assert!((ball.signed_distance(center + direction * 0.6) - 0.1).abs() < 2e-3);
            assert!((ball.signed_distance(center + direction * 0.4) + 0.1).abs() < 2e-3);
        }
        assert!(ball.nearest(center + Vector3::x() * 0.6, 0.05).is_none());
    }
}
