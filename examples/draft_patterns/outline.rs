//! Panel outlines: named segments between corners, mirroring and turning round.

use toile::geometry::Vector2;
use toile::pattern::{Arc, Curve, Shape};

/// A point of the drawing, cm; x to the body's left, y up.
pub type Point = Vector2;

/// How the pen goes to the next corner.
#[derive(Clone, Copy)]
pub enum Stroke {
    Straight,
    /// A Bézier curve with two control points.
    Cubic(Point, Point),
    /// A circular arc of less than half a turn that bulges to the right of travel, or to the left.
    Arc {
        radius: f64,
        bulges_right: bool,
    },
}

/// A named curve between two corners.
#[derive(Clone)]
pub struct Segment {
    pub name: String,
    pub curve: Curve,
}

/// A closed loop of segments.
#[derive(Clone)]
pub struct Outline {
    pub segments: Vec<Segment>,
}

/// An open run of segments, drawn pen on paper.
pub struct Path {
    start: Point,
    segments: Vec<Segment>,
}

impl Stroke {
    fn between(self, start: Point, end: Point) -> Curve {
        let shape = match self {
            Stroke::Straight => Shape::Line,
            Stroke::Cubic(c, d) => Shape::Cubic(c, d),
            Stroke::Arc { radius, bulges_right } => Shape::Arc(Arc::between(start, end, radius, false, bulges_right)),
        };
        Curve { start, end, shape }
    }
}

impl Segment {
    fn reversed(&self) -> Self {
        let Curve { start, end, shape } = self.curve.clone();
        let shape = match shape {
            Shape::Line => Shape::Line,
            Shape::Quadratic(c) => Shape::Quadratic(c),
            Shape::Cubic(c, d) => Shape::Cubic(d, c),
            Shape::Arc(arc) => Shape::Arc(Arc { sweep: -arc.sweep, ..arc }),
            Shape::Path(path) => Shape::Path(path.reversed()),
        };
        Self { name: self.name.clone(), curve: Curve { start: end, end: start, shape } }
    }

    /// The mirror image in x = 0, traveled backward; `left_` in its name becomes `right_`.
    fn mirrored(&self) -> Self {
        let Curve { start, end, shape } = self.curve.clone();
        let shape = match shape {
            Shape::Line => Shape::Line,
            Shape::Quadratic(c) => Shape::Quadratic(mirror(c)),
            Shape::Cubic(c, d) => Shape::Cubic(mirror(d), mirror(c)),
            // mirroring and turning round both change the sense of rotation
            Shape::Arc(arc) => Shape::Arc(Arc { center: mirror(arc.center), ..arc }),
            Shape::Path(path) => Shape::Path(path.mapped(mirror).reversed()),
        };
        let name = self.name.replacen("left_", "right_", 1);
        Self { name, curve: Curve { start: mirror(end), end: mirror(start), shape } }
    }
}

impl Path {
    pub fn from(start: Point) -> Self {
        Self { start, segments: Vec::new() }
    }

    fn end(&self) -> Point {
        self.segments.last().map_or(self.start, |segment| segment.curve.end)
    }

    fn to(mut self, name: &str, end: Point, stroke: Stroke) -> Self {
        let curve = stroke.between(self.end(), end);
        self.segments.push(Segment { name: name.into(), curve });
        self
    }

    pub fn line(self, name: &str, end: Point) -> Self {
        self.to(name, end, Stroke::Straight)
    }

    pub fn cubic(self, name: &str, [c, d]: [Point; 2], end: Point) -> Self {
        self.to(name, end, Stroke::Cubic(c, d))
    }

    pub fn arc(self, name: &str, radius: f64, bulges_right: bool, end: Point) -> Self {
        self.to(name, end, Stroke::Arc { radius, bulges_right })
    }

    /// Joins the end to the start by a straight segment.
    pub fn closed(self, name: &str) -> Outline {
        let start = self.start;
        Outline { segments: self.line(name, start).segments }
    }

    /// The left half of a panel, from bottom to top, becomes the whole. A segment across the middle goes before it, from
    /// the mirror image of the start, and one after it where the end is off the middle and `top` is given.
    pub fn with_mirror_image(self, bottom: (&str, Stroke), top: Option<(&str, Stroke)>) -> Outline {
        let across = |(name, stroke): (&str, Stroke), start: Point, end: Point| Segment {
            name: name.into(),
            curve: stroke.between(start, end),
        };
        let (start, end) = (self.start, self.end());
        let mirrored: Vec<Segment> = self.segments.iter().rev().map(Segment::mirrored).collect();
        let mut segments = vec![across(bottom, mirror(start), start)];
        segments.extend(self.segments);
        segments.extend(top.map(|top| across(top, end, mirror(end))));
        segments.extend(mirrored);
        Outline { segments }
    }
}

impl Outline {
    pub fn length_of(&self, name: &str) -> f64 {
        let segment = self.segments.iter().find(|segment| segment.name == name);
        segment.unwrap_or_else(|| panic!("there is no segment {name}")).curve.length()
    }

    /// The same outline, traveled the other way: the right side of the fabric changes.
    pub fn reversed(self) -> Self {
        Self { segments: self.segments.iter().rev().map(Segment::reversed).collect() }
    }

    /// The mirror image in x = 0, traveled so that the right side of the fabric stays where it is.
    pub fn mirrored(&self) -> Self {
        Self { segments: self.segments.iter().rev().map(Segment::mirrored).collect() }
    }
}

fn mirror(p: Point) -> Point {
    Point::new(-p.x, p.y)
}

/// Rotated about a center, counter-clockwise.
pub fn rotated(p: Point, center: Point, radians: f64) -> Point {
    let (sin, cos) = radians.sin_cos();
    let v = p - center;
    center + Point::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y)
}

/// The x in the range at which an increasing function reaches a value, by halving.
pub fn solve_increasing(range: [f64; 2], target: f64, function: impl Fn(f64) -> f64) -> f64 {
    /// Halvings; each gains a binary digit.
    const HALVING_COUNT: usize = 60;
    let [mut low, mut high] = range;
    for _ in 0..HALVING_COUNT {
        let middle = 0.5 * (low + high);
        if function(middle) < target {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
