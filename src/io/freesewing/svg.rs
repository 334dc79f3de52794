//! FreeSewing's own SVG: a group for each part, the meaning of a path in its class.

use super::{Part, PartPath, Pen, copies, pattern_of, too_many};
use crate::geometry::Vector2;
use crate::io::draft::Copies;
use crate::pattern::{Curve, NotchKind, Pattern, Shape};
use crate::{Error, Warning};
use kurbo::{Affine, BezPath, PathEl, Point};
use roxmltree::{Document, Node, ParsingOptions};

/// More elements than any draft has.
const MOST_NODES: u32 = 300_000;
/// More transforms on the way to one path than any editor makes.
const MOST_TRANSFORMS: usize = 32;

/// Reads an SVG of FreeSewing; `name` is what the garment is called.
pub fn parse(text: &str, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text.trim_start_matches('\u{feff}'), options)
        .map_err(|e| Error::new(format!("It is not XML: {e}."), "The file is damaged; export it again."))?;
    let mut warnings = Vec::new();
    let millimetres = scale(&document, &mut warnings)?;
    let groups: Vec<(Node, &str)> = document
        .descendants()
        .filter(|node| node.has_tag_name((SVG, "g")) || node.has_tag_name("g"))
        .filter_map(|node| Some((node, node.attribute("id")?.strip_prefix("fs-stack-")?.split_once("-part-")?.1)))
        .collect();
    if groups.is_empty() {
        return Err(Error::new(
            "The SVG has no groups `fs-stack-...-part-...`, in which FreeSewing draws its parts.",
            "Only SVG of FreeSewing is read; export patterns of other programs as DXF-AAMA.",
        ));
    }
    let mut parts = Vec::with_capacity(groups.len());
    for (group, part) in groups {
        let place = format!("part \"{}\"", part.escape_debug());
        parts.push(part_of(group, part, millimetres, &mut warnings).map_err(|e| e.within(place))?);
    }
    pattern_of(parts, name.to_owned(), warnings)
}

const SVG: &str = "http://www.w3.org/2000/svg";
const XLINK: &str = "http://www.w3.org/1999/xlink";

/// Millimetres to the unit of the drawing.
fn scale(document: &Document, warnings: &mut Vec<Warning>) -> Result<f64, Error> {
    let root = document.root_element();
    let width = root.attribute("width").and_then(|w| w.trim().strip_suffix("mm")?.trim().parse::<f64>().ok());
    let view = root
        .attribute("viewBox")
        .and_then(|view| view.split([' ', ',']).filter(|word| !word.is_empty()).nth(2)?.parse::<f64>().ok());
    match (width, view) {
        (Some(width), Some(view)) if view > 0.0 && width > 0.0 => {
            let scale = width / view;
            if (1e-3..=1e3).contains(&scale) {
                return Ok(scale);
            }
            Err(Error::new(format!("A unit of the drawing is {scale} mm."), "Check `width` and `viewBox` of the SVG."))
        }
        _ => {
            warnings.push(Warning(
                Error::new(
                    "The SVG does not give its width in mm; a unit of the drawing is taken for a millimetre.",
                    "Export it from FreeSewing without changing its size.",
                )
                .coded(crate::Code::UnitDoubtful),
            ));
            Ok(1.0)
        }
    }
}

