//! A small garment for the tests of the writers.

use super::garmentcode;
use crate::garment::Garment;
use crate::geometry::Vector3;
use crate::pattern::Pattern;

/// Two panels of 20 cm × 30 cm, sewn along one side, their right sides on -z, as the text of a
/// GarmentCode pattern.
pub const TWO_PANELS: &str = r#"{
  "pattern": {
    "panels": {
      "front": {"vertices": [[0, 0], [0, 30], [20, 30], [20, 0]], "translation": [0, 100, 20], "rotation": [0, 0, 0],
        "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]},
      "back": {"vertices": [[20, 0], [20, 30], [40, 30], [40, 0]], "translation": [0, 100, 20], "rotation": [0, 0, 0],
        "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]}
    },
    "stitches": [[{"panel": "front", "edge": 2}, {"panel": "back", "edge": 0}]]
  },
  "properties": {"units_in_meter": 100, "curvature_coords": "relative"}
}"#;

/// The pattern above, its garment at 5 and 2.5 cm, and the finest particles where the panels start.
pub fn two_panels() -> (Pattern, Garment, Vec<Vector3>) {
    let (pattern, _) = garmentcode::parse(TWO_PANELS, "two panels").unwrap();
    let garment = Garment::build(&pattern, &[0.05, 0.025]).unwrap();
    let level = &garment.levels[1];
    let mut positions = vec![Vector3::zeros(); level.particle_count];
    for (panel, range) in pattern.panels.iter().zip(&level.panels) {
        for point in range.points.clone() {
            positions[level.particle_of[point] as usize] = panel.place(level.rest[point]);
        }
    }
    (pattern, garment, positions)
}
