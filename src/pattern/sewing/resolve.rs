//! Outlines cut so that every seam joins whole segments, one to one.

use super::evidence::SidePath;
use super::{Directions, Measured, SeamPlan, check_overlaps, ease, find_directions};
use crate::geometry::UnionFind;
use crate::pattern::{NotchKind, Pattern, Seam, Segment, SegmentId, SegmentLabel, Sense};
use crate::{Error, Warning};

/// A pattern whose seams are sewn as planned, and how it came out of what was drawn.
#[derive(Clone, Debug)]
pub struct Resolved {
    pub pattern: Pattern,
    /// Per seam of the pattern: its plan. A plan makes as many seams as its sides have pieces.
    pub plan_of_seam: Vec<usize>,
    /// Per seam of the pattern: does its plan state an ease?
    pub eased: Vec<bool>,
    /// Per panel and segment of the pattern: the part of which drawn segment it is.
    pub drawn: Vec<Vec<super::Part>>,
    /// Per panel: was it turned over?
    pub turned: Vec<bool>,
    pub warnings: Vec<Warning>,
}

/// Cuts nearer than this are one, m.
const SAME_PLACE: f64 = 1e-5;

/// Sews `plans` instead of the seams that `pattern` has. Outlines are cut where a seam starts or ends within a
/// segment, where the other side has a corner, and at notches; panels are turned over where right sides would
/// not lie on one side.
pub fn resolve(pattern: &Pattern, plans: &[SeamPlan]) -> Result<Resolved, Error> {
    check_overlaps(pattern, plans)?;
    let measured = Measured::new(pattern);
    let directions = find_directions(pattern, plans);
    let paths: Vec<[SidePath; 2]> = plans
        .iter()
        .enumerate()
        .map(|(k, plan)| directions.travelled(k, plan).each_ref().map(|side| SidePath::new(side, &measured)))
        .collect();
    let cuts = cuts(pattern, &measured, &paths);
    let mut resolved = cut(pattern, plans, &cuts, &directions);
    for (index, sides) in paths.iter().enumerate() {
        let pieces = sides.each_ref().map(|side| pieces(side, &cuts));
        if pieces[0].len() != pieces[1].len() {
            return Err(plans[index].complain(
                "Its sides cannot be cut into pieces that match.",
                "Give its sides as edges that start and end at corners or notches.",
            ));
        }
        for (&a, &b) in pieces[0].iter().zip(&pieces[1]) {
            resolved.pattern.seams.push(joined([a, b], &resolved.pattern, &directions));
            resolved.plan_of_seam.push(index);
            resolved.eased.push(plans[index].ease.is_some());
        }
    }
    resolved.warnings = ease::doubts(pattern, plans);
    resolved.warnings.extend(directions.warnings);
    resolved.pattern.check()?;
    Ok(resolved)
}

/// A piece of a side: the segment of the cut panel, before the panel is turned over, and whether it is run forward.
type Piece = (SegmentId, bool);

fn joined(pieces: [Piece; 2], cut: &Pattern, directions: &Directions) -> Seam {
    let final_id = |(id, _): Piece| {
        let last = cut.panels[id.panel].segments.len() - 1;
        let segment = if directions.turned[id.panel] { last - id.segment } else { id.segment };
        SegmentId { panel: id.panel, segment }
    };
    let ways = pieces.map(|(id, forward)| forward ^ directions.turned[id.panel]);
    let sense = if ways[0] == ways[1] { Sense::Aligned } else { Sense::Opposed };
    Seam { sides: pieces.map(final_id), sense }
}

/// Per panel and segment: where it is cut, fractions ascending.
type Cuts = Vec<Vec<Vec<f64>>>;

