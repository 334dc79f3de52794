//! GarmentCode pattern JSON (Korosteleva and Sorkine-Hornung 2023), the format of `docs/formats.md`.
//!
//! [`parse`] takes the text of a `*_specification.json` and returns the pattern in metres, with the
//! warnings that a user should see. It never panics and rejects whatever cannot be sewn.

use crate::geometry::{Vector2, Vector3};
use crate::pattern::{
    Arc, BodyPart, Curve, Panel, Pattern, Placement, Seam, Segment, SegmentId, SegmentLabel, Sense, Shape,
};
use crate::{Code, Error, Warning};
use nalgebra::Rotation3;
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use std::collections::HashMap;
use std::fmt;

/// Units to the metre where the file does not say: centimetres.
const DEFAULT_UNITS_IN_METER: f64 = 100.0;

/// More edges than any pattern or panel has; a file with more is damaged, and comparing all edges of
/// a panel with each other would take long.
const MOST_EDGES: usize = 5_000;
const MOST_EDGES_PER_PANEL: usize = 1_000;

#[derive(Deserialize)]
struct File {
    pattern: RawPattern,
    #[serde(default)]
    properties: Properties,
}

#[derive(Deserialize)]
struct RawPattern {
    panels: Named<RawPanel>,
    #[serde(default)]
    stitches: Vec<Vec<StitchItem>>,
}

#[derive(Deserialize, Default)]
struct Properties {
    units_in_meter: Option<f64>,
    curvature_coords: Option<String>,
}

#[derive(Deserialize)]
struct RawPanel {
    vertices: Vec<[f64; 2]>,
    edges: Vec<RawEdge>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 3]>,
    label: Option<String>,
}

#[derive(Deserialize)]
struct RawEdge {
    endpoints: [i64; 2],
    curvature: Option<Curvature>,
    label: Option<String>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Curvature {
    Tagged {
        #[serde(rename = "type")]
        kind: String,
        params: Vec<Param>,
    },
    /// Old files: one relative control point of a quadratic curve.
    ControlPoint([f64; 2]),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Param {
    Point([f64; 2]),
    Number(f64),
    Flag(bool),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum StitchItem {
    Side { panel: String, edge: i64 },
    Word(String),
}

/// A JSON object in the order of the file, with its repeated keys.
struct Named<T>(Vec<(String, T)>);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
            type Value = Named<T>;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object that holds the panels by their names")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Named(entries))
            }
        }
        deserializer.deserialize_map(Entries(std::marker::PhantomData))
    }
}

/// Reads a pattern; `name` is what the garment is to be called.
pub fn parse(text: &str, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    let file: File = serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(json_error)?;
    let mut warnings = Vec::new();
    let unit = Unit::of(&file.properties, &mut warnings)?;
    let edges: usize = file.pattern.panels.0.iter().map(|(_, p)| p.edges.len()).sum();
    if edges > MOST_EDGES {
        return Err(Error::new(
            format!("The pattern has {edges} edges."),
            format!("A pattern of more than {MOST_EDGES} edges is taken as damaged; export it again."),
        ));
    }
    let mut panels = Vec::new();
    let mut faults = Vec::new();
    for (panel, raw) in &file.pattern.panels.0 {
        match read_panel(panel, raw, &unit, &mut warnings) {
            Ok(panel) => panels.push(panel),
            Err(fault) => faults.push(fault.within(format!("panel \"{panel}\""))),
        }
    }
    if let Some(fault) = Error::all(faults) {
        return Err(fault);
    }
    let seams = read_stitches(&file.pattern.stitches, &panels, &mut warnings);
    let (seams, fault) = match seams {
        Ok(seams) => (seams, None),
        Err(fault) => (Vec::new(), Some(fault)),
    };
    let pattern = Pattern { name: name.to_owned(), panels, seams };
    // What is wrong with the panels does not hide what is wrong with the stitches.
    match Error::all(pattern.check().err().into_iter().chain(fault)) {
        Some(fault) => Err(fault),
        None => Ok((pattern, warnings)),
    }
}

fn json_error(error: serde_json::Error) -> Error {
    let remedy = match error.classify() {
        serde_json::error::Category::Eof => "The file ends too early; copy or export it again.",
        serde_json::error::Category::Syntax => "The file is not JSON; NaN and Infinity are not JSON either.",
        _ => "The file is JSON, but not a GarmentCode pattern; see docs/formats.md for the form.",
    };
    Error::new(format!("The pattern cannot be read: {error}."), remedy)
}

fn warn(warnings: &mut Vec<Warning>, error: Error) {
    warnings.push(Warning(error));
}

/// How the file's numbers become metres.
struct Unit {
    metres: f64,
    relative_curves: bool,
}

