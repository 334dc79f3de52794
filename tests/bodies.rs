//! Real bodies: they are read without a warning, and the distance field agrees with exact distances.

mod support;

use toile::assess::CLEARANCE_TOLERANCE;
use toile::body::{Body, DistanceField};
use toile::contact::{BodyContact, BodyContactSettings};
use toile::geometry::Vector3;
use toile::io::body_obj;

const CELL: f64 = 0.006;
const BAND: f64 = 0.011;

fn real_bodies() -> Vec<(&'static str, Body)> {
    let Some(data) = support::shared_data() else { return Vec::new() };
    ["mean_all", "mean_all_apart", "female_apose", "male_apose"]
        .map(|name| {
            let (body, warnings) =
                body_obj::parse(&std::fs::read(data.join(format!("bodies/{name}.obj"))).unwrap()).unwrap();
            assert!(warnings.is_empty(), "{name}: {warnings:?}");
            (name, body)
        })
        .into()
}

/// Points up to a centimetre above and below every few triangles.
fn points_near(body: &Body, every: usize) -> Vec<Vector3> {
    let near = |k: usize| {
        let [a, b, c] = body.corners(k as u32);
        let normal = (b - a).cross(&(c - a)).normalize();
        (a + b + c) / 3.0 + normal * (0.010 * (k as f64 * 0.77).sin())
    };
    (0..body.triangles().len()).step_by(every).map(near).collect()
}

#[test]
fn distance_fields_agree_with_exact_distances() {
    for (name, body) in real_bodies() {
        let field = DistanceField::new(&body, CELL, BAND);
        let mut errors = Vec::new();
        let mut wrong_sides = 0;
        for point in points_near(&body, 23) {
            let exact = body.signed_distance(point);
            let sampled = field.sample(point).expect("the point is within the band").distance;
            errors.push((sampled - exact).abs());
            wrong_sides += usize::from(exact.abs() > 0.002 && (exact > 0.0) != (sampled > 0.0));
        }
        errors.sort_by(f64::total_cmp);
        let (median, p99) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
        eprintln!(
            "{name}: median {median:.1e} m, p99 {p99:.1e} m, {wrong_sides} of {} on the wrong side",
            errors.len()
        );
        assert!(median < 2e-4, "{name}: median {median} m");
        // More than a cell under the skin, where it only has to lead out, the field is coarse.
        assert!(p99 < 3e-3, "{name}: p99 {p99} m");
        assert!(wrong_sides * 500 <= errors.len(), "{name}: {wrong_sides} of {} are on the wrong side", errors.len());
    }
}

#[test]
fn the_gradient_points_away_from_a_real_body() {
    for (name, body) in real_bodies().into_iter().take(1) {
        let field = DistanceField::new(&body, CELL, BAND);
        let mut cosines = Vec::new();
        for point in points_near(&body, 97) {
            let Some(sample) = field.sample(point) else { continue };
            let nearest = body.nearest(point, 0.1).unwrap();
            let away = (point - nearest.point) * if body.contains(point) { -1.0 } else { 1.0 };
            if nearest.distance > 1e-3 {
                cosines.push(sample.gradient.dot(&away.normalize()));
            }
        }
        // At fingers and in folds, which are finer than a cell, it is anything.
        cosines.sort_by(f64::total_cmp);
        let (quarter, median) = (cosines[cosines.len() / 4], cosines[cosines.len() / 2]);
        assert!(median > 0.999 && quarter > 0.98, "{name}: cosine {quarter} at the worst quarter, median {median}");
    }
}

/// Where skin passes through skin the nearest triangle may face either way: only counting how often
/// the surface winds around a point tells that it is inside.
#[test]
fn what_lies_under_the_skin_is_inside_even_where_skin_passes_through_skin() {
    for (name, body) in real_bodies() {
        let (mut outside, mut twice, mut count) = (0, 0, 0);
        for triangle in 0..body.triangles().len() as u32 {
            let [a, b, c] = body.corners(triangle);
            let normal = (b - a).cross(&(c - a)).normalize();
            let winding = body.winding_number((a + b + c) / 3.0 - normal * 1e-5);
            outside += usize::from(winding < 1);
            twice += usize::from(winding > 1);
            count += 1;
        }
        eprintln!("{name}: of {count} triangles {twice} lie within the body, {outside} are inside out");
        assert!(outside * 500 < count, "{name}: {outside} of {count}");
        assert!(name != "mean_all" || twice > 0, "this body passes through itself somewhere");
    }
}

#[test]
fn real_bodies_have_the_volume_of_people() {
    for (name, body) in real_bodies() {
        let (low, high) = body.bounds();
        let size = high - low;
        let wave = |k: usize, step: f64| (k as f64 * step).fract();
        let count = 40_000;
        // An even, fixed sampling of the box: multiples of irrational numbers.
        let sample =
            |k| low + size.component_mul(&Vector3::new(wave(k, 0.819_172), wave(k, 0.671_043), wave(k, 0.549_7)));
        let inside = (0..count).filter(|&k| body.contains(sample(k))).count();
        let volume = size.x * size.y * size.z * inside as f64 / count as f64;
        assert!((0.045..0.12).contains(&volume), "{name}: {volume} m³");
    }
}

/// Particles a millimetre above or below the skin, anywhere, are taken out to their clearance; but not
/// between toes and lips that are nearer to each other than twice that, nor where skin passes through skin.
#[test]
fn held_particles_are_clear_of_real_bodies() {
    let level = support::patterns::sheet(1.0, 1.0, 0.0095);
    for (name, body) in real_bodies() {
        let field = DistanceField::new(&body, CELL, BAND);
        let settings = BodyContactSettings { clearance: 0.001, stiffness: 1.0, friction: 0.0 };
        let contact = BodyContact::new(&body, &field, &level, settings);
        let count = body.triangles().len();
        let near = |k: usize| {
            let [a, b, c] = body.corners((k * count / level.particle_count) as u32);
            (a + b + c) / 3.0 + (b - a).cross(&(c - a)).normalize() * (0.001 * (k as f64 * 0.77).sin())
        };
        let positions: Vec<Vector3> = (0..level.particle_count).map(near).collect();
        let mut moves = positions.clone();
        contact.hold(&positions, &mut vec![f64::NEG_INFINITY; positions.len()], &mut moves);
        let distances = positions.iter().zip(&moves).map(|(p, m)| body.signed_distance(p + m));
        let too_near: Vec<f64> = distances.filter(|&d| d < settings.clearance - CLEARANCE_TOLERANCE).collect();
        let inside = too_near.iter().filter(|&&d| d < 0.0).count();
        eprintln!("{name}: {} of {} are too near, {inside} inside", too_near.len(), positions.len());
        assert!(too_near.len() * 80 < positions.len() && inside * 400 < positions.len(), "{name}");
    }
}
