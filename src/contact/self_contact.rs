//! Contact of the cloth with itself, for vertices against faces and edges against edges.
//!
//! The paper keeps particles apart from particles; edges then cross between them unless the
//! clearance exceeds `h/√3`. We measure the distances of vertices to faces and of edges to edges,
//! push apart what is nearer than the clearance, and bound how the sides of a pair may move against
//! each other:
//!
//! > from a state without intersections, if the moves of no pair's particles, less their common mean,
//! > add up to the pair's distance, nothing can have passed through anything    (theory, equation 15)
//!
//! It needs no continuous collision detection. Offset Geometric Contact (Chen et al. 2025, section 3)
//! bounds the moves themselves, which locks layers that move together. Pairs are found anew when
//! particles have moved a share of the reach.

use crate::garment::Level;
use crate::geometry::{EdgeTable, RunTree, SegmentPair, Vector3, closest_between_segments, closest_on_triangle};
use rayon::prelude::*;

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

/// Share of a pair's distance that its sides may move towards each other in one step: below one, so
/// that touching stays excluded.
const APPROACH_SHARE: f64 = 0.8;
/// Share of the reach that a particle may move before the pairs are found anew. Pairs that were not
/// found are at least the reach apart; after two such moves half of it is left.
const REBUILD_SHARE: f64 = 0.25;
/// Panels that start nearer to each other than this lie on one another, m.
const TOUCHING: f64 = 1e-4;
/// How often the moves of pairs in their own way are drawn together before they are cut.
const DRAWING_ROUNDS: usize = 4;
/// How often in all, before all moves are shortened.
const MOST_ROUNDS: usize = 16;
/// Share of its shortest edge to which a particle's clearance is cut: neighbours on flat cloth must not repel.
const EDGE_SHARE: f64 = 0.4;

/// Up to so many pairs are looked at by one thread: waking another takes as long.
const MOST_PAIRS_ALONE: usize = 2048;
/// What a bound on distances is widened by for the rounding of its terms, m.
const ROUNDING: f64 = 1e-12;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Pair {
    VertexFace { vertex: u32, face: u32 },
    EdgeEdge { first: u32, second: u32 },
}

/// Up to four particles with signed weights whose sum is the vector between the closest points.
#[derive(Clone, Copy)]
struct Span {
    particles: [u32; 4],
    weights: [f64; 4],
    vector: Vector3,
}

/// A pair nearer than its clearance.
struct ActivePair {
    span: Span,
    /// m.
    distance: f64,
    /// m.
    clearance: f64,
}

/// Contact of one level with itself.
pub struct SelfContact {
    pub settings: SelfContactSettings,
    triangles: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    /// Particles of one class are, or will be, sewn to one.
    class_of: Vec<u32>,
    /// m, one per particle.
    clearance: Vec<f64>,
    pairs: Vec<Pair>,
    /// Distance of each pair when it was found, m.
    found_distance: Vec<f64>,
    /// Pairs that touched at the start, sorted: they may pass each other until they have parted.
    excused: Vec<Pair>,
    /// Where the particles were when the pairs were found.
    origin: Vec<Vector3>,
}

/// A pair in its own way.
struct Blocked {
    particles: [u32; 4],
    /// Mean of the particles' moves.
    mean: Vector3,
    /// What its particles may keep of their moves against the mean.
    share: f64,
    /// m.
    distance: f64,
}

/// No particle of a blocked pair moves farther than its part of the pair's distance.
fn stop(blocked: &[Blocked], moves: &mut [Vector3]) {
    for pair in blocked {
        let most = 0.5 * APPROACH_SHARE * pair.distance;
        for p in pair.particles {
            let m = &mut moves[p as usize];
            let length = m.norm();
            if length > most {
                *m *= most / length;
            }
        }
    }
}

/// Each particle follows the pair that leaves it the least.
fn draw_together(blocked: &[Blocked], moves: &mut [Vector3]) {
    let mut strictest: std::collections::BTreeMap<u32, (f64, Vector3)> = std::collections::BTreeMap::new();
    for pair in blocked {
        for p in pair.particles {
            let entry = strictest.entry(p).or_insert((f64::INFINITY, Vector3::zeros()));
            if pair.share < entry.0 {
                *entry = (pair.share, pair.mean);
            }
        }
    }
    for (p, (share, mean)) in strictest {
        let m = &mut moves[p as usize];
        *m = mean + (*m - mean) * (DRAWING * share);
    }
}

/// Drawn a little closer than needed, as the neighbours move as well.
const DRAWING: f64 = 0.9;

