//! Contact of the cloth with itself, for vertices against faces and edges against edges.
//!
//! The paper keeps particles apart from particles; edges then cross between them unless the
//! clearance exceeds `h/√3`. We measure the distances of vertices to faces and of edges to edges,
//! push apart what is nearer than the clearance, and bound how the sides of a pair may move against
//! each other (`bounds.rs`).
//!
//! Pairs nearer than a reach are followed. They are those of an *origin*: of where each particle was
//! when its surroundings were last searched. Before a particle strays from there by a share of the
//! reach, it and others that have moved get new origins, and only their surroundings are searched.

mod bounds;
mod hessian;
mod pairs;
mod repulsion;

use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::CHUNK;
use crate::pattern::Fabric;
pub use hessian::PairHessian;
use pairs::{Kind, Pair, PairFinder, Span};
use rayon::prelude::*;
use repulsion::repulsion;

/// How the cloth is held clear of itself.
#[derive(Clone, Copy, Debug)]
pub struct SelfContactSettings {
    /// Distance to be kept, m; less where edges are short.
    pub clearance: f64,
    /// Stiffness of each pair, N/m.
    pub stiffness: f64,
    /// Pairs nearer than this are followed, m; more than the clearance, less than an edge.
    pub reach: f64,
}

/// Clearance between layers of cloth, in resolutions, where the fabric is thinner.
const CLEARANCE: f64 = 0.1;
/// Stiffness of cloth against cloth over that of cloth against the body.
pub const SELF_STIFFNESS: f64 = 0.4;
/// Pairs nearer than this, in resolutions, are followed: less than the height of a triangle, so that
/// flat cloth has none.
const REACH: f64 = 0.7;

impl SelfContactSettings {
    /// For cloth at a resolution, m.
    pub fn of(resolution: f64, fabric: &Fabric) -> Self {
        Self {
            // Coarse cloth keeps farther apart, which leaves room for the finer.
            clearance: fabric.thickness.max(CLEARANCE * resolution),
            stiffness: SELF_STIFFNESS * fabric.contact_stiffness(),
            reach: REACH * resolution,
        }
    }
}

/// Cloth that starts nearer to other cloth than this share of the reach lies on it, as panels do that
/// the pattern places so: 0.1 mm on a coarse level. What was prolonged to a fine one may well be as
/// near, and must not be let through.
const TOUCHING: f64 = 0.003;
/// Share of its shortest edge to which a particle's clearance is cut: neighbours on flat cloth must not repel.
const EDGE_SHARE: f64 = 0.4;
/// Where more than one particle in so many gets a new origin, all do: a search everywhere is cheaper
/// than one around each.
const FEW: usize = 8;
/// Up to so many pairs are looked at by one thread: waking another takes as long.
const MOST_PAIRS_ALONE: usize = 2048;
/// Chunks of particles to a thread at least, for sweeps as cheap as a sum.
const LEAST_CHUNKS: usize = 16;
/// Pairs that are not followed are at least the reach apart at the origin. A particle may stray from there by this
/// share of what two that approach each other may before they come nearer than the clearance.
const DRIFT_SHARE: f64 = 0.9;
/// What a bound on distances is widened by for the rounding of its terms, m.
const ROUNDING: f64 = 1e-12;

/// A pair that was nearer than its clearance at the last evaluation: a spring between two points of
/// the cloth that only pushes.
#[derive(Clone, Copy, Debug)]
pub struct ActivePair {
    kind: Kind,
    pub particles: [u32; 4],
    /// The sides' closest points are weighted means of their particles; those of the second side count negative.
    pub weights: [f64; 4],
    /// From the second side's closest point to the first's, of length one.
    pub normal: Vector3,
    /// m.
    pub distance: f64,
    /// Derivative of the pair's energy by its distance, N, negative.
    pub slope: f64,
    /// Second derivative of the pair's energy by its distance, N/m, no more than the minimizer should be told.
    pub curvature: f64,
}

/// Which cloth the cloth of a panel is kept clear of, as far as that is kept clear as well.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Meets {
    Nothing,
    OtherPanels,
    #[default]
    All,
}

