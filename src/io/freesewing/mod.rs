//! FreeSewing drafts (Joost De Cock and contributors): the dump of a draft as JSON, and the program's own SVG.
//!
//! Both hold parts with paths; here is what they have in common: which path is the outline, where its corners are, what
//! the other marks mean. They have neither seams nor places around the body.

mod dump;
mod svg;

pub use dump::parse as parse_dump;
pub use svg::parse as parse_svg;

use super::draft::{Copies, Draft, Names};
use crate::geometry::Vector2;
use crate::pattern::{Curve, NotchKind, Panel, Pattern, joined};
use crate::{Error, Warning};

/// What a dump says of itself, before its version.
pub const DUMP_FORMAT: &str = "freesewing-draft-dump/";

/// Segments of an outline meet in a corner where it turns by more, rad: a hip runs into a side seam with less.
const CORNER: f64 = 20.0 / 180.0 * std::f64::consts::PI;
/// Ends of a path that are no farther apart are the same point, m.
const CLOSED: f64 = 5e-4;
/// Shorter curves are left out, m.
const NOTHING: f64 = 2e-6;
/// Notches within this distance of the outline lie on it, m; others mark places within the panel.
const ON_OUTLINE: f64 = 3e-3;
/// More curves than any drawing of a part has.
const MOST_CURVES: usize = 2_000;
/// More parts than any design has.
const MOST_PARTS: usize = 500;

/// Words in the class of a path that is not an outline.
const NOT_OUTLINE: [&str; 10] =
    ["sa", "help", "note", "contrast", "mark", "dotted", "dashed", "lashed", "hidden", "bartack"];
/// Words in the class of lines that are drawn on the fabric.
const DRAWN: [&str; 6] = ["help", "contrast", "mark", "dotted", "dashed", "lashed"];
/// Words in the class of lines that only explain, or show where to cut.
const EXPLAINS: [&str; 3] = ["note", "sa", "hidden"];

/// One part of a draft; m, y up.
struct Part {
    name: String,
    paths: Vec<PartPath>,
    /// Notches, and whether they are double.
    notches: Vec<(Vector2, NotchKind)>,
    marks: Vec<Vector2>,
    fold: Option<[Vector2; 2]>,
    grainline: Option<[Vector2; 2]>,
    copies: Copies,
    /// If it is not the main one.
    fabric: Option<String>,
}

struct PartPath {
    name: String,
    /// Words, separated by spaces.
    class: String,
    /// Connected runs of curves.
    runs: Vec<Vec<Curve>>,
}

impl PartPath {
    fn has(&self, words: &[&str]) -> bool {
        self.class.split_whitespace().any(|word| words.contains(&word))
    }

