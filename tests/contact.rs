//! Contact: its energy against its gradient, and what it promises for any moves.

mod support;

use nalgebra::Rotation3;
use proptest::prelude::*;
use support::bodies::Mesh;
use support::patterns::{sheet, two_sheets};
use toile::assess::{CLEARANCE_TOLERANCE, cloth_intersections};
use toile::body::DistanceField;
use toile::contact::{BodyContact, BodyContactSettings, SelfContact, SelfContactSettings};
use toile::energy::{Energy, Model};
use toile::garment::Level;
use toile::geometry::Vector3;
use toile::io::{body_obj, embedded, garmentcode};
use toile::minimize::{ConjugateGradient, Settings};
use toile::pattern::Fabric;
use toile::prepositioning::{Event, Observer, Relaxation, Settings as PrepositionSettings, preposition};

/// Particles where their panels lie, the second panel `gap` above the first, rumpled by up to `rough`.
fn laid(level: &Level, gap: f64, rough: f64, seed: f64) -> Vec<Vector3> {
    let wave = |k: usize, step: f64| (k as f64 * step + seed).sin() * rough;
    let mut positions = vec![Vector3::zeros(); level.particle_count];
    for (panel, range) in level.panels.iter().enumerate() {
        for k in range.points.clone() {
            let noise = Vector3::new(wave(k, 12.9898), wave(k, 78.233), wave(k, 37.719));
            let rest = level.rest[k];
            positions[level.particle_of[k] as usize] = Vector3::new(rest.x, gap * panel as f64, rest.y) + noise;
        }
    }
    positions
}

fn classes(level: &Level) -> Vec<u32> {
    (0..level.particle_count as u32).collect()
}

