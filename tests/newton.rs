//! Newton's method: second derivatives against differences, and where it ends.

mod support;

use support::bodies::Mesh;
use support::patterns::{sheet, two_sheets};
use toile::body::{Body, DistanceField};
use toile::contact::{BodyContact, BodyContactSettings, SelfContact, SelfContactSettings};
use toile::energy::{Energy, Model};
use toile::garment::Level;
use toile::geometry::Vector3;
use toile::minimize::{Cholesky, ConjugateGradient, Newton, Problem, SecondOrder, Settings, Termination, dot};
use toile::pattern::{Directional, Fabric};
use toile::prepositioning::{Hessian, Relaxation, Residual};

/// The top of the ball that the cloth lies on, m.
const TOP: f64 = 1.75;

/// Cloth against a ball and itself, with friction, as it was evaluated at `start`.
fn relaxation<'a>(body: &'a Body, field: &'a DistanceField, level: &Level, start: &[Vector3]) -> Relaxation<'a> {
    let settings = BodyContactSettings { clearance: 0.008, stiffness: 300.0, friction: 0.5 };
    let contact = BodyContact::new(body, field, level, settings);
    let apart = SelfContactSettings { clearance: 0.004, stiffness: 100.0, reach: 0.015 };
    let mut cloth = SelfContact::new(level, (0..level.particle_count as u32).collect(), apart);
    cloth.rebuild(start);
    let fabric = Fabric { stretch: Directional { warp: 300.0, weft: 200.0 }, shear: 50.0, ..Fabric::default() };
    let mut problem = Relaxation::new(Energy::new(level, &fabric, Model::default()), contact, cloth);
    problem.evaluate(start, &mut vec![Vector3::zeros(); start.len()]);
    problem.body.update_anchors(start);
    problem.hessian = Some(Hessian::new(level, &fabric, Model::default()));
    problem
}

fn noise(count: usize, size: f64) -> Vec<Vector3> {
    let wave = |k: usize, step: f64| (k as f64 * step + 1.0).sin() * size;
    (0..count).map(|k| Vector3::new(wave(k, 12.9898), wave(k, 78.233), wave(k, 37.719))).collect()
}

fn moved(positions: &[Vector3], along: &[Vector3], by: f64) -> Vec<Vector3> {
    positions.iter().zip(along).map(|(p, d)| p + d * by).collect()
}

/// Two sheets above each other on top of the ball, rumpled: every kind of contact is there.
fn rumpled(level: &Level) -> Vec<Vector3> {
    let mut positions = vec![Vector3::zeros(); level.particle_count];
    for (panel, range) in level.panels.iter().enumerate() {
        for k in range.points.clone() {
            let rest = level.rest[k];
            let height = TOP + 0.007 + 0.003 * panel as f64;
            positions[level.particle_of[k] as usize] = Vector3::new(rest.x - 0.08, height, rest.y - 0.08);
        }
    }
    moved(&positions, &noise(positions.len(), 0.0006), 1.0)
}

#[test]
fn the_hessian_is_the_derivative_of_the_gradient() {
    let (body, field) = ball();
    let level = two_sheets(0.16, 0.02);
    let start = rumpled(&level);
    let mut problem = relaxation(&body, &field, &level, &start);
    // Off the anchors, some beyond the limit of friction.
    let at = moved(&start, &noise(start.len(), 0.0002), -1.0);
    let mut gradient = vec![Vector3::zeros(); at.len()];
    assert!(problem.evaluate(&at, &mut gradient) > 0.0);
    problem.linearize(&at);
    let (mut product, mut definite) = (gradient.clone(), gradient.clone());
    let direction = noise(at.len(), 1.0).into_iter().rev().collect::<Vec<_>>();
    problem.hessian_times(&direction, &mut product);
    let mut slope = |by: f64| {
        let mut gradient = vec![Vector3::zeros(); at.len()];
        problem.evaluate(&moved(&at, &direction, by), &mut gradient);
        gradient
    };
    let step = 1e-9;
    let (forward, back) = (slope(step), slope(-step));
    let scale = product.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let off: Vec<f64> =
        (0..at.len()).map(|p| ((forward[p] - back[p]) / (2.0 * step) - product[p]).norm() / scale).collect();
    // The field's curvature is not continuous where cells of the grid meet.
    let wrong = off.iter().filter(|&&o| o > 1e-4).count();
    assert!(
        wrong * 50 < at.len(),
        "{wrong} of {} rows are wrong, by up to {:?}",
        at.len(),
        off.iter().cloned().fold(0.0, f64::max)
    );

    problem.evaluate(&at, &mut gradient);
    problem.linearize(&at);
    assert!(Cholesky::new(problem.near_matrix().pattern(), &at).factorize(problem.near_matrix()));
    problem.keep_definite_part();
    for turn in 0..20 {
        let direction: Vec<Vector3> = noise(at.len() + turn, 1.0).split_off(turn);
        problem.hessian_times(&direction, &mut definite);
        assert!(dot(&direction, &definite) > 0.0);
    }
}

#[test]
fn cloth_on_a_ball_comes_to_rest_to_a_millionth_of_its_weight() {
    let (body, field) = ball();
    let level = sheet(0.24, 0.24, 0.02);
    let flat: Vec<Vector3> = level.rest.iter().map(|p| Vector3::new(p.x - 0.12, TOP + 0.008, p.y - 0.12)).collect();
    let mut problem = relaxation(&body, &field, &level, &flat);
    let mut positions = flat;
    let settings = |evaluations| Settings { evaluations, largest_move: 0.003, restart_after: 100 };
    let count = positions.len();
    ConjugateGradient::new(count).run(&mut problem, &mut positions, &settings(200), |_| false);
    problem.evaluate(&positions, &mut vec![Vector3::zeros(); count]);
    problem.body.update_anchors(&positions);
    let masses = problem.energy.masses().to_vec();
    let mut residuals = Vec::new();
    let mut values = Vec::new();
    let (termination, _, evaluations) =
        Newton::new(count).run(&mut problem, &mut positions, &settings(150), |iterate| {
            residuals.push(Residual::of(iterate.gradient, &masses).rms);
            values.push(iterate.value);
            residuals[residuals.len() - 1] < 1e-6
        });
    assert_eq!(termination, Termination::Converged, "{residuals:?}");
    assert!(values.windows(2).all(|w| w[1] <= w[0] + 1e-12 * w[0].abs()), "{values:?}");
    assert!(evaluations < 150 && residuals.len() > 2);
}

fn ball() -> (Body, DistanceField) {
    let body = Mesh::ball([0.0, TOP - 0.6, 0.0], 0.6, 40).body();
    let field = DistanceField::new(&body, 0.01, 0.03);
    (body, field)
}
