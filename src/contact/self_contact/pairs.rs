//! Pairs of a vertex and a face, or of two edges, and how the near ones are found.
//!
//! A tree over the triangles finds those whose boxes are within the reach of each other; each vertex
//! and each edge belongs to one of its triangles, and pairs of two triangles' belongings are what is
//! looked at: every pair once (after Curtis, Tamstorf and Manocha 2008, *Fast collision detection for
//! deformable models using representative-triangles*). When few particles have moved, only the
//! surroundings of their triangles are searched.

use crate::geometry::{RunTree, SegmentPair, Vector3, closest_between_segments, closest_on_triangle};
use rayon::prelude::*;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A vertex, then the corners of a face.
    VertexFace,
    /// The ends of one edge, then those of another; of ends and of edges the smaller first.
    EdgeEdge,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pair {
    pub kind: Kind,
    pub particles: [u32; 4],
}

/// The vector between the closest points of a pair: the weighted sum of its particles' positions.
#[derive(Clone, Copy)]
pub struct Span {
    pub weights: [f64; 4],
    /// m.
    pub vector: Vector3,
}

impl Pair {
    fn vertex_face(vertex: u32, [a, b, c]: [u32; 3]) -> Self {
        Self { kind: Kind::VertexFace, particles: [vertex, a, b, c] }
    }

    fn edge_edge(one: [u32; 2], other: [u32; 2]) -> Self {
        let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let (one, other) = (sorted(one), sorted(other));
        let ([a, b], [c, d]) = (one.min(other), one.max(other));
        Self { kind: Kind::EdgeEdge, particles: [a, b, c, d] }
    }

    pub fn span(&self, positions: &[Vector3]) -> Span {
        self.kind.span(self.particles.map(|p| positions[p as usize]))
    }

    /// m.
    pub fn distance(&self, positions: &[Vector3]) -> f64 {
        self.span(positions).vector.norm()
    }

    /// The largest of four numbers, one per particle, on the first side, and on the second.
    #[inline]
    pub fn largest_on_sides(&self, [a, b, c, d]: [f64; 4]) -> (f64, f64) {
        match self.kind {
            Kind::VertexFace => (a, b.max(c).max(d)),
            Kind::EdgeEdge => (a.max(b), c.max(d)),
        }
    }

    /// Across the face, or across both edges, towards the first side; of length one, or NaN where nothing is across.
    pub fn normal(&self, positions: &[Vector3]) -> Vector3 {
        let [p, q, r, s] = self.particles.map(|p| positions[p as usize]);
        let (across, towards) = match self.kind {
            Kind::VertexFace => ((r - q).cross(&(s - q)), p - q),
            Kind::EdgeEdge => ((q - p).cross(&(s - r)), p - r),
        };
        across * (across.dot(&towards).signum() / across.norm())
    }

    /// The least of four heights, one per particle, on the first side, above the greatest on the second.
    pub fn gap(&self, [a, b, c, d]: [f64; 4]) -> f64 {
        match self.kind {
            Kind::VertexFace => a - b.max(c).max(d),
            Kind::EdgeEdge => a.min(b) - c.max(d),
        }
    }
}

impl Kind {
    /// Of four points, m.
    #[inline]
    pub fn span(self, [p, q, r, s]: [Vector3; 4]) -> Span {
        match self {
            Kind::VertexFace => {
                let [a, b, c] = closest_on_triangle(p, [q, r, s]);
                Span { weights: [1.0, -a, -b, -c], vector: p - (q * a + r * b + s * c) }
            }
            Kind::EdgeEdge => {
                let SegmentPair { s: i, t: j } = closest_between_segments([p, q], [r, s]);
                Span { weights: [1.0 - i, i, j - 1.0, -j], vector: p + (q - p) * i - r - (s - r) * j }
            }
        }
    }
}

/// A triangle with all that a search asks about it.
#[derive(Clone, Copy)]
struct Face {
    particles: [u32; 3],
    /// Bit `k`: corner `k` is this triangle's. Bit `3 + k`: so is the edge from it to the next.
    owned: u8,
}

impl Face {
    fn owns_corner(&self, k: usize) -> bool {
        self.owned >> k & 1 != 0
    }

    fn owns_edge(&self, k: usize) -> bool {
        self.owned >> (3 + k) & 1 != 0
    }

