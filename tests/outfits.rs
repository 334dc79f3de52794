//! Garments that are worn one over the other.

use toile::body::Body;
use toile::geometry::Vector3;
use toile::io::{body_obj, embedded, garmentcode};
use toile::pattern::{Cut, Fabric, Pattern};
use toile::prepositioning::{Outfit, Settings, preposition, preposition_outfit};

fn body() -> Body {
    body_obj::parse(embedded::MANNEQUIN_OBJ).unwrap().0
}

fn pattern(text: &str, name: &str) -> Pattern {
    garmentcode::parse(text, name).unwrap().0
}

fn levels() -> Settings {
    Settings { resolutions: vec![0.036, 0.018], ..Settings::for_resolution(0.018) }
}

/// A dress over a tee, of two fabrics.
fn dress_over_tee() -> Outfit {
    let patterns = [pattern(embedded::TEE, "tee"), pattern(embedded::DRESS, "dress")];
    let fabrics = [Fabric::named("cotton_jersey").unwrap(), Fabric::named("wool_suiting").unwrap()];
    let garments: Vec<(&Pattern, &Fabric)> = patterns.iter().zip(&fabrics).collect();
    preposition_outfit(&garments, &body(), &levels(), &mut ()).unwrap()
}

#[test]
fn a_dress_over_a_tee_crosses_neither_it_nor_the_body() {
    let outfit = dress_over_tee();
    assert_eq!(outfit.layers.pairs(), 0, "{:?}", outfit.layers);
    for outcome in &outfit.garments {
        assert!(outcome.assessment.intersections.is_clean(), "{:?}", outcome.assessment.intersections);
        assert_eq!(outcome.assessment.clearance.triangles_too_near, 0, "{:?}", outcome.assessment.clearance);
        assert_eq!(outcome.assessment.seams.largest, 0.0);
        assert_eq!(outcome.levels.last().unwrap().particles, outcome.positions.len());
    }
    // Half of the thicker fabric, which is 0.7 mm.
    assert!(outfit.layers.least_distance.unwrap() >= 0.00035, "{:?}", outfit.layers);
    // Between the shoulders, where the tee lies on the skin, the dress lies outside.
    let from_body = |outcome: &toile::prepositioning::Outcome| {
        let body = body();
        let chest = |p: &&Vector3| (1.15..1.25).contains(&p.y) && p.x.abs() < 0.08 && p.z > 0.0;
        let distances: Vec<f64> = outcome.positions.iter().filter(chest).map(|&p| body.signed_distance(p)).collect();
        assert!(distances.len() > 10);
        distances.iter().sum::<f64>() / distances.len() as f64
    };
    let [tee, dress] = &outfit.garments[..] else { panic!("two garments") };
    assert!(from_body(dress) > from_body(tee), "{} {}", from_body(tee), from_body(dress));
}

#[test]
fn an_outfit_is_the_same_on_any_number_of_threads() {
    let on = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
            let outfit = dress_over_tee();
            outfit.garments.into_iter().flat_map(|outcome| outcome.positions).collect::<Vec<Vector3>>()
        })
    };
    assert!(on(1) == on(3));
}

#[test]
fn one_garment_is_an_outfit_of_one() {
    let (tee, fabric) = (pattern(embedded::TEE, "tee"), Fabric::default());
    let alone = preposition(&tee, &fabric, &body(), &levels(), &mut ()).unwrap();
    let outfit = preposition_outfit(&[(&tee, &fabric)], &body(), &levels(), &mut ()).unwrap();
    assert!(outfit.garments.len() == 1 && outfit.garments[0].positions == alone.positions);
    assert_eq!(outfit.layers.least_distance, None);
}

#[test]
fn what_is_wrong_with_one_of_several_is_told_with_its_name() {
    let tee = pattern(embedded::TEE, "tee");
    let mut far = pattern(embedded::TEE, "far away");
    far.panels.iter_mut().for_each(|panel| panel.placement.as_mut().unwrap().translation.x += 30.0);
    let fabric = Fabric::default();
    let garments = [(&tee, &fabric), (&far, &fabric)];
    let error = preposition_outfit(&garments, &body(), &levels(), &mut ()).err().expect("it is too far away");
    assert!(error.to_string().contains("far away"), "{error}");
}

/// Each panel has the mass of its own fabric.
#[test]
fn panels_of_two_fabrics_weigh_what_each_weighs() {
    let tee = pattern(embedded::TEE, "tee");
    let level = toile::garment::Garment::build(&tee, &[0.03]).unwrap().levels.remove(0);
    let (light, heavy) = (Fabric::named("silk_habotai").unwrap(), Fabric::named("canvas").unwrap());
    let fabrics: Vec<&Fabric> = (0..tee.panels.len()).map(|k| if k == 0 { &heavy } else { &light }).collect();
    let energy = toile::energy::Energy::new(&level, Cut::ByPanel(&fabrics), toile::energy::Model::default());
    let areas = level.rest_areas();
    let of_first: f64 = areas[level.panels[0].triangles.clone()].iter().sum();
    let expected = heavy.areal_density * of_first + light.areal_density * (areas.iter().sum::<f64>() - of_first);
    assert!((energy.masses().iter().sum::<f64>() / expected - 1.0).abs() < 1e-12);
}
