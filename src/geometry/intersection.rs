//! Do triangles meet? Decided by exact orientation predicates (Shewchuk 1997, through the crate
//! `robust`): no tolerance, no wrong answer from rounding.

use super::{Vector2, Vector3};
use robust::{Coord, Coord3D, orient2d, orient3d};

fn coord(p: Vector3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

/// Positive when `d` lies below the plane through `a b c` seen counter-clockwise from above.
fn side(a: Vector3, b: Vector3, c: Vector3, d: Vector3) -> f64 {
    orient3d(coord(a), coord(b), coord(c), coord(d))
}

/// Are the ends on opposite sides, none of them in the plane?
fn opposite(above: f64, below: f64) -> bool {
    (above > 0.0 && below < 0.0) || (above < 0.0 && below > 0.0)
}

/// Does the line through `p` and `q` pass through the inside of the triangle?
fn line_meets_triangle(p: Vector3, q: Vector3, [a, b, c]: [Vector3; 3]) -> bool {
    let turns = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
    turns.iter().all(|&t| t > 0.0) || turns.iter().all(|&t| t < 0.0)
}

/// Does the segment cross the triangle in an inner point of both? Touching does not count.
pub fn segment_meets_triangle([p, q]: [Vector3; 2], triangle: [Vector3; 3]) -> bool {
    let [a, b, c] = triangle;
    opposite(side(a, b, c, p), side(a, b, c, q)) && line_meets_triangle(p, q, triangle)
}

/// Do two triangles without a common corner cross? Touching and overlap within one plane do not
/// count: cloth that merely lies on cloth is no intersection.
pub fn triangles_intersect(a: [Vector3; 3], b: [Vector3; 3]) -> bool {
    // Most that are asked about lie wholly on one side of the other's plane.
    let clear = |sides: [f64; 3]| sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0);
    let sides_of_a = a.map(|p| side(b[0], b[1], b[2], p));
    if clear(sides_of_a) {
        return false;
    }
    let sides_of_b = b.map(|p| side(a[0], a[1], a[2], p));
    !clear(sides_of_b) && (pierces(a, sides_of_a, b) || pierces(b, sides_of_b, a))
}

/// Does a side of the first triangle cross the second, on whose sides its corners lie as told?
fn pierces(one: [Vector3; 3], sides: [f64; 3], other: [Vector3; 3]) -> bool {
    let crosses = |k: usize, l: usize| opposite(sides[k], sides[l]) && line_meets_triangle(one[k], one[l], other);
    crosses(0, 1) || crosses(1, 2) || crosses(2, 0)
}

/// The first pair of sides of a closed polygon that cross each other, as indices of their first
/// points. Neighbouring sides count when they fold back on each other.
pub fn polygon_crossing(points: &[Vector2]) -> Option<(usize, usize)> {
    let n = points.len();
    // Sweep over x: only sides whose ranges in x overlap are compared.
    let range = |i: usize| {
        let (a, b) = (points[i].x, points[(i + 1) % n].x);
        (a.min(b), a.max(b))
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| range(i).0.total_cmp(&range(j).0).then(i.cmp(&j)));
    let mut active: Vec<usize> = Vec::new();
    let mut found: Option<(usize, usize)> = None;
    for &i in &order {
        active.retain(|&j| range(j).1 >= range(i).0);
        for &j in &active {
            let pair = (i.min(j), i.max(j));
            if sides_cross(points, pair.0, pair.1) && found.is_none_or(|f| pair < f) {
                found = Some(pair);
            }
        }
        active.push(i);
    }
    found
}

