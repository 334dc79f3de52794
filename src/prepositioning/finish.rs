//! The end of the finest level: nobody is left inside the clearance, and no part of the body comes
//! through between the particles.

use super::Scene;
use super::problem::Relaxation;
use crate::assess::body_intersections;
use crate::contact::sag;
use crate::geometry::Vector3;
use crate::minimize::{Minimizer, Problem, Settings as Steps};

/// Rounds of holding, looking and widening.
const MOST_ROUNDS: usize = 16;
/// How much farther the particles of a pierced triangle keep after each round, m, at least.
const LEAST_WIDENING: f64 = 4e-4;
/// The same for large triangles, as a share of how far an edge of theirs cuts into a limb.
const WIDENING_SHARE: f64 = 0.3;
/// Evaluations that smooth what a round has moved.
const EVALUATIONS_PER_ROUND: usize = 15;

/// What clearing the body took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clearing {
    pub moved: bool,
    pub evaluations: usize,
}

/// Takes every particle out to its clearance and every triangle out of the body.
pub fn clear_body(
    scene: &Scene,
    level: usize,
    problem: &mut Relaxation,
    minimizer: &mut Minimizer,
    positions: &mut Vec<Vector3>,
) -> Clearing {
    let cloth = &scene.garment.levels[level];
    let steps = Steps { evaluations: EVALUATIONS_PER_ROUND, ..scene.settings.steps(cloth) };
    let widening = LEAST_WIDENING.max(WIDENING_SHARE * sag(cloth.resolution));
    let mut clearing = Clearing::default();
    for _ in 0..MOST_ROUNDS {
        clearing.moved |= hold(problem, positions);
        let pierced = body_intersections(cloth, positions, scene.body);
        if pierced.is_empty() {
            return clearing;
        }
        let mut particles: Vec<u32> = pierced.iter().flat_map(|&[t, _]| cloth.particles(t as usize)).collect();
        particles.sort_unstable();
        particles.dedup();
        problem.body.widen(particles, widening);
        hold(problem, positions);
        clearing.evaluations += minimizer.run(problem, positions, &steps, |_| false).2;
        problem.evaluate(positions, &mut vec![Vector3::zeros(); positions.len()]);
        problem.body.correct(positions);
        clearing.moved = true;
    }
    hold(problem, positions);
    clearing
}

/// Is no particle in the body, and no triangle across its surface?
pub fn is_clear(scene: &Scene, level: usize, positions: &[Vector3]) -> bool {
    body_intersections(&scene.garment.levels[level], positions, scene.body).is_empty()
        && !positions.iter().any(|&p| scene.body.contains(p))
}

/// Moves particles out to their clearance, without passing through other cloth. Returns whether any
/// was moved.
fn hold(problem: &mut Relaxation, positions: &mut [Vector3]) -> bool {
    let mut moves = problem.body.hold(positions);
    problem.cloth.limit(positions, &mut moves);
    positions.iter_mut().zip(&moves).for_each(|(p, by)| *p += by);
    moves.iter().any(|by| *by != Vector3::zeros())
}
