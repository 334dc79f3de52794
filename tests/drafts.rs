//! FreeSewing drafts with the files of seams in examples/drafts: sewn, placed without any given place, worn.

mod support;

use std::path::Path;
use toile::arrangement::placing::place;
use toile::body::{Body, Landmarks};
use toile::io::{body_obj, pattern_file, read, seams_toml};
use toile::pattern::sewing::SeamPlan;
use toile::pattern::suggest::suggest;
use toile::pattern::{Fabric, Pattern, SegmentId};
use toile::prepositioning::{Settings, preposition};

/// Name, size, body, and how many of its seams are proposed at least.
const DRAFTS: [(&str, &str, &str, usize); 5] = [
    ("teagan", "cisFemaleAdult34", "female_apose", 8),
    ("penelope", "cisFemaleAdult34", "female_apose", 12),
    ("titan", "cisMaleAdult40", "male_apose", 6),
    ("brian", "cisMaleAdult40", "male_apose", 8),
    ("aaron", "cisMaleAdult40", "male_apose", 4),
];

/// The pattern as drawn, and the text of its seams.
fn drawn(name: &str, size: &str) -> Option<(Pattern, String)> {
    let file = support::shared_data()?.join("patterns/freesewing").join(format!("{name}_{size}.json"));
    let bytes = std::fs::read(&file).unwrap();
    let (pattern, _) = pattern_file::open(&bytes, name, &Default::default()).unwrap();
    let seams = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/drafts").join(format!("{name}.seams.toml"));
    Some((pattern, read::text(&seams).unwrap()))
}

fn body(name: &str) -> Option<Body> {
    let file = support::shared_data()?.join("bodies").join(format!("{name}.obj"));
    Some(body_obj::parse(&std::fs::read(file).unwrap()).unwrap().0)
}

/// The edges of each side, whatever their order.
fn sides(plan: &SeamPlan) -> [Vec<SegmentId>; 2] {
    let mut sides = plan.sides.each_ref().map(|side| {
        let mut ids: Vec<SegmentId> = side.iter().flat_map(|s| s.parts()).map(|part| part.id).collect();
        ids.sort_unstable();
        ids
    });
    sides.sort();
    sides
}

#[test]
fn drafts_are_sewn_as_their_files_say_and_most_of_it_is_proposed() {
    for (name, size, _, proposed) in DRAFTS {
        let Some((pattern, seams)) = drawn(name, size) else { return };
        let sewn = seams_toml::sew(&pattern, &seams).unwrap();
        assert!(sewn.warnings.is_empty(), "{name}: {}", sewn.warnings[0]);
        assert!(!sewn.turned.contains(&true), "{name}: fronts and backs are drawn right side up");
        let plans = seams_toml::parse(&seams, &pattern).unwrap();
        let suggestions = suggest(&pattern);
        let right = |plan: &&SeamPlan| suggestions.iter().any(|s| sides(&s.plan) == sides(plan));
        let found = plans.iter().filter(right).count();
        eprintln!("{name}: {found} of {} seams in {} proposals", plans.len(), suggestions.len());
        assert!(found >= proposed, "{name}: {found} seams proposed");
    }
}

/// A drawing of the shared files sewn as it is proposed to be, and the proposals.
fn sewn_as_proposed(dxf: &str) -> Option<(Pattern, Vec<SeamPlan>)> {
    let bytes = std::fs::read(support::shared_data()?.join("patterns/dxf").join(dxf)).unwrap();
    let (pattern, _) = pattern_file::open(&bytes, dxf, &Default::default()).unwrap();
    let proposed = seams_toml::write_suggestions(&suggest(&pattern), &pattern);
    let plans = seams_toml::parse(&proposed, &pattern).unwrap();
    Some((seams_toml::sew(&pattern, &proposed).unwrap().pattern, plans))
}

