//! What speaks for and against the two ways of sewing one seam.

use super::{Measured, SeamPlan, Stretch};
use crate::geometry::{Vector2, Vector3};
use crate::pattern::{NotchKind, Pattern, SegmentId};

/// A stretch with the direction in which the seam runs along it.
#[derive(Clone, Copy)]
pub struct Travelled<'a> {
    pub stretch: &'a Stretch,
    /// In the direction in which the outline is drawn.
    pub forward: bool,
}

/// One side of a seam, travelled from the seam's start to its end.
pub struct SidePath {
    /// Part of a segment, and whether it is travelled forward.
    pub parts: Vec<(super::Part, bool)>,
    /// Length from the start to the end of each part, m.
    pub ends: Vec<f64>,
}

impl SidePath {
    pub fn new(side: &[Travelled], measured: &Measured) -> Self {
        let mut parts = Vec::new();
        for travelled in side {
            let mut of = travelled.stretch.parts();
            if !travelled.forward {
                of.reverse();
            }
            parts.extend(of.into_iter().map(|part| (part, travelled.forward)));
        }
        let mut at = 0.0;
        let ends = parts.iter().map(|(part, _)| {
            at += (part.to - part.from) * measured.length_of(part.id);
            at
        });
        Self { ends: ends.collect(), parts }
    }

    pub fn length(&self) -> f64 {
        self.ends[self.ends.len() - 1]
    }

