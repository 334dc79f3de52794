use super::*;
use crate::geometry::{Vector2, Vector3};
use crate::pattern::{Bend, Curve, Notch, NotchKind, Panel, Placement, Segment, SegmentId, Shape};
use nalgebra::Rotation3;
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
