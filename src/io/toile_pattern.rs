//! Our own pattern format, TOML or JSON: all that a [`Pattern`] holds, to the last bit.
//!
//! `docs/formats.md` describes it, `docs/schema/pattern.schema.json` is its schema for editors. [`write_json`] and
//! [`write_toml`] write metres, so that reading gives the same numbers back; files made by hand may use another unit.

use super::length::Unit;
use crate::geometry::{Vector2, Vector3};
use crate::pattern::{
    Arc, Bend, BodyPart, Curve, Markings, Notch, NotchKind, Panel, Path, Pattern, Placement, Seam, Segment, SegmentId,
    SegmentLabel, Sense, Shape,
};
use crate::{Error, Warning};
use nalgebra::{Matrix3, Rotation3};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// What a file of ours says of itself.
pub const FORMAT: &str = "toile pattern";
const VERSION: u32 = 1;

/// More than any pattern or panel has; a file with more is damaged, and comparing all edges of a panel takes long.
const MOST_EDGES: usize = 5_000;
const MOST_EDGES_PER_PANEL: usize = 1_000;
const MOST_PATH_POINTS: usize = 200_000;
/// How far an arc may miss its own ends, and a rotation be from a rotation.
const TOLERANCE: f64 = 1e-6;
/// How far the ease that a seam declares may be from that of its sides before it is told.
const EASE_TOLERANCE: f64 = 0.005;

type Point = [f64; 2];

/// A pattern of toile.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct File {
    /// Always "toile pattern".
    format: String,
    /// Always 1.
    version: u32,
    /// What the garment is called; else the name of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    /// Of all lengths in the file; metres if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<Unit>,
    panels: Vec<FilePanel>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    seams: Vec<FileSeam>,
}

/// One flat piece of fabric.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FilePanel {
    /// Unique, one line of text.
    name: String,
    /// The zone of the body that it dresses.
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<FilePart>,
    /// The fabric that it is cut from, where that is not the garment's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    fabric: Option<String>,
    /// From one end of the line to the other: the direction of the warp.
    #[serde(skip_serializing_if = "Option::is_none")]
    grainline: Option<[Point; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    drill_holes: Vec<Point>,
    /// Drawn, not cut.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    internal_lines: Vec<Vec<Point>>,
    /// Where it starts around the body; left out while it lies in the plane as drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    placement: Option<FilePlacement>,
    /// One closed loop, counter-clockwise when the right side of the fabric faces the panel's own +z.
    outline: Vec<FileSegment>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    notches: Vec<FileNotch>,
}

/// `world = rotation * (x, y, 0) + translation`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FilePlacement {
    translation: [f64; 3],
    /// Three rows of a rotation matrix. Instead of it `angles_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation: Option<[[f64; 3]; 3]>,
    /// Turns about the fixed axes x, then y, then z, in degrees. Instead of it `rotation`.
    #[serde(skip_serializing_if = "Option::is_none")]
    angles_deg: Option<[f64; 3]>,
    /// The panel is bent around a cylinder before it is turned and moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bend: Option<FileBend>,
    /// How far above the place where it is worn the panel starts.
    #[serde(default, skip_serializing_if = "is_zero")]
    raised: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands on references.
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// A cylinder that touches the flat panel along a line.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FileBend {
    /// A point of that line.
    origin: Point,
    /// Its direction, of length one.
    along: Point,
    /// Positive where the axis is behind the panel, on its -z side; not zero.
    radius: f64,
}

/// One curve of an outline, between two corners: straight, or with one of `quadratic`, `cubic`, `arc` and `path`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FileSegment {
    /// The corner where it starts.
    from: Point,
    /// Where it ends, if that is not exactly where the next one starts.
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<Point>,
    /// What it is on the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    label: Option<FileLabel>,
    /// The control point of a quadratic Bézier curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    quadratic: Option<Point>,
    /// The control points of a cubic Bézier curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    cubic: Option<[Point; 2]>,
    /// Of several cubic Bézier curves one after the other: control, control, end, control, control, end, ...,
    /// control, control.
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<Vec<Point>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    arc: Option<FileArc>,
}