/// Contact of one level with itself.
pub struct SelfContact {
    pub settings: SelfContactSettings,
    finder: PairFinder,
    /// The farthest that a particle may be from its origin, m.
    most_drift: f64,
    /// m, one per particle.
    clearance: Vec<f64>,
    /// All pairs that at the origin are nearer than the reach and not adjacent, but for those excused.
    pairs: Vec<Pair>,
    /// Distance of each pair at the origin, m.
    origin_distance: Vec<f64>,
    /// Pairs that touched at the start, sorted: they may pass each other until they have parted.
    excused: Vec<Pair>,
    /// Where each particle was when its surroundings were last searched, m, world.
    origin: Vec<Vector3>,
    /// Squared distance of each particle from its origin when it was last asked for, m².
    squared_drift: Vec<f64>,
    /// Pairs that pushed at the last evaluation.
    active: Vec<ActivePair>,
}

impl SelfContact {
    /// `class_of` tells which particles are to be sewn together.
    pub fn new(level: &Level, class_of: Vec<u32>, settings: SelfContactSettings) -> Self {
        Self::by_panel(level, class_of, settings, |_| Meets::All)
    }

    /// The same, where `meets` tells of each panel what it is kept clear of.
    pub fn by_panel(
        level: &Level,
        class_of: Vec<u32>,
        settings: SelfContactSettings,
        meets: impl Fn(usize) -> Meets,
    ) -> Self {
        let triangles = level.particle_triangles();
        let mut clearance = vec![settings.clearance; level.particle_count];
        for (t, particles) in triangles.iter().enumerate() {
            let rest = level.rest_corners(t);
            for k in 0..3 {
                let length = (rest[(k + 1) % 3] - rest[k]).norm();
                for p in [particles[k], particles[(k + 1) % 3]] {
                    clearance[p as usize] = clearance[p as usize].min(EDGE_SHARE * length);
                }
            }
        }
        // What nothing meets is left out. Triangles of one group do not meet each other.
        let (mut met, mut groups) = (Vec::new(), Vec::new());
        for (triangle, panel) in triangles.iter().zip(level.panel_of_triangle()) {
            let meets = meets(panel as usize);
            if meets != Meets::Nothing {
                met.push(*triangle);
                groups.push((meets == Meets::OtherPanels).then_some(panel));
            }
        }
        let largest_clearance = clearance.iter().copied().fold(0.0, larger);
        Self {
            settings,
            most_drift: DRIFT_SHARE * 0.5 * (settings.reach - largest_clearance),
            finder: PairFinder::new(&met, class_of, settings.reach).with_groups(groups),
            clearance,
            pairs: Vec::new(),
            origin_distance: Vec::new(),
            excused: Vec::new(),
            origin: Vec::new(),
            squared_drift: Vec::new(),
            active: Vec::new(),
        }
    }

    /// Finds the near pairs at `positions`, which must be free of intersections.
    pub fn rebuild(&mut self, positions: &[Vector3]) {
        let touching = self.touching();
        let first = self.origin.is_empty();
        self.origin.clear();
        self.origin.extend_from_slice(positions);
        self.squared_drift.clear();
        self.squared_drift.resize(positions.len(), 0.0);
        self.pairs.clear();
        self.origin_distance.clear();
        let found = self.finder.all(positions);
        if first {
            let lying = found.iter().filter(|(_, distance)| *distance < touching);
            self.excused = lying.map(|(pair, _)| *pair).collect();
            self.excused.sort_unstable();
        } else {
            self.excused.retain(|pair| pair.distance(positions) < touching);
        }
        self.follow(found);
    }

    /// Forgets what was followed: the next pairs are those of cloth that is seen for the first time.
    pub fn forget(&mut self) {
        self.origin.clear();
        self.excused.clear();
    }

    /// Distance of what lies on one another, m.
    fn touching(&self) -> f64 {
        TOUCHING * self.settings.reach
    }

