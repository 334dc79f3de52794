//! The end of the finest level: no part of the cloth is left inside the clearance, neither particles nor what
//! lies between them.

use super::Scene;
use super::problem::Relaxation;
use super::smoothing::{Neighbours, smooth};
use crate::assess::{CLEARANCE_TOLERANCE, ClothCrossings, body_intersections, crossed, near_triangles};
use crate::contact::{DistanceBounds, below, sag};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::{Minimizer, Problem, Settings as Steps};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Rounds of holding, looking and widening.
const MOST_ROUNDS: usize = 16;
/// Rounds after those in which nothing is smoothed any more, so that nothing that is clear comes near again.
const LAST_ROUNDS: usize = 8;
/// How much farther the particles of a pierced triangle keep after each round, m, at least.
const LEAST_WIDENING: f64 = 4e-4;
/// The same for large triangles, as a share of how far an edge of theirs cuts into a limb.
const WIDENING_SHARE: f64 = 0.3;
/// Evaluations that smooth what a round has moved.
const EVALUATIONS_PER_ROUND: usize = 15;
/// The same where nothing crosses the body and only fractions of a millimetre are missing, or where it is rare.
const EVALUATIONS_PER_GENTLE_ROUND: usize = 5;
/// The share of particles that are moved below which a round is gentle, whatever they have to do.
const RARE: f64 = 0.01;
/// The share of particles below which those that miss less than this, m, are moved out and no more.
const FEW: f64 = 3e-3;
const SLIGHTLY: f64 = 2e-4;

/// What clearing the body took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clearing {
    pub moved: bool,
    pub evaluations: usize,
}

/// Takes all of the cloth out to its clearance: particles, and whatever of the body comes nearer between them.
pub fn clear_body(
    scene: &Scene,
    level: usize,
    problem: &mut Relaxation,
    minimizer: &mut Minimizer,
    positions: &mut Vec<Vector3>,
) -> Clearing {
    let cloth = &scene.garment.levels[level];
    let steps = Steps { evaluations: EVALUATIONS_PER_ROUND, ..scene.settings.steps(cloth) };
    let gentle_steps = Steps { evaluations: EVALUATIONS_PER_GENTLE_ROUND, ..steps };
    let widening = LEAST_WIDENING.max(WIDENING_SHARE * sag(cloth.resolution));
    // Halfway between what is asked for and what is let pass.
    let enough = scene.settings.clearance - 0.5 * CLEARANCE_TOLERANCE;
    let mut bounds = DistanceBounds::unknown(cloth, positions);
    let mut clearing = Clearing::default();
    for round in 0..MOST_ROUNDS + LAST_ROUNDS {
        clearing.moved |= hold(cloth, problem, &mut bounds, minimizer, positions);
        let near = too_near(scene, level, &mut bounds, positions);
        if near.is_empty() {
            return clearing;
        }
        // By particle, what is missing most of the triangles around it.
        let (mut missing, mut pierced) = (BTreeMap::<u32, f64>::new(), BTreeSet::new());
        for (t, distance) in near {
            for p in cloth.particles(t as usize) {
                if distance > 0.0 {
                    let most = missing.entry(p).or_default();
                    *most = most.max(enough - distance);
                } else {
                    pierced.insert(p);
                }
            }
        }
        missing.retain(|p, _| !pierced.contains(p));
        // Layers have to give way to each other before they are pushed again.
        let rare = scene.garments == 1 && ((missing.len() + pierced.len()) as f64) < RARE * positions.len() as f64;
        let gentle = pierced.is_empty() || rare;
        let few = pierced.is_empty()
            && (missing.len() as f64) < FEW * positions.len() as f64
            && missing.values().all(|&missing| missing < SLIGHTLY);
        problem.body.keep_farther(missing);
        problem.body.widen(pierced, widening);
        clearing.moved = true;
        hold(cloth, problem, &mut bounds, minimizer, positions);
        // Moving a few by a hair across the cloth stretches nothing that would have to be smoothed.
        if few || round >= MOST_ROUNDS {
            continue;
        }
        let steps = if gentle { &gentle_steps } else { &steps };
        clearing.evaluations += minimizer.run(problem, positions, steps, |_| false).2;
        problem.evaluate(positions, minimizer.spare(positions.len()));
        problem.body.correct(positions);
    }
    hold(cloth, problem, &mut bounds, minimizer, positions);
    clearing
}

/// Lets particles that keep farther from the body than all triangles around them need to come nearer again: clearing
/// widens in steps, and what was in its way may have moved since.
pub fn let_nearer(scene: &Scene, level: usize, problem: &mut Relaxation, positions: &[Vector3]) {
    let cloth = &scene.garment.levels[level];
    let needed = scene.settings.clearance - 0.5 * CLEARANCE_TOLERANCE;
    let mut spare = vec![MOST_NEARER; positions.len()];
    for (t, distance) in near_triangles(cloth, positions, scene.body, needed + MOST_NEARER) {
        for p in cloth.particles(t as usize) {
            let least = &mut spare[p as usize];
            *least = least.min((distance - needed).max(0.0));
        }
    }
    problem.body.let_nearer((0..).zip(spare));
}

/// By how much a particle comes nearer at once, at most, m.
const MOST_NEARER: f64 = 3e-3;

