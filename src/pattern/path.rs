//! Several cubic Béziers one after the other, as one curve: what runs between two corners of a drawing.

use super::curve::{LENGTH_ACCURACY, bezier_at_fraction, kurbo_point, our_point};
use crate::geometry::Vector2;
use kurbo::{CubicBez, ParamCurve, ParamCurveArclen, ParamCurveArea, ParamCurveNearest};
use std::fmt;
use std::sync::{Arc as Shared, OnceLock};

/// Cubic Béziers, each from where the one before ended; m, panel-local. A copy shares the points.
#[derive(Clone)]
pub struct Path(Shared<Pieces>);

struct Pieces {
    /// Of `n` pieces `3 n + 1`: start, control, control, end, control, control, end ...
    points: Vec<Vector2>,
    /// From the start to the end of each piece, `n + 1` of them. Measured when first asked for: a damaged file may
    /// hold curves that would take for ever.
    lengths: OnceLock<Vec<f64>>,
}

impl Path {
    /// The path through `3 n + 1` points; none if their number is another.
    pub fn new(points: Vec<Vector2>) -> Option<Self> {
        let fits = points.len() >= 4 && points.len() % 3 == 1;
        fits.then(|| Self(Shared::new(Pieces { points, lengths: OnceLock::new() })))
    }

    /// Ends and controls of its pieces, `3 n + 1`.
    pub fn points(&self) -> &[Vector2] {
        &self.0.points
    }

    fn piece_count(&self) -> usize {
        self.points().len() / 3
    }

    fn piece(&self, k: usize) -> CubicBez {
        let p = |i: usize| kurbo_point(self.points()[3 * k + i]);
        CubicBez::new(p(0), p(1), p(2), p(3))
    }

    fn lengths(&self) -> &[f64] {
        self.0.lengths.get_or_init(|| {
            let mut lengths = vec![0.0];
            for k in 0..self.piece_count() {
                lengths.push(lengths[k] + self.piece(k).arclen(LENGTH_ACCURACY));
            }
            lengths
        })
    }

    /// Arc length, m.
    pub fn length(&self) -> f64 {
        self.lengths()[self.piece_count()]
    }

    /// The point at a fraction of the arc length, between 0 and 1.
    pub fn at_fraction(&self, fraction: f64) -> Vector2 {
        let lengths = self.lengths();
        let target = fraction * self.length();
        let k = lengths.partition_point(|&l| l <= target).clamp(1, self.piece_count()) - 1;
        let within = (target - lengths[k]) / (lengths[k + 1] - lengths[k]);
        match within {
            w if w <= 0.0 || w.is_nan() => self.points()[3 * k],
            w if w >= 1.0 => self.points()[3 * k + 3],
            w => bezier_at_fraction(&self.piece(k), w),
        }
    }

    /// What the path adds to the signed area of its outline.
    pub fn signed_area(&self) -> f64 {
        (0..self.piece_count()).map(|k| self.piece(k).signed_area()).sum()
    }

    /// Points along the path but its end, at least `count` and at least one on each piece.
    pub fn sketch(&self, count: usize) -> Vec<Vector2> {
        let each = count.div_ceil(self.piece_count());
        let on = |k: usize| {
            let piece = self.piece(k);
            (0..each).map(move |i| our_point(piece.eval(i as f64 / each as f64)))
        };
        (0..self.piece_count()).flat_map(on).collect()
    }

    /// The fraction of the arc length nearest to a point, and the place.
    pub fn nearest(&self, point: Vector2) -> (f64, Vector2) {
        let mut best = (f64::INFINITY, 0, 0.0);
        for k in 0..self.piece_count() {
            let near = self.piece(k).nearest(kurbo_point(point), 1e-6);
            if near.distance_sq < best.0 {
                best = (near.distance_sq, k, near.t);
            }
        }
        let (_, k, t) = best;
        let before = self.lengths()[k] + self.piece(k).subsegment(0.0..t).arclen(LENGTH_ACCURACY);
        let fraction = if self.length() > 0.0 { (before / self.length()).clamp(0.0, 1.0) } else { 0.0 };
        (fraction, our_point(self.piece(k).eval(t)))
    }

