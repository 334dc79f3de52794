//! The curves of an outline: lengths, points at fractions of the length, areas.
//!
//! Bézier curves are measured by kurbo; circular arcs have closed formulas.

use crate::geometry::{Vector2, cross};
use kurbo::{CubicBez, ParamCurveArclen, ParamCurveArea, Point, QuadBez};

/// To how many metres kurbo measures a length. A pattern is cut to a tenth of a millimetre; matching
/// the two sides of a seam asks for far less than the finest resolution.
const LENGTH_ACCURACY: f64 = 1e-9;

/// One curve from `start` to `end`, m, panel-local.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    pub start: Vector2,
    pub end: Vector2,
    pub shape: Shape,
}

/// What runs between the two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Line,
    /// Quadratic Bézier with its control point.
    Quadratic(Vector2),
    /// Cubic Bézier with its two control points.
    Cubic(Vector2, Vector2),
    Arc(Arc),
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
}

fn kurbo_point(p: Vector2) -> Point {
    Point::new(p.x, p.y)
}

fn our_point(p: Point) -> Vector2 {
    Vector2::new(p.x, p.y)
}

impl Curve {
    pub fn line(start: Vector2, end: Vector2) -> Self {
        Self { start, end, shape: Shape::Line }
    }

    fn quadratic(&self, control: Vector2) -> QuadBez {
        QuadBez::new(kurbo_point(self.start), kurbo_point(control), kurbo_point(self.end))
    }

    fn cubic(&self, first: Vector2, second: Vector2) -> CubicBez {
        CubicBez::new(kurbo_point(self.start), kurbo_point(first), kurbo_point(second), kurbo_point(self.end))
    }

    /// Arc length, m.
    pub fn length(&self) -> f64 {
        match self.shape {
            Shape::Line => (self.end - self.start).norm(),
            Shape::Quadratic(c) => self.quadratic(c).arclen(LENGTH_ACCURACY),
            Shape::Cubic(c, d) => self.cubic(c, d).arclen(LENGTH_ACCURACY),
            Shape::Arc(arc) => arc.radius * arc.sweep.abs(),
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
        match self.shape {
            Shape::Line => self.start.lerp(&self.end, fraction),
            Shape::Quadratic(c) => bezier_at_fraction(&self.quadratic(c), fraction),
            Shape::Cubic(c, d) => bezier_at_fraction(&self.cubic(c, d), fraction),
            Shape::Arc(arc) => {
                let (sin, cos) = (arc.sweep * fraction).sin_cos();
                let r = self.start - arc.center;
                arc.center + Vector2::new(cos * r.x - sin * r.y, sin * r.x + cos * r.y)
            }
        }
    }

    /// What the curve adds to the signed area of its outline: the integral of `(x dy - y dx) / 2`.
    pub fn signed_area(&self) -> f64 {
        match self.shape {
            Shape::Line => 0.5 * cross(self.start, self.end),
            Shape::Quadratic(c) => self.quadratic(c).signed_area(),
            Shape::Cubic(c, d) => self.cubic(c, d).signed_area(),
            Shape::Arc(arc) => 0.5 * (arc.radius * arc.radius * arc.sweep + cross(arc.center, self.end - self.start)),
        }
    }

    pub fn is_straight(&self) -> bool {
        self.shape == Shape::Line
    }

    /// The points whose hull a Bézier curve stays in: its ends and controls. An arc has but its ends.
    pub fn control_points(&self) -> impl Iterator<Item = Vector2> + use<> {
        let inner = match self.shape {
            Shape::Line | Shape::Arc(_) => [None, None],
            Shape::Quadratic(c) => [Some(c), None],
            Shape::Cubic(c, d) => [Some(c), Some(d)],
        };
        [Some(self.start), Some(self.end)].into_iter().chain(inner).flatten()
    }

    /// Are all numbers of the curve finite?
    pub fn is_finite(&self) -> bool {
        let inner = match self.shape {
            Shape::Line => true,
            Shape::Quadratic(c) => finite(c),
            Shape::Cubic(c, d) => finite(c) && finite(d),
            Shape::Arc(arc) => finite(arc.center) && arc.radius.is_finite() && arc.sweep.is_finite(),
        };
        inner && finite(self.start) && finite(self.end)
    }
}

fn finite(p: Vector2) -> bool {
    p.iter().all(|c| c.is_finite())
}

fn bezier_at_fraction(bezier: &impl ParamCurveArclen, fraction: f64) -> Vector2 {
    let target = fraction * bezier.arclen(LENGTH_ACCURACY);
    our_point(bezier.eval(bezier.inv_arclen(target, LENGTH_ACCURACY)))
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