fn part_of(group: Node, name: &str, millimetres: f64, warnings: &mut Vec<Warning>) -> Result<Part, Error> {
    let mut part = Part {
        name: name.to_owned(),
        paths: Vec::new(),
        notches: Vec::new(),
        marks: Vec::new(),
        fold: None,
        grainline: None,
        copies: Copies::One,
        fabric: None,
    };
    let mut words = String::new();
    for node in group.descendants().filter(Node::is_element) {
        // Groups lay the parts out on paper; what is moved within a part is meant.
        let transform = transform_within(group, node);
        let at = |p: Point| {
            let p = transform * p;
            Vector2::new(p.x * millimetres / 1000.0, -p.y * millimetres / 1000.0)
        };
        match node.tag_name().name() {
            "path" => {
                let Some(data) = node.attribute("d") else { continue };
                let path = BezPath::from_svg(data).map_err(|e| {
                    let within = node.attribute("id").unwrap_or("without id");
                    Error::new(format!("A path cannot be read: {e}."), "The file is damaged; export it again.")
                        .within(format!("path {}", within.escape_debug()))
                })?;
                let runs = runs(&path, at)?;
                mark_lines(&node, &runs, &mut part);
                let class = node.attribute("class").unwrap_or_default().to_owned();
                part.paths.push(PartPath { name: String::new(), class, runs });
            }
            "use" => {
                let reference = node.attribute((XLINK, "href")).or_else(|| node.attribute("href")).unwrap_or_default();
                let number = |key: &str| node.attribute(key).and_then(|n| n.trim().parse::<f64>().ok());
                let (Some(x), Some(y)) = (number("x"), number("y")) else { continue };
                let place = at(Point::new(x, y));
                if !place.iter().all(|c| c.is_finite()) {
                    continue;
                }
                match reference.trim_start_matches('#') {
                    "notch" => part.notches.push((place, NotchKind::Single)),
                    "bnotch" => part.notches.push((place, NotchKind::Double)),
                    "logo" => {}
                    _ => part.marks.push(place),
                }
            }
            "text" => {
                words.extend(node.descendants().filter(Node::is_text).filter_map(|n| n.text()));
                words.push(' ');
            }
            _ => {}
        }
    }
    let (count, identical, fabric) = cut_text(&words);
    let (copies, more) = copies(count, identical);
    part.copies = copies;
    part.fabric = fabric;
    if more {
        warnings.push(too_many(name, count));
    }
    Ok(part)
}

/// Fold and grainline are paths with arrows of their own.
fn mark_lines(node: &Node, runs: &[Vec<Curve>], part: &mut Part) {
    let marker = node.attribute("marker-start").unwrap_or_default().to_ascii_lowercase();
    let ends = match (runs.iter().flatten().next(), runs.iter().flatten().last()) {
        (Some(first), Some(last)) if first.start != last.end => [first.start, last.end],
        _ => return,
    };
    if marker.contains("cutonfold") {
        part.fold = Some(ends);
        let text = node.attribute("data-text").unwrap_or_default().to_ascii_lowercase();
        if text.contains("grain") {
            part.grainline = Some(ends);
        }
    } else if marker.contains("grainline") {
        part.grainline = Some(ends);
    }
}

/// How often a part is cut, whether the copies are alike, and its material if it is not the main one: from a text such as
/// "Cut 2 mirrored from Fabric", or with the names of these words as they stand in the program.
fn cut_text(words: &str) -> (f64, bool, Option<String>) {
    let lower = words.to_lowercase().replace("plugin-annotations:", "");
    let Some(at) = lower.find("cut,").or_else(|| lower.find("cut ")) else { return (1.0, false, None) };
    let rest = &lower[at + 4..];
    let digits: String = rest.trim_start().chars().take_while(char::is_ascii_digit).take(3).collect();
    let Ok(count) = digits.parse::<f64>() else { return (1.0, false, None) };
    let mut tokens = rest.split([',', ' ']).filter(|w| !w.is_empty());
    let material = tokens.by_ref().skip_while(|w| *w != "from").nth(1);
    let fabric = material.filter(|m| ["lining", "interfacing", "canvas", "various"].contains(m));
    (count, rest.contains("identical"), fabric.map(str::to_owned))
}

fn runs(path: &BezPath, at: impl Fn(Point) -> Vector2) -> Result<Vec<Vec<Curve>>, Error> {
    let mut pen = Pen::default();
    for element in path.elements() {
        let start = pen.at;
        match *element {
            PathEl::MoveTo(p) => pen.move_to(at(p)),
            PathEl::LineTo(p) => pen.draw(Curve::line(start, at(p)))?,
            PathEl::QuadTo(c, p) => pen.draw(Curve { start, end: at(p), shape: Shape::Quadratic(at(c)) })?,
            PathEl::CurveTo(c, d, p) => pen.draw(Curve { start, end: at(p), shape: Shape::Cubic(at(c), at(d)) })?,
            PathEl::ClosePath => pen.close()?,
        }
    }
    Ok(pen.runs)
}

