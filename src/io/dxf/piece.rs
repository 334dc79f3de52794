//! From what is drawn in one block to a drafted piece: which loop is the outline, what the other marks are.

use super::block::{Block, Mark};
use super::outline::{Loop, Marked, Polyline, largest_loop};
use super::sizes::Piece;
use crate::geometry::Vector2;
use crate::io::draft::{Copies, Draft};
use crate::pattern::{Curve, NotchKind};
use crate::{Error, Warning};

/// A loop on layer 8 is the sew line if it has at least this share of the area of the cut line, and at most the other.
const SEW_LINE_AREA: std::ops::RangeInclusive<f64> = 0.6..=1.001;
const SEW_LINE_AREA_ON_8: std::ops::RangeInclusive<f64> = 0.8..=1.001;
/// No seam allowance is wider, m.
const WIDEST_ALLOWANCE: f64 = 0.06;
/// Notches nearer to each other are one double notch, m: they are set a quarter to half an inch apart.
const DOUBLE_NOTCH: f64 = 0.0135;
/// More vertices than any outline has; comparing all of them takes long.
pub const MOST_VERTICES: usize = 20_000;
/// More segments than any panel has.
const MOST_SEGMENTS: usize = 1_000;

/// Layer and width of a notch: notches that differ in it are of different kinds.
pub type NotchSign = (i32, i64);

pub fn notch_sign(mark: &Mark) -> NotchSign {
    // Widths are compared to a hundredth of the unit.
    (mark.layer, (mark.width.clamp(-1e6, 1e6) * 100.0).round() as i64)
}

pub fn is_notch(layer: i32) -> bool {
    layer == 4 || (80..=83).contains(&layer)
}

/// What a block is read into.
pub struct Read {
    pub draft: Draft,
    /// Was the outline on the layer of sew lines, or told from them?
    pub has_sew_line: bool,
}