    /// The segment and the fraction along it at a fraction of the whole side.
    pub fn at(&self, fraction: f64) -> (SegmentId, f64) {
        let target = fraction * self.length();
        let k = self.ends.partition_point(|&end| end < target).min(self.parts.len() - 1);
        let start = if k == 0 { 0.0 } else { self.ends[k - 1] };
        let (part, forward) = self.parts[k];
        let share = ((target - start) / (self.ends[k] - start).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let share = if forward { share } else { 1.0 - share };
        (part.id, part.from + (part.to - part.from) * share)
    }

    /// The notches on the side, by the fraction of the whole side, ascending; those at its ends say nothing.
    pub fn notches(&self, pattern: &Pattern) -> Vec<(f64, NotchKind)> {
        /// A notch nearer to the end than this share marks the end.
        const AT_END: f64 = 0.01;
        let mut found = Vec::new();
        for (k, (part, forward)) in self.parts.iter().enumerate() {
            let start = if k == 0 { 0.0 } else { self.ends[k - 1] };
            for notch in pattern.panels[part.id.panel].markings.notches.iter().filter(|n| n.segment == part.id.segment)
            {
                let share = (notch.fraction - part.from) / (part.to - part.from);
                if (0.0..=1.0).contains(&share) {
                    let share = if *forward { share } else { 1.0 - share };
                    found.push(((start + share * (self.ends[k] - start)) / self.length(), notch.kind));
                }
            }
        }
        found.retain(|(f, _)| (AT_END..=1.0 - AT_END).contains(f));
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }
}

/// What placements, forms, notches and corners say against a way of sewing; only differences between the ways count.
pub fn cost(pattern: &Pattern, measured: &Measured, plan: &SeamPlan, sides: [&SidePath; 2]) -> f64 {
    /// Weight of the mean distance of what is to meet, in lengths of the seam.
    const PLACEMENT: f64 = 4.0;
    /// Weight of the mean difference of the bulges, in tenths of the chord.
    const FORM: f64 = 1.0;
    /// Weight of notches that find no partner of their kind.
    const NOTCHES: f64 = 3.0;
    /// Weight of the angles at the ends, in right angles.
    const CORNERS: f64 = 0.3;
    let mut cost = 0.0;
    if plan.sides.iter().flatten().all(|stretch| pattern.panels[stretch.panel].placement.is_some()) {
        cost += PLACEMENT * mean_distance(pattern, measured, sides);
    }
    if plan.sides.iter().all(|side| side.len() == 1) {
        cost += FORM * bulge_difference(measured, sides);
        cost += CORNERS * corner_difference(pattern, measured, sides);
    }
    cost + NOTCHES * notch_difference(&sides.map(|side| side.notches(pattern)))
}

/// Fractions at which two sides are compared.
const PROBES: usize = 9;

fn probes() -> impl Iterator<Item = f64> {
    (0..PROBES).map(|k| (k as f64 + 0.5) / PROBES as f64)
}

fn mean_distance(pattern: &Pattern, measured: &Measured, sides: [&SidePath; 2]) -> f64 {
    /// Short seams are not worth more than long ones, m.
    const LEAST_LENGTH: f64 = 0.05;
    let place = |side: &SidePath, t: f64| -> Vector3 {
        let (id, fraction) = side.at(t);
        pattern.panels[id.panel].place(measured.point(id, fraction))
    };
    let sum: f64 = probes().map(|t| (place(sides[0], t) - place(sides[1], t)).norm()).sum();
    sum / PROBES as f64 / sides[0].length().max(sides[1].length()).max(LEAST_LENGTH)
}

/// How differently the two sides bulge out of their chords, without regard to which way.
fn bulge_difference(measured: &Measured, sides: [&SidePath; 2]) -> f64 {
    /// Bulges in tenths of the chord: those of armholes and sleeve caps are about three.
    const TENTH: f64 = 0.1;
    let bulge = |side: &SidePath| -> Vec<f64> {
        let at = |t: f64| {
            let (id, fraction) = side.at(t);
            measured.point(id, fraction)
        };
        let (start, chord) = (at(0.0), at(1.0) - at(0.0));
        let length = chord.norm().max(1e-9);
        let across = Vector2::new(-chord.y, chord.x) / (length * length);
        probes().map(|t| (at(t) - start).dot(&across)).collect()
    };
    let (a, b) = (bulge(sides[0]), bulge(sides[1]));
    let difference = |sign: f64| a.iter().zip(&b).map(|(a, b)| (a - sign * b).abs()).sum::<f64>() / PROBES as f64;
    (difference(1.0).min(difference(-1.0)) / TENTH).min(2.0)
}

/// The interior angle at a corner of a panel, radians: at the start of a segment.
pub fn corner_angle(pattern: &Pattern, measured: &Measured, panel: usize, corner: usize) -> f64 {
    let count = pattern.panels[panel].segments.len();
    let before = SegmentId { panel, segment: (corner + count - 1) % count };
    let after = SegmentId { panel, segment: corner % count };
    let (arriving, leaving) = (measured.tangents(before)[1], measured.tangents(after)[0]);
    let turn = crate::geometry::cross(arriving, leaving).atan2(arriving.dot(&leaving));
    std::f64::consts::PI - turn * pattern.panels[panel].signed_area().signum()
}

/// Angles at ends that meet are alike, as at a fold, or add up to a straight line; in right angles.
fn corner_difference(pattern: &Pattern, measured: &Measured, sides: [&SidePath; 2]) -> f64 {
    let angle = |side: &SidePath, first: bool| -> Option<f64> {
        let (part, forward) = if first { side.parts[0] } else { side.parts[side.parts.len() - 1] };
        let at_start = first == forward;
        let fraction = if at_start { part.from } else { part.to };
        let corner = part.id.segment + usize::from(!at_start);
        let count = pattern.panels[part.id.panel].segments.len();
        (fraction == f64::from(u8::from(!at_start)))
            .then(|| corner_angle(pattern, measured, part.id.panel, corner % count))
    };
    let at = |first: bool| -> f64 {
        let (Some(a), Some(b)) = (angle(sides[0], first), angle(sides[1], first)) else { return 0.0 };
        (a - b).abs().min((a + b - std::f64::consts::PI).abs()) / std::f64::consts::FRAC_PI_2
    };
    at(true) + at(false)
}

/// The share of notches that have no partner of their kind nearby on the other side.
fn notch_difference([a, b]: &[Vec<(f64, NotchKind)>; 2]) -> f64 {
    /// Notches farther apart than this share of the seam are no partners: ease shifts them by less.
    const NEAR: f64 = 0.12;
    if a.is_empty() || b.is_empty() {
        return 0.0;
    }
    let missing = |from: &[(f64, NotchKind)], among: &[(f64, NotchKind)]| -> f64 {
        let miss = |(f, kind): &(f64, NotchKind)| {
            let nearest = among.iter().filter(|(_, k)| k == kind).map(|(g, _)| (f - g).abs()).fold(NEAR, f64::min);
            nearest / NEAR
        };
        from.iter().map(miss).sum::<f64>() / from.len() as f64
    };
    0.5 * (missing(a, b) + missing(b, a))
}
