//! Motions of the drawing plane: turned, shifted, mirrored, scaled.

use super::{Arc, Curve, Shape};
use crate::geometry::{Vector2, cross};

/// `moved = x_axis * p.x + y_axis * p.y + shift`, with axes of equal length at right angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    x_axis: Vector2,
    y_axis: Vector2,
    shift: Vector2,
}

impl Motion {
    /// Counter-clockwise about the origin, rad.
    pub fn turn(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { x_axis: Vector2::new(cos, sin), y_axis: Vector2::new(-sin, cos), shift: Vector2::zeros() }
    }

    /// About the origin by a positive factor.
    pub fn scale(factor: f64) -> Self {
        let (x_axis, y_axis) = (Vector2::new(factor, 0.0), Vector2::new(0.0, factor));
        Self { x_axis, y_axis, shift: Vector2::zeros() }
    }

    /// The mirror image in the line through two different points.
    pub fn mirror([a, b]: [Vector2; 2]) -> Self {
        let along = (b - a).normalize();
        let image = |v: Vector2| along * (2.0 * along.dot(&v)) - v;
        Self { x_axis: image(Vector2::x()), y_axis: image(Vector2::y()), shift: a - image(a) }
    }

    pub fn apply(&self, p: Vector2) -> Vector2 {
        self.x_axis * p.x + self.y_axis * p.y + self.shift
    }

    /// Does it turn left into right?
    pub fn mirrors(&self) -> bool {
        cross(self.x_axis, self.y_axis) < 0.0
    }
}

impl Curve {
    /// The curve moved; its start stays its start.
    pub fn moved(&self, motion: &Motion) -> Self {
        let at = |p: Vector2| motion.apply(p);
        let shape = match &self.shape {
            Shape::Line => Shape::Line,
            Shape::Quadratic(c) => Shape::Quadratic(at(*c)),
            Shape::Cubic(c, d) => Shape::Cubic(at(*c), at(*d)),
            Shape::Arc(arc) => Shape::Arc(Arc {
                center: at(arc.center),
                radius: arc.radius * motion.x_axis.norm(),
                sweep: if motion.mirrors() { -arc.sweep } else { arc.sweep },
            }),
            Shape::Path(path) => Shape::Path(path.mapped(at)),
        };
        Self { start: at(self.start), end: at(self.end), shape }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64) -> Vector2 {
        Vector2::new(x, y)
    }

    #[test]
    fn moved_curves_are_the_curves_of_moved_points() {
        let (start, end) = (v(0.1, 0.2), v(0.9, 0.4));
        let arc = Shape::Arc(Arc::between(start, end, 0.7, true, true));
        let shapes = [Shape::Line, Shape::Quadratic(v(0.3, 0.9)), Shape::Cubic(v(0.0, 1.0), v(1.0, 1.0)), arc];
        let mirror = Motion::mirror([v(0.0, 1.0), v(2.0, 2.0)]);
        assert!(mirror.mirrors() && !Motion::turn(1.0).mirrors());
        for motion in [mirror, Motion::turn(0.7), Motion::scale(25.4)] {
            for shape in &shapes {
                let curve = Curve { start, end, shape: shape.clone() };
                let moved = curve.moved(&motion);
                for k in 0..=8 {
                    let fraction = f64::from(k) / 8.0;
                    let expected = motion.apply(curve.at_fraction(fraction));
                    assert!((moved.at_fraction(fraction) - expected).norm() < 1e-7, "{motion:?} {shape:?} {k}");
                }
            }
        }
    }

    #[test]
    fn points_of_the_mirror_stay() {
        let (a, b) = (v(0.3, -0.4), v(1.7, 2.2));
        let mirror = Motion::mirror([a, b]);
        assert!((mirror.apply(a) - a).norm() < 1e-12 && (mirror.apply(b) - b).norm() < 1e-12);
        assert!((mirror.apply(mirror.apply(v(5.0, 6.0))) - v(5.0, 6.0)).norm() < 1e-12);
    }
}
