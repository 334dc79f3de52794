//! Small GarmentCode patterns, drawn here.

use serde_json::{Value, json};
use toile::garment::{Garment, Level};
use toile::io::garmentcode;
use toile::pattern::Pattern;

pub fn pattern_of(document: &Value) -> Pattern {
    garmentcode::parse(&document.to_string(), "drawn for a test").unwrap().0
}

/// A rectangle of `width` by `height`, m, as one level.
pub fn sheet(width: f64, height: f64, resolution: f64) -> Level {
    let mut document = towel();
    let (w, h) = (100.0 * width, 100.0 * height);
    document["pattern"]["panels"]["towel"]["vertices"] = json!([[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]]);
    Garment::build(&pattern_of(&document), &[resolution]).unwrap().levels.remove(0)
}

/// Two squares of `side`, m, that are not sewn, as one level.
pub fn two_sheets(side: f64, resolution: f64) -> Level {
    let mut document = towel();
    let s = 100.0 * side;
    let panels = &mut document["pattern"]["panels"];
    panels["towel"]["vertices"] = json!([[0.0, 0.0], [s, 0.0], [s, s], [0.0, s]]);
    panels["second"] = panels["towel"].clone();
    // Turned, so that the meshes of the two do not lie vertex on vertex.
    panels["second"]["vertices"] = json!([[0.1 * s, 0.05 * s], [1.04 * s, 0.0], [s, 0.93 * s], [0.0, s]]);
    Garment::build(&pattern_of(&document), &[resolution]).unwrap().levels.remove(0)
}

/// A flared skirt of `width` by `height`, cm: a front with a gathered waist sewn to a belt, a back
/// with a dart. It has every kind of curve, a dart, a gather and a `right_wrong` seam.
pub fn skirt(width: f64, height: f64) -> Value {
    let (w, h) = (width, height);
    let placed = |z: f64| json!([-w / 2.0, 100.0 - h, z]);
    json!({
        "pattern": {
            "panels": {
                "front": {
                    "vertices": [[0.0, 0.0], [w, 0.0], [0.9 * w, h], [0.1 * w, h]],
                    "edges": [
                        {"endpoints": [0, 1], "curvature": {"type": "circle", "params": [1.5 * w, 0, 1]}},
                        {"endpoints": [1, 2], "curvature": {"type": "quadratic", "params": [[0.6, -0.03]]}},
                        {"endpoints": [2, 3], "label": "lower_interface"},
                        {"endpoints": [3, 0], "curvature": {"type": "cubic", "params": [[0.3, -0.02], [0.6, -0.02]]}},
                    ],
                    "translation": placed(25.0), "rotation": [0.0, 0.0, 0.0], "label": "leg",
                },
                "back": {
                    "vertices": [[0.0, 0.0], [0.0, h], [0.45 * w, h], [0.5 * w, 0.6 * h], [0.55 * w, h], [w, h], [w, 0.0]],
                    "edges": [
                        {"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 4]},
                        {"endpoints": [4, 5]}, {"endpoints": [5, 6]}, {"endpoints": [6, 0], "curvature": [0.5, 0.05]},
                    ],
                    "translation": placed(-20.0), "rotation": [0.0, 5.0, 0.0],
                },
                "belt": {
                    "vertices": [[0.0, 0.0], [0.6 * w, 0.0], [0.6 * w, 8.0], [0.0, 8.0]],
                    "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}],
                    "translation": [-0.3 * w, 104.0, 25.0], "rotation": [-4.0, 0.0, 0.0], "label": "body",
                },
            },
            "stitches": [
                [{"panel": "front", "edge": 1}, {"panel": "back", "edge": 5}],
                [{"panel": "front", "edge": 3}, {"panel": "back", "edge": 0}],
                [{"panel": "back", "edge": 2}, {"panel": "back", "edge": 3}],
                [{"panel": "belt", "edge": 0}, {"panel": "front", "edge": 2}],
                [{"panel": "belt", "edge": 1}, {"panel": "back", "edge": 4}, "right_wrong"],
            ],
            "panel_order": ["front", "back", "belt"],
        },
        "properties": {"units_in_meter": 100, "curvature_coords": "relative", "normalized_edge_loops": true},
        "parameters": {},
    })
}

/// One straight rectangle of 60 by 40 cm, without seams.
pub fn towel() -> Value {
    json!({
        "pattern": {
            "panels": {"towel": {
                "vertices": [[0.0, 0.0], [60.0, 0.0], [60.0, 40.0], [0.0, 40.0]],
                "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}],
                "translation": [-30.0, 90.0, 25.0], "rotation": [0.0, 0.0, 0.0],
            }},
            "stitches": [],
        },
        "properties": {"units_in_meter": 100},
    })
}
