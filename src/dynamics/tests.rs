use super::*;
use crate::garment::Garment;
use crate::minimize::dot;
use crate::pattern::{Directional, shapes};

fn no_body() -> Surface {
    Surface::new(&[], &[], BroadPhase::Tree)
}

/// A square sheet of 0.4 m that lies in the air, at a resolution, m.
fn sheet(resolution: f64) -> (Level, Vec<Vector3>) {
    let pattern = shapes::cloth(shapes::rectangle("sheet", 0.4, 0.4));
    let level = Garment::build(&pattern, &[resolution]).unwrap().levels.remove(0);
    let mut positions = vec![Vector3::zeros(); level.particle_count];
    for (rest, &p) in level.rest.iter().zip(&level.particle_of) {
        positions[p as usize] = Vector3::new(rest.x, 1.0, rest.y);
    }
    (level, positions)
}

fn corners(positions: &[Vector3]) -> Vec<u32> {
    let at_corner = |p: &Vector3| p.z > 0.4 - 1e-6 && (p.x < 1e-6 || p.x > 0.4 - 1e-6);
    (0..positions.len() as u32).filter(|&p| at_corner(&positions[p as usize])).collect()
}

fn soft() -> Fabric {
    Fabric { stretch: Directional { warp: 15.0, weft: 15.0 }, shear: 5.0, stretch_limit: 0.1, ..Fabric::default() }
}

/// Vassilev and Spanlang's test: a soft sheet, held at two corners, sags. The springs there would be stretched to twice
/// their length.
#[test]
fn no_edge_of_a_sagging_sheet_is_beyond_its_limit_by_more_than_a_hundredth() {
    let (level, positions) = sheet(0.03);
    let held = corners(&positions);
    assert_eq!(held.len(), 2);
    let fabric = soft();
    let mut worst = [0.0f64; 2];
    for (k, limit) in [Some(0.1), None].into_iter().enumerate() {
        let settings = Settings { stretch_limit: limit, ..Settings::default() };
        let mut simulation = Simulation::new(&level, &fabric, &fabric, Model::default(), &settings, positions.clone());
        simulation.pin(&held);
        simulation.look_afresh();
        for _ in 0..60 {
            let course = simulation.run(&mut no_body(), 0.02, |_| false);
            worst[k] = worst[k].max(course.largest_strain);
        }
        for &p in &held {
            assert!((simulation.movement.positions[p as usize] - positions[p as usize]).norm() < 1e-9);
        }
    }
    let [limited, free] = worst;
    assert!(limited < 0.11, "an edge was stretched by {limited}");
    assert!(free > 0.3, "without the limit by no more than {free}");
}

/// The step is stable if no vibration is faster than `2/Δt`: the fastest one is found by power iteration.
#[test]
fn no_vibration_is_too_fast_for_the_step() {
    for resolution in [0.05, 0.02] {
        let (level, positions) = sheet(resolution);
        for fabric in [Fabric::default(), Fabric::named("denim_11oz").unwrap(), Fabric::named("canvas").unwrap()] {
            let settings = Settings { self_collision: false, ..Settings::default() };
            let mut forces = Forces::new(&level, &fabric, &fabric, Model::default(), &settings, &positions);
            let inertia = forces.pace.inertia.clone();
            let mut mode: Vec<Vector3> =
                (0..positions.len()).map(|k| Vector3::new((k as f64).sin(), (k as f64 * 1.7).cos(), 0.3)).collect();
            let mut squared = 0.0;
            let mut gradients = [vec![Vector3::zeros(); positions.len()], vec![Vector3::zeros(); positions.len()]];
            for _ in 0..60 {
                let size = dot(&mode, &mode).sqrt();
                let by = 1e-6 / size;
                for (gradient, sign) in gradients.iter_mut().zip([1.0, -1.0]) {
                    let at: Vec<Vector3> = positions.iter().zip(&mode).map(|(p, m)| p + m * (sign * by)).collect();
                    forces.gradient(&at, gradient);
                }
                let [ahead, behind] = &gradients;
                let next: Vec<Vector3> =
                    (0..mode.len()).map(|p| (ahead[p] - behind[p]) / (2.0 * by * inertia[p])).collect();
                squared = dot(&next, &next).sqrt() / size.max(f64::MIN_POSITIVE);
                mode = next.iter().map(|m| m / squared).collect();
            }
            let fastest = squared.sqrt();
            let product = fastest * forces.pace.step;
            assert!(product < 2.0, "{} at {resolution} m: {product} of 2", fabric.name);
            assert!(product > 1.6, "{} at {resolution} m: the step could be longer, {product} of 2", fabric.name);
        }
    }
}