    fn edge(&self, k: usize) -> [u32; 2] {
        [self.particles[k], self.particles[(k + 1) % 3]]
    }
}

/// Finds pairs nearer than the reach.
pub struct PairFinder {
    faces: Vec<Face>,
    /// Class of each particle: those of one class are, or will be, sewn to one. Empty where each is its own.
    class_of: Vec<u32>,
    /// Of each face, if it is in one: those of a group make no pairs. Empty where none is in any.
    groups: Vec<Option<u32>>,
    /// Boxes around the faces, grown by half the reach. Empty before the first search.
    tree: RunTree,
    /// m.
    reach: f64,
}

impl PairFinder {
    /// `class_of` gives the class of each particle: what shares one is adjacent.
    pub fn new(triangles: &[[u32; 3]], mut class_of: Vec<u32>, reach: f64) -> Self {
        let owned = owned(triangles, class_of.len());
        let face = |(&particles, owned): (&[u32; 3], u8)| Face { particles, owned };
        let faces = triangles.iter().zip(owned).map(face).collect();
        if (0..).zip(&class_of).all(|(p, &class)| p == class) {
            class_of = Vec::new();
        }
        Self { faces, class_of, groups: Vec::new(), tree: RunTree::new(std::iter::empty()), reach }
    }

    /// The same, but without the pairs within a group of faces. One group or none for each face.
    pub fn with_groups(mut self, groups: Vec<Option<u32>>) -> Self {
        if groups.iter().any(Option::is_some) {
            self.groups = groups;
        }
        self
    }

    fn is_grouped(&self, t: u32, u: u32) -> bool {
        !self.groups.is_empty()
            && self.groups[t as usize].is_some()
            && self.groups[t as usize] == self.groups[u as usize]
    }

    #[inline]
    fn classes(&self, face: &Face) -> [u32; 3] {
        if self.class_of.is_empty() { face.particles } else { face.particles.map(|p| self.class_of[p as usize]) }
    }

    /// All pairs nearer than the reach that are not adjacent, with their distances, m. Their order is
    /// the same for any number of threads.
    pub fn all(&mut self, positions: &[Vector3]) -> Vec<(Pair, f64)> {
        // The old one goes before the new one comes: they are large.
        self.tree = RunTree::new(std::iter::empty());
        self.tree = RunTree::new(self.faces.iter().map(|face| self.around(face, positions)));
        self.tree.collect_pairs(|t, u, found| self.belongings([t, u], positions, |_, _| true, found))
    }

    /// The same, but only pairs with a particle among those `moved`; all others are where the last
    /// search found them.
    pub fn near(&mut self, moved: &[bool], positions: &[Vector3]) -> Vec<(Pair, f64)> {
        let is_moved = |p: &u32| moved[*p as usize];
        let touched: Vec<u32> =
            (0..self.faces.len() as u32).filter(|&t| self.faces[t as usize].particles.iter().any(is_moved)).collect();
        let boxes: Vec<_> = touched.iter().map(|&t| (t, self.around(&self.faces[t as usize], positions))).collect();
        self.tree.update(boxes.into_iter());
        let around = |&t: &u32| {
            let mut found = Vec::new();
            self.tree.for_each_meeting(t, |u| {
                // Of two that moved each would find the other; itself it finds as well.
                let twice = u <= t && self.faces[u as usize].particles.iter().any(is_moved);
                if !twice {
                    let wanted = |one: &[u32], other: &[u32]| one.iter().chain(other).any(is_moved);
                    self.belongings([t, u], positions, wanted, &mut found);
                }
            });
            found
        };
        touched.par_iter().with_min_len(LEAST_QUERIES).flat_map_iter(around).collect()
    }

    fn around(&self, face: &Face, positions: &[Vector3]) -> (Vector3, Vector3) {
        let [a, b, c] = face.particles.map(|p| positions[p as usize]);
        let grow = Vector3::repeat(0.5 * self.reach);
        (a.inf(&b).inf(&c) - grow, a.sup(&b).sup(&c) + grow)
    }