/// A circular arc.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FileArc {
    center: Point,
    radius: f64,
    /// Angle from the start to the end, radians, counter-clockwise positive.
    sweep: f64,
}

/// An alignment mark on the outline.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FileNotch {
    /// Number of its segment in the outline, from 0.
    segment: usize,
    /// Of the segment's arc length, from 0 at its start to 1 at its end.
    fraction: f64,
    #[serde(default = "single", skip_serializing_if = "FileNotchKind::is_single")]
    kind: FileNotchKind,
}

/// Two segments sewn together over their whole lengths.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FileSeam {
    /// For messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    /// How much longer the second side is meant to be than the first: 0.02 is 2 %. A check, not an order.
    #[serde(skip_serializing_if = "Option::is_none")]
    ease: Option<f64>,
    #[serde(default = "opposed", skip_serializing_if = "FileSense::is_opposed")]
    sense: FileSense,
    sides: [FileSide; 2],
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FileSide {
    panel: String,
    /// Number in the outline, from 0.
    segment: usize,
}

/// Words of the file for words of ours, one for one.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident = $ours:ident { $($(#[$about:meta])* $word:ident),+ }) => {
        $(#[$doc])*
        #[derive(Serialize, Deserialize, Clone, Copy)]
        #[serde(rename_all = "snake_case")]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        enum $name { $($(#[$about])* $word),+ }
        impl From<$ours> for $name {
            fn from(ours: $ours) -> Self {
                match ours { $($ours::$word => Self::$word),+ }
            }
        }
        impl From<$name> for $ours {
            fn from(word: $name) -> Self {
                match word { $($name::$word => Self::$word),+ }
            }
        }
    };
}

words!(FilePart = BodyPart { Body, Arm, Leg });
words!(FileLabel = SegmentLabel { LowerInterface, Collar, Armhole, StraplessTop });
words!(FileNotchKind = NotchKind { Single, Double });
words!(
    /// Which ends of the two sides meet.
    FileSense = Sense {
        /// Start meets end: right side to right side.
        Opposed,
        /// Start meets start: right side to wrong side.
        Aligned
    }
);

impl FileNotchKind {
    fn is_single(&self) -> bool {
        matches!(self, Self::Single)
    }
}

fn single() -> FileNotchKind {
    FileNotchKind::Single
}

impl FileSense {
    fn is_opposed(&self) -> bool {
        matches!(self, Self::Opposed)
    }
}

fn opposed() -> FileSense {
    FileSense::Opposed
}

/// The pattern as JSON, one line.
pub fn write_json(pattern: &Pattern) -> String {
    serde_json::to_string(&file_of(pattern)).expect("all of it can be written")
}

/// The pattern as TOML.
pub fn write_toml(pattern: &Pattern) -> String {
    toml::to_string(&file_of(pattern)).expect("all of it can be written")
}

/// Reads JSON; `name` is what the garment is called if the file does not say.
pub fn parse_json(text: &str, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    let file = serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|e: serde_json::Error| {
        Error::new(
            format!("The pattern cannot be read: {e}."),
            "See docs/formats.md for the form of a pattern of toile.",
        )
    })?;
    pattern_of(file, name)
}

/// Reads TOML; `name` is what the garment is called if the file does not say.
pub fn parse_toml(text: &str, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    let text = text.trim_start_matches('\u{feff}');
    let file = toml::from_str(text).map_err(|e: toml::de::Error| {
        let line = e
            .span()
            .map(|span| 1 + text.as_bytes()[..span.start.min(text.len())].iter().filter(|&&b| b == b'\n').count());
        let error = Error::new(
            format!("The pattern cannot be read: {}.", e.message().trim_end_matches('.').replace('\n', ", ")),
            "See docs/formats.md for the form of a pattern of toile.",
        );
        line.map_or(error.clone(), |line| error.within(format!("line {line}")))
    })?;
    pattern_of(file, name)
}

