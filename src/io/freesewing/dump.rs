//! The JSON dump of a FreeSewing draft: parts with paths of lines and cubics, snippets, and how they are cut.

use super::{DUMP_FORMAT, Part, PartPath, Pen, copies, pattern_of, too_many};
use crate::geometry::Vector2;
use crate::io::draft::Copies;
use crate::pattern::{Curve, NotchKind, Pattern, Shape};
use crate::{Error, Warning};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

#[derive(Deserialize)]
struct Dump {
    format: String,
    design: Option<String>,
    units: Option<String>,
    y_axis: Option<String>,
    parts: Vec<DumpPart>,
}

#[derive(Deserialize)]
struct DumpPart {
    name: String,
    #[serde(default)]
    cut: Option<Cut>,
    #[serde(default)]
    paths: Vec<DumpPath>,
    #[serde(default)]
    snippets: Vec<Snippet>,
}

#[derive(Deserialize)]
struct Cut {
    #[serde(default)]
    materials: BTreeMap<String, Vec<CutEntry>>,
    /// Two points, or what JavaScript calls false.
    #[serde(default, rename = "cutOnFold")]
    fold: Value,
    /// Degrees, counter-clockwise as seen.
    #[serde(default)]
    grain: Value,
}

#[derive(Deserialize)]
struct CutEntry {
    #[serde(default)]
    cut: Value,
    #[serde(default)]
    identical: Value,
}

#[derive(Deserialize)]
struct DumpPath {
    #[serde(default)]
    name: String,
    #[serde(default)]
    class: Option<String>,
    #[serde(default)]
    ops: Vec<Op>,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Op {
    Move {
        to: [f64; 2],
    },
    Line {
        to: [f64; 2],
    },
    Curve {
        cp1: [f64; 2],
        cp2: [f64; 2],
        to: [f64; 2],
    },
    Close,
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
struct Snippet {
    def: String,
    at: [f64; 2],
}

/// Reads a dump; `name` is what the garment is called if the file does not say.
pub fn parse(text: &str, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    let dump: Dump = serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|e| {
        Error::new(
            format!("The draft cannot be read: {e}."),
            "The file is damaged or not a dump of a FreeSewing draft; see docs/formats.md for the form.",
        )
    })?;
    if !dump.format.starts_with(DUMP_FORMAT) {
        return Err(Error::new(
            format!("The format is \"{}\".", dump.format.escape_debug()),
            format!("Known is \"{DUMP_FORMAT}1\"."),
        ));
    }
    for (what, said, known) in [("unit", &dump.units, "mm"), ("direction of y", &dump.y_axis, "down")] {
        if let Some(said) = said.as_deref().filter(|said| *said != known) {
            return Err(Error::new(
                format!("The {what} is \"{}\".", said.escape_debug()),
                format!("Drafts of FreeSewing have \"{known}\"."),
            ));
        }
    }
    let mut warnings = Vec::new();
    let mut left_aside: Vec<String> = Vec::new();
    let mut parts = Vec::with_capacity(dump.parts.len());
    for part in dump.parts {
        let place = format!("part \"{}\"", part.name.escape_debug());
        parts.push(part_of(part, &mut warnings, &mut left_aside).map_err(|e| e.within(place))?);
    }
    if !left_aside.is_empty() {
        warnings.push(Warning(Error::new(
            format!("Parts that are also cut from another material were taken once: {}.", left_aside.join(", ")),
            "Linings and interfacings are garments of their own.",
        )));
    }
    pattern_of(parts, dump.design.unwrap_or_else(|| name.to_owned()), warnings)
}

/// A point of the draft in metres, y up.
fn at([x, y]: [f64; 2]) -> Vector2 {
    Vector2::new(x / 1000.0, -y / 1000.0)
}

fn part_of(part: DumpPart, warnings: &mut Vec<Warning>, left_aside: &mut Vec<String>) -> Result<Part, Error> {
    let mut paths = Vec::with_capacity(part.paths.len());
    for path in part.paths {
        let runs = runs(&path.ops).map_err(|e| e.within(format!("path \"{}\"", path.name.escape_debug())))?;
        paths.push(PartPath { name: path.name, class: path.class.unwrap_or_default(), runs });
    }
    let mut read = Part {
        name: part.name,
        paths,
        notches: Vec::new(),
        marks: Vec::new(),
        fold: None,
        grainline: None,
        copies: Copies::One,
        fabric: None,
    };
    for snippet in &part.snippets {
        match snippet.def.as_str() {
            "notch" => read.notches.push((at(snippet.at), NotchKind::Single)),
            "bnotch" => read.notches.push((at(snippet.at), NotchKind::Double)),
            "logo" => {}
            _ => read.marks.push(at(snippet.at)),
        }
    }
    let Some(cut) = part.cut else { return Ok(read) };
    let coordinate = |point: &Value, key: &str| point.get(key).and_then(Value::as_f64);
    let point = |point: &Value| Some(at([coordinate(point, "x")?, coordinate(point, "y")?]));
    if let Some([a, b]) = cut.fold.as_array().map(Vec::as_slice)
        && let (Some(a), Some(b)) = (point(a), point(b))
        && a != b
    {
        read.fold = Some([a, b]);
    }
    read.grainline = cut.grain.as_f64().filter(|g| g.abs() < 1e6).and_then(|degrees| {
        let curves = read.paths.iter().flat_map(|p| &p.runs).flatten();
        let points = curves.map(|c| c.start);
        let bounds = points.fold(None, |b: Option<(Vector2, Vector2)>, p| {
            Some(b.map_or((p, p), |(low, high)| (low.inf(&p), high.sup(&p))))
        });
        // The dump tells the direction alone: drawn through the middle of the part.
        let (low, high) = bounds?;
        let (sin, cos) = degrees.to_radians().sin_cos();
        let half = Vector2::new(cos, sin) * (0.25 * (high - low).amin().max(0.04));
        let middle = (low + high) * 0.5;
        Some([middle - half, middle + half])
    });
    const MAIN: &str = "fabric";
    let material =
        if cut.materials.contains_key(MAIN) { Some(MAIN) } else { cut.materials.keys().next().map(String::as_str) };
    if let Some(material) = material {
        let entries = &cut.materials[material];
        let count: f64 = entries.iter().filter_map(|e| e.cut.as_f64()).sum();
        let identical = entries.first().is_some_and(|e| e.identical == Value::Bool(true));
        let (copies, more) = copies(count, identical);
        read.copies = copies;
        if more {
            warnings.push(too_many(&read.name, count));
        }
        read.fabric = (material != MAIN).then(|| material.to_owned());
        if cut.materials.len() > 1 {
            left_aside.push(read.name.clone());
        }
    }
    Ok(read)
}

fn runs(ops: &[Op]) -> Result<Vec<Vec<Curve>>, Error> {
    let mut pen = Pen::default();
    for op in ops {
        let from = pen.at;
        match op {
            Op::Move { to } => pen.move_to(at(*to)),
            Op::Line { to } => pen.draw(Curve::line(from, at(*to)))?,
            Op::Curve { cp1, cp2, to } => {
                let shape = Shape::Cubic(at(*cp1), at(*cp2));
                pen.draw(Curve { start: from, end: at(*to), shape })?;
            }
            Op::Close => pen.close()?,
            Op::Other => {}
        }
    }
    Ok(pen.runs)
}