    /// Near pairs of what belongs to one of two faces and what belongs to the other, or that face itself,
    /// where the particles of both sides are `wanted`.
    #[inline]
    fn belongings(
        &self,
        faces: [u32; 2],
        positions: &[Vector3],
        wanted: impl Fn(&[u32], &[u32]) -> bool,
        found: &mut Vec<(Pair, f64)>,
    ) {
        if self.is_grouped(faces[0], faces[1]) {
            return;
        }
        let [one, other] = faces.map(|t| &self.faces[t as usize]);
        // Bit `3 i + j`: corner `i` of the one and corner `j` of the other are, or will be, sewn to one.
        let (classes, others) = (self.classes(one), self.classes(other));
        let mut shared = 0u32;
        for (i, class) in classes.iter().enumerate() {
            for (j, other) in others.iter().enumerate() {
                shared |= u32::from(class == other) << (3 * i + j);
            }
        }
        let [a, b] = [one, other].map(|face| face.particles.map(|p| positions[p as usize]));
        if shared == 0 && clearly_apart(a, b, self.reach) {
            return;
        }
        let mut keep = |pair: Pair| {
            let distance = pair.distance(positions);
            if distance < self.reach {
                found.push((pair, distance));
            }
        };
        let next = |k: usize| (k + 1) % 3;
        let (p, q) = (one.particles, other.particles);
        for k in 0..3 {
            let adjacent = [shared & (0b111 << (3 * k)) != 0, shared & (0b1_001_001 << k) != 0];
            if one.owns_corner(k) && !adjacent[0] && wanted(&[p[k]], &q) && !clearly_apart([a[k]], b, self.reach) {
                keep(Pair::vertex_face(p[k], q));
            }
            if other.owns_corner(k) && !adjacent[1] && wanted(&[q[k]], &p) && !clearly_apart([b[k]], a, self.reach) {
                keep(Pair::vertex_face(q[k], p));
            }
        }
        for i in (0..3).filter(|&i| one.owns_edge(i)) {
            for j in (0..3).filter(|&j| other.owns_edge(j)) {
                let ends = 1 << j | 1 << next(j);
                let adjacent = shared & (ends << (3 * i) | ends << (3 * next(i))) != 0;
                if !adjacent
                    && wanted(&one.edge(i), &other.edge(j))
                    && !clearly_apart([a[i], a[next(i)]], [b[j], b[next(j)]], self.reach)
                {
                    keep(Pair::edge_edge(one.edge(i), other.edge(j)));
                }
            }
        }
    }
}

/// Triangles whose surroundings one thread searches at least.
const LEAST_QUERIES: usize = 64;

/// To each vertex and each edge the first triangle that has it: bits as in [`Face::owned`].
fn owned(triangles: &[[u32; 3]], particle_count: usize) -> Vec<u8> {
    let mut owned = vec![0; triangles.len()];
    let mut has_owner = vec![false; particle_count];
    // Edges of each particle to larger ones, behind one another, filled from `begin`.
    let mut begin = vec![0u32; particle_count + 1];
    let edges = |t: &[u32; 3]| [0, 1, 2].map(|k| (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3])));
    for (smaller, _) in triangles.iter().flat_map(edges) {
        begin[smaller as usize + 1] += 1;
    }
    for p in 0..particle_count {
        begin[p + 1] += begin[p];
    }
    let mut larger_ends = vec![0u32; 3 * triangles.len()];
    let mut count = vec![0u32; particle_count];
    for (triangle, owned) in triangles.iter().zip(&mut owned) {
        for (k, (smaller, larger)) in edges(triangle).into_iter().enumerate() {
            if !std::mem::replace(&mut has_owner[triangle[k] as usize], true) {
                *owned |= 1 << k;
            }
            let start = begin[smaller as usize] as usize;
            let count = &mut count[smaller as usize];
            let seen = &mut larger_ends[start..=start + *count as usize];
            seen[*count as usize] = larger;
            if !seen[..*count as usize].contains(&larger) {
                *count += 1;
                *owned |= 8 << k;
            }
        }
    }
    owned
}

