//! Our two patterns, read from their files, against the mannequin they are drafted for.

#[allow(dead_code)]
#[path = "../examples/draft_patterns/main.rs"]
mod draft_patterns;

use toile::body::mannequin::{Measurements, Mesh, sculpt, stations, tape};
use toile::geometry::{Vector2, Vector3};
use toile::io::{embedded, garmentcode};
use toile::pattern::{BodyPart, Panel, Pattern, SegmentLabel};

/// Panels keep this distance from the mannequin, and parallel panels from each other, m.
const PANEL_CLEARANCE: f64 = 0.02;
/// Sewn segments agree in length within this part.
const SEAM_TOLERANCE: f64 = 0.005;
/// A sleeve cap is longer than its armhole by 1 to 3 %.
const CAP_EASE: std::ops::RangeInclusive<f64> = 0.01..=0.03;
/// A shorter segment is awkward to sew, m.
const SHORTEST_SEGMENT: f64 = 0.01;

/// The reader has checked that outlines are closed and simple, and that no segment is sewn twice.
fn tee() -> Pattern {
    read(embedded::TEE, "tee")
}

fn dress() -> Pattern {
    read(embedded::DRESS, "dress")
}

fn read(text: &str, name: &str) -> Pattern {
    let (pattern, warnings) = garmentcode::parse(text, name).unwrap();
    assert_eq!(warnings, []);
    pattern
}

fn mesh() -> Mesh {
    sculpt(&Measurements::default()).unwrap()
}

#[test]
fn the_files_are_what_the_generator_writes() {
    let measures = draft_patterns::Measures::taken(&Measurements::default()).unwrap();
    let [(_, tee), (_, dress)] = draft_patterns::files(&measures);
    assert!(tee == embedded::TEE, "run the example draft_patterns: data/tee.json is not what it writes");
    assert!(dress == embedded::DRESS, "run the example draft_patterns: data/dress.json is not what it writes");
}

#[test]
fn sewn_segments_have_equal_lengths_and_caps_have_their_ease() {
    for pattern in [tee(), dress()] {
        for seam in &pattern.seams {
            let [a, b] = pattern.seam_lengths(seam);
            let surplus = b / a - 1.0;
            let is_armhole = pattern.segment(seam.sides[0]).label == Some(SegmentLabel::Armhole);
            let fits = if is_armhole { CAP_EASE.contains(&surplus) } else { surplus.abs() < SEAM_TOLERANCE };
            assert!(fits, "{}, {}: {surplus:+.4}", pattern.name, pattern.seam_name(seam));
            assert!(a > SHORTEST_SEGMENT, "{}, {}: {a} m", pattern.name, pattern.seam_name(seam));
        }
    }
}

#[test]
fn right_sides_face_outward_and_areas_are_those_of_clothes() {
    for (pattern, least, most) in [(tee(), 0.55, 0.75), (dress(), 0.9, 1.3)] {
        for panel in &pattern.panels {
            let away = panel.placement.unwrap().translation.z;
            assert!(panel.outward_normal().z * away > 0.0, "{} faces the body", panel.name);
        }
        let area: f64 = pattern.panels.iter().map(|panel| panel.signed_area().abs()).sum();
        assert_between(&format!("area of the {}, m²", pattern.name), area, least, most);
    }
}

#[test]
fn necklines_armholes_and_the_waist_carry_their_labels() {
    let labelled = |pattern: &Pattern, label| {
        let count = |panel: &Panel| panel.segments.iter().filter(|s| s.label == Some(label)).count();
        pattern.panels.iter().filter(|p| count(p) > 0).map(|p| (p.name.clone(), count(p))).collect::<Vec<_>>()
    };
    let on = |front: &str, back: &str, count| vec![(front.to_owned(), count), (back.to_owned(), count)];
    for label in [SegmentLabel::Collar, SegmentLabel::Armhole] {
        assert_eq!(labelled(&tee(), label), on("front", "back", 2));
        assert_eq!(labelled(&dress(), label), on("front_bodice", "back_bodice", 2));
    }
    assert_eq!(labelled(&tee(), SegmentLabel::LowerInterface), []);
    assert_eq!(labelled(&dress(), SegmentLabel::LowerInterface), on("front_skirt", "back_skirt", 3));
}

