//! Closest points, after Ericson, *Real-Time Collision Detection* (2005), sections 5.1.5 and 5.1.9.

use super::Vector3;

/// Barycentric weights of the point of the triangle that is nearest to `point`.
pub fn closest_on_triangle(point: Vector3, [a, b, c]: [Vector3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let area_c = d1 * d4 - d3 * d2;
    if area_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let along = d1 / (d1 - d3);
        return [1.0 - along, along, 0.0];
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let area_b = d5 * d2 - d1 * d6;
    if area_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let along = d2 / (d2 - d6);
        return [1.0 - along, 0.0, along];
    }
    let area_a = d3 * d6 - d5 * d4;
    if area_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - along, along];
    }
    let total = area_a + area_b + area_c;
    let (weight_b, weight_c) = (area_b / total, area_c / total);
    [1.0 - weight_b - weight_c, weight_b, weight_c]
}

/// Where two segments are nearest: the fraction along each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentPair {
    pub s: f64,
    pub t: f64,
}

/// The closest points of the segments `p0 p1` and `q0 q1`. Segments of no length count as points.
pub fn closest_between_segments([p0, p1]: [Vector3; 2], [q0, q1]: [Vector3; 2]) -> SegmentPair {
    let (d1, d2, r) = (p1 - p0, q1 - q0, p0 - q0);
    let (a, e, f) = (d1.norm_squared(), d2.norm_squared(), d2.dot(&r));
    // Below this a segment is a point: squares of lengths under a picometre.
    const POINT: f64 = 1e-24;
    if a <= POINT && e <= POINT {
        return SegmentPair { s: 0.0, t: 0.0 };
    }
    if a <= POINT {
        return SegmentPair { s: 0.0, t: (f / e).clamp(0.0, 1.0) };
    }
    let c = d1.dot(&r);
    if e <= POINT {
        return SegmentPair { s: (-c / a).clamp(0.0, 1.0), t: 0.0 };
    }
    let b = d1.dot(&d2);
    let denominator = a * e - b * b;
    // Parallel within rounding: any point of the overlap is as near, take the start.
    let s = if denominator > 1e-12 * a * e { ((b * f - c * e) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let t = (b * s + f) / e;
    if t < 0.0 {
        SegmentPair { s: (-c / a).clamp(0.0, 1.0), t: 0.0 }
    } else if t > 1.0 {
        SegmentPair { s: ((b - c) / a).clamp(0.0, 1.0), t: 1.0 }
    } else {
        SegmentPair { s, t }
    }
}

/// Distance between two triangles that do not intersect; some positive number where they do.
pub fn triangle_distance(a: [Vector3; 3], b: [Vector3; 3]) -> f64 {
    let to_face = |p: Vector3, t: [Vector3; 3]| {
        let w = closest_on_triangle(p, t);
        (t[0] * w[0] + t[1] * w[1] + t[2] * w[2] - p).norm()
    };
    let mut least = f64::INFINITY;
    for i in 0..3 {
        least = least.min(to_face(a[i], b)).min(to_face(b[i], a));
        for j in 0..3 {
            let (p, q) = ([a[i], a[(i + 1) % 3]], [b[j], b[(j + 1) % 3]]);
            let SegmentPair { s, t } = closest_between_segments(p, q);
            least = least.min((p[0].lerp(&p[1], s) - q[0].lerp(&q[1], t)).norm());
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vector3> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0f64].prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn no_point_of_the_triangle_is_nearer(p in point(), a in point(), b in point(), c in point(), u in 0.0..1.0f64, v in 0.0..1.0f64) {
            let w = closest_on_triangle(p, [a, b, c]);
            prop_assert!(w.iter().all(|&w| w >= -1e-12) && (w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let nearest = a * w[0] + b * w[1] + c * w[2];
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let other = a + (b - a) * u + (c - a) * v;
            prop_assert!((p - nearest).norm() <= (p - other).norm() + 1e-9);
        }

        #[test]
        fn no_points_of_the_segments_are_nearer(p0 in point(), p1 in point(), q0 in point(), q1 in point(), s in 0.0..1.0f64, t in 0.0..1.0f64) {
            let at = closest_between_segments([p0, p1], [q0, q1]);
            let distance = |s: f64, t: f64| (p0 + (p1 - p0) * s - q0 - (q1 - q0) * t).norm();
            prop_assert!(distance(at.s, at.t) <= distance(s, t) + 1e-9);
        }
    }
}