/// Energy of a pair at a distance below its clearance, its slope and its curvature: quadratic down to
/// half the clearance, logarithmic below, with continuous slope (Chen et al. 2025, equation 18).
#[inline]
fn repulsion(distance: f64, clearance: f64, stiffness: f64) -> (f64, f64, f64) {
    let depth = clearance - distance;
    let half = 0.5 * clearance;
    if distance >= half {
        return (0.5 * stiffness * depth * depth, -stiffness * depth, stiffness);
    }
    let barrier = stiffness * half * half;
    let energy = 0.5 * stiffness * half * half - barrier * (distance / half).ln();
    (energy, -barrier / distance, (barrier / (distance * distance)).min(STIFFEST * stiffness))
}

/// The barrier's curvature is not taken for more than this many times the pair's stiffness: one
/// nearly closed pair must not hold up the step of the whole garment.
const STIFFEST: f64 = 20.0;

impl SelfContact {
    /// `class_of` tells which particles are to be sewn together.
    pub fn new(level: &Level, class_of: Vec<u32>, settings: SelfContactSettings) -> Self {
        let triangles = level.particle_triangles();
        let edges: Vec<[u32; 2]> = EdgeTable::new(&triangles).edges.into_iter().map(|e| e.ends).collect();
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
        Self {
            settings,
            triangles,
            edges,
            class_of,
            clearance,
            pairs: Vec::new(),
            found_distance: Vec::new(),
            excused: Vec::new(),
            origin: Vec::new(),
        }
    }

    /// Finds the near pairs at `positions`, which must be free of intersections.
    pub fn rebuild(&mut self, positions: &[Vector3]) {
        let first = self.origin.is_empty();
        self.origin = positions.to_vec();
        let (touching, found): (Vec<_>, Vec<_>) = self
            .near_pairs(positions)
            .into_iter()
            .partition(|(pair, distance)| *distance < TOUCHING && (first || self.excused.binary_search(pair).is_ok()));
        self.excused = touching.into_iter().map(|(pair, _)| pair).collect();
        self.excused.sort_unstable();
        (self.pairs, self.found_distance) = found.into_iter().unzip();
    }

    fn particles_of(&self, pair: Pair) -> [u32; 4] {
        match pair {
            Pair::VertexFace { vertex, face } => {
                let [a, b, c] = self.triangles[face as usize];
                [vertex, a, b, c]
            }
            Pair::EdgeEdge { first, second } => {
                let ([a, b], [c, d]) = (self.edges[first as usize], self.edges[second as usize]);
                [a, b, c, d]
            }
        }
    }

    fn span(&self, pair: Pair, positions: &[Vector3]) -> Span {
        let particles = self.particles_of(pair);
        let [p, q, r, s] = particles.map(|p| positions[p as usize]);
        match pair {
            Pair::VertexFace { .. } => {
                let [a, b, c] = closest_on_triangle(p, [q, r, s]);
                Span { particles, weights: [1.0, -a, -b, -c], vector: p - (q * a + r * b + s * c) }
            }
            Pair::EdgeEdge { .. } => {
                let SegmentPair { s: i, t: j } = closest_between_segments([p, q], [r, s]);
                Span { particles, weights: [1.0 - i, i, j - 1.0, -j], vector: p + (q - p) * i - r - (s - r) * j }
            }
        }
    }

    /// Clearance of a pair: the least of its particles'.
    fn clearance_of(&self, particles: [u32; 4]) -> f64 {
        particles.iter().map(|&p| self.clearance[p as usize]).fold(f64::INFINITY, f64::min)
    }

    /// Pairs nearer than their clearance, with their distance and clearance, m.
    fn active(&self, positions: &[Vector3]) -> Vec<ActivePair> {
        // Most pairs were found so far apart that no particle has moved enough for them to touch.
        let within = self.settings.clearance + 2.0 * self.drift(positions) + ROUNDING;
        self.pairs
            .par_iter()
            .zip(&self.found_distance)
            .with_min_len(MOST_PAIRS_ALONE)
            .filter_map(|(&pair, &found)| {
                if found > within {
                    return None;
                }
                let span = self.span(pair, positions);
                let clearance = self.clearance_of(span.particles);
                let distance = span.vector.norm();
                (distance < clearance && distance > 0.0).then_some(ActivePair { span, distance, clearance })
            })
            .collect()
    }

    /// The farthest that a particle is from where it was when the pairs were found, m.
    fn drift(&self, positions: &[Vector3]) -> f64 {
        let squared = positions.iter().zip(&self.origin).map(|(p, o)| (p - o).norm_squared());
        squared.fold(0.0, f64::max).sqrt()
    }

    /// Adds the gradient, N, and returns the energy, J.
    pub fn evaluate(&self, positions: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let mut energy = 0.0;
        for ActivePair { span, distance, clearance } in self.active(positions) {
            let (pair_energy, slope, _) = repulsion(distance, clearance, self.settings.stiffness);
            energy += pair_energy;
            let pull = span.vector * (slope / distance);
            for (p, w) in span.particles.iter().zip(span.weights) {
                gradient[*p as usize] += pull * w;
            }
        }
        energy
    }