fn against_itself(level: &Level, positions: &[Vector3]) -> SelfContact {
    let settings = SelfContactSettings { clearance: 0.008, stiffness: 200.0, reach: 0.03 };
    let mut contact = SelfContact::new(level, classes(level), settings);
    contact.rebuild(positions);
    contact
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_gradient_of_cloth_against_cloth_is_the_derivative(seed in 0.0..100.0f64, gap in 0.002..0.009f64) {
        let level = two_sheets(0.16, 0.05);
        let positions = laid(&level, gap, 0.25 * gap, seed);
        let mut contact = against_itself(&level, &positions);
        let mut gradient = vec![Vector3::zeros(); positions.len()];
        prop_assert!(contact.evaluate(&positions, &mut gradient) > 0.0);
        let scale = gradient.iter().map(|g| g.norm()).fold(0.0, f64::max);
        let mut ignored = gradient.clone();
        let step = 1e-8;
        for p in 0..positions.len() {
            for axis in 0..3 {
                let mut energy = |by: f64| {
                    let mut at = positions.clone();
                    at[p][axis] += by;
                    contact.evaluate(&at, &mut ignored)
                };
                // A kink may lie nearer than the step, where the nearest features change: the gradient is that of one side.
                let here = energy(0.0);
                let [before, after] = [(here - energy(-step)) / step, (energy(step) - here) / step];
                let (least, most) = (before.min(after) - 1e-4 * scale, before.max(after) + 1e-4 * scale);
                prop_assert!((least..most).contains(&gradient[p][axis]), "{} is not in {least}..{most}", gradient[p][axis]);
            }
        }
        let sum: Vector3 = gradient.iter().sum();
        prop_assert!(sum.norm() < 1e-9 * scale * positions.len() as f64, "cloth pushes itself away: {sum}");
    }

    /// The promise on which all rests: no move that was limited leads through cloth.
    #[test]
    fn limited_moves_never_lead_through_cloth(seed in 0.0..100.0f64, gap in 0.001..0.01f64, size in 0.002..0.05f64) {
        let level = two_sheets(0.2, 0.04);
        let mut positions = laid(&level, gap, 0.2 * gap, seed);
        prop_assume!(cloth_intersections(&level, &positions).is_empty());
        let mut contact = against_itself(&level, &positions);
        for round in 0..25 {
            let wave = |k: usize, step: f64| (k as f64 * step + seed * 3.0 + 17.0 * f64::from(round)).sin() * size;
            let mut moves: Vec<Vector3> =
                (0..positions.len()).map(|k| Vector3::new(wave(k, 45.164), wave(k, 94.673), wave(k, 7.781))).collect();
            // Half the time the sheets are pressed together as a whole.
            if round % 2 == 0 {
                let lower = level.panels[0].points.clone();
                moves.iter_mut().enumerate().for_each(|(k, m)| m.y += if lower.contains(&k) { size } else { -size });
            }
            contact.limit(&positions, &mut moves);
            positions.iter_mut().zip(&moves).for_each(|(p, m)| *p += m);
            let crossing = cloth_intersections(&level, &positions);
            prop_assert!(crossing.is_empty(), "round {round}: triangles {crossing:?} have met");
        }
    }

    /// Layers that were pressed together until rounding is near could part by a share of their distance at a time only, and
    /// not slide at all.
    #[test]
    fn squeezed_layers_slide_and_part_at_once(seed in 0.0..100.0f64, exponent in 4..10i32) {
        let level = two_sheets(0.2, 0.04);
        let (mut apart, gap) = (laid(&level, 0.005, 0.0, seed), 10f64.powi(-exponent));
        let lower = level.panels[0].points.clone();
        // Turned, as edges that are parallel have no direction across them.
        let turn = Rotation3::new(Vector3::y() * 0.3);
        apart.iter_mut().enumerate().filter(|(p, _)| !lower.contains(p)).for_each(|(_, x)| *x = turn * *x);
        let mut contact = against_itself(&level, &apart);
        let over = |by: Vector3| -> Vec<Vector3> {
            (0..apart.len()).map(|p| if lower.contains(&p) { Vector3::zeros() } else { by }).collect()
        };
        let mut positions = apart.clone();
        positions.iter_mut().zip(over(Vector3::y() * (gap - 0.005))).for_each(|(p, m)| *p += m);
        let (towards, step) = (seed.sin_cos(), 0.003);
        for rise in [0.0, 0.001] {
            let wanted = over(Vector3::new(step * towards.0, rise, step * towards.1));
            let mut moves = wanted.clone();
            prop_assert_eq!(contact.limit(&positions, &mut moves), 0);
            prop_assert_eq!(&moves, &wanted);
        }
        // Rough moves may lead nowhere through, whether they part or not.
        for round in 0..10 {
            let wave = |k: usize, by: f64| (k as f64 * by + seed + 17.0 * f64::from(round)).sin() * step;
            let mut moves: Vec<Vector3> =
                (0..positions.len()).map(|k| Vector3::new(wave(k, 45.164), wave(k, 94.673), wave(k, 7.781))).collect();
            contact.limit(&positions, &mut moves);
            positions.iter_mut().zip(&moves).for_each(|(p, m)| *p += m);
            let crossing = cloth_intersections(&level, &positions);
            prop_assert!(crossing.is_empty(), "round {round}: triangles {crossing:?} have met");
        }
    }

    /// In a groove the way out of one side may lead into the other.
    #[test]
    fn held_particles_are_clear_even_in_a_groove(seed in 0.0..100.0f64, clearance in 0.0..0.01f64) {
        let body = Mesh::groove().body();
        let field = DistanceField::new(&body, 0.02, 0.05);
        let level = sheet(0.5, 0.5, 0.05);
        let contact = BodyContact::new(&body, &field, &level, BodyContactSettings { clearance, stiffness: 1.0, friction: 0.0 });
        let wave = |k: usize| (k as f64 * 12.9898 + seed).sin() * 0.01;
        let mut positions: Vec<Vector3> = (0..level.particle_count)
            .map(|k| (level.rest[k].x - 0.25, level.rest[k].y - 0.25, k))
            .map(|(x, z, k)| Vector3::new(0.3 * x, 0.305 + 0.25 * x.abs() + wave(k), z))
            .collect();
        let mut moves = positions.clone();
        contact.hold(&positions, &mut vec![f64::NEG_INFINITY; positions.len()], &mut moves);
        positions.iter_mut().zip(&moves).for_each(|(p, m)| *p += m);
        for p in &positions {
            let distance = body.signed_distance(*p);
            prop_assert!(distance > clearance - CLEARANCE_TOLERANCE, "{} mm is left of {} mm", distance * 1e3, clearance * 1e3);
        }
    }
}

