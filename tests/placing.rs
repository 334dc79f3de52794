//! Panels without a placement find their places.

mod support;

use serde_json::Value;
use toile::arrangement::placed;
use toile::arrangement::placing::{Limb, Override, Report, place};
use toile::body::{Body, Landmarks};
use toile::garment::Garment;
use toile::io::{body_obj, garmentcode};
use toile::pattern::Pattern;

fn body(name: &str) -> Option<(Body, Landmarks)> {
    let file = support::shared_data()?.join("bodies").join(format!("{name}.obj"));
    let (body, _) = body_obj::parse(&std::fs::read(file).unwrap()).unwrap();
    let marks = Landmarks::find(&body).unwrap();
    Some((body, marks))
}

/// The pattern without its placement; without names and labels too if asked.
fn bare(text: &str, nameless: bool) -> Pattern {
    let mut document: Value = serde_json::from_str(text).unwrap();
    let panels = document["pattern"]["panels"].as_object_mut().unwrap();
    let mut names = Vec::new();
    for (name, panel) in panels.iter_mut() {
        let panel = panel.as_object_mut().unwrap();
        panel.remove("translation");
        panel.remove("rotation");
        if nameless {
            panel.remove("label");
        }
        names.push(name.clone());
    }
    let mut text = document.to_string();
    if nameless {
        // Whole strings, so that no name is changed within another.
        for (k, name) in names.iter().enumerate() {
            text = text.replace(&format!("\"{name}\""), &format!("\"panel_{k}\""));
        }
    }
    garmentcode::parse(&text, "bare").unwrap().0
}

fn place_all(pattern: &mut Pattern, (body, marks): &(Body, Landmarks)) -> Report {
    let none = vec![None; pattern.panels.len()];
    place(pattern, body, marks, &none).unwrap()
}

#[test]
fn panels_face_outwards_at_their_side_of_the_body_with_short_seams() {
    for name in ["mean_all", "female_apose"] {
        let Some(dressed) = body(name) else { return };
        for (pattern_name, text) in support::shared_patterns() {
            let mut pattern = bare(&text, false);
            let report = place_all(&mut pattern, &dressed);
            let place = format!("{pattern_name} on {name}");
            assert!(report.warnings.is_empty(), "{place}: {:?}", report.warnings);
            // Flat panels start 20 to 30 cm from their partners where they were placed by hand.
            assert!(report.mean_gap < 0.35, "{place}: {}", report.mean_gap);
            for placed in &report.panels {
                let panel = &pattern.panels[placed.panel];
                let n = panel.outward_normal();
                assert!(n.dot(&placed.face) > 0.999, "{place}, {}: {n}", panel.name);
                let words: Vec<&str> = panel.name.split('_').collect();
                let has = |list: &[&str]| words.iter().any(|word| list.contains(word));
                let m = placed.middle;
                let at = |right: bool| assert!(right, "{place}, {} is at {m}, faces {n}", panel.name);
                if has(&["left"]) {
                    at(m.x > 0.0);
                }
                if has(&["right"]) {
                    at(m.x < 0.0);
                }
                if has(&["front", "ftorso", "f"]) && placed.limb != Limb::Head {
                    at(n.z > 0.9 && m.z > 0.0);
                }
                if has(&["back", "btorso", "b"]) && placed.limb != Limb::Head {
                    at(n.z < -0.9 && m.z < 0.0);
                }
                if has(&["sleeve", "cuff"]) {
                    at(matches!(placed.limb, Limb::Arm(_)));
                }
            }
        }
    }
}

#[test]
fn no_particle_starts_inside_the_body() {
    let Some(dressed) = body("mean_all") else { return };
    for (name, text) in
        support::shared_patterns().into_iter().filter(|(name, _)| name != "circle_skirt" && name != "dress")
    {
        let mut pattern = bare(&text, false);
        place_all(&mut pattern, &dressed);
        let open = Garment::build(&pattern, &[0.04]).unwrap().open;
        let positions = placed(&pattern, &open);
        for (panel, range) in pattern.panels.iter().zip(&open.panels) {
            // The tips of a hood reach down into the shoulders; the search of first positions lifts it.
            let inside = positions[range.points.clone()].iter().filter(|&&p| dressed.0.contains(p)).count();
            assert!(inside == 0 || panel.name.contains("hood"), "{name}, {}: {inside}", panel.name);
        }
    }
}

#[test]
fn seams_tell_front_from_back_without_any_name() {
    let Some(dressed) = body("mean_all") else { return };
    for (name, text) in
        support::shared_patterns().into_iter().filter(|(name, _)| ["tee", "pants", "hoodie"].contains(&name.as_str()))
    {
        let (mut named, mut nameless) = (bare(&text, false), bare(&text, true));
        let (with, without) = (place_all(&mut named, &dressed), place_all(&mut nameless, &dressed));
        assert!(without.warnings.is_empty(), "{name}");
        for (a, b) in with.panels.iter().zip(&without.panels) {
            let panel = &named.panels[a.panel].name;
            // Left and right of a garment that is the same on both sides cannot be told, front and back can.
            if a.limb == Limb::Torso && b.limb == Limb::Torso {
                assert!(a.face.z * b.face.z > 0.5, "{name}, {panel}: {} or {}", a.face, b.face);
            }
        }
    }
}

#[test]
fn what_an_override_asks_for_is_done() {
    let Some(dressed) = body("mean_all") else { return };
    let Some((_, text)) = support::shared_patterns().into_iter().find(|(name, _)| name == "tee") else { return };
    let mut pattern = bare(&text, false);
    let sleeve = pattern.panels.iter().position(|p| p.name == "left_sleeve_f").unwrap();
    let mut overrides = vec![None; pattern.panels.len()];
    overrides[sleeve] =
        Some(Override { height: Some(1.5), aside: Some(0.4), distance: Some(0.5), ..Override::default() });
    let report = place(&mut pattern, &dressed.0, &dressed.1, &overrides).unwrap();
    let stands = report.panels[sleeve].stands;
    assert!((stands.height.unwrap() - 1.5).abs() < 0.01, "{stands:?}");
    assert!((stands.aside.unwrap() - 0.4).abs() < 0.01, "{stands:?}");
    assert!((stands.distance.unwrap() - 0.5).abs() < 1e-9, "{stands:?}");
}