impl Unit {
    fn of(properties: &Properties, warnings: &mut Vec<Warning>) -> Result<Self, Error> {
        let units_in_meter = properties.units_in_meter.unwrap_or_else(|| {
            warn(
                warnings,
                Error::new(
                    "The file does not name its unit; centimetres are assumed.",
                    "Add \"units_in_meter\": 100 to its properties.",
                )
                .coded(Code::UnitDoubtful),
            );
            DEFAULT_UNITS_IN_METER
        });
        if units_in_meter <= 0.0 || units_in_meter.is_nan() {
            return Err(Error::new(
                format!("`units_in_meter` is {units_in_meter}."),
                "Give how many pattern units make a metre: 100 for centimetres.",
            ));
        }
        let relative_curves = match properties.curvature_coords.as_deref() {
            None | Some("relative") => true,
            Some("absolute") => false,
            Some(other) => {
                return Err(Error::new(
                    format!("`curvature_coords` is \"{other}\"."),
                    "It is \"relative\" or \"absolute\".",
                ));
            }
        };
        Ok(Self { metres: 1.0 / units_in_meter, relative_curves })
    }
}

fn read_panel(name: &str, raw: &RawPanel, unit: &Unit, warnings: &mut Vec<Warning>) -> Result<Panel, Error> {
    if raw.edges.len() > MOST_EDGES_PER_PANEL {
        return Err(Error::new(
            format!("The panel has {} edges.", raw.edges.len()),
            format!("A panel of more than {MOST_EDGES_PER_PANEL} edges is taken as damaged; draw it with curves."),
        ));
    }
    let corners: Vec<Vector2> = raw.vertices.iter().map(|&v| Vector2::from(v) * unit.metres).collect();
    let mut segments = Vec::with_capacity(raw.edges.len());
    for (k, edge) in raw.edges.iter().enumerate() {
        segments.push(read_edge(edge, &corners, unit).map_err(|e| e.within(format!("edge {k}")))?);
    }
    close_loop(&raw.edges)?;
    let part = match raw.label.as_deref() {
        None | Some("") => None,
        Some("body") => Some(BodyPart::Body),
        Some("arm") => Some(BodyPart::Arm),
        Some("leg") => Some(BodyPart::Leg),
        Some(other) => {
            warn(
                warnings,
                Error::new(
                    format!("The label \"{other}\" is not known and is left aside."),
                    "Known are body, arm and leg.",
                )
                .within(format!("panel \"{name}\"")),
            );
            None
        }
    };
    // A panel with neither lies in the plane as it was drawn.
    let is_placed = raw.translation.is_some() || raw.rotation.is_some();
    let [a, b, c] = raw.rotation.unwrap_or_default().map(f64::to_radians);
    // About x first, then y, then z, all fixed: the order of the tool's own mesher, not that of the
    // angles it writes (docs/formats.md).
    let rotation = Rotation3::from_euler_angles(a, b, c);
    let translation = Vector3::from(raw.translation.unwrap_or_default()) * unit.metres;
    let placement = is_placed.then(|| Placement::flat(rotation, translation));
    Ok(Panel { part, placement, ..Panel::new(name, segments) })
}

/// The edges must form one loop: each starts at the vertex where the one before ended.
fn close_loop(edges: &[RawEdge]) -> Result<(), Error> {
    for (k, edge) in edges.iter().enumerate() {
        let next = &edges[(k + 1) % edges.len()];
        if edge.endpoints[1] != next.endpoints[0] {
            return Err(Error::new(
                format!(
                    "The outline is open: edge {k} ends at vertex {}, but edge {} starts at vertex {}.",
                    edge.endpoints[1],
                    (k + 1) % edges.len(),
                    next.endpoints[0]
                ),
                "List the edges in the order of the loop, each from its start to its end.",
            )
            .coded(Code::OutlineOpen));
        }
    }
    Ok(())
}

fn read_edge(edge: &RawEdge, corners: &[Vector2], unit: &Unit) -> Result<Segment, Error> {
    let corner = |index: i64| {
        usize::try_from(index).ok().and_then(|i| corners.get(i)).copied().ok_or_else(|| {
            Error::new(
                format!("It names vertex {index}, which does not exist."),
                format!("The panel has {} vertices, counted from 0.", corners.len()),
            )
        })
    };
    let (start, end) = (corner(edge.endpoints[0])?, corner(edge.endpoints[1])?);
    let shape = match &edge.curvature {
        None => Shape::Line,
        Some(curvature) => read_curvature(curvature, start, end, unit)?,
    };
    let label = edge.label.as_deref().and_then(segment_label);
    Ok(Segment { curve: Curve { start, end, shape }, label })
}

fn segment_label(label: &str) -> Option<SegmentLabel> {
    match label {
        "lower_interface" => Some(SegmentLabel::LowerInterface),
        "strapless_top" => Some(SegmentLabel::StraplessTop),
        _ if label.ends_with("collar") => Some(SegmentLabel::Collar),
        _ if label.ends_with("armhole") => Some(SegmentLabel::Armhole),
        _ => None,
    }
}

