//! Garments that pass through one another are brought into their order: inner ones inside outer ones.
//!
//! Where an inner sleeve is too wide for an outer one it sticks out of it. Layer by layer is pushed to its side of the
//! others by planes at the nearest points of these: what is inside of an inner garment outwards, what is outside of an outer
//! one inwards. Both give way, so that a wide sleeve folds into a narrow one. Openings count for nothing: a shirt
//! may hang out of a jacket. It ends when no two triangles of different garments cross, by the exact test.

use super::outfit::Garments;
use super::problem::Relaxation;
use super::relaxing::problem;
use super::{Scene, Settings};
use crate::assess::cloth_intersections;
use crate::body::{Body, DistanceField, Enclosure};
use crate::energy::Wall;
use crate::garment::{Garment, Level};
use crate::geometry::{EdgeTable, Vector3};
use crate::minimize::{Minimizer, Settings as Steps};

/// Rounds of looking where the others are, and moving.
const MOST_ROUNDS: usize = 80;
/// Rounds without a better state than the best until then, after which that has to do.
const PATIENCE: usize = 40;
/// Evaluations of a round, for each garment: what moves far between two looks at the others goes through them.
const EVALUATIONS_PER_ROUND: usize = 5;
/// How far a layer is to be from the next, in resolutions: so far its flat triangles miss what is between the
/// particles of the other where both are bent around a limb.
const MARGIN: f64 = 0.12;
/// By so much it grows in each round in which they still cross, as a share of itself.
const GROWTH: f64 = 0.05;
/// Cloth is not sought farther than this from a particle, m.
const REACH: f64 = 0.15;
/// Only what is so near to where garments cross is pushed, m: elsewhere they are in their order.
const NEAR: f64 = 0.12;
/// Cloth on its side is held there where it is no farther than this beyond the margin, m.
const SLACK: f64 = 0.02;
/// Stiffness of a plane over that of contact with the body.
const STIFFNESS: f64 = 0.5;

/// One garment on its way.
struct Layer<'a> {
    scene: &'a Scene<'a>,
    problem: Relaxation<'a>,
    minimizer: Minimizer,
    triangles: Vec<[u32; 3]>,
    /// Each particle, and the middle of each edge.
    samples: Vec<[u32; 2]>,
    positions: Vec<Vector3>,
}

impl<'a> Layer<'a> {
    fn new(scene: &'a Scene<'a>, level: usize, positions: Vec<Vector3>) -> Self {
        let cloth = &scene.garment.levels[level];
        let triangles = cloth.particle_triangles();
        let edges = EdgeTable::new(&triangles).edges;
        let particles = (0..cloth.particle_count as u32).map(|p| [p, p]);
        Self {
            scene,
            problem: problem(scene, level, None, &positions),
            minimizer: Minimizer::new(scene.settings.minimizer, positions.len()),
            samples: particles.chain(edges.iter().map(|edge| edge.ends)).collect(),
            triangles,
            positions,
        }
    }

    fn at(&self, [a, b]: [u32; 2]) -> Vector3 {
        (self.positions[a as usize] + self.positions[b as usize]) * 0.5
    }

    /// Planes between this layer and another one, which has to be inside of it or around it. Garments cross at `places`.
    fn walls(&self, places: &[Vector3], other: &Enclosure, is_inner: bool, margin: f64) -> Vec<Wall> {
        let is_near = |at: Vector3| places.iter().any(|place| (place - at).norm_squared() < NEAR * NEAR);
        let stiffness = STIFFNESS * self.scene.fabric.contact_stiffness();
        let wall = |&particles: &[u32; 2]| {
            let at = self.at(particles);
            let nearest = other.nearest_cloth(at, REACH)?;
            let (away, inside) = (at - nearest, other.contains(at));
            let right = inside != is_inner;
            let matters = if right { away.norm() <= margin + SLACK } else { is_near(at) };
            if !matters {
                return None;
            }
            let outward = away.try_normalize(1e-12)? * if inside { -1.0 } else { 1.0 };
            let normal = if is_inner { outward } else { -outward };
            Some(Wall { particles, point: nearest + normal * margin, normal, stiffness })
        };
        self.samples.iter().filter_map(wall).collect()
    }
}

/// The state with the fewest crossings.
struct Best {
    crossing: usize,
    round: usize,
    positions: Vec<Vector3>,
}

/// Brings garments on a level into their order, innermost first. The positions are those of all, one garment
/// after the other, m, world. Returns the evaluations that it took.
pub fn bring_into_order(
    (garments, built): (&Garments, &[Garment]),
    (body, field): (&Body, &DistanceField),
    settings: &Settings,
    level: usize,
    positions: &mut [Vector3],
) -> usize {
    let levels: Vec<&Level> = built.iter().map(|garment| &garment.levels[level]).collect();
    let all = Level::together(&levels);
    let garment_of: Vec<u32> =
        (0..).zip(&levels).flat_map(|(k, level)| std::iter::repeat_n(k, level.triangles.len())).collect();
    let scene = |k: usize| {
        let (pattern, fabric) = garments[k];
        let (garment, cut) = (&built[k], fabric.into());
        Scene { pattern, fabric, cut, garment, garments: 1, body, field, settings }
    };
    let scenes: Vec<Scene> = (0..garments.len()).map(scene).collect();
    let mut rest = &*positions;
    let mut layers: Vec<Layer> = Vec::new();
    for scene in &scenes {
        let (own, others) = rest.split_at(scene.garment.levels[level].particle_count);
        layers.push(Layer::new(scene, level, own.to_vec()));
        rest = others;
    }
    let mut evaluations = 0;
    let mut best = Best { crossing: usize::MAX, round: 0, positions: Vec::new() };
    for round in 0..MOST_ROUNDS {
        let mut crossing = cloth_intersections(&all, positions);
        crossing.retain(|&[t, u]| garment_of[t as usize] != garment_of[u as usize]);
        if crossing.len() < best.crossing {
            best = Best { crossing: crossing.len(), round, positions: positions.to_vec() };
        }
        if crossing.is_empty() || round > best.round + PATIENCE {
            break;
        }
        let middle = |t: u32| all.particles(t as usize).iter().map(|&p| positions[p as usize]).sum::<Vector3>() / 3.0;
        let places: Vec<Vector3> = crossing.iter().flatten().map(|&t| middle(t)).collect();
        for k in 0..layers.len() {
            let margin = MARGIN * levels[k].resolution * (1.0 + GROWTH * round as f64);
            let mut walls = Vec::new();
            for (j, other) in layers.iter().enumerate().filter(|(j, _)| *j != k) {
                let enclosure = Enclosure::new(&other.positions, &other.triangles);
                walls.extend(layers[k].walls(&places, &enclosure, j < k, margin));
            }
            let layer = &mut layers[k];
            layer.problem.energy.walls = walls;
            let steps = Steps { evaluations: EVALUATIONS_PER_ROUND, ..settings.steps(levels[k]) };
            let Layer { problem, minimizer, positions, .. } = layer;
            evaluations += minimizer.run(problem, positions, &steps, |_| false).2;
        }
        let moved = layers.iter().flat_map(|layer| &layer.positions);
        positions.iter_mut().zip(moved).for_each(|(position, to)| *position = *to);
    }
    positions.copy_from_slice(&best.positions);
    evaluations
}
