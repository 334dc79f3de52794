//! The same input gives the same bytes, on any number of threads.

mod support;

use support::bodies::Mesh;
use support::patterns::sheet;
use toile::body::{Body, DistanceField};
use toile::contact::{BodyContact, BodyContactSettings, SelfContact, SelfContactSettings};
use toile::energy::{Energy, Model};
use toile::garment::Level;
use toile::geometry::Vector3;
use toile::minimize::{CHUNK, ConjugateGradient, Problem, Settings, flattened};
use toile::pattern::Fabric;
use toile::prepositioning::Relaxation;

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|n| n.to_bits()).collect()
}

/// Values, gradients and positions of some evaluations and steps of a cloth that falls on a body.
fn run(body: &Body, level: &Level) -> (Vec<u64>, usize) {
    let field = DistanceField::new(body, 0.02, 0.04);
    let start: Vec<Vector3> =
        level.rest.iter().map(|p| Vector3::new(p.x - 0.5, 1.751 + 0.004 * (90.0 * p.x).sin(), p.y - 0.5)).collect();
    let contact = BodyContactSettings { clearance: 0.003, stiffness: 500.0, friction: 0.3 };
    let contact = BodyContact::new(body, &field, level, contact);
    let apart = SelfContactSettings { clearance: 0.001, stiffness: 200.0, reach: 0.006 };
    let mut cloth = SelfContact::new(level, (0..level.particle_count as u32).collect(), apart);
    cloth.rebuild(&start);
    let mut problem = Relaxation::new(Energy::new(level, &Fabric::default(), Model::default()), contact, cloth);
    let mut gradient = vec![Vector3::zeros(); start.len()];
    let value = problem.evaluate(&start, &mut gradient);
    let curvature = problem.curvature(&start, &gradient);
    problem.body.update_anchors(&start);
    let mut positions = start;
    let steps = Settings { evaluations: 12, largest_move: 0.002, restart_after: 50 };
    let (_, last, evaluations) =
        ConjugateGradient::new(positions.len()).run(&mut problem, &mut positions, &steps, |_| false);
    let mut held = positions.clone();
    problem.body.hold(&positions, &mut vec![f64::NEG_INFINITY; positions.len()], &mut held);
    let mut numbers = vec![value, curvature, last];
    numbers.extend([gradient, positions, held].iter().flat_map(|v| flattened(v)));
    (bits(&numbers), evaluations)
}

#[test]
fn a_result_has_the_same_bytes_on_one_two_and_three_threads() {
    let body = Mesh::figure().body();
    let level = sheet(1.0, 1.0, 0.0095);
    assert!(level.particle_count > 5 * CHUNK, "{} particles do not fill enough chunks", level.particle_count);
    let one = on_threads(1, || run(&body, &level));
    for threads in [2, 3] {
        assert!(one == on_threads(threads, || run(&body, &level)), "{threads} threads give other bytes than one");
    }
    assert!(one == on_threads(2, || run(&body, &level)), "a second run gives other bytes than the first");
}