#[test]
fn seams_join_the_ends_that_are_nearer_to_each_other() {
    for pattern in [tee(), dress()] {
        for seam in &pattern.seams {
            let [[a, b], [c, d]] = seam.sides.map(|side| {
                let (panel, curve) = (&pattern.panels[side.panel], &pattern.segment(side).curve);
                [curve.start, curve.end].map(|p| panel.place(p).xy())
            });
            // Opposed sides: start meets end.
            let (straight, twisted) = ((a - d).norm() + (b - c).norm(), (a - c).norm() + (b - d).norm());
            assert!(straight < twisted, "{}, {} is sewn the wrong way round", pattern.name, pattern.seam_name(seam));
        }
    }
}

#[test]
fn panels_keep_clear_of_the_mannequin_and_of_each_other() {
    let mesh = mesh();
    for pattern in [tee(), dress()] {
        for panel in &pattern.panels {
            let (outline, z) = (in_front_view(panel), panel.placement.unwrap().translation.z);
            // All panels hang in planes of constant z. No triangle of the mannequin is larger than the slab is thick, so
            // one that crosses the plane has a corner in the slab.
            for p in mesh.positions.iter().filter(|p| (p.z - z).abs() < PANEL_CLEARANCE) {
                let clear = !contains(&outline, p.xy()) && distance_to(&outline, p.xy()) > PANEL_CLEARANCE;
                assert!(clear, "{}, {}: touches the mannequin at {p}", pattern.name, panel.name);
            }
        }
        for (i, a) in pattern.panels.iter().enumerate() {
            for b in &pattern.panels[i + 1..] {
                let in_depth = (a.placement.unwrap().translation.z - b.placement.unwrap().translation.z).abs();
                let apart = in_depth >= PANEL_CLEARANCE || boxes_apart(a, b);
                assert!(apart, "{}: {} and {} meet", pattern.name, a.name, b.name);
            }
        }
    }
}

#[test]
fn every_panel_hangs_where_it_will_be_worn() {
    let m = Measurements::default();
    for pattern in [tee(), dress()] {
        for panel in &pattern.panels {
            let (low, high) = bounds(&in_front_view(panel));
            let (lowest, highest) = match panel.part.unwrap() {
                BodyPart::Body => (m.hip_height - 0.05, m.chin_height + 0.05),
                BodyPart::Arm => (m.waist_height, m.neck_height),
                BodyPart::Leg => (m.knee_height - 0.05, m.waist_height + 0.05),
            };
            assert!(low.y > lowest && high.y < highest, "{}: from {} to {} m", panel.name, low.y, high.y);
        }
    }
}

#[test]
fn the_tee_leaves_the_intended_ease() {
    let (tee, mesh, m) = (tee(), mesh(), Measurements::default());
    let width_at =
        |height| [panel(&tee, "front"), panel(&tee, "back")].map(|p| width_at(p, height)).iter().sum::<f64>();
    assert_between("bust ease", width_at(m.bust_height + 0.02) - girth(&mesh, "bust"), 0.08, 0.10);
    assert_between("hip ease", width_at(m.hip_height + 0.02) - girth(&mesh, "hip"), 0.04, 0.09);
    let half_width = |name| {
        let (low, high) = bounds(&panel(&tee, name).polygon(50));
        high.y - low.y
    };
    let sleeve = half_width("left_sleeve_front") + half_width("left_sleeve_back");
    assert_between("sleeve ease", sleeve - girth(&mesh, "upper arm"), 0.06, 0.10);
    let armhole = 0.5 * length_of(&tee, SegmentLabel::Armhole);
    assert_between("armhole ease", armhole - armhole_girth(&mesh), 0.05, 0.10);
    assert_between("neckline", length_of(&tee, SegmentLabel::Collar), 0.44, 0.50);
}