/// Falls by `½ g t²` without drag, whatever the integrator. Viscosity takes nothing from a fall, and the midpoint rule
/// needs it: no step of that rule is stable for a vibration that nothing damps.
#[test]
fn all_integrators_let_cloth_fall_as_galilei_has_it() {
    let (level, positions) = sheet(0.08);
    let fabric = Fabric::default();
    for (name, integrator) in Integrator::ALL {
        let settings = Settings { integrator, drag: 0.0, ..Settings::default() };
        let mut simulation = Simulation::new(&level, &fabric, &fabric, Model::default(), &settings, positions.clone());
        // Masses that were added for longer steps fall more slowly by themselves.
        let course = simulation.frame(&mut no_body(), 0.2);
        let mean = |of: &[Vector3]| of.iter().map(|p| p.y).sum::<f64>() / of.len() as f64;
        let fallen = mean(&positions) - mean(&simulation.movement.positions);
        let expected = 0.5 * 9.80665 * 0.04;
        assert!((fallen / expected - 1.0).abs() < 0.03, "{name}: {fallen} m is not {expected}");
        assert!((course.elapsed - 0.2).abs() < 1e-12 && course.steps > 50, "{name}: {course:?}");
    }
}

/// Energies of a swinging sheet without any damping: the sum stays.
#[test]
fn integrators_of_higher_order_and_the_symplectic_one_keep_the_energy_of_a_swing() {
    let (level, positions) = sheet(0.08);
    let fabric = soft();
    let held = corners(&positions);
    for (name, integrator) in Integrator::ALL {
        let settings = Settings {
            integrator,
            drag: 0.0,
            damping: 0.0,
            added_mass: 0.0,
            implicit_step: 2e-4,
            ..Settings::default()
        };
        let mut simulation = Simulation::new(&level, &fabric, &fabric, Model::default(), &settings, positions.clone());
        simulation.pin(&held);
        let total = |simulation: &mut Simulation| {
            let Movement { positions, velocities } = simulation.movement.clone();
            simulation.forces.gradient(&positions, &mut vec![Vector3::zeros(); positions.len()]);
            let masses = simulation.forces.energy.masses().clone();
            let kinetic: f64 = velocities.iter().zip(&masses[..]).map(|(v, m)| 0.5 * m * v.norm_squared()).sum();
            (kinetic, kinetic + simulation.forces.terms.total())
        };
        let (_, before) = total(&mut simulation);
        simulation.frame(&mut no_body(), 0.25);
        let (kinetic, after) = total(&mut simulation);
        assert!(kinetic > 1e-3, "{name}: it swings");
        let lost = (before - after) / kinetic;
        // The implicit method damps by itself, and the midpoint rule gains a little.
        let allowed = if integrator == Integrator::Implicit { 0.3 } else { 0.02 };
        assert!(lost.abs() < allowed && lost > -0.02, "{name}: {lost} of the kinetic energy was lost");
    }
}

/// Cloth falls onto a ball that moves up to meet it; the number of threads shows nowhere, and a simulation that is
/// taken up between two frames goes on with the same bytes.
#[test]
fn the_number_of_threads_and_a_pause_change_no_byte() {
    let (vertices, triangles) = crate::body::shapes::sphere(Vector3::new(0.2, 0.8, 0.2), 0.15, 20);
    let (level, positions) = sheet(0.02);
    let fabric = Fabric::default();
    let settings = Settings::default();
    let start = |movement: Movement| {
        let mut simulation = Simulation::new(&level, &fabric, &fabric, Model::default(), &settings, positions.clone());
        simulation.movement = movement;
        simulation
    };
    let still = Movement { positions: positions.clone(), velocities: vec![Vector3::zeros(); positions.len()] };
    let lifted = |frame: u32| -> Vec<Vector3> {
        vertices.iter().map(|v| v + Vector3::new(0.01, 0.015, 0.0) * f64::from(frame)).collect()
    };
    let frames = |simulation: &mut Simulation, range: std::ops::Range<u32>| {
        let mut surface = Surface::new(&lifted(range.start), &triangles, settings.broad_phase);
        for frame in range {
            surface.move_to(&lifted(frame + 1), 0.04);
            let course = simulation.frame(&mut surface, 0.04);
            assert!(course.met.deepest < 1e-3, "{course:?}");
        }
    };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = start(still.clone());
            frames(&mut simulation, 0..6);
            simulation.movement
        })
    };
    let whole = run(1);
    assert_eq!(whole, run(2));
    let mut first = start(still.clone());
    frames(&mut first, 0..3);
    let mut second = start(first.movement.clone());
    second.remember(&first.remembered());
    frames(&mut second, 3..6);
    assert!(whole == second.movement, "a pause changed the result");
    let ball = Vector3::new(0.26, 0.89, 0.2);
    for p in &whole.positions {
        assert!((p - ball).norm() > 0.148, "{p} is in the ball");
    }
}