fn sides_cross(points: &[Vector2], i: usize, j: usize) -> bool {
    let n = points.len();
    let turn = |a: usize, b: usize, c: usize| {
        let at = |k: usize| Coord { x: points[k].x, y: points[k].y };
        orient2d(at(a), at(b), at(c))
    };
    let (i1, j1) = ((i + 1) % n, (j + 1) % n);
    let above = |a: usize, b: usize, c: usize, d: usize| points[a].y.min(points[b].y) > points[c].y.max(points[d].y);
    if above(i, i1, j, j1) || above(j, j1, i, i1) {
        return false;
    }
    if i1 == j || j1 == i {
        // Neighbours share a point; they overlap only when one runs back along the other.
        let (before, shared, after) = if i1 == j { (i, j, j1) } else { (j, i, i1) };
        let back = (points[before] - points[shared]).dot(&(points[after] - points[shared]));
        return turn(before, shared, after) == 0.0 && back > 0.0;
    }
    let (t1, t2) = (turn(i, i1, j), turn(i, i1, j1));
    let (t3, t4) = (turn(j, j1, i), turn(j, j1, i1));
    if t1 == 0.0 && t2 == 0.0 && t3 == 0.0 && t4 == 0.0 {
        let along = points[i1] - points[i];
        let place = |k: usize| (points[k] - points[i]).dot(&along);
        let (low, high) = (place(j).min(place(j1)), place(j).max(place(j1)));
        return high >= 0.0 && low <= along.norm_squared();
    }
    // A point of one side that lies on the other counts as well: such an outline has no inside there.
    let apart = |a: f64, b: f64| (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0);
    !apart(t1, t2) && !apart(t3, t4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn v(x: f64, y: f64, z: f64) -> Vector3 {
        Vector3::new(x, y, z)
    }

    #[test]
    fn a_needle_through_a_triangle_is_found_and_a_touch_is_not() {
        let triangle = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)];
        assert!(segment_meets_triangle([v(0.2, 0.2, -1.0), v(0.2, 0.2, 1.0)], triangle));
        assert!(!segment_meets_triangle([v(0.2, 0.2, 0.0), v(0.2, 0.2, 1.0)], triangle));
        assert!(!segment_meets_triangle([v(0.8, 0.8, -1.0), v(0.8, 0.8, 1.0)], triangle));
    }

    #[test]
    fn crossing_triangles_are_found_whichever_pierces_the_other() {
        let flat = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)];
        let upright = [v(0.2, 0.2, -0.5), v(0.3, 0.2, -0.5), v(0.2, 0.2, 0.5)];
        assert!(triangles_intersect(flat, upright) && triangles_intersect(upright, flat));
        let above = flat.map(|p| p + v(0.0, 0.0, 1e-300));
        assert!(!triangles_intersect(flat, above));
    }

    /// Whether a side of one passes through the other, side by side.
    fn intersect_plainly(a: [Vector3; 3], b: [Vector3; 3]) -> bool {
        let sides = |[i, j, k]: [Vector3; 3]| [[i, j], [j, k], [k, i]];
        sides(a).into_iter().any(|s| segment_meets_triangle(s, b))
            || sides(b).into_iter().any(|s| segment_meets_triangle(s, a))
    }

    proptest! {
        /// Corners on a coarse grid: many lie in the other's plane, on its sides, on its corners.
        #[test]
        fn what_lies_on_one_side_of_a_plane_is_told_apart_rightly(c in prop::collection::vec(0..4u8, 18)) {
            let corner = |k: usize| v(f64::from(c[k]), f64::from(c[k + 1]), f64::from(c[k + 2]));
            let (a, b) = ([corner(0), corner(3), corner(6)], [corner(9), corner(12), corner(15)]);
            prop_assert_eq!(triangles_intersect(a, b), intersect_plainly(a, b));
            prop_assert_eq!(triangles_intersect(a, b), triangles_intersect(b, a));
        }
    }

    #[test]
    fn a_bow_tie_crosses_itself_and_a_square_does_not() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vector2::from);
        assert_eq!(polygon_crossing(&square), None);
        let bow_tie = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(Vector2::from);
        assert_eq!(polygon_crossing(&bow_tie), Some((1, 3)));
    }

    #[test]
    fn a_side_that_runs_back_counts_as_crossing() {
        let spike = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.0], [0.5, 1.0]].map(Vector2::from);
        assert!(polygon_crossing(&spike).is_some());
    }
}
