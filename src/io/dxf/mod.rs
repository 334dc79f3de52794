//! DXF-AAMA (ANSI/AAMA-292) and ASTM D6673: the pieces of a style as pattern programs exchange them.
//!
//! These files have neither seams nor places around the body; what comes out lies in the plane as it was drawn. They are read
//! tolerantly: hardly a program writes them as the standards say, so that wherever a file leaves something open, what
//! was made of it is told by a warning. `docs/formats.md` says what is read.

mod block;
mod outline;
mod piece;
mod sizes;
mod tokens;
mod units;

use super::draft::Names;
use super::length::Unit;
use crate::geometry::Vector2;
use crate::pattern::Pattern;
use crate::{Error, Warning};
use block::Drawing;

/// What the user says about a file that does not say it, or says it wrongly.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The unit of the drawing; guessed if none is given.
    pub unit: Option<Unit>,
    /// The size to be read of a graded file; the sample size if none is given.
    pub size: Option<String>,
}

/// More pieces than any style has in one size.
const MOST_PIECES: usize = 500;
/// Pieces that are drawn farther from the origin than this are moved to it, m.
const FARTHEST: f64 = 8.0;

/// Reads a drawing; `name` is what the garment is called if the file does not say.
pub fn parse(bytes: &[u8], name: &str, options: &Options) -> Result<(Pattern, Vec<Warning>), Error> {
    let drawing = Drawing::of(&tokens::decode(bytes))?;
    let mut warnings = Vec::new();
    let pieces = sizes::choose(&drawing, options.size.as_deref(), &mut warnings)?;
    if pieces.is_empty() {
        return Err(no_pieces(&drawing));
    }
    if pieces.len() > MOST_PIECES {
        return Err(Error::new(
            format!("The file has {} pieces in one size.", pieces.len()),
            format!("More than {MOST_PIECES} are taken as damage; export one style at a time."),
        ));
    }
    if !drawing.unread.is_empty() {
        warnings.push(Warning(Error::new(
            format!("Outlines have parts of kinds that are not read: {}.", drawing.unread.join(", ")),
            "Export the pattern with polylines.",
        )));
    }
    let unit = match options.unit {
        Some(unit) => unit,
        None => {
            let (unit, how) = units::guess(middle_extent(&pieces), drawing.style.get(&["units", "unit"]));
            warnings.push(how);
            unit
        }
    };
    let pieces: Vec<sizes::Piece> = pieces.into_iter().map(|piece| in_metres(piece, unit)).collect();
    let marks = pieces.iter().flat_map(|p| &p.block.points).filter(|m| piece::is_notch(m.layer));
    // Of several kinds of notches the plainest is the single one.
    let first_sign = marks.map(piece::notch_sign).min();
    let mut names = Names::default();
    let mut panels = Vec::new();
    let mut without_sew_line = 0;
    for piece in &pieces {
        let read = piece::read(piece, first_sign, &mut warnings).map_err(|e| e.within(piece::place(piece)))?;
        without_sew_line += usize::from(!read.has_sew_line);
        panels.extend(read.draft.panels(&mut names, &mut warnings));
    }
    if without_sew_line > 0 {
        let of = if without_sew_line == pieces.len() {
            "none of the pieces has".to_owned()
        } else {
            format!("{without_sew_line} of {} pieces have no", pieces.len())
        };
        warnings.push(Warning(Error::new(
            format!("Whether the outlines have seam allowances is not said: {of} a sew line (layer 14). They are taken as they are.").replace("no a sew", "no sew"),
            "If they have, export the pattern with sew lines, or without seam allowances.",
        )));
    }
    let name = drawing.style.get(&["style name"]).unwrap_or(name).to_owned();
    let pattern = Pattern { name, panels, seams: Vec::new() };
    pattern.check()?;
    Ok((pattern, warnings))
}

fn no_pieces(drawing: &Drawing) -> Error {
    let loose = drawing.loose.polylines.len();
    let problem = match (drawing.blocks.len(), loose) {
        (0, 0) => "The drawing has no pieces: no blocks, and no lines outside them.".to_owned(),
        (0, _) => format!("The drawing has {loose} polylines, but no blocks."),
        (blocks, _) => format!("None of the {blocks} blocks has an outline on layer 1 or 14."),
    };
    Error::new(
        problem,
        "Export the pattern as DXF-AAMA or ASTM: there each piece is a block with its outline on layer 1.",
    )
}

/// Of the longest sides of the boxes around the pieces the middle one.
fn middle_extent(pieces: &[sizes::Piece]) -> f64 {
    let extent = |p: &sizes::Piece| p.block.bounds().map_or(0.0, |(low, high)| (high - low).amax());
    let mut extents: Vec<f64> = pieces.iter().map(extent).collect();
    extents.sort_by(f64::total_cmp);
    extents[extents.len() / 2]
}

fn in_metres(piece: sizes::Piece, unit: Unit) -> sizes::Piece {
    let metres = |p: Vector2| Vector2::new(unit.to_metres(p.x), unit.to_metres(p.y));
    let mut block = piece.block.mapped(metres);
    block.points.iter_mut().for_each(|m| m.width = unit.to_metres(m.width) * 1e3);
    if let Some((low, high)) = block.bounds()
        && low.amax().max(high.amax()) > FARTHEST
    {
        block = block.mapped(|p| p - low);
    }
    sizes::Piece { block, ..piece }
}