fn file_of(pattern: &Pattern) -> File {
    let side = |id: SegmentId| FileSide { panel: pattern.panels[id.panel].name.clone(), segment: id.segment };
    let seam = |s: &Seam| FileSeam { name: None, ease: None, sense: s.sense.into(), sides: s.sides.map(side) };
    File {
        format: FORMAT.to_owned(),
        version: VERSION,
        name: Some(pattern.name.clone()),
        unit: None,
        panels: pattern.panels.iter().map(panel_to_file).collect(),
        seams: pattern.seams.iter().map(seam).collect(),
    }
}

fn point(p: Vector2) -> Point {
    [p.x, p.y]
}

fn panel_to_file(panel: &Panel) -> FilePanel {
    let Markings { notches, grainline, lines, drill_holes } = &panel.markings;
    let placement = |p: &Placement| {
        let rows = |m: &Matrix3<f64>| [0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], m[(i, 2)]]);
        let rotation = Some(rows(p.rotation.matrix()));
        FilePlacement {
            translation: p.translation.into(),
            rotation,
            angles_deg: None,
            bend: p.bend.as_ref().map(file_bend),
            raised: p.raised,
        }
    };
    let notch = |n: &Notch| FileNotch { segment: n.segment, fraction: n.fraction, kind: n.kind.into() };
    let next = |k: usize| panel.segments[(k + 1) % panel.segments.len()].curve.start;
    FilePanel {
        name: panel.name.clone(),
        part: panel.part.map(Into::into),
        fabric: panel.fabric.clone(),
        grainline: grainline.map(|ends| ends.map(point)),
        drill_holes: drill_holes.iter().copied().map(point).collect(),
        internal_lines: lines.iter().map(|line| line.iter().copied().map(point).collect()).collect(),
        placement: panel.placement.as_ref().map(placement),
        outline: panel.segments.iter().enumerate().map(|(k, s)| segment_to_file(s, next(k))).collect(),
        notches: notches.iter().map(notch).collect(),
    }
}

fn segment_to_file(segment: &Segment, next: Vector2) -> FileSegment {
    let Curve { start, end, shape } = &segment.curve;
    let mut file = FileSegment {
        from: point(*start),
        to: (*end != next).then(|| point(*end)),
        label: segment.label.map(Into::into),
        quadratic: None,
        cubic: None,
        path: None,
        arc: None,
    };
    match shape {
        Shape::Line => {}
        Shape::Quadratic(c) => file.quadratic = Some(point(*c)),
        Shape::Cubic(c, d) => file.cubic = Some([point(*c), point(*d)]),
        Shape::Arc(arc) => {
            file.arc = Some(FileArc { center: point(arc.center), radius: arc.radius, sweep: arc.sweep });
        }
        Shape::Path(path) => {
            let points = path.points();
            file.path = Some(points[1..points.len() - 1].iter().copied().map(point).collect());
        }
    }
    file
}

fn pattern_of(file: File, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    if file.format != FORMAT {
        return Err(Error::new(
            format!("The format is \"{}\".", file.format),
            format!("A pattern of toile has `format = \"{FORMAT}\"`."),
        ));
    }
    if file.version != VERSION {
        return Err(Error::new(
            format!("The pattern has version {}; this toile reads version {VERSION}.", file.version),
            "Use a newer toile, or write the pattern again.",
        ));
    }
    check_counts(&file)?;
    let unit = file.unit.unwrap_or(Unit::Metre);
    let panels = file
        .panels
        .iter()
        .map(|p| panel_from_file(p, unit).map_err(|e| e.within(format!("panel \"{}\"", p.name))))
        .collect::<Result<Vec<_>, _>>()?;
    let mut index_of: HashMap<&str, usize> = HashMap::new();
    for (k, panel) in panels.iter().enumerate() {
        index_of.entry(&panel.name).or_insert(k);
    }
    let mut seams = Vec::with_capacity(file.seams.len());
    for (k, seam) in file.seams.iter().enumerate() {
        let sides = [&seam.sides[0], &seam.sides[1]];
        let [a, b] = sides.map(|side| side_of(side, &index_of, &panels).map_err(|e| e.within(seam_place(seam, k))));
        seams.push(Seam { sides: [a?, b?], sense: seam.sense.into() });
    }
    let pattern = Pattern { name: file.name.unwrap_or_else(|| name.to_owned()), panels, seams };
    pattern.check()?;
    let warnings = file.seams.iter().zip(&pattern.seams).enumerate().filter_map(|(k, (declared, seam))| {
        let [a, b] = pattern.seam_lengths(seam);
        let (ease, drawn) = (declared.ease?, b / a - 1.0);
        ((ease - drawn).abs() > EASE_TOLERANCE).then(|| {
            let error = Error::new(
                format!(
                    "Its ease is to be {:.1} %, but the sides are drawn with {:.1} %.",
                    100.0 * ease,
                    100.0 * drawn
                ),
                "Correct the outline or the figure; the sides are sewn as they are drawn.",
            );
            Warning(error.coded(crate::Code::EaseNotAsStated).within(seam_place(declared, k)))
        })
    });
    let warnings = warnings.collect();
    Ok((pattern, warnings))
}