    /// The part between two fractions of the arc length, the first the smaller one.
    pub fn between(&self, from: f64, to: f64) -> Self {
        let lengths = self.lengths();
        let (start, end) = (from.max(0.0) * self.length(), to.min(1.0) * self.length());
        let mut points = vec![self.at_fraction(from.max(0.0))];
        for k in 0..self.piece_count() {
            let (low, high) = (start.max(lengths[k]), end.min(lengths[k + 1]));
            if high - low <= LENGTH_ACCURACY {
                continue;
            }
            let piece = self.piece(k);
            let at = |length: f64| match length - lengths[k] {
                l if l <= 0.0 => 0.0,
                _ if length >= lengths[k + 1] => 1.0,
                l => piece.inv_arclen(l, LENGTH_ACCURACY),
            };
            let part = piece.subsegment(at(low)..at(high));
            points.extend([part.p1, part.p2, part.p3].map(our_point));
        }
        if points.len() == 1 {
            // Nothing of any length.
            points.extend([self.at_fraction(to.min(1.0)); 3]);
        }
        // Where it ends is asked for by fraction elsewhere; the two are to be one place.
        if let Some(last) = points.last_mut() {
            *last = self.at_fraction(to.min(1.0));
        }
        Self::new(points).expect("three points for each piece and one more")
    }

    /// From the end to the start.
    pub fn reversed(&self) -> Self {
        let points = self.points().iter().rev().copied().collect();
        Self(Shared::new(Pieces { points, lengths: OnceLock::new() }))
    }

    /// With every point moved.
    pub fn mapped(&self, map: impl Fn(Vector2) -> Vector2) -> Self {
        let points = self.points().iter().map(|&p| map(p)).collect();
        Self(Shared::new(Pieces { points, lengths: OnceLock::new() }))
    }
}

impl PartialEq for Path {
    fn eq(&self, other: &Self) -> bool {
        self.points() == other.points()
    }
}

impl fmt::Debug for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Path").field(&self.points()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Arc, Curve, Shape};
    use std::f64::consts::PI;

    fn v(x: f64, y: f64) -> Vector2 {
        Vector2::new(x, y)
    }

    fn three_quarters() -> (Curve, Curve) {
        let (start, end) = (v(1.0, 0.0), v(0.0, -1.0));
        let arc = Curve { start, end, shape: Shape::Arc(Arc::between(start, end, 1.0, true, true)) };
        let path = Curve::along(Path::new(arc.cubics()).unwrap());
        (arc, path)
    }

    #[test]
    fn a_path_along_an_arc_has_its_length_area_and_points() {
        let (arc, path) = three_quarters();
        assert!(matches!(path.shape, Shape::Path(_)));
        assert!((arc.length() - 1.5 * PI).abs() < 1e-12 && (path.length() - arc.length()).abs() < 3e-5);
        assert!((path.signed_area() - arc.signed_area()).abs() < 3e-5);
        for k in 0..=100 {
            let fraction = f64::from(k) / 100.0;
            assert!((path.at_fraction(fraction) - arc.at_fraction(fraction)).norm() < 3e-5, "{k}");
            let (found, distance) = path.nearest(0.5 * arc.at_fraction(fraction));
            assert!((found - fraction).abs() < 1e-4 && (distance - 0.5).abs() < 3e-5, "{k}: {found}, {distance}");
            let (found, distance) = arc.nearest(1.5 * arc.at_fraction(fraction));
            assert!((found - fraction).abs() < 1e-9 && (distance - 0.5).abs() < 1e-9, "{k}: {found}, {distance}");
        }
    }

    #[test]
    fn reversed_curves_run_backwards() {
        let (arc, path) = three_quarters();
        for curve in [arc, path] {
            let back = curve.reversed();
            assert!((back.length() - curve.length()).abs() < 1e-9);
            assert!((back.signed_area() + curve.signed_area()).abs() < 1e-12);
            for k in 0..=10 {
                let fraction = f64::from(k) / 10.0;
                assert!((back.at_fraction(fraction) - curve.at_fraction(1.0 - fraction)).norm() < 1e-7);
            }
            let ([a, b], [c, d]) = (curve.end_directions(), back.end_directions());
            assert!((a + d).norm() < 1e-9 && (b + c).norm() < 1e-9);
        }
    }

    #[test]
    fn numbers_of_points_that_make_no_path_are_refused() {
        for count in [0, 1, 3, 5, 6] {
            assert!(Path::new(vec![Vector2::zeros(); count]).is_none());
        }
    }
}
