//! The curves of an outline: lengths, points at fractions of the length, areas.
//!
//! Bézier curves are measured by kurbo; circular arcs have closed formulas.

use super::Path;
use crate::geometry::{Vector2, cross};
use kurbo::{CubicBez, ParamCurve, ParamCurveArclen, ParamCurveArea, ParamCurveNearest, Point, QuadBez};

/// To how many metres kurbo measures a length. A pattern is cut to a tenth of a millimetre; matching
/// the two sides of a seam asks for far less than the finest resolution.
pub(super) const LENGTH_ACCURACY: f64 = 1e-9;

/// One curve from `start` to `end`, m, panel-local.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    pub start: Vector2,
    pub end: Vector2,
    pub shape: Shape,
}

/// What runs between the two ends.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    Line,
    /// Quadratic Bézier with its control point.
    Quadratic(Vector2),
    /// Cubic Bézier with its two control points.
    Cubic(Vector2, Vector2),
    Arc(Arc),
    /// Several cubic Béziers, one after the other.
    Path(Path),
}

/// A circular arc around `center`, starting at the curve's start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    pub center: Vector2,
    pub radius: f64,
    /// Angle swept from start to end, radians, counter-clockwise positive.
    pub sweep: f64,
}

impl Arc {
    /// The arc of `radius` between two points.
    ///
    /// ```text
    ///        _--^--_            counter_clockwise: the arc bulges to the right of the travel
    ///      /         \          large: the longer of the two arcs
    ///   start - - -> end        a radius shorter than half the chord is taken as half the chord
    /// ```
    pub fn between(start: Vector2, end: Vector2, radius: f64, large: bool, counter_clockwise: bool) -> Self {
        let chord = end - start;
        let half = chord.norm() / 2.0;
        let radius = radius.max(half);
        let left = Vector2::new(-chord.y, chord.x) / chord.norm();
        let turn = if counter_clockwise { 1.0 } else { -1.0 };
        let side = if large { -turn } else { turn };
        let height = (radius * radius - half * half).max(0.0).sqrt();
        let minor = 2.0 * (half / radius).min(1.0).asin();
        let angle = if large { std::f64::consts::TAU - minor } else { minor };
        Self { center: (start + end) / 2.0 + left * (side * height), radius, sweep: turn * angle }
    }

    fn at_fraction(&self, start: Vector2, fraction: f64) -> Vector2 {
        let (sin, cos) = (self.sweep * fraction).sin_cos();
        let r = start - self.center;
        self.center + Vector2::new(cos * r.x - sin * r.y, sin * r.x + cos * r.y)
    }

    fn nearest(&self, start: Vector2, end: Vector2, point: Vector2) -> (f64, Vector2) {
        let (r, s) = (start - self.center, point - self.center);
        // The angle from the start to the point in the sense of the sweep, 0 to a full turn.
        let angle = (cross(r, s).atan2(r.dot(&s)) * self.sweep.signum()).rem_euclid(std::f64::consts::TAU);
        let fraction = angle / self.sweep.abs();
        if fraction <= 1.0 {
            return (fraction, self.at_fraction(start, fraction));
        }
        if (point - start).norm() <= (point - end).norm() { (0.0, start) } else { (1.0, end) }
    }

    /// Pieces of at most an eighth of a turn: their error is 4e-6 of the radius.
    fn cubics(&self, start: Vector2, end: Vector2) -> Vec<Vector2> {
        let count = (self.sweep.abs() / std::f64::consts::FRAC_PI_4).ceil().clamp(1.0, 64.0) as usize;
        let step = self.sweep / count as f64;
        // Handles of the usual length, Goldapp 1991, equation for k.
        let handle = 4.0 / 3.0 * (step / 4.0).tan();
        let tangent = |p: Vector2| Vector2::new(self.center.y - p.y, p.x - self.center.x) * handle;
        let mut points = vec![start];
        for k in 1..=count {
            let from = points[points.len() - 1];
            let to = if k == count { end } else { self.at_fraction(start, k as f64 / count as f64) };
            points.extend([from + tangent(from), to - tangent(to), to]);
        }
        points
    }
}

