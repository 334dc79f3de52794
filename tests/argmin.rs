//! An independent optimizer as a baseline: argmin's L-BFGS on a relaxation must find what our own
//! conjugate gradients find.

mod support;

use argmin::core::{Executor, State, TerminationReason, TerminationStatus};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use support::bodies::Mesh;
use support::patterns::sheet;
use toile::body::{Body, DistanceField};
use toile::contact::{BodyContact, BodyContactSettings, SelfContact, SelfContactSettings};
use toile::energy::{Energy, Model};
use toile::garment::Level;
use toile::geometry::Vector3;
use toile::minimize::{ArgminDoor, ConjugateGradient, Problem, Settings, flattened, unflattened};
use toile::pattern::{Directional, Fabric};
use toile::prepositioning::Relaxation;

/// The top of the ball that the cloth lies on, m.
const TOP: f64 = 1.75;
const RADIUS: f64 = 0.6;

/// A square of soft cloth, so heavy that all of it stays on the ball, to which it sticks by friction:
/// what comes loose and touches again makes the energy rough, and its minima many.
fn relaxation<'a>(body: &'a Body, field: &'a DistanceField, level: &Level, start: &[Vector3]) -> Relaxation<'a> {
    let settings = BodyContactSettings { clearance: 0.008, stiffness: 30.0, friction: 0.8 };
    let contact = BodyContact::new(body, field, level, settings);
    let apart = SelfContactSettings { clearance: 0.002, stiffness: 100.0, reach: 0.02 };
    let mut cloth = SelfContact::new(level, (0..level.particle_count as u32).collect(), apart);
    cloth.rebuild(start);
    let fabric = Fabric { stretch: Directional { warp: 300.0, weft: 200.0 }, shear: 50.0, ..Fabric::default() };
    let mut energy = Energy::new(level, &fabric, Model::default());
    energy.gravity = 200.0;
    let mut problem = Relaxation::new(energy, contact, cloth);
    problem.evaluate(start, &mut vec![Vector3::zeros(); start.len()]);
    problem.body.update_anchors(start);
    problem
}

#[test]
fn argmin_finds_the_energy_that_conjugate_gradients_find() {
    let body = Mesh::ball([0.0, TOP - RADIUS, 0.0], RADIUS, 40).body();
    let field = DistanceField::new(&body, 0.01, 0.03);
    let level = sheet(0.24, 0.24, 0.04);
    // Stretched one way, compressed the other, and rolled onto the ball a little inside its clearance.
    let start: Vec<Vector3> = level
        .rest
        .iter()
        .map(|p| {
            let (x, z) = (1.04 * (p.x - 0.12), 0.97 * (p.y - 0.12));
            let (sin, cos) = (x.hypot(z) / RADIUS).sin_cos();
            let around = if sin > 0.0 { sin / x.hypot(z) } else { 1.0 / RADIUS };
            Vector3::new(x * around, cos, z * around) * (RADIUS + 0.0065) + Vector3::y() * (TOP - RADIUS)
        })
        .collect();

    let mut ours = relaxation(&body, &field, &level, &start);
    let mut positions = start.clone();
    let steps = Settings { evaluations: 20_000, largest_move: 0.01, restart_after: 200 };
    let small = |gradient: &[Vector3]| gradient.iter().all(|g| g.norm() < 1e-5);
    let (termination, energy, evaluations) =
        ConjugateGradient::new(start.len()).run(&mut ours, &mut positions, &steps, |i| small(i.gradient));

    let door = ArgminDoor::new(relaxation(&body, &field, &level, &start));
    let solver: LBFGS<_, Vec<f64>, Vec<f64>, f64> =
        LBFGS::new(MoreThuenteLineSearch::new(), 20).with_tolerance_grad(1e-5).unwrap();
    let run =
        Executor::new(door, solver).configure(|state| state.param(flattened(&start)).max_iters(5000)).run().unwrap();
    let theirs = run.state().get_best_cost();
    let door = run.problem().problem.as_ref().unwrap();
    eprintln!("ours {energy} J, {termination:?} after {evaluations}; argmin {theirs} J after {}", door.evaluations());
    let reason = run.state().get_termination_status();
    assert_ne!(reason, &TerminationStatus::Terminated(TerminationReason::MaxItersReached));

    let mut gradient = vec![Vector3::zeros(); start.len()];
    let before = ours.evaluate(&start, &mut gradient);
    assert!(before - energy > 1e-3, "there was something to minimize: {before} J became {energy} J");
    let best = unflattened(run.state().get_best_param().unwrap());
    assert!((theirs - energy).abs() < 1e-6 * (before - energy), "ours {energy} J, argmin {theirs} J");
    let apart = best.iter().zip(&positions).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(apart < 1e-4, "the two minima are {} mm apart", apart * 1e3);
}
