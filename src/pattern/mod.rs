//! The sewing pattern: flat panels, where they start around the body, and the seams between them.
//!
//! A pattern is what a pattern maker drew, in metres; nothing here knows of particles. Whoever reads
//! a file builds a [`Pattern`] from it and calls [`Pattern::check`], which finds all that would make
//! the garment impossible to build.

mod check;
mod curve;
mod fabric;
mod inside;
mod motion;
mod names;
mod path;
pub mod sewing;
#[cfg(test)]
pub(crate) mod shapes;
mod spline;
mod split;
pub mod suggest;
pub mod surface;

pub use curve::{Arc, Curve, Shape};
pub use fabric::{Cut, Directional, Fabric, PRESETS, Preset, Quality};
pub use motion::Motion;
pub use path::Path;
pub use spline::{joined, through};

use crate::geometry::{Vector2, Vector3, polygon_crossing};
use nalgebra::Rotation3;

/// All panels and seams of one garment.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    pub name: String,
    pub panels: Vec<Panel>,
    pub seams: Vec<Seam>,
}

/// One flat piece of fabric.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Unique within the pattern.
    pub name: String,
    /// The outline: a closed loop, each segment starting where the one before ended. Counter-clockwise
    /// when the right side of the fabric faces the panel's own +z, clockwise when it faces -z.
    pub segments: Vec<Segment>,
    /// Where it starts around the body; none while it lies in the plane as it was drawn.
    pub placement: Option<Placement>,
    pub part: Option<BodyPart>,
    pub markings: Markings,
    /// The fabric that it is cut from, by name, where that is not the garment's own.
    pub fabric: Option<String>,
}

/// What is drawn on a panel besides its outline; panel coordinates, m.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Markings {
    pub notches: Vec<Notch>,
    /// From one end of the line to the other: the direction of the warp, whose sign says nothing.
    pub grainline: Option<[Vector2; 2]>,
    /// Drawn, not cut.
    pub lines: Vec<Vec<Vector2>>,
    pub drill_holes: Vec<Vector2>,
}

/// An alignment mark on the outline: at a fraction of the arc length of one of its segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Notch {
    pub segment: usize,
    pub fraction: f64,
    pub kind: NotchKind,
}

/// Marks of one kind meet marks of the same kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NotchKind {
    /// One slit or point: the usual mark, and that of front pieces.
    Single,
    /// Two beside each other, or a point that stands for them: the mark of back pieces.
    Double,
}

/// One curve of an outline, between two corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    pub curve: Curve,
    /// What the segment is on the body, when the pattern says so.
    pub label: Option<SegmentLabel>,
}

/// Where a panel starts: flat, `world = rotation * (x, y, 0) + translation`, or bent before that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    pub rotation: Rotation3<f64>,
    /// m.
    pub translation: Vector3,
    /// None for a flat panel.
    pub bend: Option<Bend>,
    /// How far above the place where it is worn the panel starts, m: trousers that are too long start above the feet.
    pub raised: f64,
}

/// A panel rolled around a cylinder that touches it along a line: no length on it changes.
///
/// ```text
///        along                       across --> _______ line        radius > 0: the axis of the cylinder lies
///          ^    the line of touch             /         \           at the panel's -z, its +z faces outward;
///          |                                 |     o     |          radius < 0: the other way round
///          origin --> across                  \  axis   /
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// A point of the line along which the flat panel and the cylinder touch, m, panel coordinates.
    pub origin: Vector2,
    /// Unit vector along that line, panel coordinates.
    pub along: Vector2,
    /// m, not zero.
    pub radius: f64,
}

impl Bend {
    /// Where a point of the panel comes to lie in the panel's own frame, m.
    pub fn bend(&self, point: Vector2) -> Vector3 {
        let across = Vector2::new(self.along.y, -self.along.x);
        let from = point - self.origin;
        let (sin, cos) = (from.dot(&across) / self.radius).sin_cos();
        let flat = self.origin + self.along * from.dot(&self.along) + across * (self.radius * sin);
        Vector3::new(flat.x, flat.y, self.radius * (cos - 1.0))
    }
}

impl Placement {
    /// A panel that stays flat.
    pub fn flat(rotation: Rotation3<f64>, translation: Vector3) -> Self {
        Self { rotation, translation, bend: None, raised: 0.0 }
    }

    /// Where a point of the panel starts in the world.
    pub fn place(&self, point: Vector2) -> Vector3 {
        let in_panel = self.bend.map_or(Vector3::new(point.x, point.y, 0.0), |bend| bend.bend(point));
        self.rotation * in_panel + self.translation
    }
}

/// The coarse zone of the body that a panel dresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BodyPart {
    /// Torso, neck and head.
    Body,
    Arm,
    /// Hips and below.
    Leg,
}

/// Segments that hold a garment in its place on the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SegmentLabel {
    /// The waist line that holds up what hangs below.
    LowerInterface,
    Collar,
    Armhole,
    StraplessTop,
}

/// A segment by the indices of its panel and of itself within the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SegmentId {
    pub panel: usize,
    pub segment: usize,
}

/// Two whole segments sewn together, point by point at equal fractions of their arc lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seam {
    pub sides: [SegmentId; 2],
    pub sense: Sense,
}

