//! What the seams make of the panels: pieces, and the kind of surface that each of them is.
//!
//! Corners that meet are one vertex, sewn edges are one edge, panels are faces. A surface with `b` rims and `h` handles has
//! `V - E + F = 2 - 2h - b` (Euler's characteristic). Garments have rims, not handles: a handle comes about where seams cross,
//! as of sides sewn to the wrong partners. That no edge belongs to three panels is seen by [`Pattern::check`], as every edge
//! is sewn once.

use super::{Finding, listed};
use crate::Code;
use crate::geometry::UnionFind;
use crate::pattern::{Pattern, SegmentId, Sense};
use std::collections::{BTreeMap, BTreeSet};

pub fn findings(pattern: &Pattern) -> Vec<Finding> {
    if pattern.seams.is_empty() {
        return unsewn(pattern).into_iter().collect();
    }
    let pieces = pieces(pattern);
    let mut findings = apart(pattern, &pieces);
    for piece in &pieces {
        if is_one_sided(pattern, piece) {
            findings.push(one_sided(pattern, piece));
        } else if handles(pattern, piece) > 0 {
            findings.push(crossing(pattern, piece));
        }
    }
    findings
}

fn unsewn(pattern: &Pattern) -> Option<Finding> {
    (pattern.panels.len() > 1).then(|| {
        Finding::new(
            Code::NoSeams,
            format!(
                "The {} panels have no seams: drawings such as DXF and FreeSewing hold none.",
                pattern.panels.len()
            ),
            "Have seams proposed with `toile seams suggest`, look them over, and give the file with --seams.",
        )
    })
}

/// Panels that hang together, the largest piece first; pieces of one size in the order of the pattern.
fn pieces(pattern: &Pattern) -> Vec<Vec<usize>> {
    let mut sets = UnionFind::new(pattern.panels.len());
    pattern.seams.iter().for_each(|seam| sets.union(seam.sides[0].panel as u32, seam.sides[1].panel as u32));
    let mut pieces: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    (0..pattern.panels.len()).for_each(|panel| pieces.entry(sets.find(panel as u32)).or_default().push(panel));
    let mut pieces: Vec<Vec<usize>> = pieces.into_values().collect();
    pieces.sort_by_key(|piece| (usize::MAX - piece.len(), piece[0]));
    pieces
}

fn apart(pattern: &Pattern, pieces: &[Vec<usize>]) -> Vec<Finding> {
    let finding = |piece: &Vec<usize>| {
        let names = listed(piece.iter().map(|&p| pattern.panels[p].name.as_str()));
        let problem = match piece.len() {
            1 => "It is sewn to no other panel.".to_owned(),
            _ => format!("It hangs together with {names} alone, not with the rest of the garment."),
        };
        let remedy =
            "Add the missing seam, or fit the pieces as patterns of their own: nothing else keeps them together.";
        Finding::new(Code::PieceApart, problem, remedy).within(format!("panel \"{}\"", pattern.panels[piece[0]].name))
    };
    pieces[1..].iter().map(finding).collect()
}

/// Seams within a piece.
fn seams_of<'a>(pattern: &'a Pattern, piece: &'a [usize]) -> impl Iterator<Item = &'a crate::pattern::Seam> {
    pattern.seams.iter().filter(|seam| piece.binary_search(&seam.sides[0].panel).is_ok())
}

/// Does a way around along the seams come back on the other side of the fabric? Each seam that sews the right side to the
/// wrong side changes sides.
fn is_one_sided(pattern: &Pattern, piece: &[usize]) -> bool {
    // Each panel twice: its right side, its wrong side.
    let count = pattern.panels.len() as u32;
    let mut sides = UnionFind::new(2 * count as usize);
    for seam in seams_of(pattern, piece) {
        let [a, b] = seam.sides.map(|side| side.panel as u32);
        let change = if seam.sense == Sense::Aligned { count } else { 0 };
        sides.union(a, b + change);
        sides.union(a + count, b + count - change);
    }
    piece.iter().any(|&panel| sides.find(panel as u32) == sides.find(panel as u32 + count))
}