/// Are the hulls of some points farther apart than `reach` along the line between their means? Then
/// they are so altogether; most candidates are told from pairs by this, without finding their
/// closest points.
#[inline]
fn clearly_apart<const N: usize, const M: usize>(ones: [Vector3; N], others: [Vector3; M], reach: f64) -> bool {
    // From mean to mean, longer by a factor that the comparison below does not see.
    let line = ones.iter().sum::<Vector3>() * M as f64 - others.iter().sum::<Vector3>() * N as f64;
    let nearest = ones.iter().map(|p| p.dot(&line)).fold(f64::INFINITY, f64::min);
    let farthest = others.iter().map(|p| p.dot(&line)).fold(f64::NEG_INFINITY, f64::max);
    let gap = nearest - farthest;
    // Times the length of the line, squared; rounding must not exclude a pair.
    gap > 0.0 && gap * gap > (1.0 + 1e-6) * reach * reach * line.norm_squared()
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::garment::{Garment, Level};
    use crate::pattern::shapes;
    use proptest::prelude::*;

    /// What a [`PairFinder`] finds, in order, by looking at every pair there is.
    pub fn near_pairs_plainly(
        triangles: &[[u32; 3]],
        class_of: &[u32],
        positions: &[Vector3],
        reach: f64,
    ) -> Vec<(Pair, f64)> {
        let mut edges: Vec<[u32; 2]> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let vertices = 0..positions.len() as u32;
        let vertex_faces = vertices.flat_map(|v| triangles.iter().map(move |&t| Pair::vertex_face(v, t)));
        let edge_edges = (0..edges.len())
            .flat_map(|i| edges[i + 1..].iter().map(|e| Pair::edge_edge(edges[i], *e)).collect::<Vec<_>>());
        let adjacent = |pair: &Pair| {
            let side = if pair.kind == Kind::VertexFace { 1 } else { 2 };
            let (one, other) = pair.particles.split_at(side);
            one.iter().any(|&p| other.iter().any(|&q| class_of[p as usize] == class_of[q as usize]))
        };
        let mut found: Vec<_> = vertex_faces
            .chain(edge_edges)
            .filter(|pair| !adjacent(pair))
            .map(|pair| (pair, pair.distance(positions)))
            .filter(|(_, distance)| *distance < reach)
            .collect();
        found.sort_by_key(|(pair, _)| *pair);
        found
    }

    /// A flat tube, its seams closed, crumpled more or less.
    pub fn crumpled_tube(rough: f64, seed: f64) -> (Level, Vec<Vector3>) {
        let level = Garment::build(&shapes::tube(0.3, 0.2), &[0.03]).unwrap().levels.remove(0);
        let wave = |k: usize, step: f64| (k as f64 * step + seed).sin() * rough;
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        for (k, (rest, &p)) in level.rest.iter().zip(&level.particle_of).enumerate() {
            let turn = rest.x / 0.3 * std::f64::consts::TAU;
            let tube = Vector3::new(turn.sin(), 0.0, 0.1 * turn.cos()) * (0.3 / std::f64::consts::TAU);
            positions[p as usize] = tube + Vector3::new(wave(k, 12.9898), rest.y + wave(k, 78.233), wave(k, 37.719));
        }
        (level, positions)
    }

    fn in_order(mut pairs: Vec<(Pair, f64)>) -> Vec<(Pair, f64)> {
        pairs.sort_by_key(|(pair, _)| *pair);
        pairs
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn the_tree_finds_the_pairs_that_looking_at_all_finds(
            seed in 0.0..100.0f64, rough in 0.0..0.05f64, reach in 0.01..0.08f64, classes in 20..400u32, every in 1..30usize,
        ) {
            let (level, mut positions) = crumpled_tube(rough, seed);
            let triangles = level.particle_triangles();
            // Some particles far apart are to be sewn to one.
            let class_of: Vec<u32> = (0..level.particle_count as u32).map(|p| p % classes).collect();
            let mut finder = PairFinder::new(&triangles, class_of.clone(), reach);
            let found = in_order(finder.all(&positions));
            prop_assert!(rough > 0.03 || reach < 0.04 || classes < 100 || !found.is_empty());
            prop_assert_eq!(&found, &near_pairs_plainly(&triangles, &class_of, &positions, reach));
            // Some move; pairs of the others remain.
            let moved: Vec<bool> = (0..positions.len()).map(|p| p % every == 0).collect();
            let (_, elsewhere) = crumpled_tube(rough, seed + 1.0);
            positions.iter_mut().zip(&elsewhere).zip(&moved).filter(|(_, moved)| **moved).for_each(|((p, to), _)| *p = *to);
            let mut found: Vec<_> =
                found.into_iter().filter(|(pair, _)| !pair.particles.iter().any(|&p| moved[p as usize])).collect();
            found.extend(finder.near(&moved, &positions));
            prop_assert_eq!(in_order(found), near_pairs_plainly(&triangles, &class_of, &positions, reach));
        }
    }
}
