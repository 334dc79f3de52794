//! One curve between two corners, from the points or the curves that a drawing has there.

use super::{Curve, Path};
use crate::geometry::{Vector2, cross};

/// A run that leaves its chord by less than this share of it is straight: half a millimetre in a metre.
const STRAIGHT: f64 = 5e-4;
/// But by no more than this, m: a line is drawn to a tenth of a millimetre, and a half is unfolded no better.
const STRAIGHT_AT_MOST: f64 = 1.5e-4;
/// A stretch so many times longer than those beside it is a straight line that runs into a curve: whoever marks a
/// curve by points sets them about evenly.
const LONG_STRETCH: f64 = 4.0;

/// The curve through points, from the first to the last: a Catmull-Rom spline (Catmull and Rom 1974), whose pieces are
/// cubics, with the speeds of the centripetal one (Yuksel, Schaefer and Keyser 2011), which keep uneven points from
/// making loops. `around` are the points before the first and after the last where the curve goes on; at an end it
/// leaves as the parabola through three points does. At least two points, no two in a row at the same place.
pub fn through(points: &[Vector2], around: [Option<Vector2>; 2]) -> Curve {
    let last = points.len() - 1;
    let chord = |k: usize| points[k + 1] - points[k];
    let knot = |d: Vector2| d.norm().sqrt();
    // As long as the derivative of the parabola through three points, for knots at the roots of the chords, and parallel to
    // the line from the first to the last: drawings are thinned until chords stay near to the curve, so that a long
    // chord tells more of the direction than a short one.
    let middle = |before: Vector2, after: Vector2| {
        let (s, t) = (knot(before), knot(after));
        let derivative = (before / s * t + after / t * s) / (s + t);
        let direction = (before + after).try_normalize(0.0);
        direction.map_or(derivative, |direction| direction * derivative.norm())
    };
    let at_end = |near: Vector2, far: Vector2| near * (2.0 / knot(near)) - middle(near, far);
    let mut tangents: Vec<[Vector2; 2]> = Vec::with_capacity(last);
    for k in 0..last {
        let d = chord(k);
        let before = if k > 0 { Some(chord(k - 1)) } else { around[0].map(|p| points[0] - p) };
        let after = if k + 1 < last { Some(chord(k + 1)) } else { around[1].map(|p| p - points[last]) };
        let straight = d / knot(d);
        tangents.push(match (before, after) {
            (None, None) => [straight, straight],
            (Some(b), None) => [middle(b, d), at_end(d, b)],
            (None, Some(a)) => [at_end(d, a), middle(d, a)],
            (Some(b), Some(a)) => [middle(b, d), middle(d, a)],
        });
    }
    for k in 0..last {
        let beside = [k.checked_sub(1), Some(k + 1).filter(|&n| n < last)];
        let longest = beside.iter().flatten().map(|&n| chord(n).norm()).fold(0.0, f64::max);
        if longest > 0.0 && chord(k).norm() > LONG_STRETCH * longest {
            let direction = chord(k).normalize();
            tangents[k] = [chord(k) / knot(chord(k)); 2];
            // Its neighbours leave in its direction.
            if let Some(n) = beside[0] {
                tangents[n][1] = direction * knot(chord(n));
            }
            if let Some(n) = beside[1] {
                tangents[n][0] = direction * knot(chord(n));
            }
        }
    }
    let mut controls = vec![points[0]];
    for (k, [leaving, reaching]) in tangents.iter().enumerate() {
        let third = knot(chord(k)) / 3.0;
        controls.extend([points[k] + leaving * third, points[k + 1] - reaching * third, points[k + 1]]);
    }
    along_or_straight(controls)
}

/// Curves that follow one another as one curve. At least one.
pub fn joined(curves: &[Curve]) -> Curve {
    if let [only] = curves {
        let straight = only.is_straight() || is_straight(&only.cubics());
        return if straight { Curve::line(only.start, only.end) } else { only.clone() };
    }
    let mut controls = vec![curves[0].start];
    for curve in curves {
        controls.extend(&curve.cubics()[1..]);
    }
    along_or_straight(controls)
}

fn along_or_straight(controls: Vec<Vector2>) -> Curve {
    if is_straight(&controls) {
        return Curve::line(controls[0], controls[controls.len() - 1]);
    }
    Path::new(controls).map(Curve::along).expect("three points for each piece, and the first")
}