    /// Gives the particles `strayed` their positions as new origins and finds the pairs around them.
    fn renew(&mut self, positions: &[Vector3], strayed: &[u32]) {
        if strayed.len() * FEW > positions.len() {
            return self.rebuild(positions);
        }
        let mut moved = vec![false; positions.len()];
        for &p in strayed {
            moved[p as usize] = true;
            self.origin[p as usize] = positions[p as usize];
            self.squared_drift[p as usize] = 0.0;
        }
        let has_moved = |pair: &Pair| pair.particles.iter().any(|&p| moved[p as usize]);
        let mut kept = 0;
        for k in 0..self.pairs.len() {
            if !has_moved(&self.pairs[k]) {
                self.pairs[kept] = self.pairs[k];
                self.origin_distance[kept] = self.origin_distance[k];
                kept += 1;
            }
        }
        self.pairs.truncate(kept);
        self.origin_distance.truncate(kept);
        let mut found = self.finder.near(&moved, &self.origin);
        let touching = self.touching();
        let (lying, parted): (Vec<_>, Vec<_>) =
            self.excused.iter().partition(|pair| pair.distance(positions) < touching);
        self.excused = lying;
        // Those that have parted are pairs like others; those that moved are found already.
        let origin = &self.origin;
        let parted = parted.into_iter().filter(|pair| !has_moved(pair)).map(|pair| (pair, pair.distance(origin)));
        found.extend(parted.filter(|(_, distance)| *distance < self.settings.reach));
        self.follow(found);
    }

    /// Follows pairs, given with their distances at the origin, unless they are excused.
    fn follow(&mut self, found: Vec<(Pair, f64)>) {
        for (pair, distance) in found {
            if self.excused.binary_search(&pair).is_err() {
                self.pairs.push(pair);
                self.origin_distance.push(distance);
            }
        }
    }

    /// Measures how far the particles are from their origins; returns the farthest, m.
    fn measure_drift(&mut self, positions: &[Vector3]) -> f64 {
        let chunks = self.squared_drift.par_chunks_mut(CHUNK).zip(self.origin.par_chunks(CHUNK));
        let chunks = chunks.zip(positions.par_chunks(CHUNK)).with_min_len(LEAST_CHUNKS);
        let farthest = chunks.map(|((drift, origin), positions)| {
            let mut farthest = 0.0;
            for ((drift, origin), p) in drift.iter_mut().zip(origin).zip(positions) {
                *drift = (p - origin).norm_squared();
                farthest = larger(farthest, *drift);
            }
            farthest
        });
        farthest.reduce(|| 0.0, larger).sqrt()
    }

    /// What is left of a pair's distance at the origin after its particles have drifted, m: it is at
    /// least so far apart.
    #[inline]
    fn least_distance(&self, pair: &Pair, at_origin: f64) -> f64 {
        let (one, other) = pair.largest_on_sides(pair.particles.map(|p| self.squared_drift[p as usize]));
        at_origin - one.sqrt() - other.sqrt() - ROUNDING
    }

    /// Clearance of a pair, m: the least of its particles'.
    pub(crate) fn clearance_of(&self, particles: [u32; 4]) -> f64 {
        particles.iter().map(|&p| self.clearance[p as usize]).fold(f64::INFINITY, f64::min)
    }

    /// The pair as a spring, if it is nearer than its clearance.
    fn spring(&self, pair: &Pair, positions: &[Vector3]) -> Option<(f64, ActivePair)> {
        let Span { weights, vector } = pair.span(positions);
        let clearance = self.clearance_of(pair.particles);
        let distance = vector.norm();
        if !(distance < clearance && distance > 0.0) {
            return None;
        }
        let (energy, slope, curvature) = repulsion(distance, clearance, self.settings.stiffness);
        let normal = vector / distance;
        Some((
            energy,
            ActivePair { kind: pair.kind, particles: pair.particles, weights, normal, distance, slope, curvature },
        ))
    }

    /// Adds the gradient, N, and returns the energy, J.
    pub fn evaluate(&mut self, positions: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let energy = self.find_active(positions);
        for pair in &self.active {
            for (p, w) in pair.particles.iter().zip(pair.weights) {
                gradient[*p as usize] += pair.normal * (w * pair.slope);
            }
        }
        energy
    }