    /// `dᵀ H d` without what is negative.
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3]) -> f64 {
        let mut sum = 0.0;
        for ActivePair { span, distance, clearance } in self.active(positions) {
            let rate: Vector3 = span.particles.iter().zip(span.weights).map(|(p, w)| direction[*p as usize] * w).sum();
            let (_, _, curvature) = repulsion(distance, clearance, self.settings.stiffness);
            sum += curvature * (rate.dot(&span.vector) / distance).powi(2);
        }
        sum
    }

    /// Shortens moves until no pair can pass through each other; tells how many pairs were in the way.
    ///
    /// The sides of a pair at distance `d` cannot meet while the moves of their particles, less their
    /// common mean, add up to less than `d`. Where they do not, the particles' moves are first drawn
    /// towards the mean; where a few rounds of that do not suffice they are cut to a share of `d`
    /// each, which may block neighbours in turn; in the end all moves are shortened alike.
    pub fn limit(&mut self, positions: &[Vector3], moves: &mut [Vector3]) -> usize {
        let farthest = REBUILD_SHARE * self.settings.reach;
        for m in moves.iter_mut() {
            let length = m.norm();
            if length > farthest {
                *m *= farthest / length;
            }
        }
        let gone = |p: usize| (positions[p] + moves[p] - self.origin[p]).norm_squared() > farthest * farthest;
        if (0..positions.len()).any(gone) {
            self.rebuild(positions);
        }
        let drift = self.drift(positions);
        let mut first = None;
        for round in 0..MOST_ROUNDS {
            let blocked = self.blocked(positions, moves, drift);
            first = first.or(Some(blocked.len()));
            if blocked.is_empty() {
                break;
            } else if round < DRAWING_ROUNDS {
                draw_together(&blocked, moves);
            } else if round + 1 < MOST_ROUNDS {
                stop(&blocked, moves);
            } else {
                let least = blocked.iter().map(|b| b.share).fold(1.0, f64::min);
                moves.iter_mut().for_each(|m| *m *= least);
            }
        }
        first.unwrap_or(0)
    }

    /// Pairs whose sides would come too near.
    fn blocked(&self, positions: &[Vector3], moves: &[Vector3], drift: f64) -> Vec<Blocked> {
        // A particle differs from the mean by at most two of the longest moves.
        let most_closing = 4.0 * moves.iter().map(|m| m.norm_squared()).fold(0.0, f64::max).sqrt();
        self.pairs
            .par_iter()
            .zip(&self.found_distance)
            .with_min_len(MOST_PAIRS_ALONE)
            .filter_map(|(&pair, &found)| {
                if most_closing <= APPROACH_SHARE * (found - 2.0 * drift) {
                    return None;
                }
                let particles = self.particles_of(pair);
                let m = particles.map(|p| moves[p as usize]);
                let mean = (m[0] + m[1] + m[2] + m[3]) * 0.25;
                let apart = m.map(|m| (m - mean).norm());
                let closing = match pair {
                    Pair::VertexFace { .. } => apart[0] + apart[1].max(apart[2]).max(apart[3]),
                    Pair::EdgeEdge { .. } => apart[0].max(apart[1]) + apart[2].max(apart[3]),
                };
                // Most pairs are far from meeting; only for the others the distance is worth measuring.
                if closing <= APPROACH_SHARE * (found - 2.0 * drift) {
                    return None;
                }
                let distance = self.span(pair, positions).vector.norm();
                let share = APPROACH_SHARE * distance / closing;
                // Rounding must not block what was just cut to fit.
                (share < 1.0 - 1e-9).then_some(Blocked { particles, mean, share, distance })
            })
            .collect()
    }

    fn adjacent(&self, a: &[u32], b: &[u32]) -> bool {
        let class = |p: &u32| self.class_of[*p as usize];
        a.iter().any(|p| b.iter().any(|q| class(p) == class(q)))
    }

    /// All pairs nearer than the reach that are not adjacent, with their distances, m, in order.
    fn near_pairs(&self, positions: &[Vector3]) -> Vec<(Pair, f64)> {
        let reach = self.settings.reach;
        let at = |p: u32| positions[p as usize];
        let grow = Vector3::repeat(reach);
        let near = |pair: Pair| {
            let distance = self.span(pair, positions).vector.norm();
            (distance < reach).then_some((pair, distance))
        };
        let faces = RunTree::new(self.triangles.iter().map(|t| {
            let [a, b, c] = t.map(at);
            (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
        }));
        let vertex_faces = (0..positions.len() as u32).into_par_iter().with_min_len(256).flat_map_iter(|vertex| {
            let mut found = Vec::new();
            faces.for_each_meeting(at(vertex) - grow, at(vertex) + grow, 0, |face| {
                let corners = self.triangles[face as usize];
                if !self.adjacent(&[vertex], &corners) && !clearly_apart([at(vertex)], corners.map(at), reach) {
                    found.extend(near(Pair::VertexFace { vertex, face }));
                }
            });
            found
        });
        let mut pairs: Vec<(Pair, f64)> = vertex_faces.collect();
        let edges = RunTree::new(self.edges.iter().map(|e| {
            let [a, b] = e.map(at);
            (a.inf(&b), a.sup(&b))
        }));
        let edge_edges = (0..self.edges.len() as u32).into_par_iter().with_min_len(256).flat_map_iter(|first| {
            let ends = self.edges[first as usize];
            let [a, b] = ends.map(at);
            let mut found = Vec::new();
            edges.for_each_meeting(a.inf(&b) - grow, a.sup(&b) + grow, first + 1, |second| {
                let others = self.edges[second as usize];
                if !self.adjacent(&ends, &others) && !clearly_apart([a, b], others.map(at), reach) {
                    found.extend(near(Pair::EdgeEdge { first, second }));
                }
            });
            found
        });
        pairs.par_extend(edge_edges);
        pairs
    }
}