    /// The largest of its runs that is closed, and its area.
    fn outline(&self) -> Option<(&Vec<Curve>, f64)> {
        let closed = self.runs.iter().filter(|run| match (run.first(), run.last()) {
            (Some(first), Some(last)) => (last.end - first.start).norm() <= CLOSED,
            _ => false,
        });
        let area = |run: &Vec<Curve>| run.iter().map(Curve::signed_area).sum::<f64>().abs();
        closed.map(|run| (run, area(run))).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Joins drawing commands to runs of curves.
#[derive(Default)]
struct Pen {
    runs: Vec<Vec<Curve>>,
    start: Vector2,
    at: Vector2,
    drawn: usize,
}

impl Pen {
    fn move_to(&mut self, to: Vector2) {
        self.runs.push(Vec::new());
        (self.start, self.at) = (to, to);
    }

    fn draw(&mut self, curve: Curve) -> Result<(), Error> {
        self.drawn += 1;
        if self.drawn > MOST_CURVES {
            return Err(Error::new(
                format!("A path has more than {MOST_CURVES} curves."),
                "The file is damaged; export the draft again.",
            ));
        }
        if !curve.is_finite() {
            return Err(Error::new(
                "A path has a coordinate that is not a number.",
                "The file is damaged; export the draft again.",
            ));
        }
        // Measuring a curve of a light-year takes for ever; kurbo gives up on it with a panic.
        if curve.control_points().iter().any(|p| p.norm() > crate::io::draft::FARTHEST) {
            return Err(Error::new(
                format!("A path reaches farther than {} m from the origin.", crate::io::draft::FARTHEST),
                "The file is damaged; export the draft again.",
            ));
        }
        self.at = curve.end;
        // What has no length is left out; its end is kept as the start of the next.
        if curve.control_points().iter().any(|p| (p - curve.start).norm() > NOTHING) {
            if self.runs.is_empty() {
                self.runs.push(Vec::new());
            }
            let run = self.runs.last_mut().expect("there is a run");
            run.push(curve);
        }
        Ok(())
    }

    fn close(&mut self) -> Result<(), Error> {
        let start = self.start;
        if (self.at - start).norm() > CLOSED {
            self.draw(Curve::line(self.at, start))?;
        }
        self.move_to(start);
        Ok(())
    }
}

/// The panels of all parts that have an outline.
fn pattern_of(parts: Vec<Part>, name: String, mut warnings: Vec<Warning>) -> Result<(Pattern, Vec<Warning>), Error> {
    if parts.len() > MOST_PARTS {
        return Err(Error::new(
            format!("The draft has {} parts.", parts.len()),
            format!("More than {MOST_PARTS} are taken as damage; export the draft again."),
        ));
    }
    // `teagan.front` is a front, unless another design in the file has one as well.
    let short = |name: &str| name.rsplit('.').next().unwrap_or(name).to_owned();
    let shorts: Vec<String> = parts.iter().map(|part| short(&part.name)).collect();
    let mut names = Names::default();
    let mut panels: Vec<Panel> = Vec::new();
    for (part, short) in parts.into_iter().zip(&shorts) {
        let only = shorts.iter().filter(|other| *other == short).count() == 1;
        let name = if only && !short.is_empty() { short.clone() } else { part.name.clone() };
        match drafted(part, name.clone()) {
            Some(draft) => panels.extend(draft.panels(&mut names, &mut warnings)),
            None => warnings.push(Warning(
                Error::new(
                    "It has no closed outline and is left aside.",
                    "Draw its outline as a closed path, \"seam\".",
                )
                .within(format!("part \"{}\"", name.escape_debug())),
            )),
        }
    }
    if panels.is_empty() {
        return Err(Error::new(
            "No part of the draft has a closed outline.",
            "Export the whole draft; the outline of a part is its path \"seam\".",
        ));
    }
    let pattern = Pattern { name, panels, seams: Vec::new() };
    pattern.check()?;
    Ok((pattern, warnings))
}

fn drafted(part: Part, name: String) -> Option<Draft> {
    let named = |wanted: &str| {
        part.paths.iter().find(|path| path.name.eq_ignore_ascii_case(wanted)).and_then(PartPath::outline)
    };
    let plain = part.paths.iter().filter(|path| !path.has(&NOT_OUTLINE));
    let largest = || plain.filter_map(PartPath::outline).max_by(|a, b| a.1.total_cmp(&b.1));
    let (outline, _) = named("seam").or_else(|| named("outline")).or_else(largest)?;
    let outline = segments(outline);
    let drawn = part.paths.iter().filter(|path| path.has(&DRAWN) && !path.has(&EXPLAINS));
    let sketched = |run: &Vec<Curve>| {
        const PER_CURVE: usize = 8;
        let mut points: Vec<Vector2> = run.iter().flat_map(|curve| curve.sketch(PER_CURVE)).collect();
        points.extend(run.last().map(|curve| curve.end));
        points
    };
    let lines = drawn.flat_map(|path| &path.runs).map(sketched).filter(|line| line.len() > 1).collect();
    let near = |p: Vector2| outline.iter().any(|curve| curve.nearest(p).1 <= ON_OUTLINE);
    let (notches, inside): (Vec<_>, Vec<_>) = part.notches.into_iter().partition(|(p, _)| near(*p));
    let drill_holes = part.marks.into_iter().chain(inside.into_iter().map(|(p, _)| p)).collect();
    Some(Draft {
        name,
        outline,
        notches,
        grainline: part.grainline,
        lines,
        drill_holes,
        fold: part.fold,
        copies: part.copies,
        fabric: part.fabric,
    })
}

/// A closed run as segments from corner to corner. Without two corners it is cut at its start and half-way.
fn segments(run: &[Curve]) -> Vec<Curve> {
    let count = run.len();
    let turn = |k: usize| {
        let [_, reaching] = run[(k + count - 1) % count].end_directions();
        let [leaving, _] = run[k].end_directions();
        reaching.dot(&leaving).clamp(-1.0, 1.0).acos()
    };
    let mut corners: Vec<usize> = (0..count).filter(|&k| turn(k) > CORNER).collect();
    if corners.len() < 2 && count > 1 {
        let first = corners.first().copied().unwrap_or(0);
        corners = vec![first, (first + count / 2) % count];
        corners.sort_unstable();
    }
    if count == 1 {
        // One curve around: two halves of it.
        let points = (0..=32).map(|i| run[0].at_fraction(f64::from(i) / 32.0)).collect::<Vec<_>>();
        return [&points[..17], &points[16..]].map(|half| crate::pattern::through(half, [None, None])).to_vec();
    }
    let mut segments: Vec<Curve> = Vec::new();
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        let length = (to + count - from - 1) % count + 1;
        let mut parts: Vec<Curve> = (0..length).map(|k| run[(from + k) % count].clone()).collect();
        // Where a path closes but for a hair, it closes.
        let start = parts[0].start;
        if let Some(last) = segments.last_mut() {
            close_to(last, start);
        }
        for k in 1..parts.len() {
            let start = parts[k].start;
            close_to(&mut parts[k - 1], start);
        }
        segments.push(joined(&parts));
    }
    let start = segments[0].start;
    close_to(segments.last_mut().expect("there are segments"), start);
    segments
}

/// Moves the end of a curve to where the next one starts.
fn close_to(curve: &mut Curve, end: Vector2) {
    if curve.end == end {
        return;
    }
    let mut points = curve.cubics();
    let last = points.len() - 1;
    points[last] = end;
    *curve = if curve.is_straight() {
        Curve::line(curve.start, end)
    } else {
        crate::pattern::Path::new(points).map_or_else(|| curve.clone(), Curve::along)
    };
}

/// How a number of pieces is cut, and whether more are asked for than are made.
fn copies(count: f64, identical: bool) -> (Copies, bool) {
    match count {
        c if c < 2.0 || c.is_nan() => (Copies::One, false),
        c if identical => (Copies::Two, c > 2.0),
        c => (Copies::MirroredPair, c > 2.0),
    }
}

fn too_many(name: &str, count: f64) -> Warning {
    Warning(
        Error::new(
            format!("It is to be cut {count} times; two were taken."),
            "More than two are linings or layers: add the panels that are to be sewn.",
        )
        .within(format!("part \"{}\"", name.escape_debug())),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::Shape;

    fn v(x: f64, y: f64) -> Vector2 {
        Vector2::new(x, y)
    }

    #[test]
    fn smooth_joins_are_no_corners() {
        // A rectangle whose right side is two cubics that meet smoothly, closed but for a hair.
        let bow = |from: Vector2, to: Vector2, c: Vector2, d: Vector2| Curve {
            start: from,
            end: to,
            shape: Shape::Cubic(c, d),
        };
        let run = [
            Curve::line(v(0.0, 0.0), v(0.2, 0.0)),
            Curve::line(v(0.2, 0.0), v(0.4, 0.0)),
            bow(v(0.4, 0.0), v(0.5, 0.3), v(0.4, 0.1), v(0.5, 0.2)),
            bow(v(0.5, 0.3), v(0.4, 0.6), v(0.5, 0.4), v(0.4, 0.5)),
            Curve::line(v(0.4, 0.6), v(0.0, 0.6)),
            Curve::line(v(0.0, 0.6), v(1e-5, 0.0)),
        ];
        let segments = segments(&run);
        assert_eq!(segments.len(), 4);
        assert!(segments[0].is_straight() && (segments[0].length() - 0.4).abs() < 1e-12);
        assert!(matches!(segments[1].shape, Shape::Path(_)));
        assert!((0..4).all(|k| segments[k].end == segments[(k + 1) % 4].start));
    }

    #[test]
    fn an_outline_of_one_curve_is_halved() {
        let drop = Curve { start: v(0.0, 0.0), end: v(0.0, 0.0), shape: Shape::Cubic(v(0.5, 0.5), v(-0.5, 0.5)) };
        let halves = segments(std::slice::from_ref(&drop));
        assert_eq!(halves.len(), 2);
        let area: f64 = halves.iter().map(Curve::signed_area).sum();
        assert!((area / drop.signed_area() - 1.0).abs() < 2e-3, "{area} {}", drop.signed_area());
    }
}