    /// Finds the pairs that push at `positions` and returns their energy, J.
    pub(crate) fn find_active(&mut self, positions: &[Vector3]) -> f64 {
        let clearance = self.settings.clearance;
        // Most pairs were so far apart that no particle has moved enough for them to touch.
        let within = clearance + 2.0 * self.measure_drift(positions) + ROUNDING;
        let pairs = self.pairs.par_iter().zip(&self.origin_distance).with_min_len(MOST_PAIRS_ALONE);
        let near = |&(pair, &at_origin): &(&Pair, &f64)| {
            at_origin <= within && self.least_distance(pair, at_origin) <= clearance
        };
        let active: Vec<_> = pairs.filter(near).filter_map(|(pair, _)| self.spring(pair, positions)).collect();
        let mut energy = 0.0;
        self.active.clear();
        for (pair_energy, pair) in active {
            energy += pair_energy;
            self.active.push(pair);
        }
        energy
    }

    /// The pairs that pushed at the last evaluation, in an order that no number of threads changes.
    pub(crate) fn active(&self) -> &[ActivePair] {
        &self.active
    }

    /// How many of the pairs that pushed at the last evaluation are nearer than `least`, m, and than half their clearance.
    pub fn too_near(&self, least: f64) -> usize {
        let is_near = |pair: &&ActivePair| pair.distance < least.min(0.5 * self.clearance_of(pair.particles));
        self.active.iter().filter(is_near).count()
    }

    /// `dᵀ H d` without what is negative, by the pairs that pushed at the last evaluation: it should
    /// have been at `positions`.
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3]) -> f64 {
        let along = |pair: &ActivePair| {
            let weighted = |of: &[Vector3]| -> Vector3 {
                pair.particles.iter().zip(pair.weights).map(|(&p, w)| of[p as usize] * w).sum()
            };
            pair.curvature * (weighted(direction).dot(&weighted(positions)) / pair.distance).powi(2)
        };
        self.active().iter().map(along).sum()
    }
}