/// A flag across the wind takes up its pressure; one along it does not.
#[test]
fn wind_pushes_what_stands_across_it() {
    let (level, positions) = sheet(0.08);
    let fabric = Fabric::default();
    let push = |wind: Vector3| {
        let settings = Settings { wind, ..Settings::default() };
        let mut forces = Forces::new(&level, &fabric, &fabric, Model::default(), &settings, &positions);
        forces.energy.gravity = 0.0;
        let mut accelerations = vec![Vector3::zeros(); positions.len()];
        let still = vec![Vector3::zeros(); positions.len()];
        forces.accelerations(&positions, &still, &mut accelerations);
        accelerations.iter().zip(&forces.pace.inertia).map(|(a, i)| a * *i).sum::<Vector3>()
    };
    let across = push(Vector3::new(0.0, 5.0, 0.0));
    let expected = 0.5 * 1.2 * 1.2 * 0.16 * 25.0;
    assert!((across - Vector3::new(0.0, expected, 0.0)).norm() < 1e-3 * expected, "{across}");
    assert!(push(Vector3::new(5.0, 0.0, 0.0)).norm() < 1e-9);
}

/// A sheet that is let go sinks while it settles, but slowly, and stands still in the end.
#[test]
fn cloth_that_settles_is_never_fast() {
    let (level, positions) = sheet(0.04);
    let (fabric, settings) = (soft(), Settings::default());
    let mut simulation = Simulation::new(&level, &fabric, &fabric, Model::default(), &settings, positions.clone());
    simulation.pin(&corners(&positions));
    let course = simulation.settle(&mut no_body(), 0.2);
    assert!(course.largest_speed <= SETTLING_SPEED * (1.0 + 1e-12), "{course:?}");
    assert!(simulation.movement.velocities.iter().all(|v| *v == Vector3::zeros()));
    let sunk = positions.iter().zip(&simulation.movement.positions).map(|(a, b)| a.y - b.y).fold(0.0, f64::max);
    assert!(sunk > 5e-3, "{sunk}");
}

/// A ball bulges out by two millimetres between particles that are five centimetres apart: without looking between them it
/// would come through.
#[test]
fn a_ball_does_not_come_through_between_the_particles() {
    let (vertices, triangles) = crate::body::shapes::sphere(Vector3::new(0.2, 0.84, 0.2), 0.15, 20);
    let (level, positions) = sheet(0.05);
    let (fabric, settings) = (Fabric::default(), Settings::default());
    let mut simulation = Simulation::new(&level, &fabric, &fabric, Model::default(), &settings, positions);
    let mut surface = Surface::new(&vertices, &triangles, settings.broad_phase);
    for _ in 0..10 {
        simulation.frame(&mut surface, 0.04);
    }
    let at = |p: u32| simulation.movement.positions[p as usize];
    let mut near = 0;
    for edge in crate::geometry::EdgeTable::new(&level.particle_triangles()).edges {
        let middle = (at(edge.ends[0]) + at(edge.ends[1])) * 0.5;
        if let Some(place) = surface.nearest(middle, 0.01) {
            assert!(place.distance > 0.0, "{middle} is {} m in the ball", -place.distance);
            near += 1;
        }
    }
    assert!(near > 5, "only {near} edges lie on the ball");
}