/// The transforms of a node and of what it lies in, up to its part. That of a `use` puts it to its place.
fn transform_within(group: Node, node: Node) -> Affine {
    let own = if node.has_tag_name((SVG, "use")) || node.has_tag_name("use") { 1 } else { 0 };
    let way = node.ancestors().take_while(|n| *n != group).skip(own).take(MOST_TRANSFORMS);
    way.filter_map(|n| n.attribute("transform")).map(affine).fold(Affine::IDENTITY, |inner, outer| outer * inner)
}

/// A list of transforms; unknown ones are left out.
fn affine(text: &str) -> Affine {
    let mut all = Affine::IDENTITY;
    for part in text.split(')').take(MOST_TRANSFORMS) {
        let Some((word, list)) = part.split_once('(') else { continue };
        let numbers: Vec<f64> =
            list.split([',', ' ']).filter_map(|n| n.trim().parse().ok()).filter(|n: &f64| n.is_finite()).collect();
        all *= match (word.trim_matches([' ', ',']), numbers.as_slice()) {
            ("translate", [x]) => Affine::translate((*x, 0.0)),
            ("translate", [x, y]) => Affine::translate((*x, *y)),
            ("scale", [s]) => Affine::scale(*s),
            ("scale", [x, y]) => Affine::scale_non_uniform(*x, *y),
            ("rotate", [degrees]) => Affine::rotate(degrees.to_radians()),
            ("rotate", [degrees, x, y]) => Affine::rotate_about(degrees.to_radians(), Point::new(*x, *y)),
            ("matrix", [a, b, c, d, e, f]) => Affine::new([*a, *b, *c, *d, *e, *f]),
            _ => Affine::IDENTITY,
        };
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_tell_how_often_to_cut() {
        let cut = |text| cut_text(text);
        assert_eq!(
            cut(
                "plugin-annotations:cut,2,plugin-annotations:mirrored,plugin-annotations:from,plugin-annotations:fabric,"
            ),
            (2.0, false, None)
        );
        assert_eq!(cut("front Cut 1 on the fold from Fabric"), (1.0, false, None));
        assert_eq!(cut("cut,4,identical,from,lining,"), (4.0, true, Some("lining".into())));
        assert_eq!(cut("haircut by night"), (1.0, false, None));
    }

    #[test]
    fn transforms_within_a_part_are_followed_and_those_of_the_layout_are_not() {
        let text = r##"<svg xmlns="http://www.w3.org/2000/svg" width="400mm" height="400mm" viewBox="0 0 200 200">
          <g id="fs-stack-x.yoke" transform="translate(500, 0)"><g id="fs-stack-x.yoke-part-x.yoke" transform="rotate(30)">
            <g transform="translate(10, 0) scale(2)"><path class="fabric" d="M 0,0 h 20 v 10 h -20 z" /></g>
            <use x="50" y="10" href="#notch" transform="translate(50, 10) scale(1) translate(-50, -10)" />
          </g></g></svg>"##;
        let (pattern, warnings) = parse(text, "x").unwrap();
        assert!(warnings.is_empty());
        let panel = &pattern.panels[0];
        assert_eq!(panel.name, "yoke");
        // 20 by 10 units, twice as large, of 2 mm.
        assert!((panel.signed_area() - 0.08 * 0.04).abs() < 1e-9, "{}", panel.signed_area());
        let notch = panel.markings.notches[0];
        let at = panel.segments[notch.segment].curve.at_fraction(notch.fraction);
        assert!((at - Vector2::new(0.1, -0.02)).norm() < 1e-9, "{at}");
    }
}
