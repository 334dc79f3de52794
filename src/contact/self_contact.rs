//! Contact of the cloth with itself, for vertices against faces and edges against edges.
//!
//! The paper keeps particles apart from particles; edges then cross between them unless the
//! clearance exceeds `h/√3`. We measure the distances of vertices to faces and of edges to edges,
//! push apart what is nearer than the clearance, and bound how far each particle may move:
//!
//! > from a state without intersections, if no particle moves farther than half of the least
//! > distance of any pair that it is part of, nothing can have passed through anything
//!
//! (Offset Geometric Contact, Chen et al. 2025, section 3; the bound needs no continuous collision
//! detection). Pairs and bounds are found anew when the bounds are used up.

use crate::garment::Level;
use crate::geometry::{EdgeTable, SegmentPair, Vector3, closest_between_segments, closest_on_triangle};
use crate::minimize::CHUNK;
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

/// Share of the half distance that a particle may move: below one, so that touching stays excluded.
const BOUND_SHARE: f64 = 0.9;
/// Share of its shortest edge to which a particle's clearance is cut: neighbours on flat cloth must not repel.
const EDGE_SHARE: f64 = 0.4;

#[derive(Clone, Copy, Debug)]
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
    /// Where the bounds count from.
    origin: Vec<Vector3>,
    /// m, one per particle.
    bound: Vec<f64>,
    pub rebuilds: usize,
}

impl SelfContact {
    /// `class_of` tells which particles are to be sewn together.
    pub fn new(level: &Level, class_of: Vec<u32>, settings: SelfContactSettings) -> Self {
        let triangles = level.particle_triangles();
        let edges: Vec<[u32; 2]> = EdgeTable::new(&triangles).edges.into_iter().map(|e| e.ends).collect();
        let mut clearance = vec![settings.clearance; level.particle_count];
        for t in 0..triangles.len() {
            let rest = level.rest_corners(t);
            for k in 0..3 {
                let length = (rest[(k + 1) % 3] - rest[k]).norm();
                for p in [triangles[t][k], triangles[t][(k + 1) % 3]] {
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
            origin: Vec::new(),
            bound: vec![0.0; level.particle_count],
            rebuilds: 0,
        }
    }

    /// Finds the near pairs at `positions`, which must be free of intersections, and how far each
    /// particle may move from there.
    pub fn rebuild(&mut self, positions: &[Vector3]) {
        self.rebuilds += 1;
        self.origin = positions.to_vec();
        let mut found = self.near_pairs(positions);
        self.bound.fill(0.5 * BOUND_SHARE * self.settings.reach);
        self.pairs.clear();
        for (pair, distance) in found.drain(..) {
            let bound = 0.5 * BOUND_SHARE * distance;
            for &p in self.particles_of(pair).iter() {
                let b = &mut self.bound[p as usize];
                *b = b.min(bound);
            }
            self.pairs.push(pair);
        }
    }

    pub fn pair_count(&self) -> usize {
        self.pairs.len()
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
                Span {
                    particles,
                    weights: [1.0 - i, i, j - 1.0, -j],
                    vector: p + (q - p) * i - r - (s - r) * j,
                }
            }
        }
    }

    /// Clearance of a pair: the least of its particles'.
    fn clearance_of(&self, particles: [u32; 4]) -> f64 {
        particles.iter().map(|&p| self.clearance[p as usize]).fold(f64::INFINITY, f64::min)
    }

    fn active(&self, positions: &[Vector3]) -> Vec<(Span, f64, f64)> {
        self.pairs
            .par_iter()
            .with_min_len(512)
            .filter_map(|&pair| {
                let span = self.span(pair, positions);
                let clearance = self.clearance_of(span.particles);
                let distance = span.vector.norm();
                (distance < clearance && distance > 0.0).then_some((span, distance, clearance))
            })
            .collect()
    }

