//! The reader against reference values that an independent curve library produced.

mod support;

use serde_json::Value;
use support::{shared_data, shared_patterns};
use toile::io::garmentcode;
use toile::pattern::Sense;

/// Relative deviation allowed from the reference; its figures have four decimals in centimetres.
const TOLERANCE: f64 = 1e-3;

fn close(ours: f64, reference: f64, floor: f64) -> bool {
    (ours - reference).abs() <= TOLERANCE * reference.abs().max(floor)
}

#[test]
fn patterns_have_the_reference_areas_lengths_and_places() {
    let Some(data) = shared_data() else { return };
    let text = std::fs::read_to_string(data.join("patterns/garmentcode.expected.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
    for (name, text) in shared_patterns() {
        let (pattern, _) = garmentcode::parse(&text, &name).unwrap();
        let reference = &expected[name.as_str()];
        assert_eq!(pattern.panels.len(), reference["panels"].as_object().unwrap().len());
        for panel in &pattern.panels {
            let at = format!("{name}, {}", panel.name);
            let panel_reference = &reference["panels"][panel.name.as_str()];
            let area = panel_reference["signed_area_cm2"].as_f64().unwrap();
            assert!(close(panel.signed_area() * 1e4, area, 1.0), "{at}: area {}", panel.signed_area() * 1e4);
            for (segment, length) in panel.segments.iter().zip(panel_reference["edge_lengths_cm"].as_array().unwrap()) {
                assert!(close(segment.curve.length() * 100.0, length.as_f64().unwrap(), 0.1), "{at}: length");
            }
            for axis in 0..3 {
                let normal = panel_reference["outward_normal"][axis].as_f64().unwrap();
                assert!((panel.outward_normal()[axis] - normal).abs() < 1e-3, "{at}: normal");
                let first = panel.place(panel.segments[0].curve.start)[axis] * 100.0;
                let first_reference = panel_reference["first_vertex_3d_cm"][axis].as_f64().unwrap();
                assert!((first - first_reference).abs() < 1e-2, "{at}: placement {first} {first_reference}");
            }
        }
        for (seam, reference) in pattern.seams.iter().zip(reference["stitches"].as_array().unwrap()) {
            let [a, b] = pattern.seam_lengths(seam).map(|l| l * 100.0);
            let at = format!("{name}: {}", pattern.seam_name(seam));
            assert!(close(a, reference["length_a_cm"].as_f64().unwrap(), 0.1), "{at}");
            assert!(close(b, reference["length_b_cm"].as_f64().unwrap(), 0.1), "{at}");
            assert_eq!(seam.sense == Sense::Opposed, reference["reversed"].as_bool().unwrap(), "{at}");
        }
    }
}