#[test]
fn the_dress_leaves_the_intended_ease() {
    let (dress, mesh, m) = (dress(), mesh(), Measurements::default());
    let widest = |name| {
        let widths = (0..200).map(|i| width_at(panel(&dress, name), m.waist_height + 0.001 * f64::from(i)));
        widths.fold(0.0, f64::max)
    };
    let bust = widest("front_bodice") + widest("back_bodice");
    assert_between("bust ease", bust - girth(&mesh, "bust"), 0.04, 0.065);
    let waist = length_of(&dress, SegmentLabel::LowerInterface);
    assert_between("waist ease", waist - girth(&mesh, "waist"), 0.02, 0.04);
    // The skirt is a sector of a ring: its girth grows evenly from waist to hem.
    let hem_and_side = ["front_skirt", "back_skirt"].map(|name| {
        let mut lengths: Vec<f64> = panel(&dress, name).segments.iter().map(|s| s.curve.length()).collect();
        lengths.sort_by(f64::total_cmp);
        (lengths[lengths.len() - 1], lengths[lengths.len() - 2])
    });
    let [(front_hem, side), (back_hem, _)] = hem_and_side;
    let hip = waist + (front_hem + back_hem - waist) * (m.waist_height - m.hip_height) / side;
    assert_between("hip ease", hip - girth(&mesh, "hip"), 0.08, 0.14);
    let armhole = 0.5 * length_of(&dress, SegmentLabel::Armhole);
    assert_between("armhole ease", armhole - armhole_girth(&mesh), 0.03, 0.08);
    let neck = length_of(&dress, SegmentLabel::Collar);
    assert!(neck > girth(&mesh, "head"), "the head does not pass through a neckline of {neck} m");
}

fn assert_between(what: &str, value: f64, low: f64, high: f64) {
    assert!((low..=high).contains(&value), "{what} is {value:.4}, not {low} to {high}");
}

/// m.
fn girth(mesh: &Mesh, name: &str) -> f64 {
    stations(&Measurements::default()).into_iter().find(|station| station.name == name).unwrap().measure(mesh)
}

/// Around the joint of the arm, over shoulder point and armpit, m.
fn armhole_girth(mesh: &Mesh) -> f64 {
    tape::girth(mesh, &Vector3::new(0.17, 1.36, 0.0), &Vector3::x())
}

fn panel<'a>(pattern: &'a Pattern, name: &str) -> &'a Panel {
    pattern.panels.iter().find(|panel| panel.name == name).unwrap()
}

/// Of all segments with a label, m.
fn length_of(pattern: &Pattern, label: SegmentLabel) -> f64 {
    let segments = pattern.panels.iter().flat_map(|panel| &panel.segments);
    segments.filter(|segment| segment.label == Some(label)).map(|segment| segment.curve.length()).sum()
}

/// The placed outline, seen from the front: a closed polygon, dense on every segment.
fn in_front_view(panel: &Panel) -> Vec<Vector2> {
    let points = panel.segments.iter().flat_map(|s| (0..40).map(|i| s.curve.at_fraction(f64::from(i) / 40.0)));
    points.map(|p| panel.place(p).xy()).collect()
}

/// Cloth across the panel at a height above the floor, notches left out, m.
fn width_at(panel: &Panel, height: f64) -> f64 {
    let points = in_front_view(panel);
    let next = points.iter().cycle().skip(1);
    let crossing = |(a, b): (&Vector2, &Vector2)| {
        let crosses = (a.y >= height) != (b.y >= height);
        crosses.then(|| a.x + (b.x - a.x) * (height - a.y) / (b.y - a.y))
    };
    let mut crossings: Vec<f64> = points.iter().zip(next).filter_map(crossing).collect();
    crossings.sort_by(f64::total_cmp);
    crossings.chunks(2).map(|pair| pair[1] - pair[0]).sum()
}

fn bounds(points: &[Vector2]) -> (Vector2, Vector2) {
    points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)))
}

fn contains(polygon: &[Vector2], p: Vector2) -> bool {
    let next = polygon.iter().cycle().skip(1);
    let crosses = |(a, b): &(&Vector2, &Vector2)| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)
    };
    polygon.iter().zip(next).filter(crosses).count() % 2 == 1
}

fn distance_to(polygon: &[Vector2], p: Vector2) -> f64 {
    polygon.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min)
}

/// Are the boxes of two placed panels apart in front view?
fn boxes_apart(a: &Panel, b: &Panel) -> bool {
    let ((a_low, a_high), (b_low, b_high)) = (bounds(&in_front_view(a)), bounds(&in_front_view(b)));
    (0..2).any(|k| a_high[k] + PANEL_CLEARANCE < b_low[k] || b_high[k] + PANEL_CLEARANCE < a_low[k])
}