pub(super) fn kurbo_point(p: Vector2) -> Point {
    Point::new(p.x, p.y)
}

pub(super) fn our_point(p: Point) -> Vector2 {
    Vector2::new(p.x, p.y)
}

impl Curve {
    pub fn line(start: Vector2, end: Vector2) -> Self {
        Self { start, end, shape: Shape::Line }
    }

    /// The curve along a path of cubic Béziers; one piece is a cubic.
    pub fn along(path: Path) -> Self {
        let points = path.points();
        let (start, end) = (points[0], points[points.len() - 1]);
        let shape = if let [_, c, d, _] = points { Shape::Cubic(*c, *d) } else { Shape::Path(path) };
        Self { start, end, shape }
    }

    fn quadratic(&self, control: Vector2) -> QuadBez {
        QuadBez::new(kurbo_point(self.start), kurbo_point(control), kurbo_point(self.end))
    }

    fn cubic(&self, first: Vector2, second: Vector2) -> CubicBez {
        CubicBez::new(kurbo_point(self.start), kurbo_point(first), kurbo_point(second), kurbo_point(self.end))
    }

    /// Arc length, m.
    pub fn length(&self) -> f64 {
        match &self.shape {
            Shape::Line => (self.end - self.start).norm(),
            Shape::Quadratic(c) => self.quadratic(*c).arclen(LENGTH_ACCURACY),
            Shape::Cubic(c, d) => self.cubic(*c, *d).arclen(LENGTH_ACCURACY),
            Shape::Arc(arc) => arc.radius * arc.sweep.abs(),
            Shape::Path(path) => path.length(),
        }
    }

    /// The point at a fraction of the arc length; the ends are exact.
    pub fn at_fraction(&self, fraction: f64) -> Vector2 {
        if fraction <= 0.0 {
            return self.start;
        }
        if fraction >= 1.0 {
            return self.end;
        }
        match &self.shape {
            Shape::Line => self.start.lerp(&self.end, fraction),
            Shape::Quadratic(c) => bezier_at_fraction(&self.quadratic(*c), fraction),
            Shape::Cubic(c, d) => bezier_at_fraction(&self.cubic(*c, *d), fraction),
            Shape::Arc(arc) => arc.at_fraction(self.start, fraction),
            Shape::Path(path) => path.at_fraction(fraction),
        }
    }

    /// Points along the curve but its end, at about even steps, whose chords show its form. Cheaper than points at
    /// fractions of the length: `count` at even steps of the parameter, and no fewer than one for each piece of a path.
    pub fn sketch(&self, count: usize) -> Vec<Vector2> {
        let steps = |count: usize| (0..count).map(move |k| k as f64 / count as f64);
        match &self.shape {
            Shape::Line => vec![self.start],
            Shape::Quadratic(c) => steps(count).map(|t| our_point(self.quadratic(*c).eval(t))).collect(),
            Shape::Cubic(c, d) => steps(count).map(|t| our_point(self.cubic(*c, *d).eval(t))).collect(),
            Shape::Arc(arc) => steps(count).map(|t| arc.at_fraction(self.start, t)).collect(),
            Shape::Path(path) => path.sketch(count),
        }
    }