fn cuts(pattern: &Pattern, measured: &Measured, paths: &[[SidePath; 2]]) -> Cuts {
    let mut cuts: Cuts = pattern.panels.iter().map(|p| vec![Vec::new(); p.segments.len()]).collect();
    let mut add = |id: SegmentId, fraction: f64| cuts[id.panel][id.segment].push(fraction);
    for sides in paths {
        for (part, _) in sides.iter().flat_map(|side| &side.parts) {
            add(part.id, part.from);
            add(part.id, part.to);
        }
        for fractions in breaks(pattern, sides) {
            for (side, fraction) in sides.iter().zip(fractions) {
                let (id, fraction) = side.at(fraction);
                add(id, fraction);
            }
        }
    }
    for (panel, segments) in cuts.iter_mut().enumerate() {
        for (segment, at) in segments.iter_mut().enumerate() {
            let length = measured.length_of(SegmentId { panel, segment });
            at.sort_by(f64::total_cmp);
            at.dedup_by(|b, a| (*b - *a) * length < SAME_PLACE);
            at.retain(|f| f * length >= SAME_PLACE && (1.0 - f) * length >= SAME_PLACE);
        }
    }
    cuts
}

/// What lies along a side.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    Corner,
    Notch(NotchKind),
}

/// Where both sides are cut within, as fractions of each.
fn breaks(pattern: &Pattern, sides: &[SidePath; 2]) -> Vec<[f64; 2]> {
    /// A mark that has no partner cuts the other side nowhere nearer than this to another cut, m.
    const NEAREST: f64 = 1e-3;
    let marks = sides.each_ref().map(|side| marks(pattern, side));
    let anchors = partners(&marks);
    let mut knots: Vec<[f64; 2]> = anchors.iter().map(|&[a, b]| [marks[0][a].0, marks[1][b].0]).collect();
    knots.insert(0, [0.0, 0.0]);
    knots.push([1.0, 1.0]);
    let across = |from: usize, fraction: f64| {
        let k = knots.partition_point(|knot| knot[from] < fraction).clamp(1, knots.len() - 1);
        let [low, high] = [knots[k - 1], knots[k]];
        let share = (fraction - low[from]) / (high[from] - low[from]).max(f64::MIN_POSITIVE);
        low[1 - from] + share.clamp(0.0, 1.0) * (high[1 - from] - low[1 - from])
    };
    let mut found: Vec<([f64; 2], bool)> = knots.iter().map(|&knot| (knot, true)).collect();
    for from in 0..2 {
        for (k, &(fraction, mark)) in marks[from].iter().enumerate() {
            if anchors.iter().all(|pair| pair[from] != k) {
                let other = across(from, fraction);
                let both = if from == 0 { [fraction, other] } else { [other, fraction] };
                found.push((both, mark == Mark::Corner));
            }
        }
    }
    found.sort_by(|(a, i), (b, j)| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(j.cmp(i)));
    // Corners stay; notches too near to another cut do not.
    let near = |a: &[f64; 2], b: &[f64; 2]| (0..2).any(|k| (a[k] - b[k]).abs() * sides[k].length() < NEAREST);
    let firm: Vec<[f64; 2]> = found.iter().filter(|(_, firm)| *firm).map(|(at, _)| *at).collect();
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for (at, is_firm) in found {
        if is_firm || !(firm.iter().any(|other| near(&at, other)) || kept.last().is_some_and(|last| near(&at, last))) {
            kept.push(at);
        }
    }
    kept.retain(|at| at[0] > 0.0 && at[0] < 1.0 && at[1] > 0.0 && at[1] < 1.0);
    kept
}

/// Corners within a side, and notches, by fractions of its length, ascending.
fn marks(pattern: &Pattern, side: &SidePath) -> Vec<(f64, Mark)> {
    let inner = side.ends[..side.ends.len() - 1].iter().map(|end| (end / side.length(), Mark::Corner));
    let mut marks: Vec<(f64, Mark)> = inner.collect();
    for (fraction, kind) in side.notches(pattern) {
        // A notch at a corner is the corner.
        if marks.iter().all(|(f, _)| (f - fraction).abs() * side.length() > SAME_PLACE) {
            marks.push((fraction, Mark::Notch(kind)));
        }
    }
    marks.sort_by(|a, b| a.0.total_cmp(&b.0));
    marks
}