/// A tube wider than the ball inside it would fall. Held by its upper edge it goes along with the ball, the same on any number
/// of threads and after a pause; a floor catches what is not held.
#[test]
fn a_skirt_that_is_held_goes_along_and_what_falls_lies_on_the_floor() {
    let (vertices, triangles) = crate::body::shapes::sphere(Vector3::new(0.0, 1.0, 0.0), 0.1, 20);
    let garment = Garment::build(&crate::pattern::shapes::tube(0.7, 0.2), &[0.02]).unwrap();
    let level = &garment.levels[0];
    let mut positions = vec![Vector3::zeros(); level.particle_count];
    for (rest, &p) in level.rest.iter().zip(&level.particle_of) {
        let (sin, cos) = (rest.x / 0.7 * std::f64::consts::TAU).sin_cos();
        positions[p as usize] = Vector3::new(0.1114 * sin, 0.85 + rest.y, 0.1114 * cos);
    }
    let waist: Vec<u32> = (0..positions.len() as u32).filter(|&p| positions[p as usize].y > 1.049).collect();
    let fabric = Fabric::default();
    let settings = Settings { floor: Some(0.8), ..Settings::default() };
    let lifted = |frame: u32| vertices.iter().map(|v| v + Vector3::y() * (0.02 * f64::from(frame))).collect::<Vec<_>>();
    let run = |threads: usize, waist: &[u32], frames: u32, pause: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let start = || {
                let mut simulation =
                    Simulation::new(level, &fabric, &fabric, Model::default(), &settings, positions.clone());
                simulation.hold_waist(&Surface::new(&lifted(0), &triangles, settings.broad_phase), waist);
                simulation
            };
            let mut simulation = start();
            let mut surface = Surface::new(&lifted(0), &triangles, settings.broad_phase);
            for frame in 0..frames {
                if frame == pause {
                    let (movement, remembered) = (simulation.movement.clone(), simulation.remembered());
                    simulation = start();
                    simulation.movement = movement;
                    simulation.remember(&remembered);
                }
                surface.move_to(&lifted(frame + 1), 0.04);
                simulation.frame(&mut surface, 0.04);
            }
            simulation.movement
        })
    };
    let held = run(1, &waist, 6, 99);
    for &p in &waist {
        let (start, now) = (positions[p as usize].y, held.positions[p as usize].y);
        assert!(now > start + 0.12 - 1e-3, "particle {p} sank from {start} to {now}");
    }
    assert!(held == run(2, &waist, 6, 3), "threads or a pause changed the result");
    let free = run(2, &[], 10, 99);
    let lowest = free.positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!(lowest > 0.8 && lowest < 0.803, "{lowest}");
    assert!(waist.iter().all(|&p| free.positions[p as usize].y < 1.01));
}

/// The limit has to know of contact. When what led into the body was taken back after all edges had been visited, the edges
/// next to it bore alone what a knee asked of a skirt.
#[test]
fn edges_share_what_contact_does_not_give_back() {
    let (level, positions) = sheet(0.02);
    let limit = 0.08;
    let stretched: Vec<Vector3> = positions.iter().map(|p| p * (1.0 + limit)).collect();
    let (count, step) = (positions.len(), 1e-3);
    // One side of the sheet is pushed away by a body, and may not come back.
    let pushed: Vec<bool> = positions.iter().map(|p| p.z > 0.4 - 1e-6).collect();
    let hold = |p: usize, v: &mut Vector3| v.z = v.z.max(if pushed[p] { 0.5 } else { f64::NEG_INFINITY });
    let strain = |within: bool| {
        let mut elastic = SuperElasticity::new(&level, Some(limit), &positions);
        let mut v = vec![Vector3::zeros(); count];
        v.iter_mut().enumerate().for_each(|(p, v)| hold(p, v));
        elastic.limit(&stretched, &mut v, &vec![1e-3; count], step, |p, v| {
            if within {
                hold(p, v)
            }
        });
        v.iter_mut().enumerate().for_each(|(p, v)| hold(p, v));
        let after: Vec<Vector3> = stretched.iter().zip(&v).map(|(x, v)| x + v * step).collect();
        let (ends, strain) = elastic.most_stretched(&after).unwrap();
        assert_eq!(strain, elastic.largest_strain(&after));
        assert!(within || ends.iter().any(|&p| pushed[p as usize]));
        strain - limit
    };
    let (within, afterwards) = (strain(true), strain(false));
    assert!(afterwards > 0.01 && within < 0.3 * afterwards, "{within} within, {afterwards} afterwards");
}