/// Parts layers that are pressed together to less than half their thickness, by making their contact stiffer; what
/// that presses into the body is taken out again. Returns the evaluations that it took.
pub fn part_layers(
    scene: &Scene,
    level: usize,
    problem: &mut Relaxation,
    minimizer: &mut Minimizer,
    positions: &mut Vec<Vector3>,
) -> usize {
    let steps = Steps { evaluations: EVALUATIONS_PER_ROUND, ..scene.settings.steps(&scene.garment.levels[level]) };
    let mut evaluations = 0;
    for _ in 0..MOST_PARTINGS {
        problem.evaluate(positions, minimizer.spare(positions.len()));
        if problem.cloth.too_near(0.5 * scene.fabric.thickness) == 0 {
            break;
        }
        problem.cloth.settings.stiffness *= STIFFENING;
        evaluations += minimizer.run(problem, positions, &steps, |_| false).2;
        evaluations += clear_body(scene, level, problem, minimizer, positions).evaluations;
    }
    evaluations
}

/// How often layers are parted, and how much stiffer their contact is each time.
const MOST_PARTINGS: usize = 6;
const STIFFENING: f64 = 3.0;

/// Takes cloth out of cloth that slipped through it all the same, and out of the body what that pressed into it. Returns
/// the evaluations that it took, and whether nothing crosses now.
pub fn part_crossings(
    scene: &Scene,
    level: usize,
    problem: &mut Relaxation,
    minimizer: &mut Minimizer,
    positions: &mut Vec<Vector3>,
) -> (usize, bool) {
    let cloth = &scene.garment.levels[level];
    let steps = Steps { evaluations: EVALUATIONS_PER_MENDING, ..scene.settings.steps(cloth) };
    let (mut neighbours, mut evaluations) = (None, 0);
    // The search needs a tenth of all memory, and is nearly always the end.
    minimizer.resize(0);
    for _ in 0..MOST_MENDINGS {
        let mut crossings = ClothCrossings::new(cloth, positions);
        if crossings.pairs().is_empty() {
            return (evaluations, true);
        }
        let neighbours = neighbours.get_or_insert_with(|| {
            minimizer.resize(positions.len());
            Neighbours::of(cloth)
        });
        smooth(cloth, neighbours, &mut crossings, positions);
        // What is near, and on which side, is another thing now.
        problem.cloth.rebuild(positions);
        evaluations += minimizer.run(problem, positions, &steps, |_| false).2;
        problem.evaluate(positions, minimizer.spare(positions.len()));
        problem.body.correct(positions);
        evaluations += clear_body(scene, level, problem, minimizer, positions).evaluations;
    }
    (evaluations, false)
}

/// How often cloth that crosses cloth is smoothed and taken out of the body.
const MOST_MENDINGS: usize = 4;
/// Evaluations in which what was smoothed finds its length again.
const EVALUATIONS_PER_MENDING: usize = 40;

/// Triangles nearer to the body than the clearance, in order, with their distances, m: zero for those that cross it. Those
/// that are known to be farther away are not measured.
fn too_near(scene: &Scene, level: usize, bounds: &mut DistanceBounds, positions: &[Vector3]) -> Vec<(u32, f64)> {
    let cloth = &scene.garment.levels[level];
    let within = scene.settings.clearance - CLEARANCE_TOLERANCE;
    let look = |(t, bound): (usize, &mut f32)| {
        if f64::from(*bound) > within {
            return None;
        }
        let corners = cloth.particles(t).map(|p| positions[p as usize]);
        let measured = scene.body.distance_to_triangle(corners, within + LOOKED_BEYOND);
        // What is hidden in the body keeps nothing at a distance, but it is not to be crossed.
        let crosses = measured == Some(0.0) || !crossed(corners, scene.body).is_empty();
        let distance = if crosses { 0.0 } else { measured.unwrap_or(within + LOOKED_BEYOND) };
        // From outside nothing comes to what is hidden but through the skin; from inside it does.
        let outside = scene.field.distance(corners[0]) > 0.0;
        *bound = if outside { below(distance) } else { 0.0 };
        (distance <= within).then_some((t as u32, distance))
    };
    bounds.follow(cloth, positions);
    bounds.triangles.par_iter_mut().enumerate().with_min_len(512).filter_map(look).collect()
}

/// How far beyond the clearance distances of triangles are measured, m: who keeps so much need not be looked at again
/// before it has moved by that.
const LOOKED_BEYOND: f64 = 5e-4;

/// Is no particle in the body, and no triangle across its surface?
pub fn is_clear(scene: &Scene, level: usize, positions: &[Vector3]) -> bool {
    body_intersections(&scene.garment.levels[level], positions, scene.body).is_empty()
        && !positions.iter().any(|&p| scene.body.contains(p))
}

/// Moves particles out to their clearance, without passing through other cloth. Returns whether any
/// was moved.
fn hold(
    cloth: &Level,
    problem: &mut Relaxation,
    bounds: &mut DistanceBounds,
    minimizer: &mut Minimizer,
    positions: &mut [Vector3],
) -> bool {
    bounds.follow(cloth, positions);
    let moves = minimizer.spare(positions.len());
    problem.body.hold(positions, &mut bounds.particles, moves);
    if moves.iter().all(|by| *by == Vector3::zeros()) {
        return false;
    }
    problem.cloth.limit(positions, moves);
    positions.iter_mut().zip(moves.iter()).for_each(|(p, by)| *p += by);
    moves.iter().any(|by| *by != Vector3::zeros())
}