fn read_curvature(curvature: &Curvature, start: Vector2, end: Vector2, unit: &Unit) -> Result<Shape, Error> {
    let control = |[p, q]: [f64; 2]| {
        if unit.relative_curves {
            let chord = end - start;
            start + chord * p + Vector2::new(-chord.y, chord.x) * q
        } else {
            Vector2::new(p, q) * unit.metres
        }
    };
    match curvature {
        Curvature::ControlPoint(point) => Ok(Shape::Quadratic(control(*point))),
        Curvature::Tagged { kind, params } => match (kind.as_str(), params.as_slice()) {
            ("quadratic", [Param::Point(c)]) => Ok(Shape::Quadratic(control(*c))),
            ("cubic", [Param::Point(c), Param::Point(d)]) => Ok(Shape::Cubic(control(*c), control(*d))),
            ("circle", [Param::Number(radius), large, right]) => read_arc(*radius, large, right, start, end, unit),
            ("quadratic" | "cubic" | "circle", _) => Err(Error::new(
                format!("The parameters of its {kind} curve have the wrong form."),
                "quadratic takes [[x, y]], cubic [[x, y], [x, y]], circle [radius, large_arc, right].",
            )),
            _ => Err(Error::new(
                format!("The curve type \"{kind}\" is not known."),
                "Known are quadratic, cubic and circle.",
            )),
        },
    }
}

fn read_arc(
    radius: f64,
    large: &Param,
    right: &Param,
    start: Vector2,
    end: Vector2,
    unit: &Unit,
) -> Result<Shape, Error> {
    let flag = |param: &Param| match param {
        Param::Flag(flag) => Ok(*flag),
        Param::Number(number) => Ok(*number != 0.0),
        Param::Point(_) => Err(Error::new("A flag of its circle is not a number.", "Give 0 or 1.")),
    };
    if radius <= 0.0 || radius.is_nan() {
        return Err(Error::new(
            format!("The radius of its circle is {radius}."),
            "Give a positive radius in pattern units.",
        ));
    }
    if start == end {
        return Err(Error::new("Its circle starts where it ends.", "Split the circle into two edges."));
    }
    // A radius beyond any garment is a straight line in all but name; the arc formulas would lose digits.
    const STRAIGHT_RADIUS: f64 = 1e4;
    let radius = radius * unit.metres;
    if radius > STRAIGHT_RADIUS {
        return Ok(Shape::Line);
    }
    Ok(Shape::Arc(Arc::between(start, end, radius, flag(large)?, flag(right)?)))
}

fn read_stitches(
    stitches: &[Vec<StitchItem>],
    panels: &[Panel],
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Seam>, Error> {
    let index_of: HashMap<&str, usize> = panels.iter().enumerate().map(|(i, p)| (p.name.as_str(), i)).collect();
    let side = |item: &StitchItem| match item {
        StitchItem::Side { panel, edge } => {
            let index = *index_of.get(panel.as_str()).ok_or_else(|| {
                Error::new(
                    format!("It names panel \"{panel}\", which does not exist."),
                    "Check the spelling of the panel's name.",
                )
                .coded(Code::SeamUnknownEdge)
            })?;
            let count = panels[index].segments.len();
            let segment = usize::try_from(*edge).ok().filter(|&k| k < count).ok_or_else(|| {
                Error::new(
                    format!("It names edge {edge} of panel \"{panel}\", which does not exist."),
                    format!("The panel has {count} edges, counted from 0."),
                )
                .coded(Code::SeamUnknownEdge)
            })?;
            Ok(SegmentId { panel: index, segment })
        }
        StitchItem::Word(word) => Err(Error::new(
            format!("It has the word \"{word}\" where an edge should be."),
            "A stitch is [{\"panel\": ..., \"edge\": ...}, {\"panel\": ..., \"edge\": ...}].",
        )
        .coded(Code::SeamUnusable)),
    };
    let mut seams = Vec::with_capacity(stitches.len());
    let mut faults = Vec::new();
    for (index, stitch) in stitches.iter().enumerate() {
        let at = |e: Error| e.within(format!("stitch {index}"));
        let [a, b, words @ ..] = stitch.as_slice() else {
            let error = Error::new(format!("It has {} sides.", stitch.len()), "A stitch joins two edges.");
            faults.push(at(error.coded(Code::SeamWithoutPartner)));
            continue;
        };
        let mut sense = Sense::Opposed;
        for word in words {
            match word {
                StitchItem::Word(w) if w == "right_wrong" => sense = Sense::Aligned,
                StitchItem::Word(w) => warn(
                    warnings,
                    at(Error::new(
                        format!("The word \"{w}\" is not known and is left aside."),
                        "Known is right_wrong.",
                    )),
                ),
                StitchItem::Side { .. } => {
                    let error =
                        Error::new("It has more than two sides.", "A stitch joins two edges; split the edges instead.");
                    faults.push(at(error.coded(Code::SeamWithoutPartner)));
                }
            }
        }
        match (side(a), side(b)) {
            (Ok(a), Ok(b)) => seams.push(Seam { sides: [a, b], sense }),
            (a, b) => faults.extend([a.err(), b.err()].into_iter().flatten().map(at)),
        }
    }
    Error::all(faults).map_or(Ok(seams), Err)
}