fn one_sided(pattern: &Pattern, piece: &[usize]) -> Finding {
    let folded: Vec<String> = seams_of(pattern, piece)
        .filter(|seam| seam.sense == Sense::Aligned)
        .map(|seam| pattern.seam_name(seam))
        .collect();
    Finding::new(
        Code::OneSided,
        format!(
            "Whoever follows the right side of the fabric over its seams comes back on the wrong side. Sewn right side to wrong side: {}.",
            listed(folded.iter().map(String::as_str))
        ),
        "Look which of these seams is to fold one panel over the other; of the others turn the direction around.",
    )
    .within(format!("panel \"{}\"", pattern.panels[piece[0]].name))
}

/// Corners that the seams bring together, one set per vertex.
struct Corners {
    /// Of all panels.
    count: usize,
    /// Per panel: number of its first corner.
    first: Vec<u32>,
    sets: UnionFind,
}

impl Corners {
    fn new(pattern: &Pattern) -> Self {
        let mut count: u32 = 0;
        let first = pattern.panels.iter().map(|panel| {
            count += panel.segments.len() as u32;
            count - panel.segments.len() as u32
        });
        let first: Vec<u32> = first.collect();
        let count = count as usize;
        let mut corners = Self { count, first, sets: UnionFind::new(count) };
        for seam in &pattern.seams {
            let [a, b] = seam.sides.map(|side| corners.ends(pattern, side));
            let b = if seam.sense == Sense::Opposed { [b[1], b[0]] } else { b };
            corners.sets.union(a[0], b[0]);
            corners.sets.union(a[1], b[1]);
        }
        corners
    }

    /// Of an edge, its start and its end.
    fn ends(&self, pattern: &Pattern, side: SegmentId) -> [u32; 2] {
        let count = pattern.panels[side.panel].segments.len();
        [side.segment, (side.segment + 1) % count].map(|k| self.first[side.panel] + k as u32)
    }
}

/// The handles of the surface that a piece is; it has two sides.
fn handles(pattern: &Pattern, piece: &[usize]) -> usize {
    let mut corners = Corners::new(pattern);
    let sewn: BTreeSet<SegmentId> = seams_of(pattern, piece).flat_map(|seam| seam.sides).collect();
    let all = || {
        let of =
            |&panel: &usize| (0..pattern.panels[panel].segments.len()).map(move |segment| SegmentId { panel, segment });
        piece.iter().flat_map(of)
    };
    let mut vertices = BTreeSet::new();
    let mut rims = UnionFind::new(corners.count);
    let mut on_rims = BTreeSet::new();
    for side in all() {
        let ends = corners.ends(pattern, side).map(|corner| corners.sets.find(corner));
        vertices.extend(ends);
        if !sewn.contains(&side) {
            rims.union(ends[0], ends[1]);
            on_rims.extend(ends);
        }
    }
    let rims: BTreeSet<u32> = on_rims.into_iter().map(|vertex| rims.find(vertex)).collect();
    let edges = all().count() - sewn.len() / 2;
    let characteristic = vertices.len() as i64 - edges as i64 + piece.len() as i64;
    ((2 - rims.len() as i64 - characteristic) / 2).max(0) as usize
}

fn crossing(pattern: &Pattern, piece: &[usize]) -> Finding {
    let names = listed(piece.iter().map(|&p| pattern.panels[p].name.as_str()));
    Finding::new(
        Code::SeamsCross,
        format!("Some seams of {names} pass through each other: the surface that they make has a handle, like a cup."),
        "Look for seams that sew a left side to a right one, with `toile seams show`. A strap from hem to neckline is meant so.",
    )
    .within(format!("panel \"{}\"", pattern.panels[piece[0]].name))
}