    /// The fraction of the arc length at which the curve comes nearest to a point, and the distance there.
    pub fn nearest(&self, point: Vector2) -> (f64, f64) {
        let (fraction, on_curve) = match &self.shape {
            Shape::Line => {
                let along = self.end - self.start;
                let fraction = ((point - self.start).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                let fraction = if fraction.is_nan() { 0.0 } else { fraction };
                (fraction, self.start.lerp(&self.end, fraction))
            }
            Shape::Quadratic(c) => nearest_on_bezier(&self.quadratic(*c), point),
            Shape::Cubic(c, d) => nearest_on_bezier(&self.cubic(*c, *d), point),
            Shape::Arc(arc) => arc.nearest(self.start, self.end, point),
            Shape::Path(path) => path.nearest(point),
        };
        (fraction, (on_curve - point).norm())
    }

    /// The curve as cubic Béziers: the `3 n + 1` points of `n` of them. Arcs are followed to a millionth of their radius.
    pub fn cubics(&self) -> Vec<Vector2> {
        let (a, b) = (self.start, self.end);
        match &self.shape {
            Shape::Line => vec![a, a.lerp(&b, 1.0 / 3.0), a.lerp(&b, 2.0 / 3.0), b],
            Shape::Quadratic(c) => vec![a, a.lerp(c, 2.0 / 3.0), b.lerp(c, 2.0 / 3.0), b],
            Shape::Cubic(c, d) => vec![a, *c, *d, b],
            Shape::Arc(arc) => arc.cubics(a, b),
            Shape::Path(path) => path.points().to_vec(),
        }
    }

    /// The same curve from its end to its start.
    pub fn reversed(&self) -> Self {
        let shape = match &self.shape {
            Shape::Line => Shape::Line,
            Shape::Quadratic(c) => Shape::Quadratic(*c),
            Shape::Cubic(c, d) => Shape::Cubic(*d, *c),
            Shape::Arc(arc) => Shape::Arc(Arc { sweep: -arc.sweep, ..*arc }),
            Shape::Path(path) => Shape::Path(path.reversed()),
        };
        Self { start: self.end, end: self.start, shape }
    }

    /// Unit directions in which the curve leaves its start and reaches its end; zero where it has no length.
    pub fn end_directions(&self) -> [Vector2; 2] {
        let unit = |v: Vector2| v.try_normalize(0.0).unwrap_or_default();
        if let Shape::Arc(arc) = &self.shape {
            let turn = arc.sweep.signum();
            let tangent = |p: Vector2| unit(Vector2::new(arc.center.y - p.y, p.x - arc.center.x) * turn);
            return [tangent(self.start), tangent(self.end)];
        }
        // A control point on the end leaves the direction to the next one; a hair is no direction.
        let points = self.cubics();
        let extent = points.iter().map(|p| (p - self.start).norm()).fold(0.0, f64::max);
        let away = |from: Vector2, p: &Vector2| ((p - from).norm() > 1e-6 * extent).then(|| p - from);
        let leaving = points.iter().find_map(|p| away(self.start, p)).unwrap_or_default();
        let reaching = points.iter().rev().find_map(|p| away(self.end, p)).unwrap_or_default();
        [unit(leaving), -unit(reaching)]
    }

    /// What the curve adds to the signed area of its outline: the integral of `(x dy - y dx) / 2`.
    pub fn signed_area(&self) -> f64 {
        match &self.shape {
            Shape::Line => 0.5 * cross(self.start, self.end),
            Shape::Quadratic(c) => self.quadratic(*c).signed_area(),
            Shape::Cubic(c, d) => self.cubic(*c, *d).signed_area(),
            Shape::Arc(arc) => 0.5 * (arc.radius * arc.radius * arc.sweep + cross(arc.center, self.end - self.start)),
            Shape::Path(path) => path.signed_area(),
        }
    }

    pub fn is_straight(&self) -> bool {
        self.shape == Shape::Line
    }

    /// The points whose hull a Bézier curve stays in: its ends and controls. An arc has but its ends.
    pub fn control_points(&self) -> Vec<Vector2> {
        match &self.shape {
            Shape::Line | Shape::Arc(_) => vec![self.start, self.end],
            Shape::Quadratic(c) => vec![self.start, *c, self.end],
            Shape::Cubic(c, d) => vec![self.start, *c, *d, self.end],
            Shape::Path(path) => path.points().to_vec(),
        }
    }

    /// Are all numbers of the curve finite?
    pub fn is_finite(&self) -> bool {
        let circle = match &self.shape {
            Shape::Arc(arc) => finite(&arc.center) && arc.radius.is_finite() && arc.sweep.is_finite(),
            _ => true,
        };
        circle && self.control_points().iter().all(finite)
    }
}

fn finite(p: &Vector2) -> bool {
    p.iter().all(|c| c.is_finite())
}

pub(super) fn bezier_at_fraction(bezier: &impl ParamCurveArclen, fraction: f64) -> Vector2 {
    let target = fraction * bezier.arclen(LENGTH_ACCURACY);
    our_point(bezier.eval(bezier.inv_arclen(target, LENGTH_ACCURACY)))
}

/// The fraction of the length at which a Bézier curve is nearest to a point, and the place.
fn nearest_on_bezier(bezier: &(impl ParamCurveArclen + ParamCurveNearest), point: Vector2) -> (f64, Vector2) {
    // The parameter of the nearest point is sought to a micrometre.
    let t = bezier.nearest(kurbo_point(point), 1e-6).t;
    let total = bezier.arclen(LENGTH_ACCURACY);
    let fraction = if total > 0.0 { bezier.subsegment(0.0..t).arclen(LENGTH_ACCURACY) / total } else { 0.0 };
    (fraction.clamp(0.0, 1.0), our_point(bezier.eval(t)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn v(x: f64, y: f64) -> Vector2 {
        Vector2::new(x, y)
    }

    fn half_circle(counter_clockwise: bool) -> Curve {
        let (start, end) = (v(-1.0, 0.0), v(1.0, 0.0));
        Curve { start, end, shape: Shape::Arc(Arc::between(start, end, 1.0, false, counter_clockwise)) }
    }

    #[test]
    fn a_counter_clockwise_arc_bulges_to_the_right_of_the_travel() {
        let middle = half_circle(true).at_fraction(0.5);
        assert!((middle - v(0.0, -1.0)).norm() < 1e-12);
        assert!((half_circle(false).at_fraction(0.5) - v(0.0, 1.0)).norm() < 1e-12);
    }

    #[test]
    fn a_half_disc_has_its_area_and_length() {
        let arc = half_circle(true);
        let chord = Curve::line(arc.end, arc.start);
        assert!((arc.length() - PI).abs() < 1e-12);
        assert!((arc.signed_area() + chord.signed_area() - PI / 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_large_arc_takes_the_long_way() {
        let (start, end) = (v(0.0, 0.0), v(1.0, 0.0));
        let large = Arc::between(start, end, 1.0, true, true);
        assert!((large.sweep - (2.0 * PI - PI / 3.0)).abs() < 1e-12);
        let curve = Curve { start, end, shape: Shape::Arc(large) };
        assert!((curve.at_fraction(0.999_999_999) - end).norm() < 1e-7);
    }

    #[test]
    fn a_radius_below_half_the_chord_is_a_half_circle() {
        let arc = Arc::between(v(0.0, 0.0), v(2.0, 0.0), 0.999, false, false);
        assert_eq!(arc.radius, 1.0);
        assert!((arc.sweep + PI).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn equal_fractions_are_equal_lengths(c in [-1.0..2.0, -1.0..1.0f64], d in [-1.0..2.0, -1.0..1.0f64]) {
            let curve = Curve { start: v(0.0, 0.0), end: v(1.0, 0.0), shape: Shape::Cubic(c.into(), d.into()) };
            let points: Vec<_> = (0..=1000).map(|i| curve.at_fraction(i as f64 / 1000.0)).collect();
            let step = curve.length() / 1000.0;
            for pair in points.windows(2) {
                // A chord is never longer than its arc; cusps shorten it.
                prop_assert!((pair[1] - pair[0]).norm() <= step * 1.0001);
            }
        }
    }
}