/// Marks of both sides that meet, in their order: the nearest first, and none across another.
fn partners(marks: &[Vec<(f64, Mark)>; 2]) -> Vec<[usize; 2]> {
    /// How far partners may lie apart, as a share of the seam: ease is spread between notches.
    const NOTCHES: f64 = 0.12;
    /// Corners lie beside each other only where they are drawn so.
    const CORNERS: f64 = 0.015;
    /// A notch may stand for a corner, as that of a sleeve cap for the shoulder.
    const NOTCH_AND_CORNER: f64 = 0.05;
    let mut pairs: Vec<(f64, [usize; 2])> = Vec::new();
    for (i, (f, a)) in marks[0].iter().enumerate() {
        for (j, (g, b)) in marks[1].iter().enumerate() {
            let farthest = match (a, b) {
                (Mark::Corner, Mark::Corner) => CORNERS,
                (Mark::Notch(k), Mark::Notch(l)) => {
                    if k == l {
                        NOTCHES
                    } else {
                        0.0
                    }
                }
                _ => NOTCH_AND_CORNER,
            };
            if (f - g).abs() < farthest {
                pairs.push(((f - g).abs(), [i, j]));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut taken: Vec<[usize; 2]> = Vec::new();
    for (_, [i, j]) in pairs {
        if taken.iter().all(|&[k, l]| (i < k && j < l) || (i > k && j > l)) {
            taken.push([i, j]);
        }
    }
    taken.sort_unstable();
    taken
}

/// The pieces of a side from its start to its end.
fn pieces(side: &SidePath, cuts: &Cuts) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (part, forward) in &side.parts {
        let panel = &cuts[part.id.panel];
        let first: usize = panel[..part.id.segment].iter().map(|c| c.len() + 1).sum();
        let at = &panel[part.id.segment];
        let bound = |k: usize| if k == 0 { 0.0 } else { at[k - 1] };
        let middle = |k: usize| 0.5 * (bound(k) + at.get(k).copied().unwrap_or(1.0));
        let within = (0..=at.len()).filter(|&k| (part.from..part.to).contains(&middle(k)));
        let mut of: Vec<Piece> =
            within.map(|k| (SegmentId { panel: part.id.panel, segment: first + k }, *forward)).collect();
        if !forward {
            of.reverse();
        }
        pieces.extend(of);
    }
    pieces
}

/// The pattern without seams, its segments cut and its panels turned.
fn cut(pattern: &Pattern, plans: &[SeamPlan], cuts: &Cuts, directions: &Directions) -> Resolved {
    let mut made = Pattern { seams: Vec::with_capacity(plans.len()), ..pattern.clone() };
    let mut drawn = Vec::new();
    for (index, panel) in made.panels.iter_mut().enumerate() {
        let mut segments = Vec::new();
        let mut parts = Vec::new();
        let notches = std::mem::take(&mut panel.markings.notches);
        for (k, segment) in panel.segments.iter().enumerate() {
            let at = &cuts[index][k];
            let first = segments.len();
            let label: Option<SegmentLabel> = segment.label;
            segments.extend(segment.curve.split(at).into_iter().map(|curve| Segment { curve, label }));
            let bounds: Vec<f64> = std::iter::once(0.0).chain(at.iter().copied()).chain([1.0]).collect();
            let id = SegmentId { panel: index, segment: k };
            parts.extend(bounds.windows(2).map(|w| super::Part { id, from: w[0], to: w[1] }));
            for notch in notches.iter().filter(|n| n.segment == k) {
                // A notch that became a corner is at the start of the piece that it begins.
                let piece = at.partition_point(|&cut| cut <= notch.fraction + 1e-9);
                let fraction = (notch.fraction - bounds[piece]) / (bounds[piece + 1] - bounds[piece]);
                let fraction = fraction.clamp(0.0, 1.0);
                panel.markings.notches.push(crate::pattern::Notch { segment: first + piece, fraction, ..*notch });
            }
        }
        panel.segments = segments;
        if directions.turned[index] {
            *panel = panel.turned_over();
            parts.reverse();
        }
        drawn.push(parts);
    }
    Resolved {
        pattern: made,
        plan_of_seam: Vec::new(),
        eased: Vec::new(),
        drawn,
        turned: directions.turned.clone(),
        warnings: Vec::new(),
    }
}

impl Resolved {
    /// How many pieces of cloth hang together.
    pub fn pieces(&self) -> usize {
        let mut sets = UnionFind::new(self.pattern.panels.len());
        for seam in &self.pattern.seams {
            sets.union(seam.sides[0].panel as u32, seam.sides[1].panel as u32);
        }
        (0..self.pattern.panels.len() as u32).filter(|&p| sets.find(p) == p).count()
    }
}