/// Which ends of the two sides meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sense {
    /// Start meets end: right side to right side, the rule for panels that lie side by side.
    Opposed,
    /// Start meets start: right side to wrong side, which folds one panel over the other.
    Aligned,
}

impl Sense {
    /// The fraction on the second side that meets `fraction` on the first.
    pub fn partner(self, fraction: f64) -> f64 {
        match self {
            Sense::Opposed => 1.0 - fraction,
            Sense::Aligned => fraction,
        }
    }
}

impl Pattern {
    pub fn segment(&self, id: SegmentId) -> &Segment {
        &self.panels[id.panel].segments[id.segment]
    }

    /// Have all panels places around a body?
    pub fn is_placed(&self) -> bool {
        self.panels.iter().all(|panel| panel.placement.is_some())
    }

    /// Lengths of the two sides of a seam, m.
    pub fn seam_lengths(&self, seam: &Seam) -> [f64; 2] {
        seam.sides.map(|side| self.segment(side).curve.length())
    }

    /// A seam as its author knows it: `front:3 + back:1`.
    pub fn seam_name(&self, seam: &Seam) -> String {
        let [a, b] = seam.sides.map(|side| format!("{}:{}", self.panels[side.panel].name, side.segment));
        format!("{a} + {b}")
    }
}

impl Panel {
    /// A panel that lies in the plane as it was drawn, with nothing on it.
    pub fn new(name: impl Into<String>, segments: Vec<Segment>) -> Self {
        let name = name.into();
        Self { name, segments, placement: None, part: None, markings: Markings::default(), fabric: None }
    }

    /// The same panel at a place.
    pub fn at(self, placement: Placement) -> Self {
        Self { placement: Some(placement), ..self }
    }

    /// Where a point of the panel starts in the world. The panel has a placement.
    pub fn place(&self, point: Vector2) -> Vector3 {
        self.start().place(point)
    }

    /// Its placement: whoever looks for it has placed the panel before.
    fn start(&self) -> &Placement {
        self.placement.as_ref().expect("the panel has a placement")
    }

    pub fn corners(&self) -> impl Iterator<Item = Vector2> + '_ {
        self.segments.iter().map(|s| s.curve.start)
    }

    /// Area within the outline, m²: positive for a counter-clockwise loop.
    pub fn signed_area(&self) -> f64 {
        self.segments.iter().map(|s| s.curve.signed_area()).sum()
    }

    pub fn perimeter(&self) -> f64 {
        self.segments.iter().map(|s| s.curve.length()).sum()
    }

    /// Unit normal of the right side of the fabric at its start, in the world; of a bent panel that along the line where
    /// it touches its cylinder. The panel has a placement.
    pub fn outward_normal(&self) -> Vector3 {
        self.start().rotation * Vector3::new(0.0, 0.0, self.signed_area().signum())
    }

    /// Points along the outline, `per_curve` for each curved segment and one for each straight one.
    pub fn polygon(&self, per_curve: usize) -> Vec<Vector2> {
        let mut points = Vec::new();
        for Segment { curve, .. } in &self.segments {
            let count = if curve.is_straight() { 1 } else { per_curve };
            points.extend((0..count).map(|i| curve.at_fraction(i as f64 / count as f64)));
        }
        points
    }

    /// The first two segments whose curves cross each other, if any do.
    pub fn crossing_segments(&self) -> Option<(usize, usize)> {
        // Chords of a twenty-fourth stay within 0.1 % of the length of any curve that is cut in cloth.
        const PER_CURVE: usize = 24;
        let mut owner: Vec<usize> = Vec::new();
        let mut points: Vec<Vector2> = Vec::new();
        for (k, segment) in self.segments.iter().enumerate() {
            points.extend(segment.curve.sketch(PER_CURVE));
            owner.resize(points.len(), k);
        }
        polygon_crossing(&points).map(|(i, j)| (owner[i], owner[j]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bending_keeps_lengths_and_brings_the_right_side_outside() {
        for radius in [0.1, -0.1] {
            let along = Vector2::new(0.6, 0.8);
            let bend = Bend { origin: Vector2::new(0.3, -0.2), along, radius };
            let axis = Vector3::new(0.3, -0.2, -radius);
            let along_3d = Vector3::new(along.x, along.y, 0.0);
            for k in 0..40 {
                let point = Vector2::new(0.3 + 0.01 * f64::from(k), 0.02 * f64::from(k) - 0.5);
                let off = bend.bend(point) - axis;
                let from_axis = off - along_3d * off.dot(&along_3d);
                assert!((from_axis.norm() - 0.1).abs() < 1e-12, "all points lie on the cylinder");
                let step = 1e-6;
                let along_x = (bend.bend(point + Vector2::x() * step) - bend.bend(point)) / step;
                let along_y = (bend.bend(point + Vector2::y() * step) - bend.bend(point)) / step;
                assert!((along_x.norm() - 1.0).abs() < 1e-4 && along_x.dot(&along_y).abs() < 1e-4, "no length changes");
                // The panel's +z faces away from the axis where the radius is positive.
                assert!(along_x.cross(&along_y).dot(&from_axis) * radius > 0.0);
            }
            assert_eq!(bend.bend(bend.origin), Vector3::new(0.3, -0.2, 0.0));
        }
    }
}
