//! Curves cut in pieces, and run through from the other end.

use super::{Arc, Curve, Panel, Segment, Shape};
use crate::geometry::Vector2;
use kurbo::{CubicBez, ParamCurve, ParamCurveArclen, Point, QuadBez};

/// To how many metres the place of a cut is found along a Bézier curve.
const CUT_ACCURACY: f64 = 1e-9;

fn to(p: Vector2) -> Point {
    Point::new(p.x, p.y)
}

fn from(p: Point) -> Vector2 {
    Vector2::new(p.x, p.y)
}

impl Curve {
    /// The pieces between cuts at fractions of the arc length, ascending and within (0, 1). Neighbours share
    /// their ends exactly; the first starts and the last ends exactly where the curve does.
    pub fn split(&self, cuts: &[f64]) -> Vec<Curve> {
        if cuts.is_empty() {
            return std::slice::from_ref(self).to_vec();
        }
        let whole = self.length();
        let mut bounds = vec![(0.0, self.start)];
        bounds.extend(cuts.iter().map(|&f| (f, self.at_fraction(f))));
        bounds.push((1.0, self.end));
        bounds
            .windows(2)
            .map(|w| {
                let [(a, start), (b, end)] = [w[0], w[1]];
                Curve { start, end, shape: self.shape_between(a, b, whole) }
            })
            .collect()
    }

    fn shape_between(&self, a: f64, b: f64, length: f64) -> Shape {
        let range = |bezier: &dyn Fn(f64) -> f64| {
            let at = |f: f64| {
                if f <= 0.0 {
                    0.0
                } else if f >= 1.0 {
                    1.0
                } else {
                    bezier(f * length)
                }
            };
            at(a)..at(b)
        };
        match &self.shape {
            Shape::Line => Shape::Line,
            Shape::Quadratic(c) => {
                let whole = QuadBez::new(to(self.start), to(*c), to(self.end));
                Shape::Quadratic(from(whole.subsegment(range(&|l| whole.inv_arclen(l, CUT_ACCURACY))).p1))
            }
            Shape::Cubic(c, d) => {
                let whole = CubicBez::new(to(self.start), to(*c), to(*d), to(self.end));
                let piece = whole.subsegment(range(&|l| whole.inv_arclen(l, CUT_ACCURACY)));
                Shape::Cubic(from(piece.p1), from(piece.p2))
            }
            Shape::Arc(arc) => Shape::Arc(Arc { sweep: arc.sweep * (b - a), ..*arc }),
            Shape::Path(path) => Shape::Path(path.between(a, b)),
        }
    }
}

impl Panel {
    /// The same panel in the same place with the other side of the fabric as its right side: its outline is run
    /// through the other way, so that segment `k` of `n` becomes segment `n - 1 - k`.
    pub fn turned_over(&self) -> Panel {
        let last = self.segments.len().saturating_sub(1);
        let mut turned = self.clone();
        turned.segments =
            self.segments.iter().rev().map(|s| Segment { curve: s.curve.reversed(), label: s.label }).collect();
        for notch in &mut turned.markings.notches {
            notch.segment = last - notch.segment.min(last);
            notch.fraction = 1.0 - notch.fraction;
        }
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::shapes::rectangle;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pieces_follow_the_curve_and_have_their_share_of_its_length(
            c in [-1.0..2.0, -1.0..1.0f64], d in [-1.0..2.0, -1.0..1.0f64], cut in 0.05..0.9f64, kind in 0..4
        ) {
            let (start, end) = (Vector2::new(0.0, 0.0), Vector2::new(1.0, 0.2));
            let shape = match kind {
                0 => Shape::Line,
                1 => Shape::Quadratic(c.into()),
                2 => Shape::Cubic(c.into(), d.into()),
                _ => Shape::Arc(Arc::between(start, end, 0.8, cut > 0.5, cut > 0.3)),
            };
            let curve = Curve { start, end, shape };
            let cuts = [cut, 0.5 * (cut + 1.0)];
            let pieces = curve.split(&cuts);
            let length = curve.length();
            for (piece, [a, b]) in pieces.iter().zip([[0.0, cuts[0]], [cuts[0], cuts[1]], [cuts[1], 1.0]]) {
                prop_assert!((piece.length() - (b - a) * length).abs() < 1e-6);
                let middle = curve.at_fraction(0.5 * (a + b));
                prop_assert!((piece.at_fraction(0.5) - middle).norm() < 1e-6);
                let back = piece.reversed();
                prop_assert!((back.at_fraction(0.25) - piece.at_fraction(0.75)).norm() < 1e-6);
            }
            prop_assert!(pieces.windows(2).all(|w| w[0].end == w[1].start));
            prop_assert_eq!((pieces[0].start, pieces[2].end), (start, end));
        }
    }

    #[test]
    fn a_panel_turned_over_twice_is_the_panel() {
        let panel = rectangle("p", 0.2, 0.3);
        let turned = panel.turned_over();
        assert_eq!(turned.signed_area(), -panel.signed_area());
        assert_eq!(turned.turned_over(), panel);
    }
}