    /// Adds the gradient, N, and returns the energy, J.
    pub fn evaluate(&self, positions: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let mut energy = 0.0;
        for (span, distance, clearance) in self.active(positions) {
            let depth = clearance - distance;
            energy += 0.5 * self.settings.stiffness * depth * depth;
            let pull = span.vector * (-self.settings.stiffness * depth / distance);
            for (p, w) in span.particles.iter().zip(span.weights) {
                gradient[*p as usize] += pull * w;
            }
        }
        energy
    }

    /// `dᵀ H d` without what is negative.
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3]) -> f64 {
        let mut sum = 0.0;
        for (span, distance, _) in self.active(positions) {
            let rate: Vector3 =
                span.particles.iter().zip(span.weights).map(|(p, w)| direction[*p as usize] * w).sum();
            sum += self.settings.stiffness * (rate.dot(&span.vector) / distance).powi(2);
        }
        sum
    }

    /// How many particles the moves would take past their bounds.
    pub fn exceeding(&self, positions: &[Vector3], moves: &[Vector3]) -> usize {
        (0..positions.len())
            .filter(|&p| (positions[p] + moves[p] - self.origin[p]).norm_squared() > self.bound[p].powi(2))
            .count()
    }

    /// Cuts moves off at the bounds; tells how many.
    pub fn truncate(&self, positions: &[Vector3], moves: &mut [Vector3]) -> usize {
        let mut count = 0;
        for p in 0..positions.len() {
            let target = positions[p] + moves[p] - self.origin[p];
            let length = target.norm();
            if length > self.bound[p] {
                moves[p] = self.origin[p] + target * (self.bound[p] / length) - positions[p];
                count += 1;
            }
        }
        count
    }

    fn adjacent(&self, a: &[u32], b: &[u32]) -> bool {
        let class = |p: &u32| self.class_of[*p as usize];
        a.iter().any(|p| b.iter().any(|q| class(p) == class(q)))
    }

    fn near_pairs(&self, positions: &[Vector3]) -> Vec<(Pair, f64)> {
        let reach = self.settings.reach;
        let grow = Vector3::repeat(reach);
        let tree = crate::geometry::BoxTree::of_triangles(self.triangles.iter().map(|t| t.map(|p| positions[p as usize])), 0.0);
        let mut found: Vec<(Pair, f64)> = (0..positions.len() as u32)
            .into_par_iter()
            .with_min_len(256)
            .flat_map_iter(|vertex| {
                let at = positions[vertex as usize];
                let mut near = Vec::new();
                tree.for_each_meeting(at - grow, at + grow, |face| {
                    let corners = self.triangles[face as usize];
                    if self.adjacent(&[vertex], &corners) {
                        return;
                    }
                    let pair = Pair::VertexFace { vertex, face };
                    let distance = self.span(pair, positions).vector.norm();
                    if distance < reach {
                        near.push((pair, distance));
                    }
                });
                near.sort_unstable_by_key(|(p, _)| match p { Pair::VertexFace { face, .. } => *face, _ => 0 });
                near
            })
            .collect();
        let edge_tree = crate::geometry::BoxTree::new(self.edges.iter().map(|e| {
            let [a, b] = e.map(|p| positions[p as usize]);
            (a.inf(&b), a.sup(&b))
        }));
        let edges: Vec<(Pair, f64)> = (0..self.edges.len() as u32)
            .into_par_iter()
            .with_min_len(256)
            .flat_map_iter(|first| {
                let [a, b] = self.edges[first as usize].map(|p| positions[p as usize]);
                let mut near = Vec::new();
                edge_tree.for_each_meeting(a.inf(&b) - grow, a.sup(&b) + grow, |second| {
                    if second <= first || self.adjacent(&self.edges[first as usize], &self.edges[second as usize]) {
                        return;
                    }
                    let pair = Pair::EdgeEdge { first, second };
                    let distance = self.span(pair, positions).vector.norm();
                    if distance < reach {
                        near.push((pair, distance));
                    }
                });
                near.sort_unstable_by_key(|(p, _)| match p { Pair::EdgeEdge { second, .. } => *second, _ => 0 });
                near
            })
            .collect();
        found.extend(edges);
        found
    }
}