/// The tee's backs are drawn as one sees them through the front: right fronts were sewn to left backs, and the sleeves found no
/// armholes.
#[test]
fn a_tee_whose_backs_are_drawn_from_inside_is_sewn_side_to_side() {
    let Some((sewn, plans)) = sewn_as_proposed("gc_tee_aama_clo_mm.dxf") else { return };
    let text = std::fs::read(support::shared_data().unwrap().join("patterns/garmentcode/tee.json")).unwrap();
    let (tee, _) = pattern_file::open(&text, "tee", &Default::default()).unwrap();
    // The same panels are sewn together, whatever their order and the spelling of their names; the back of a sleeve reaches over the
    // shoulder in the original.
    let pairs = |pattern: &Pattern| {
        let name = |id: SegmentId| pattern.panels[id.panel].name.to_lowercase();
        let mut pairs: Vec<[String; 2]> = pattern.seams.iter().map(|seam| seam.sides.map(name)).collect();
        pairs.iter_mut().for_each(|pair| pair.sort());
        pairs.sort();
        pairs.retain(|[a, b]| !(a.ends_with("ftorso") && b.ends_with("sleeve_b")));
        pairs
    };
    assert_eq!(pairs(&sewn), pairs(&tee));
    assert_eq!(plans.len(), 12, "{plans:?}");
    let backs = sewn.panels.iter().filter(|panel| panel.signed_area() < 0.0).map(|panel| &panel.name[..]);
    assert!(
        backs.clone().count() == 4 && backs.clone().all(|name| name.contains("_B")),
        "{:?}",
        backs.collect::<Vec<_>>()
    );
}

/// The band of the skirt was placed anyhow, as what goes all around faces nowhere, and the edges of its vent pulled the backs to
/// the sides.
#[test]
fn a_skirt_with_a_vent_has_its_band_closed_behind() {
    let (Some((mut sewn, _)), Some(body)) = (sewn_as_proposed("penelope_astm_accumark_inch.dxf"), body("female_apose"))
    else {
        return;
    };
    let marks = Landmarks::find(&body).unwrap();
    let none = vec![None; sewn.panels.len()];
    let report = place(&mut sewn, &body, &marks, &none).unwrap();
    for (panel, placed) in sewn.panels.iter().zip(&report.panels) {
        match panel.name.split(' ').nth(1) {
            Some("BACK") => assert!(placed.face.z < 0.5, "{} faces {}", panel.name, placed.face),
            _ => assert!(placed.face.z > 0.9, "{} faces {}", panel.name, placed.face),
        }
    }
    assert!(report.mean_gap < 0.25, "{}", report.mean_gap);
}

#[test]
fn drafts_find_their_places_outside_the_body() {
    for (name, size, body_name, _) in DRAFTS {
        let (Some((pattern, seams)), Some(body)) = (drawn(name, size), body(body_name)) else { return };
        let mut pattern = seams_toml::sew(&pattern, &seams).unwrap().pattern;
        let marks = Landmarks::find(&body).unwrap();
        let none = vec![None; pattern.panels.len()];
        let report = place(&mut pattern, &body, &marks, &none).unwrap();
        assert!(report.warnings.is_empty(), "{name}: {:?}", report.warnings);
        // Trousers that are too long start with their legs apart, and their middle seams open.
        assert!(report.mean_gap < 0.45, "{name}: {}", report.mean_gap);
        for (panel, placed) in pattern.panels.iter().zip(&report.panels) {
            let inside = panel.polygon(8).iter().filter(|&&p| body.contains(panel.place(p))).count();
            assert_eq!(inside, 0, "{name}: {} starts inside the body", panel.name);
            let z = placed.face.z;
            match panel.name.split(' ').next() {
                Some("front") => assert!(z > 0.5, "{name}: {} faces {z}", panel.name),
                Some("back") => assert!(z < 0.5, "{name}: {} faces {z}", panel.name),
                _ => {}
            }
        }
    }
}

#[test]
fn a_tee_and_trousers_are_worn_as_drafted() {
    for (name, size, body_name) in
        [("teagan", "cisFemaleAdult34", "female_apose"), ("titan", "cisMaleAdult40", "male_apose")]
    {
        let (Some((pattern, seams)), Some(body)) = (drawn(name, size), body(body_name)) else { return };
        let mut pattern = seams_toml::sew(&pattern, &seams).unwrap().pattern;
        let none = vec![None; pattern.panels.len()];
        place(&mut pattern, &body, &Landmarks::find(&body).unwrap(), &none).unwrap();
        let settings = Settings::for_resolution(0.02);
        let outcome = preposition(&pattern, &Fabric::default(), &body, &settings, &mut ()).unwrap();
        let crossings = &outcome.assessment.intersections;
        assert_eq!((crossings.body_pairs, crossings.cloth_pairs), (0, 0), "{name}");
        assert!(outcome.assessment.strain.mean < 0.02, "{name}: {}", outcome.assessment.strain.mean);
    }
}
