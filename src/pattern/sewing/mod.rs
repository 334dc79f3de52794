//! Seams as a pattern maker states them: runs of segments and parts of segments, n to m, without directions.
//!
//! A [`SeamPlan`] says what is sewn to what. [`find_directions`] finds for all plans together which ends meet, and
//! [`resolve`] cuts the outlines so that every seam joins whole segments, one to one, as [`Pattern::seams`] has them.
//! [`ease_of`] tells how long the sides of each are.

mod directions;
mod ease;
pub(in crate::pattern) mod evidence;
mod resolve;

pub use directions::{Directions, find_directions};
pub use ease::{Ease, SeamEase, ease_of};
pub use resolve::{Resolved, resolve};

use super::{Pattern, Seam, SegmentId, Sense};
use crate::geometry::Vector2;
use crate::{Code, Error};

/// A seam as it is meant, before the outlines are cut to fit it.
#[derive(Clone, Debug, PartialEq)]
pub struct SeamPlan {
    pub name: String,
    /// Each side: its stretches in the order in which they lie along the seam; at least one.
    pub sides: [Vec<Stretch>; 2],
    /// Along the outlines as they are drawn, from the first stretch of one side to that of the other; none where it
    /// is to be found.
    pub direction: Option<Sense>,
    /// The right side of the one is sewn to the wrong side of the other, which folds it over.
    pub right_wrong: bool,
    /// How much longer the longer side is said to be.
    pub ease: Option<Ease>,
    /// Where it is written, for messages; may be empty.
    pub place: String,
}

/// A piece of an outline: consecutive segments of one panel, the first and the last perhaps in part.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    pub panel: usize,
    /// In the order of the outline, each following the one before; at least one.
    pub segments: Vec<usize>,
    /// Where it starts: a fraction of the arc length of its first segment.
    pub from: f64,
    /// Where it ends: a fraction of the arc length of its last segment.
    pub to: f64,
}

/// A part of one segment, from a fraction of its arc length to another, ascending.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    pub id: SegmentId,
    pub from: f64,
    pub to: f64,
}

impl Stretch {
    /// A whole segment.
    pub fn whole(id: SegmentId) -> Self {
        Self { panel: id.panel, segments: vec![id.segment], from: 0.0, to: 1.0 }
    }

    /// Its segments with what of each belongs to it, in the order of the outline.
    pub fn parts(&self) -> Vec<Part> {
        let last = self.segments.len() - 1;
        let part = |(k, &segment): (usize, &usize)| Part {
            id: SegmentId { panel: self.panel, segment },
            from: if k == 0 { self.from } else { 0.0 },
            to: if k == last { self.to } else { 1.0 },
        };
        self.segments.iter().enumerate().map(part).collect()
    }

    /// m.
    pub fn length(&self, pattern: &Pattern) -> f64 {
        self.parts().iter().map(|p| (p.to - p.from) * pattern.segment(p.id).curve.length()).sum()
    }
}

impl SeamPlan {
    /// The plan that sews two whole segments.
    pub fn whole(name: impl Into<String>, sides: [SegmentId; 2]) -> Self {
        Self {
            name: name.into(),
            sides: sides.map(|side| vec![Stretch::whole(side)]),
            direction: None,
            right_wrong: false,
            ease: None,
            place: String::new(),
        }
    }

    /// The lengths of the two sides, m.
    pub fn lengths(&self, pattern: &Pattern) -> [f64; 2] {
        self.sides.each_ref().map(|side| side.iter().map(|stretch| stretch.length(pattern)).sum())
    }

    /// An error or a warning about this seam: with its name, and where it is written.
    pub fn complain(&self, problem: impl Into<String>, remedy: impl Into<String>) -> Error {
        let error = Error::new(problem, remedy).within(format!("seam \"{}\"", self.name));
        if self.place.is_empty() { error } else { error.within(&self.place) }
    }
}