/// Reads a block in metres. `first_sign` is the sign of single notches in this file.
pub fn read(piece: &Piece, first_sign: Option<NotchSign>, warnings: &mut Vec<Warning>) -> Result<Read, Error> {
    let block = &piece.block;
    let mut warn =
        |problem: String, remedy: &str| warnings.push(Warning(Error::new(problem, remedy).within(place(piece))));
    let vertices: usize = block.polylines.iter().map(|(_, line)| line.points.len()).sum();
    if vertices > MOST_VERTICES {
        return Err(Error::new(
            format!("It has {vertices} vertices."),
            format!("A piece of more than {MOST_VERTICES} vertices is taken as damaged; export it with fewer."),
        ));
    }
    let extent = block.bounds().map_or(0.0, |(low, high)| (high - low).amax());
    if extent > crate::io::draft::FARTHEST {
        return Err(Error::new(
            format!("It is {extent:.0} m long."),
            "Check the unit of the drawing, --unit, or export it again: a vertex may be damaged.",
        ));
    }
    let on = |layer: i32| -> Vec<Polyline> {
        block.polylines.iter().filter(|(l, _)| *l == layer).map(|(_, line)| line.clone()).collect()
    };
    // The same curve stands on two layers: the one with more vertices shows it better.
    let better = |layer: i32, copy: i32| -> Option<Loop> {
        let loops = [layer, copy].map(|l| largest_loop(&on(l), extent));
        match loops {
            [Some(a), Some(b)] if b.gap <= a.gap && b.points.len() > a.points.len() => Some(b),
            [Some(a), _] => Some(a),
            [None, b] => b,
        }
    };
    let cut = better(1, 84);
    let area = |l: &Loop| l.area().abs();
    let within_cut = |sew: &Loop, share: &std::ops::RangeInclusive<f64>| {
        sew.gap == 0.0 && cut.as_ref().is_none_or(|cut| share.contains(&(area(sew) / area(cut))))
    };
    let drawn_sew_line = better(14, 87);
    if let Some(sew) = &drawn_sew_line
        && !within_cut(sew, &SEW_LINE_AREA)
    {
        warn(
            "Its sew line (layer 14) is open or does not fit into the cut line; the cut line is taken.".to_owned(),
            "Draw the sew line as one closed loop, or remove the seam allowance before the export.",
        );
    }
    let sew = drawn_sew_line.filter(|sew| within_cut(sew, &SEW_LINE_AREA));
    let internal = if on(8).is_empty() { on(85) } else { on(8) };
    let parallel = |line: &Polyline| {
        let found = largest_loop(std::slice::from_ref(line), extent)?;
        let cut = cut.as_ref()?;
        let near = |p: &Vector2| distance(&cut.points, *p) <= WIDEST_ALLOWANCE;
        (within_cut(&found, &SEW_LINE_AREA_ON_8) && found.points.iter().all(near)).then_some(found)
    };
    let mut lines = internal;
    let mut sew_on_8 = None;
    if sew.is_none()
        && let Some(k) = lines.iter().position(|line| parallel(line).is_some())
    {
        sew_on_8 = parallel(&lines.remove(k));
    }
    let has_sew_line = sew.is_some() || sew_on_8.is_some();
    let Some(outline) = sew.or(sew_on_8).or(cut) else {
        return Err(Error::new(
            "It has no closed outline on layer 1 or 14.",
            "Export the pattern as DXF-AAMA or ASTM with the boundaries of its pieces.",
        ));
    };
    if outline.gap > 0.0 {
        warn(
            format!("Its outline is open by {}; it was closed with a line.", crate::io::length::describe(outline.gap)),
            "Draw the outline as one closed loop.",
        );
    }
    let curves = outline.curves(&marked(block), extent);
    if curves.len() > MOST_SEGMENTS {
        return Err(Error::new(
            format!("Its outline has {} corners.", curves.len()),
            format!("More than {MOST_SEGMENTS} are taken as damage; export the curves with more points, or smooth."),
        ));
    }
    let closed = |line: Polyline| {
        let mut points = line.points;
        if line.closed
            && let Some(&first) = points.first()
        {
            points.push(first);
        }
        points
    };
    let cut_outs: Vec<Polyline> = on(11);
    if !cut_outs.is_empty() {
        warn(
            "It has cut-outs (layer 11); they are taken as internal lines and not cut.".to_owned(),
            "Split the panel where it has a hole.",
        );
    }
    let segments = block.lines.iter().filter(|(layer, _)| *layer == 8).map(|(_, ends)| ends.to_vec());
    let lines = lines.into_iter().chain(cut_outs).map(closed).chain(segments).filter(|l| l.len() > 1).collect();
    let longest = |layer: i32| {
        let on = block.lines.iter().filter(|(l, _)| *l == layer).map(|(_, ends)| *ends);
        let polylines = block.polylines.iter().filter(|(l, p)| *l == layer && p.points.len() > 1);
        let ends = polylines.map(|(_, p)| [p.points[0], p.points[p.points.len() - 1]]);
        on.chain(ends).max_by(|a, b| (a[1] - a[0]).norm().total_cmp(&(b[1] - b[0]).norm()))
    };
    let grainline = longest(7);
    let fold = longest(6).filter(|f| f[0] != f[1]).or_else(|| fold_by_text(block, &curves, grainline, &mut warn));
    let copies = copies(block.texts.get(&["quantity"]), &mut warn);
    let fabric = block.texts.get(&["material", "fabric"]).filter(|f| f.chars().any(char::is_alphabetic));
    let draft = Draft {
        name: piece.name.clone(),
        notches: notches(block, &outline, first_sign),
        outline: curves,
        grainline,
        lines,
        drill_holes: block.points.iter().filter(|m| m.layer == 13).map(|m| m.point).collect(),
        fold,
        copies,
        fabric: fabric.map(str::to_owned),
    };
    Ok(Read { draft, has_sew_line })
}

pub fn place(piece: &Piece) -> String {
    format!("piece \"{}\"", piece.name.chars().take(100).collect::<String>().escape_debug())
}

fn marked(block: &Block) -> Marked {
    let on = |layer: i32| block.points.iter().filter(|m| m.layer == layer).map(|m| m.point).collect();
    Marked { corners: on(2), smooth: on(3) }
}

