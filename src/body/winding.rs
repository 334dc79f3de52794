//! Inside or outside, by counting how often the surface winds around a point.
//!
//! Real bodies pass through themselves at toes, lips and armpits; the direction of the nearest
//! triangle is no guide there. A ray to +x crosses the surface outwards once more than inwards
//! exactly when the point is inside. Orientation predicates are exact, and a ray through an edge or
//! a vertex is given to one side by the fill rule of rasterizers, so that no crossing is lost or
//! counted twice.

use super::Body;
use crate::geometry::Vector3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Seen along x, is `(y, z)` of `point` inside the triangle? Returns +1 where the surface faces +x,
/// -1 where it faces -x, 0 where the line misses the triangle.
pub fn crossing_sense(point: Vector3, corners: [Vector3; 3]) -> i32 {
    let flat = |p: Vector3| Coord { x: p.y, y: p.z };
    let turn = |a: Vector3, b: Vector3, c: Vector3| orient2d(flat(a), flat(b), flat(c));
    let [a, b, c] = corners;
    let facing = turn(a, b, c);
    if facing == 0.0 {
        return 0;
    }
    let (b, c, sense) = if facing > 0.0 { (b, c, 1) } else { (c, b, -1) };
    // On an edge: inside only if the edge runs up, or level towards smaller y.
    let covers = |p: Vector3, q: Vector3| {
        let side = turn(p, q, point);
        side > 0.0 || (side == 0.0 && (q.z > p.z || (q.z == p.z && q.y < p.y)))
    };
    if covers(a, b) && covers(b, c) && covers(c, a) { sense } else { 0 }
}

/// How often a surface winds around a point. `for_each_meeting` calls back with the corners of each of its
/// triangles whose box meets a box, given by its lowest and highest corner.
pub fn winding_number(
    point: Vector3,
    for_each_meeting: impl FnOnce(Vector3, Vector3, &mut dyn FnMut([Vector3; 3])),
) -> i32 {
    let coord = |p: Vector3| Coord3D { x: p.x, y: p.y, z: p.z };
    let mut winding = 0;
    for_each_meeting(point, Vector3::new(f64::MAX, point.y, point.z), &mut |corners| {
        let sense = crossing_sense(point, corners);
        if sense != 0 {
            // `orient3d` is positive when the point lies below the triangle, against its normal.
            let below = orient3d(coord(corners[0]), coord(corners[1]), coord(corners[2]), coord(point));
            if (below > 0.0) == (sense > 0) && below != 0.0 {
                winding += sense;
            }
        }
    });
    winding
}

impl Body {
    /// How often the surface winds around the point: 0 outside, 1 inside, 2 where two parts of the
    /// body overlap.
    pub fn winding_number(&self, point: Vector3) -> i32 {
        winding_number(point, |low, high, visit| {
            self.for_each_meeting(low, high, |triangle| visit(self.corners(triangle)));
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    #[test]
    fn rays_through_edges_and_vertices_count_once() {
        let ball = shapes::ball();
        let center = Vector3::new(0.0, 0.5, 0.0);
        // The rays from these points run exactly through vertices and along edges of the mesh.
        for y in [0.5, 0.3, 0.2] {
            let inside = Vector3::new(0.0, y, 0.0);
            assert_eq!(ball.winding_number(inside), 1, "{inside}");
            assert_eq!(ball.winding_number(inside - Vector3::x() * 2.0), 0);
        }
        for vertex in ball.positions().iter().step_by(7) {
            let inside = center.lerp(vertex, 0.9);
            assert_eq!(ball.winding_number(Vector3::new(inside.x, vertex.y.clamp(0.1, 0.9), inside.z * 0.2)), 1);
        }
    }

    #[test]
    fn overlapping_parts_are_inside() {
        let (mut positions, mut triangles) = shapes::sphere(Vector3::new(0.0, 0.5, 0.0), 0.5, 20);
        let (more, other) = shapes::sphere(Vector3::new(0.3, 0.5, 0.0), 0.4, 20);
        let offset = positions.len() as u32;
        positions.extend(more);
        triangles.extend(other.iter().map(|t| t.map(|v| v + offset)));
        let (body, _) = Body::new(positions, triangles).unwrap();
        assert_eq!(body.winding_number(Vector3::new(0.2, 0.5, 0.0)), 2);
        assert_eq!(body.winding_number(Vector3::new(-0.4, 0.5, 0.0)), 1);
        assert!(body.contains(Vector3::new(0.6, 0.5, 0.0)));
        assert!(!body.contains(Vector3::new(0.8, 0.5, 0.0)));
    }
}