/// Per seam: does it state its ease? Empty for what cannot be read.
pub fn stated_ease_json(text: &str) -> Vec<bool> {
    serde_json::from_str(text.trim_start_matches('\u{feff}')).map_or_else(|_| Vec::new(), |file| stated_ease(&file))
}

pub fn stated_ease_toml(text: &str) -> Vec<bool> {
    toml::from_str(text.trim_start_matches('\u{feff}')).map_or_else(|_| Vec::new(), |file| stated_ease(&file))
}

fn stated_ease(file: &File) -> Vec<bool> {
    file.seams.iter().map(|seam| seam.ease.is_some()).collect()
}

fn seam_place(seam: &FileSeam, index: usize) -> String {
    seam.name.as_ref().map_or_else(|| format!("seam {index}"), |name| format!("seam \"{name}\""))
}

fn check_counts(file: &File) -> Result<(), Error> {
    let edges: usize = file.panels.iter().map(|p| p.outline.len()).sum();
    let most = file.panels.iter().map(|p| p.outline.len()).max().unwrap_or(0);
    let points: usize = file.panels.iter().flat_map(|p| &p.outline).filter_map(|s| s.path.as_ref()).map(Vec::len).sum();
    let limits = [
        (edges, MOST_EDGES, "edges"),
        (most, MOST_EDGES_PER_PANEL, "edges in one panel"),
        (points, MOST_PATH_POINTS, "points in its paths"),
    ];
    match limits.iter().find(|(count, most, _)| count > most) {
        None => Ok(()),
        Some((count, most, what)) => Err(Error::new(
            format!("The pattern has {count} {what}."),
            format!("More than {most} are taken as damage; export it again, with curves instead of many points."),
        )),
    }
}

fn side_of(side: &FileSide, index_of: &HashMap<&str, usize>, panels: &[Panel]) -> Result<SegmentId, Error> {
    let Some(&panel) = index_of.get(side.panel.as_str()) else {
        return Err(Error::new(
            format!("It names panel \"{}\", which does not exist.", side.panel),
            "Check the spelling of the panel's name.",
        )
        .coded(crate::Code::SeamUnknownEdge));
    };
    let count = panels[panel].segments.len();
    if side.segment >= count {
        return Err(Error::new(
            format!("It names segment {} of panel \"{}\", which does not exist.", side.segment, side.panel),
            format!("The panel has {count} segments, counted from 0."),
        )
        .coded(crate::Code::SeamUnknownEdge));
    }
    Ok(SegmentId { panel, segment: side.segment })
}