/// How far a cloth has slid down an incline of `degrees` in the second half of many rounds, m.
fn slid(degrees: f64, friction: f64) -> f64 {
    let angle = degrees.to_radians();
    let body = Mesh::incline(angle).body();
    let field = DistanceField::new(&body, 0.01, 0.03);
    let level = sheet(0.12, 0.12, 0.04);
    let (sin, cos) = angle.sin_cos();
    let (down, up) = (Vector3::new(cos, -sin, 0.0), Vector3::new(sin, cos, 0.0));
    let start = Vector3::new(0.0, 0.6, 0.0) + up * 0.2005 - down * 0.3;
    let mut positions: Vec<Vector3> =
        level.rest.iter().map(|p| start + down * p.x + Vector3::z() * (0.06 - p.y)).collect();
    // Soft contact, so that each round of slipping is long enough to be seen.
    let settings = BodyContactSettings { clearance: 0.004, stiffness: 3.0, friction };
    let fabric = Fabric::default();
    let contact = BodyContact::new(&body, &field, &level, settings);
    let cloth = against_itself(&level, &positions);
    let mut problem = Relaxation::new(Energy::new(&level, &fabric, Model::default()), contact, cloth);
    let mut minimizer = ConjugateGradient::new(positions.len());
    let steps = Settings { evaluations: 300, largest_move: 0.01, restart_after: 100 };
    let along = |positions: &[Vector3]| positions.iter().map(|p| p.dot(&down)).sum::<f64>() / positions.len() as f64;
    let mut half_way = 0.0;
    for round in 0..40 {
        minimizer.run(&mut problem, &mut positions, &steps, |_| false);
        problem.body.update_anchors(&positions);
        if round == 19 {
            half_way = along(&positions);
        }
    }
    along(&positions) - half_way
}

#[test]
fn cloth_sticks_on_a_slope_below_the_angle_of_friction_and_slides_above() {
    let friction = 0.5f64;
    let limit = friction.atan().to_degrees();
    let (below, above) = (slid(limit - 2.0, friction), slid(limit + 2.0, friction));
    assert!(below.abs() < 1e-4, "it slid {} mm where it should stick", below * 1e3);
    assert!(above > 1e-3, "it slid {} mm where it should slide on", above * 1e3);
}

/// What finding the near pairs of a particle takes must not grow with the number of particles. Prints
/// figures instead of judging them: `cargo test --release --test contact -- --ignored --nocapture`.
#[test]
#[ignore = "takes a minute, and tells times"]
fn finding_pairs_takes_as_long_for_each_of_a_million_particles() {
    struct Watcher;
    impl Observer for Watcher {
        fn event(&mut self, event: &Event) {
            let Event::LevelDone { cloth, positions, .. } = event else { return };
            let h = cloth.resolution;
            let settings = SelfContactSettings { clearance: 0.1 * h, stiffness: 1.0, reach: 0.7 * h };
            let mut contact = SelfContact::new(cloth, classes(cloth), settings);
            let shortest = |work: &mut dyn FnMut()| {
                let timed = |_| {
                    let start = std::time::Instant::now();
                    work();
                    start.elapsed().as_secs_f64() / cloth.particle_count as f64 * 1e6
                };
                (0..5).map(timed).fold(f64::INFINITY, f64::min)
            };
            let pairs = shortest(&mut || contact.rebuild(positions));
            let crossings = shortest(&mut || assert!(cloth_intersections(cloth, positions).is_empty()));
            let (n, h) = (cloth.particle_count, 1e3 * h);
            println!("{n:8} particles at {h:.2} mm: pairs {pairs:.2} µs a particle, intersections {crossings:.2} µs");
        }
    }
    let body = body_obj::parse(embedded::MANNEQUIN_OBJ).unwrap().0;
    let pattern = garmentcode::parse(embedded::TEE, "tee").unwrap().0;
    let resolutions = vec![0.04, 0.02, 0.01, 0.005, 0.0025, 0.00125, 0.0008];
    let settings = PrepositionSettings {
        resolutions,
        coarse_evaluations: 300,
        finest_evaluations: 1,
        ..PrepositionSettings::for_resolution(0.005)
    };
    preposition(&pattern, &Fabric::default(), &body, &settings, &mut Watcher).unwrap();
}