/// Positions and kinds of the notches; two beside each other are one double notch.
fn notches(block: &Block, outline: &Loop, first_sign: Option<NotchSign>) -> Vec<(Vector2, NotchKind)> {
    let mut notches: Vec<(Vector2, NotchKind)> = Vec::new();
    let mut add = |point: Vector2, sign: NotchSign| {
        let kind = if first_sign.is_none_or(|first| first == sign) { NotchKind::Single } else { NotchKind::Double };
        let beside = notches.iter_mut().find(|(p, k)| *k == kind && (p - point).norm() < DOUBLE_NOTCH);
        match beside {
            Some(other) => *other = ((other.0 + point) * 0.5, NotchKind::Double),
            None => notches.push((point, kind)),
        }
    };
    for mark in block.points.iter().filter(|m| is_notch(m.layer)).take(MOST_SEGMENTS) {
        add(mark.point, notch_sign(mark));
    }
    // A notch may be drawn as its slit, one end of which is on the outline.
    for (layer, ends) in block.lines.iter().filter(|(layer, _)| is_notch(*layer)).take(MOST_SEGMENTS) {
        let on_outline =
            ends.iter().min_by(|a, b| distance(&outline.points, **a).total_cmp(&distance(&outline.points, **b)));
        if let Some(&point) = on_outline {
            add(point, (*layer, 0));
        }
    }
    notches
}

/// From a point to the nearest side of a polygon.
fn distance(polygon: &[Vector2], p: Vector2) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let to_side = |(a, b): (&Vector2, &Vector2)| {
        let along = b - a;
        let t = ((p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (a + along * t - p).norm()
    };
    polygon.iter().zip(next).map(to_side).fold(f64::INFINITY, f64::min)
}

/// The fold of a piece that a text alone calls folded: its longest straight edge, along the grain if it has one.
fn fold_by_text(
    block: &Block,
    outline: &[Curve],
    grainline: Option<[Vector2; 2]>,
    warn: &mut impl FnMut(String, &str),
) -> Option<[Vector2; 2]> {
    let said = block.texts.get(&["fold", "mirror"])?;
    if ["0", "no", "none", "n", "false"].contains(&said.to_lowercase().as_str()) {
        return None;
    }
    let along_grain = |c: &&Curve| {
        grainline.is_none_or(|[a, b]| {
            let (grain, edge) = (b - a, c.end - c.start);
            crate::geometry::cross(grain, edge).abs() < 0.02 * grain.norm() * edge.norm()
        })
    };
    let straight = outline.iter().filter(|c| c.is_straight()).filter(along_grain);
    let longest = straight.max_by(|a, b| a.length().total_cmp(&b.length()))?;
    warn(
        format!(
            "It is to be folded, but its fold line (layer 6) is missing; its longest straight edge, of {}, is taken for it.",
            crate::io::length::describe(longest.length())
        ),
        "Draw the fold line on layer 6.",
    );
    Some([longest.start, longest.end])
}

/// `2` is a pair, `1,1` one left and one right.
fn copies(quantity: Option<&str>, warn: &mut impl FnMut(String, &str)) -> Copies {
    let Some(quantity) = quantity else { return Copies::One };
    let counts: Vec<u32> = quantity.split([',', ';', '/']).map_while(|n| n.trim().parse().ok()).collect();
    let (copies, total) = match counts.as_slice() {
        [] | [0 | 1] => (Copies::One, 1),
        [n] => (Copies::MirroredPair, *n),
        [l, r, ..] if *l > 0 && *r > 0 => (Copies::MirroredPair, l.saturating_add(*r)),
        [l, r, ..] if *l > 1 || *r > 1 => (Copies::Two, (*l).max(*r)),
        _ => (Copies::One, 1),
    };
    if total > 2 {
        warn(
            format!("It is to be cut {total} times; two were taken."),
            "More than two are linings or layers: add the panels that are to be sewn.",
        );
    }
    copies
}