fn panel_from_file(file: &FilePanel, unit: Unit) -> Result<Panel, Error> {
    let at = |[x, y]: Point| Vector2::new(unit.to_metres(x), unit.to_metres(y));
    let count = file.outline.len();
    let mut segments = Vec::with_capacity(count);
    for (k, segment) in file.outline.iter().enumerate() {
        let next = file.outline[(k + 1) % count].from;
        let curve = curve_from_file(segment, next, unit).map_err(|e| e.within(format!("edge {k}")))?;
        segments.push(Segment { curve, label: segment.label.map(Into::into) });
    }
    let mut notches = Vec::with_capacity(file.notches.len());
    for (k, notch) in file.notches.iter().enumerate() {
        if notch.segment >= count || !(0.0..=1.0).contains(&notch.fraction) {
            return Err(Error::new(
                format!("It lies at {} of segment {}.", notch.fraction, notch.segment),
                format!("Give a segment from 0 to {} and a fraction from 0 to 1.", count.saturating_sub(1)),
            )
            .within(format!("notch {k}")));
        }
        notches.push(Notch { segment: notch.segment, fraction: notch.fraction, kind: notch.kind.into() });
    }
    let markings = Markings {
        notches,
        grainline: file.grainline.map(|ends| ends.map(at)),
        lines: file.internal_lines.iter().map(|line| line.iter().copied().map(at).collect()).collect(),
        drill_holes: file.drill_holes.iter().copied().map(at).collect(),
    };
    Ok(Panel {
        placement: file.placement.as_ref().map(|p| placement_from_file(p, unit)).transpose()?,
        part: file.part.map(Into::into),
        markings,
        fabric: file.fabric.clone(),
        ..Panel::new(file.name.as_str(), segments)
    })
}

fn placement_from_file(file: &FilePlacement, unit: Unit) -> Result<Placement, Error> {
    let rotation = match (&file.rotation, file.angles_deg) {
        (Some(rows), None) => {
            let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
            let apart = (matrix.transpose() * matrix - Matrix3::identity()).amax();
            if apart.is_nan() || apart > TOLERANCE || matrix.determinant() < 0.0 {
                return Err(Error::new(
                    "The matrix of its placement is not a rotation.",
                    "Give three rows of unit length at right angles, or `angles_deg` instead.",
                ));
            }
            Rotation3::from_matrix_unchecked(matrix)
        }
        (None, Some(angles)) => {
            let [a, b, c] = angles.map(f64::to_radians);
            Rotation3::from_euler_angles(a, b, c)
        }
        (None, None) => Rotation3::identity(),
        (Some(_), Some(_)) => {
            return Err(Error::new("Its placement has both `rotation` and `angles_deg`.", "Give one of the two."));
        }
    };
    let bend = file.bend.as_ref().map(|bend| bend_from_file(bend, unit)).transpose()?;
    let translation = Vector3::from(file.translation.map(|x| unit.to_metres(x)));
    Ok(Placement { rotation, translation, bend, raised: unit.to_metres(file.raised) })
}

fn bend_from_file(file: &FileBend, unit: Unit) -> Result<Bend, Error> {
    let along = Vector2::from(file.along);
    if !((along.norm() - 1.0).abs() < TOLERANCE
        && file.radius.is_finite()
        && unit.to_metres(file.radius).abs() > LEAST_RADIUS)
    {
        return Err(Error::new(
            "The bend of its placement is no cylinder.",
            "Give `along` as a direction of length one, and a `radius` of at least a millimetre.",
        ));
    }
    let origin = Vector2::from(file.origin.map(|x| unit.to_metres(x)));
    Ok(Bend { origin, along, radius: unit.to_metres(file.radius) })
}

/// No cloth is bent to less when it starts, m.
const LEAST_RADIUS: f64 = 1e-3;

fn file_bend(bend: &Bend) -> FileBend {
    FileBend { origin: bend.origin.into(), along: bend.along.into(), radius: bend.radius }
}

fn curve_from_file(file: &FileSegment, next: Point, unit: Unit) -> Result<Curve, Error> {
    let at = |[x, y]: Point| Vector2::new(unit.to_metres(x), unit.to_metres(y));
    let (start, end) = (at(file.from), at(file.to.unwrap_or(next)));
    let shape = match (file.quadratic, file.cubic, &file.arc, &file.path) {
        (None, None, None, None) => Shape::Line,
        (Some(c), None, None, None) => Shape::Quadratic(at(c)),
        (None, Some([c, d]), None, None) => Shape::Cubic(at(c), at(d)),
        (None, None, Some(arc), None) => {
            let arc = Arc { center: at(arc.center), radius: unit.to_metres(arc.radius), sweep: arc.sweep };
            check_arc(&arc, start, end)?;
            Shape::Arc(arc)
        }
        (None, None, None, Some(inner)) => {
            let points = [start].into_iter().chain(inner.iter().copied().map(at)).chain([end]).collect();
            let path = Path::new(points).ok_or_else(|| {
                Error::new(
                    format!("Its path has {} points.", inner.len()),
                    "Give two controls for each piece, and between pieces the point where they meet: 2, 5, 8, ... points.",
                )
            })?;
            Shape::Path(path)
        }
        _ => {
            return Err(Error::new(
                "It has more than one of `quadratic`, `cubic`, `path` and `arc`.",
                "Give one, or none for a straight line.",
            ));
        }
    };
    Ok(Curve { start, end, shape })
}

