//! Real patterns, cut into triangles on many levels: what every level must keep.

mod support;

use std::collections::HashSet;
use toile::garment::{Garment, Level};
use toile::geometry::signed_area;
use toile::io::garmentcode;
use toile::pattern::Pattern;

const LEVELS: [&[f64]; 3] = [&[0.04, 0.02, 0.01], &[0.045, 0.0232, 0.0108], &[0.03, 0.003]];

/// The real patterns, or where there are none the small ones drawn for the tests.
fn patterns() -> Vec<(String, Pattern)> {
    let mut texts = support::shared_patterns();
    texts.push(("skirt".to_owned(), support::patterns::skirt(70.0, 60.0).to_string()));
    texts.push(("towel".to_owned(), support::patterns::towel().to_string()));
    texts.into_iter().map(|(name, text)| (name.clone(), garmentcode::parse(&text, &name).unwrap().0)).collect()
}

fn built(levels: &[&'static [f64]]) -> impl Iterator<Item = (String, Pattern, Garment)> {
    let cases = patterns().into_iter().flat_map(|named| levels.iter().map(move |&levels| (named.clone(), levels)));
    cases.filter_map(|((name, pattern), levels)| match Garment::build(&pattern, levels) {
        Ok(garment) => Some((format!("{name} at {levels:?}"), pattern, garment)),
        // Narrow bands cannot be sewn at every resolution; the error must say so.
        Err(error) => {
            assert!(error.remedy().contains("finer") && error.place().contains("panel"), "{name}: {error}");
            eprintln!("{name} at {levels:?}: {error}");
            None
        }
    })
}

#[test]
fn real_patterns_are_cut_on_every_level_as_drawn() {
    let mut sewn = HashSet::new();
    for (name, pattern, garment) in built(&LEVELS) {
        sewn.insert(pattern.name.clone());
        garment.open.sanity_check();
        for (level, k) in garment.levels.iter().zip(0..) {
            let at = format!("{name}, level {k}");
            level.sanity_check();
            assert_seam_partners(&at, level);
            assert_covered(&at, &pattern, level);
            assert_even(&at, level);
        }
        for pair in garment.levels.windows(2) {
            assert_contained(&name, &pair[0], &pair[1]);
        }
    }
    assert!(sewn.len() + 1 >= patterns().len(), "only {sewn:?} could be sewn at all");
}

/// Both sides of a seam have the same number of points, and partners are one particle.
fn assert_seam_partners(at: &str, level: &Level) {
    for [a, b] in &level.seams {
        assert_eq!(a.len(), b.len(), "{at}");
        let particle = |p: &u32| level.particle_of[*p as usize];
        assert!(a.iter().map(particle).eq(b.iter().map(particle)), "{at}");
    }
}

/// The triangles cover their panel once, all wound like its outline.
fn assert_covered(at: &str, pattern: &Pattern, level: &Level) {
    for (panel, range) in pattern.panels.iter().zip(&level.panels) {
        let drawn = panel.signed_area();
        let areas = range.triangles.clone().map(|t| {
            let [a, b, c] = level.rest_corners(t);
            signed_area(a, b, c)
        });
        let mut covered = 0.0;
        for area in areas {
            assert!(area * drawn > 0.0, "{at}, {}: a triangle is flipped", panel.name);
            covered += area;
        }
        // A chord of h on a curve of radius R cuts off h³/12R; a decimetre is a tight curve.
        let curved: f64 = panel.segments.iter().filter(|s| !s.curve.is_straight()).map(|s| s.curve.length()).sum();
        let cut_off = curved * level.resolution.powi(2) / (12.0 * 0.05) + 1e-9;
        assert!((covered - drawn).abs() < cut_off, "{at}, {}: {covered} of {drawn} m²", panel.name);
    }
}

fn assert_even(at: &str, level: &Level) {
    let (mut sum, mut count) = (0.0, 0);
    for t in 0..level.triangles.len() {
        let corners = level.rest_corners(t);
        for k in 0..3 {
            sum += (corners[(k + 1) % 3] - corners[k]).norm();
            count += 1;
        }
    }
    let mean = sum / f64::from(count) / level.resolution;
    assert!((0.5..1.3).contains(&mean), "{at}: the mean edge has {mean} resolutions");
}

/// Corners are the same on every level, and what is a particle of an outline stays one.
fn assert_contained(name: &str, coarse: &Level, fine: &Level) {
    let bits = |level: &Level, p: &u32| level.rest[*p as usize].map(f64::to_bits);
    for (coarse_panel, fine_panel) in coarse.segments.iter().zip(&fine.segments) {
        for (few, many) in coarse_panel.iter().zip(fine_panel) {
            let finer: HashSet<_> = many.iter().map(|p| bits(fine, p)).collect();
            assert!(few.iter().all(|p| finer.contains(&bits(coarse, p))), "{name}: a boundary particle is lost");
            let ends = |level, points: &[u32]| [bits(level, &points[0]), bits(level, &points[points.len() - 1])];
            assert_eq!(ends(coarse, few), ends(fine, many), "{name}: a corner moved");
        }
    }
}

#[test]
fn prolongation_keeps_affine_maps_of_real_garments() {
    for (name, _, garment) in built(&LEVELS[..1]) {
        for (k, correspondence) in garment.correspondences.iter().enumerate() {
            let (coarse, fine) = (&garment.levels[k], &garment.levels[k + 1]);
            for (location, point) in correspondence.locations.iter().zip(&fine.rest) {
                let [a, b, c] = coarse.rest_corners(location.triangle as usize);
                let [u, v, w] = location.weights;
                assert!((u + v + w - 1.0).abs() < 1e-9, "{name}");
                assert!((a * u + b * v + c * w - point).norm() < 1e-9, "{name}: the location is elsewhere");
            }
            for (range, fine_range) in coarse.panels.iter().zip(&fine.panels) {
                let inside = |l: &toile::garment::Location| range.triangles.contains(&(l.triangle as usize));
                assert!(
                    correspondence.locations[fine_range.points.clone()].iter().all(inside),
                    "{name}: another panel"
                );
            }
        }
    }
}