/// Are the hulls of some points farther apart than `reach` along the line between their means? Then
/// they are so altogether; most candidates are told from pairs by this, without finding their
/// closest points.
#[inline]
fn clearly_apart<const N: usize, const M: usize>(ones: [Vector3; N], others: [Vector3; M], reach: f64) -> bool {
    let line = ones.iter().sum::<Vector3>() / N as f64 - others.iter().sum::<Vector3>() / M as f64;
    let nearest = ones.iter().map(|p| p.dot(&line)).fold(f64::INFINITY, f64::min);
    let farthest = others.iter().map(|p| p.dot(&line)).fold(f64::NEG_INFINITY, f64::max);
    let gap = nearest - farthest;
    // Times the length of the line, squared; rounding must not exclude a pair.
    gap > 0.0 && gap * gap > (1.0 + 1e-6) * reach * reach * line.norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::shapes;
    use proptest::prelude::*;

    /// What [`SelfContact::near_pairs`] finds, by looking at every pair there is.
    fn near_pairs_plainly(contact: &SelfContact, positions: &[Vector3]) -> Vec<(Pair, f64)> {
        let (vertices, faces) = (0..positions.len() as u32, 0..contact.triangles.len() as u32);
        let edges = 0..contact.edges.len() as u32;
        let vertex_faces = vertices.flat_map(|vertex| faces.clone().map(move |face| Pair::VertexFace { vertex, face }));
        let after = |first: u32| edges.clone().skip(first as usize + 1);
        let edge_edges =
            edges.clone().flat_map(|first| after(first).map(move |second| Pair::EdgeEdge { first, second }));
        let sides = |pair: Pair| match pair {
            Pair::VertexFace { vertex, face } => (vec![vertex], contact.triangles[face as usize].to_vec()),
            Pair::EdgeEdge { first, second } => {
                (contact.edges[first as usize].to_vec(), contact.edges[second as usize].to_vec())
            }
        };
        vertex_faces
            .chain(edge_edges)
            .filter(|&pair| {
                let (one, other) = sides(pair);
                !contact.adjacent(&one, &other)
            })
            .map(|pair| (pair, contact.span(pair, positions).vector.norm()))
            .filter(|(_, distance)| *distance < contact.settings.reach)
            .collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn the_tree_finds_the_pairs_that_looking_at_all_finds(seed in 0.0..100.0f64, rough in 0.0..0.05f64, reach in 0.01..0.08f64) {
            // A flat tube, its seams closed, crumpled more or less.
            let level = Garment::build(&shapes::tube(0.3, 0.2), &[0.03]).unwrap().levels.remove(0);
            let wave = |k: usize, step: f64| (k as f64 * step + seed).sin() * rough;
            let mut positions = vec![Vector3::zeros(); level.particle_count];
            for (k, (rest, &p)) in level.rest.iter().zip(&level.particle_of).enumerate() {
                let turn = rest.x / 0.3 * std::f64::consts::TAU;
                let tube = Vector3::new(turn.sin(), 0.0, 0.1 * turn.cos()) * (0.3 / std::f64::consts::TAU);
                positions[p as usize] = tube + Vector3::new(wave(k, 12.9898), rest.y + wave(k, 78.233), wave(k, 37.719));
            }
            let settings = SelfContactSettings { clearance: 0.003, stiffness: 1.0, reach };
            let contact = SelfContact::new(&level, (0..level.particle_count as u32).collect(), settings);
            let found = contact.near_pairs(&positions);
            prop_assert!(rough > 0.03 || reach < 0.04 || !found.is_empty());
            prop_assert_eq!(found, near_pairs_plainly(&contact, &positions));
        }
    }
}