/// Do all points lie on the line from the first to the last, one behind the other?
fn is_straight(points: &[Vector2]) -> bool {
    let (first, last) = (points[0], points[points.len() - 1]);
    let Some(along) = (last - first).try_normalize(f64::MIN_POSITIVE) else { return false };
    let tolerance = (STRAIGHT * (last - first).norm()).min(STRAIGHT_AT_MOST);
    let beside = |p: &Vector2| cross(along, p - first).abs() <= tolerance;
    let forward = |w: &[Vector2]| (w[1] - w[0]).dot(&along) >= -tolerance;
    points.iter().all(beside) && points.windows(2).all(forward)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::Shape;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn v(x: f64, y: f64) -> Vector2 {
        Vector2::new(x, y)
    }

    fn on_circle(angles: &[f64]) -> Vec<Vector2> {
        angles.iter().map(|a| v(0.2 * a.cos(), 0.2 * a.sin())).collect()
    }

    #[test]
    fn a_few_points_of_a_circle_give_its_length_and_area() {
        // A quarter by six points at uneven steps, as an armhole is marked.
        let points = on_circle(&[0.0, 0.25, 0.55, 0.95, 1.25, PI / 2.0]);
        let curve = through(&points, [None, None]);
        assert!((curve.length() / (0.1 * PI) - 1.0).abs() < 2e-3, "{}", curve.length());
        assert!((curve.signed_area() / (0.01 * PI) - 1.0).abs() < 2e-3, "{}", curve.signed_area());
        for p in &points {
            assert!(curve.nearest(*p).1 < 1e-7);
        }
    }

    #[test]
    fn points_around_smooth_the_ends() {
        let points = on_circle(&[0.0, 0.4, 0.8]);
        let around = on_circle(&[-0.4, 1.2]);
        let curve = through(&points, [Some(around[0]), Some(around[1])]);
        let [leaving, reaching] = curve.end_directions();
        assert!((leaving - v(0.0, 1.0)).norm() < 1e-9);
        assert!((reaching - v(-(0.8f64.sin()), 0.8f64.cos())).norm() < 1e-9);
    }

    #[test]
    fn a_line_that_runs_into_a_curve_stays_straight() {
        let arc = (0..=10).map(|k| f64::from(k) * 0.1).map(|a| v(0.05 * a.sin(), 0.05 * (1.0 - a.cos())));
        let points: Vec<Vector2> = [v(-0.4, 0.0)].into_iter().chain(arc).collect();
        let curve = through(&points, [None, None]);
        for k in 0..=70 {
            assert!(curve.at_fraction(f64::from(k) / 100.0).y.abs() < 1e-6);
        }
        assert!((curve.length() - 0.45).abs() < 1e-5, "{}", curve.length());
    }

    #[test]
    fn points_on_a_line_are_a_line() {
        let points = [0.0, 0.1, 0.35, 1.0].map(|t| v(0.3 * t, 0.7 * t));
        assert_eq!(through(&points, [None, None]), Curve::line(points[0], points[3]));
        let halves = [Curve::line(points[0], points[2]), Curve::line(points[2], points[3])];
        assert_eq!(joined(&halves), Curve::line(points[0], points[3]));
        let back = [Curve::line(points[0], points[3]), Curve::line(points[3], points[1])];
        assert!(!joined(&back).is_straight());
    }

    proptest! {
        #[test]
        fn a_joined_curve_is_as_long_as_its_parts(
            parts in proptest::collection::vec([-0.5..0.5f64, -0.5..0.5, -0.5..0.5, -0.5..0.5, -0.5..0.5, -0.5..0.5], 1..5),
        ) {
            let mut start = Vector2::zeros();
            let mut curves = Vec::new();
            for [a, b, c, d, e, f] in parts {
                curves.push(Curve { start, end: v(e, f), shape: Shape::Cubic(v(a, b), v(c, d)) });
                start = v(e, f);
            }
            let whole = joined(&curves);
            let (length, area) = curves.iter().fold((0.0, 0.0), |(l, a), c| (l + c.length(), a + c.signed_area()));
            prop_assert!((whole.length() - length).abs() < 1e-6);
            prop_assert!((whole.signed_area() - area).abs() < 1e-9);
        }
    }
}
