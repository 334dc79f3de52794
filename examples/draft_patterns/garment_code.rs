//! Writes a pattern as GarmentCode JSON: centimetres, curves relative to their chord, one line per corner and edge.

use super::outline::{Point, Segment};
use super::pattern::{Panel, Pattern, Side};
use toile::pattern::{Curve, Shape};

/// Edge labels that readers of this format know; a segment whose name ends like this carries the label. Both panels at a
/// neckline or armhole carry it, sleeves do not; at the waist the skirt carries it and the bodice does not.
const LABELS: [&str; 5] = ["left_collar", "right_collar", "left_armhole", "right_armhole", "lower_interface"];

pub fn json(pattern: &Pattern) -> String {
    let panels: Vec<String> = pattern.panels.iter().map(panel_json).collect();
    let side = |side: Side| format!(r#"{{ "panel": "{}", "edge": {} }}"#, side.panel, pattern.index_of(side));
    let stitch = |seam: &[Side; 2]| format!("      [{}, {}]", side(seam[0]), side(seam[1]));
    let stitches: Vec<String> = pattern.seams.iter().map(stitch).collect();
    let order: Vec<String> = pattern.panels.iter().map(|panel| format!(r#""{}""#, panel.name)).collect();
    format!(
        r#"{{
  "pattern": {{
    "panels": {{
{}
    }},
    "stitches": [
{}
    ],
    "panel_order": [{}]
  }},
  "parameters": {{}},
  "parameter_order": [],
  "properties": {{
    "curvature_coords": "relative",
    "normalize_panel_translation": false,
    "normalized_edge_loops": true,
    "units_in_meter": 100
  }}
}}
"#,
        panels.join(",\n"),
        stitches.join(",\n"),
        order.join(", ")
    )
}

fn panel_json(panel: &Panel) -> String {
    let segments = &panel.outline.segments;
    let corners: Vec<String> = segments.iter().map(|s| format!("          {}", pair(s.curve.start))).collect();
    let edge = |(index, segment)| edge_json(segment, index, segments.len());
    let edges: Vec<String> = segments.iter().enumerate().map(edge).collect();
    let [x, y, z] = panel.translation.map(number);
    format!(
        r#"      "{}": {{
        "label": "{}",
        "translation": [{x}, {y}, {z}],
        "rotation": [0, 0, {}],
        "vertices": [
{}
        ],
        "edges": [
{}
        ]
      }}"#,
        panel.name,
        panel.part,
        number(panel.turn),
        corners.join(",\n"),
        edges.join(",\n")
    )
}

fn edge_json(segment: &Segment, index: usize, count: usize) -> String {
    let mut fields = vec![format!(r#""endpoints": [{index}, {}]"#, (index + 1) % count)];
    let control = |point| pair(relative(point, &segment.curve));
    match segment.curve.shape.clone() {
        Shape::Line => {}
        Shape::Quadratic(c) => {
            fields.push(format!(r#""curvature": {{ "type": "quadratic", "params": [{}] }}"#, control(c)));
        }
        Shape::Cubic(c, d) => {
            let params = format!("[{}, {}]", control(c), control(d));
            fields.push(format!(r#""curvature": {{ "type": "cubic", "params": {params} }}"#));
        }
        Shape::Arc(arc) => {
            // the first flag is never set: no arc of these patterns is longer than half a turn
            let params = format!("[{}, 0, {}]", number(arc.radius), u8::from(arc.sweep > 0.0));
            fields.push(format!(r#""curvature": {{ "type": "circle", "params": {params} }}"#));
        }
        Shape::Path(_) => unreachable!("no stroke of these patterns is a path"),
    }
    if let Some(label) = LABELS.iter().find(|label| segment.name.ends_with(*label)) {
        fields.push(format!(r#""label": "{label}""#));
    }
    format!("          {{ {} }}", fields.join(", "))
}

/// Along the chord and to its left, in chord lengths.
fn relative(point: Point, curve: &Curve) -> Point {
    let chord = curve.end - curve.start;
    let v = point - curve.start;
    Point::new(v.dot(&chord), chord.x * v.y - chord.y * v.x) / chord.norm_squared()
}

fn pair(point: Point) -> String {
    format!("[{}, {}]", number(point.x), number(point.y))
}

/// Four decimals: a thousandth of a millimetre for lengths. No trailing zeros, no negative zero.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}
