//! Geometry that knows nothing of cloth: points, triangles, distances, exact predicates.

pub mod coverage;
mod incidence;
mod intersection;
mod nearest;
mod run_tree;
mod topology;
mod tree;
mod union_find;

pub use incidence::Incidence;
pub use intersection::{polygon_crossing, segment_meets_triangle, triangles_intersect};
pub use nearest::{SegmentPair, closest_between_segments, closest_on_triangle, triangle_distance};
pub use run_tree::RunTree;
pub use topology::{Beside, Edge, EdgeTable};
pub use tree::BoxTree;
pub use union_find::UnionFind;

/// A point or vector in space, m unless its name says otherwise.
pub type Vector3 = nalgebra::Vector3<f64>;
/// A point or vector on a panel, m.
pub type Vector2 = nalgebra::Vector2<f64>;

/// The z component of `a × b`: twice the signed area that the two vectors span.
pub fn cross(a: Vector2, b: Vector2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Signed area of the triangle `a b c`, positive when counter-clockwise.
pub fn signed_area(a: Vector2, b: Vector2, c: Vector2) -> f64 {
    0.5 * cross(b - a, c - a)
}

/// Barycentric weights of `point` in the triangle `corners`; they sum to one and are negative
/// outside. The weights of a triangle without area are not finite.
pub fn barycentric(point: Vector2, [a, b, c]: [Vector2; 3]) -> [f64; 3] {
    let area = signed_area(a, b, c);
    let weight_a = signed_area(point, b, c) / area;
    let weight_b = signed_area(a, point, c) / area;
    [weight_a, weight_b, 1.0 - weight_a - weight_b]
}