/// The seams that a pattern has already, as plans with stated directions.
pub fn plans_of(pattern: &Pattern) -> Vec<SeamPlan> {
    let plan = |seam: &Seam| SeamPlan {
        direction: Some(seam.sense),
        right_wrong: seam.sense == Sense::Aligned,
        ..SeamPlan::whole(pattern.seam_name(seam), seam.sides)
    };
    pattern.seams.iter().map(plan).collect()
}

/// Do two sewn parts overlap, or does a part have no length? Named with both seams.
pub fn check_overlaps(pattern: &Pattern, plans: &[SeamPlan]) -> Result<(), Error> {
    /// Parts may overlap by so much, m: less than can be drawn.
    const SLACK: f64 = 1e-5;
    let mut sewn: Vec<(Part, usize)> = Vec::new();
    for (index, plan) in plans.iter().enumerate() {
        for part in plan.sides.iter().flatten().flat_map(Stretch::parts) {
            let length = pattern.segment(part.id).curve.length();
            if (part.to - part.from) * length < SLACK {
                return Err(plan.complain(
                    format!(
                        "Of edge {} of panel \"{}\" it sews nothing.",
                        part.id.segment, pattern.panels[part.id.panel].name
                    ),
                    "A part of an edge runs from a place to one farther along the edge; see `toile seams show`.",
                ));
            }
            sewn.push((part, index));
        }
    }
    sewn.sort_by(|(a, i), (b, j)| a.id.cmp(&b.id).then(a.from.total_cmp(&b.from)).then(i.cmp(j)));
    for pair in sewn.windows(2) {
        let [(a, i), (b, j)] = [pair[0], pair[1]];
        if a.id == b.id && (a.to - b.from) * pattern.segment(a.id).curve.length() > SLACK {
            let (first, second) = (i.min(j), i.max(j));
            let panel = &pattern.panels[a.id.panel].name;
            let twice = if i == j {
                "twice by this seam".to_owned()
            } else {
                format!("already by the seam \"{}\"", plans[first].name)
            };
            return Err(plans[second]
                .complain(
                    format!("Edge {} of panel \"{panel}\" is sewn {twice}.", a.id.segment),
                    "Sew every edge once; where parts of it meet different edges, give each part with `from` and `to`.",
                )
                .coded(Code::EdgeSewnTwice));
        }
    }
    Ok(())
}

/// Fractions of the arc length at which segments are sampled.
const SAMPLES: usize = 16;

/// The segments of a pattern, measured once.
pub struct Measured {
    /// Per panel and segment: its length, m.
    pub length: Vec<Vec<f64>>,
    /// Per panel and segment: points at `SAMPLES` even fractions, with both ends, m.
    points: Vec<Vec<[Vector2; SAMPLES + 1]>>,
}

impl Measured {
    pub fn new(pattern: &Pattern) -> Self {
        let points = |curve: &super::Curve| std::array::from_fn(|k| curve.at_fraction(k as f64 / SAMPLES as f64));
        Self {
            length: pattern.panels.iter().map(|p| p.segments.iter().map(|s| s.curve.length()).collect()).collect(),
            points: pattern.panels.iter().map(|p| p.segments.iter().map(|s| points(&s.curve)).collect()).collect(),
        }
    }

    /// The point at a fraction of the arc length, on a chord of a sixteenth.
    pub fn point(&self, id: SegmentId, fraction: f64) -> Vector2 {
        let at = (fraction * SAMPLES as f64).clamp(0.0, SAMPLES as f64);
        let k = (at as usize).min(SAMPLES - 1);
        let points = &self.points[id.panel][id.segment];
        points[k].lerp(&points[k + 1], at - k as f64)
    }

    /// Unit tangents at start and end of a segment, in its direction; zero where it has no length.
    pub fn tangents(&self, id: SegmentId) -> [Vector2; 2] {
        let p = &self.points[id.panel][id.segment];
        let unit = |v: Vector2| v.try_normalize(1e-12).unwrap_or_else(Vector2::zeros);
        [unit(p[1] - p[0]), unit(p[SAMPLES] - p[SAMPLES - 1])]
    }

    /// m.
    pub fn length_of(&self, id: SegmentId) -> f64 {
        self.length[id.panel][id.segment]
    }
}
