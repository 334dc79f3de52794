//! What the seams make of the panels: pieces, and the kind of surface that each of them is.
//!
//! That no edge belongs to three panels is seen by [`Pattern::check`], as every edge is sewn once; that a piece has an opening
//! at all, when the garment is built.

use super::{Finding, listed};
use crate::Code;
use crate::geometry::UnionFind;
use crate::pattern::surface::{Surface, pieces};
use crate::pattern::{Pattern, Sense};

pub fn findings(pattern: &Pattern) -> Vec<Finding> {
    if pattern.seams.is_empty() {
        return unsewn(pattern).into_iter().collect();
    }
    let pieces = pieces(pattern);
    let mut findings = apart(pattern, &pieces);
    for piece in &pieces {
        if is_one_sided(pattern, piece) {
            findings.push(one_sided(pattern, piece));
        } else if Surface::new(pattern, piece, &pattern.seams).handles > 0 {
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

fn crossing(pattern: &Pattern, piece: &[usize]) -> Finding {
    let names = listed(piece.iter().map(|&p| pattern.panels[p].name.as_str()));
    Finding::new(
        Code::SeamsCross,
        format!("Some seams of {names} pass through each other: the surface that they make has a handle, like a cup."),
        "Look for seams that sew a left side to a right one, with `toile seams show`. A strap from hem to neckline is meant so.",
    )
    .within(format!("panel \"{}\"", pattern.panels[piece[0]].name))
}