/// Do the ends lie on the circle, a sweep apart?
fn check_arc(arc: &Arc, start: Vector2, end: Vector2) -> Result<(), Error> {
    let (sin, cos) = arc.sweep.sin_cos();
    let r = start - arc.center;
    let reached = arc.center + Vector2::new(cos * r.x - sin * r.y, sin * r.x + cos * r.y);
    // Of a flat arc the last digits are lost.
    let tolerance = TOLERANCE + 1e-9 * arc.radius.abs();
    let fits = (r.norm() - arc.radius).abs() <= tolerance && (reached - end).norm() <= tolerance;
    if fits && arc.radius > 0.0 && arc.sweep.abs() < std::f64::consts::TAU && arc.sweep != 0.0 {
        return Ok(());
    }
    Err(Error::new(
        "Its arc does not lead from its start to its end.",
        "Check center, radius and sweep, radians, counter-clockwise positive.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The example of docs/formats.md: a bag of two halves, in centimetres.
    const BAG: &str = r#"
format = "toile pattern"
version = 1
name = "bag"
unit = "cm"

[[panels]]
name = "front"
part = "body"
grainline = [[15, 5], [15, 35]]
placement = { translation = [-15, 100, 25], angles_deg = [0, 0, 0] }
outline = [
  { from = [0, 0], label = "collar" },
  { from = [30, 0], arc = { center = [30, 20], radius = 20, sweep = 3.141592653589793 } },
  { from = [30, 40], path = [[25, 42], [20, 42], [15, 42], [10, 42], [5, 42]] },
  { from = [0, 40], quadratic = [-4, 20] },
]
notches = [{ segment = 1, fraction = 0.5 }, { segment = 3, fraction = 0.25, kind = "double" }]

[[panels]]
name = "back"
outline = [{ from = [0, 0] }, { from = [0, 40] }, { from = [30, 40] }, { from = [30, 0] }]
internal_lines = [[[0, 30], [30, 30]]]
drill_holes = [[15, 20]]

[[seams]]
name = "bottom"
ease = 0.0
sides = [{ panel = "front", segment = 0 }, { panel = "back", segment = 3 }]
"#;

    fn bag() -> Pattern {
        let (pattern, warnings) = parse_toml(BAG, "x").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(warnings, []);
        pattern
    }

    #[test]
    fn a_pattern_made_by_hand_is_read() {
        let bag = bag();
        let front = &bag.panels[0];
        assert_eq!((bag.name.as_str(), bag.panels.len(), bag.seams.len()), ("bag", 2, 1));
        assert!((front.segments[1].curve.length() - 0.2 * std::f64::consts::PI).abs() < 1e-9);
        assert!(matches!(front.segments[2].curve.shape, Shape::Path(_)));
        assert_eq!(front.placement.unwrap().translation, Vector3::new(-0.15, 1.0, 0.25));
        assert_eq!(front.markings.notches[1].kind, NotchKind::Double);
        assert_eq!(bag.seams[0].sides[1], SegmentId { panel: 1, segment: 3 });
    }

    #[test]
    fn all_of_it_is_written_and_read_back() {
        let bag = bag();
        assert_eq!(parse_toml(&write_toml(&bag), "x").unwrap().0, bag);
        assert_eq!(parse_json(&write_json(&bag), "x").unwrap().0, bag);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let wrong = |from: &str, to: &str| {
            assert!(BAG.contains(from), "{from}");
            parse_toml(&BAG.replacen(from, to, 1), "x").unwrap_err()
        };
        let cases = [
            ("\"cm\"", "\"ft\"", "ft"),
            ("version = 1", "version = 7", "version 7"),
            ("toile pattern", "soup", "format"),
            ("fraction = 0.5", "fraction = 1.5", "1.5"),
            ("segment = 1,", "segment = 9,", "segment 9"),
            ("radius = 20", "radius = 21", "arc"),
            ("[25, 42], ", "", "path has 4"),
            ("quadratic = [-4, 20]", "quadratic = [-4, 20], cubic = [[0, 0], [0, 0]]", "more than one"),
            ("panel = \"back\"", "panel = \"bakc\"", "bakc"),
            ("segment = 3 }]", "segment = 4 }]", "segment 4"),
            ("drill_holes", "dril_holes", "dril_holes"),
            ("angles_deg = [0, 0, 0]", "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 2]]", "not a rotation"),
        ];
        for (from, to, word) in cases {
            let error = wrong(from, to);
            assert!(error.to_string().contains(word) && error.remedy().len() > 10, "{error}: no {word}");
        }
        assert!(wrong("dril", "xdril").place().starts_with("line "));
    }

    #[test]
    fn an_ease_that_is_not_drawn_is_told() {
        let (_, warnings) = parse_toml(&BAG.replace("ease = 0.0", "ease = 0.05"), "x").unwrap();
        assert!(warnings[0].to_string().contains("seam \"bottom\""), "{}", warnings[0]);
    }

    fn schema() -> String {
        serde_json::to_string_pretty(&schemars::schema_for!(File)).unwrap() + "\n"
    }

    fn schema_file() -> std::path::PathBuf {
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/schema/pattern.schema.json")
    }

    #[test]
    fn the_schema_in_the_docs_is_that_of_the_reader() {
        let written = std::fs::read_to_string(schema_file()).unwrap_or_default();
        assert!(written == schema(), "run `cargo test --lib write_the_schema -- --ignored`");
    }

    #[test]
    #[ignore = "writes docs/schema/pattern.schema.json"]
    fn write_the_schema() {
        std::fs::write(schema_file(), schema()).unwrap();
    }

    proptest! {
        #[test]
        fn any_numbers_come_back_to_the_last_bit(
            numbers in [0.9..1.1f64, -0.1..0.1, -0.1..0.1, 0.9..1.1, -0.1..0.1, 0.0..1.0, -1e3..1e3, -10.0..10.0],
        ) {
            let [a, b, c, d, e, fraction, far, angle] = numbers;
            let corners = [[0.0, 0.0], [a, b], [d, 1.0 + c], [e, a]].map(|[x, y]| Vector2::new(x, y));
            let mut segments: Vec<Segment> = (0..4)
                .map(|k| Segment { curve: Curve::line(corners[k], corners[(k + 1) % 4]), label: None })
                .collect();
            let bowed = corners[0].lerp(&corners[1], fraction) - Vector2::new(0.0, 0.01);
            segments[0].curve = crate::pattern::through(&[corners[0], bowed, corners[1]], [None, None]);
            let mut panel = Panel::new("panel", segments);
            panel.placement = Some(Placement {
                rotation: Rotation3::from_euler_angles(angle, e, c),
                translation: Vector3::new(far / 100.0, b, c),
                bend: (fraction > 0.5).then(|| Bend { origin: corners[0], along: Vector2::new(0.6, 0.8), radius: a }),
                raised: if fraction > 0.8 { fraction } else { 0.0 },
            });
            panel.markings.notches.push(Notch { segment: 2, fraction, kind: NotchKind::Double });
            let pattern = Pattern { name: "p".into(), panels: vec![panel], seams: vec![] };
            prop_assume!(pattern.check().is_ok());
            prop_assert_eq!(&parse_toml(&write_toml(&pattern), "x").unwrap().0, &pattern);
            prop_assert_eq!(&parse_json(&write_json(&pattern), "x").unwrap().0, &pattern);
        }
    }
}