/// Unlike `f64::max` one instruction, for numbers of which none is NaN.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::pairs::tests::{crumpled_tube, near_pairs_plainly};
    use super::*;
    use proptest::prelude::*;

    fn follow(seed: f64, reach: f64, size: f64) -> Result<(), TestCaseError> {
        let (level, mut positions) = crumpled_tube(0.02, seed);
        let triangles = level.particle_triangles();
        let class_of: Vec<u32> = (0..level.particle_count as u32).collect();
        let settings = SelfContactSettings { clearance: 0.003, stiffness: 1.0, reach };
        let mut contact = SelfContact::new(&level, class_of.clone(), settings);
        contact.rebuild(&positions);
        let mut partly = 0;
        for round in 0..20 {
            // Few particles move, in each round others.
            let amount = |p: usize| if (p + round) % 17 < 2 { size * reach } else { 1e-4 * reach };
            let wave = |k: usize, step: f64| ((k + 7 * round) as f64 * step + seed).sin();
            let moves = |p: usize| Vector3::new(wave(p, 45.164), wave(p, 94.673), wave(p, 7.781)) * amount(p);
            let mut moves: Vec<Vector3> = (0..positions.len()).map(moves).collect();
            let before = contact.origin.clone();
            contact.limit(&positions, &mut moves);
            positions.iter_mut().zip(&moves).for_each(|(p, by)| *p += by);
            let renewed = before.iter().zip(&contact.origin).filter(|(a, b)| a != b).count();
            partly += usize::from(renewed > 0 && renewed < positions.len());
            let mut found: Vec<_> =
                contact.pairs.iter().copied().zip(contact.origin_distance.iter().copied()).collect();
            found.sort_by_key(|(pair, _)| *pair);
            let plainly = near_pairs_plainly(&triangles, &class_of, &contact.origin, reach);
            let plainly: Vec<_> = plainly.into_iter().filter(|(pair, _)| !contact.excused.contains(pair)).collect();
            prop_assert_eq!(found, plainly);
            let farthest = contact.measure_drift(&positions);
            prop_assert!(farthest <= contact.most_drift * (1.0 + 1e-9), "{farthest}");
            // What is known of distances without measuring them is true.
            for (pair, &at_origin) in contact.pairs.iter().zip(&contact.origin_distance) {
                prop_assert!(contact.least_distance(pair, at_origin) <= pair.distance(&positions));
            }
        }
        prop_assert!(size < 0.4 || partly > 0);
        Ok(())
    }

    /// Who was drawn along by others went farther than it would have by itself, and out of what was searched.
    #[test]
    fn who_is_drawn_along_stays_near_its_origin() {
        follow(36.55036253133658, 0.02, 0.3656305199266181).unwrap();
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        /// However particles move, the pairs are those of the origin, and no particle is far from there.
        #[test]
        fn the_pairs_followed_are_those_of_the_origin(seed in 0.0..100.0f64, reach in 0.02..0.06f64, size in 0.0..0.5f64) {
            follow(seed, reach, size)?;
        }

        /// Pairs of a panel that does not meet itself are those that lie in it altogether; what meets nothing has none.
        #[test]
        fn panels_meet_what_they_are_to_meet(seed in 0.0..100.0f64) {
            let (mut level, positions) = crumpled_tube(0.03, seed);
            // Cut in two.
            let [one] = &level.panels[..] else { panic!("a tube is of one panel") };
            let half = one.triangles.len() / 2;
            let mut other = one.clone();
            other.triangles.start += half;
            level.panels[0].triangles.end = other.triangles.start;
            level.panels.push(other);
            let (triangles, panel_of) = (level.particle_triangles(), level.panel_of_triangle());
            let in_panel = |p: u32, panel: u32| triangles.iter().zip(&panel_of).any(|(t, of)| *of == panel && t.contains(&p));
            let settings = SelfContactSettings { clearance: 0.003, stiffness: 1.0, reach: 0.03 };
            let pairs = |meets: [Meets; 2]| {
                let classes = (0..level.particle_count as u32).collect();
                let mut contact = SelfContact::by_panel(&level, classes, settings, |panel| meets[panel]);
                contact.rebuild(&positions);
                let mut pairs = contact.pairs;
                pairs.sort_unstable();
                pairs
            };
            let all = pairs([Meets::All; 2]);
            let others = pairs([Meets::OtherPanels; 2]);
            let one_alone = pairs([Meets::All, Meets::Nothing]);
            prop_assert!(others.len() < all.len() && one_alone.len() < all.len() && !one_alone.is_empty());
            prop_assert!(others.iter().chain(&one_alone).all(|pair| all.binary_search(pair).is_ok()));
            for pair in &all {
                let within = |panel: u32| pair.particles.iter().all(|&p| in_panel(p, panel));
                prop_assert!(others.binary_search(pair).is_ok() || within(0) || within(1), "{pair:?}");
                // Of a triangle beyond the border all corners may be on it.
                let clear_of_other = pair.particles.iter().all(|&p| !in_panel(p, 1));
                let kept = one_alone.binary_search(pair).is_ok();
                prop_assert!(if kept { within(0) } else { !clear_of_other }, "{pair:?}");
            }
            prop_assert!(pairs([Meets::Nothing; 2]).is_empty());
        }

        /// No pair that pushes is passed over.
        #[test]
        fn what_pushes_is_what_is_nearer_than_its_clearance(seed in 0.0..100.0f64, size in 0.0..0.25f64) {
            let (level, mut positions) = crumpled_tube(0.02, seed);
            let triangles = level.particle_triangles();
            let class_of: Vec<u32> = (0..level.particle_count as u32).collect();
            let settings = SelfContactSettings { clearance: 0.008, stiffness: 1.0, reach: 0.03 };
            let mut contact = SelfContact::new(&level, class_of.clone(), settings);
            contact.rebuild(&positions);
            positions.iter_mut().enumerate().for_each(|(k, p)| p.x += size * settings.reach * (k as f64 + seed).sin());
            contact.evaluate(&positions, &mut vec![Vector3::zeros(); positions.len()]);
            let mut active: Vec<_> = contact.active().iter().map(|pair| pair.particles).collect();
            active.sort_unstable();
            let near = near_pairs_plainly(&triangles, &class_of, &positions, settings.clearance);
            let pushes = |(pair, distance): &(Pair, f64)| {
                let clearance = pair.particles.iter().map(|&p| contact.clearance[p as usize]).fold(f64::INFINITY, f64::min);
                *distance < clearance && !contact.excused.contains(pair)
            };
            let mut expected: Vec<_> = near.iter().filter(|near| pushes(near)).map(|(pair, _)| pair.particles).collect();
            expected.sort_unstable();
            prop_assert_eq!(active, expected);
        }
    }
}
