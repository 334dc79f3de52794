//! Control cages and Catmull–Clark subdivision of a body of which only the left half is stored.
//!
//! Catmull & Clark, "Recursively generated B-spline surfaces on arbitrary topological meshes", Computer-Aided Design
//! 10(6), 1978; limit positions after Halstead, Kass & DeRose, "Efficient, fair interpolation using Catmull-Clark
//! surfaces", SIGGRAPH 1993; interpolation by repeated correction after Maekawa, Matsumoto & Namiki, "Interpolation by
//! geometric algorithm", Computer-Aided Design 39(4), 2007.
//!
//! The half lies in x >= 0. Its boundary lies exactly on the plane x = 0, and every rule behaves as if the mirror image
//! stood beyond it, so the whole body is symmetric to the last bit.

use crate::geometry::Vector3;

/// Corrections made when a cage is fitted to surface points. The error shrinks to about a third each time; what remains
/// after these is below 0.1 mm, and far more of them would only sharpen what the surface cannot bend to.
const FIT_CORRECTION_COUNT: usize = 10;

/// A quad mesh of the left half of a body.
#[derive(Clone, Debug, Default)]
pub(super) struct Cage {
    /// m; a vertex belongs to the mirror plane when x is exactly 0.
    pub positions: Vec<Vector3>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
}

/// Sums over the quads around each vertex, mirror image included.
struct Star {
    face_count: f64,
    /// Neighbors along edges, each counted twice (once from either side).
    twice_edges: Vector3,
    /// Opposite corners of the quads.
    diagonals: Vector3,
}

impl Cage {
    pub fn add(&mut self, position: Vector3) -> u32 {
        self.positions.push(position);
        (self.positions.len() - 1) as u32
    }

    /// The cage whose limit surface passes through the positions of this one.
    pub fn fitted(&self) -> Cage {
        let mut cage = self.clone();
        for _ in 0..FIT_CORRECTION_COUNT {
            let limit = cage.limit_positions();
            for (position, (target, reached)) in cage.positions.iter_mut().zip(self.positions.iter().zip(&limit)) {
                *position += target - reached;
            }
        }
        cage
    }

    /// Where each vertex would go under endless subdivision.
    pub fn limit_positions(&self) -> Vec<Vector3> {
        let limit = |(position, star): (&Vector3, &Star)| {
            let n = star.face_count;
            let sum = position * (n * n) + star.twice_edges * 2.0 + star.diagonals;
            sum / (n * (n + 5.0))
        };
        self.positions.iter().zip(&self.stars()).map(limit).collect()
    }

    /// One step of Catmull–Clark subdivision.
    pub fn subdivided(&self) -> Cage {
        let edges = self.edges();
        let mut positions: Vec<Vector3> =
            self.positions.iter().zip(&self.stars()).map(|(position, star)| moved_vertex(position, star)).collect();
        let first_edge = positions.len() as u32;
        positions.extend(edges.iter().map(|edge| self.edge_point(edge)));
        let first_face = positions.len() as u32;
        positions.extend(self.quads.iter().map(|quad| self.center(quad)));

        let edge_between = |a: u32, b: u32| {
            let key = (a.min(b), a.max(b));
            let place =
                edges.binary_search_by_key(&key, |edge| edge.vertices).expect("every side of a quad is an edge");
            first_edge + place as u32
        };
        let quarter = |(index, quad): (usize, &[u32; 4])| {
            let center = first_face + index as u32;
            let quad = *quad;
            (0..4).map(move |i| {
                let (here, next, before) = (quad[i], quad[(i + 1) % 4], quad[(i + 3) % 4]);
                [here, edge_between(here, next), center, edge_between(before, here)]
            })
        };
        let quads = self.quads.iter().enumerate().flat_map(quarter).collect();
        Cage { positions, quads }
    }

    fn stars(&self) -> Vec<Star> {
        let empty = || Star { face_count: 0.0, twice_edges: Vector3::zeros(), diagonals: Vector3::zeros() };
        let mut stars: Vec<Star> = self.positions.iter().map(|_| empty()).collect();
        for quad in &self.quads {
            let at = |i: usize| self.positions[quad[i % 4] as usize];
            for i in 0..4 {
                let star = &mut stars[quad[i] as usize];
                star.face_count += 1.0;
                star.twice_edges += at(i + 1) + at(i + 3);
                star.diagonals += at(i + 2);
            }
        }
        for (star, position) in stars.iter_mut().zip(&self.positions) {
            if position.x == 0.0 {
                star.face_count *= 2.0;
                star.twice_edges = with_mirror_image(star.twice_edges);
                star.diagonals = with_mirror_image(star.diagonals);
            }
        }
        stars
    }

    /// All edges, sorted by their vertices.
    fn edges(&self) -> Vec<Edge> {
        let mut sides: Vec<((u32, u32), u32)> = Vec::with_capacity(4 * self.quads.len());
        for (index, quad) in self.quads.iter().enumerate() {
            for i in 0..4 {
                let (a, b) = (quad[i], quad[(i + 1) % 4]);
                sides.push(((a.min(b), a.max(b)), index as u32));
            }
        }
        sides.sort_unstable();
        let group = |run: &[((u32, u32), u32)]| Edge {
            vertices: run[0].0,
            left: run[0].1,
            right: run.get(1).map(|side| side.1),
        };
        sides.chunk_by(|a, b| a.0 == b.0).map(group).collect()
    }

    fn edge_point(&self, edge: &Edge) -> Vector3 {
        let ends = self.positions[edge.vertices.0 as usize] + self.positions[edge.vertices.1 as usize];
        let left = self.center(&self.quads[edge.left as usize]);
        let faces = match edge.right {
            Some(right) => left + self.center(&self.quads[right as usize]),
            None => with_mirror_image(left),
        };
        (ends + faces) / 4.0
    }

    fn center(&self, quad: &[u32; 4]) -> Vector3 {
        let sum: Vector3 = quad.iter().map(|&vertex| self.positions[vertex as usize]).sum();
        sum / 4.0
    }
}

/// An edge and the quads beside it; `right` is missing on the mirror plane.
struct Edge {
    vertices: (u32, u32),
    left: u32,
    right: Option<u32>,
}

/// The vertex rule (Q + 2R + (n - 3) S) / n of Catmull & Clark, written in sums over neighbors.
fn moved_vertex(position: &Vector3, star: &Star) -> Vector3 {
    let n = star.face_count;
    let s = position;
    let mean_face = (s * n + star.twice_edges + star.diagonals) / (4.0 * n);
    let mean_edge_middle = (s + star.twice_edges / (2.0 * n)) / 2.0;
    (mean_face + mean_edge_middle * 2.0 + s * (n - 3.0)) / n
}

/// v plus its mirror image in the plane x = 0.
fn with_mirror_image(v: Vector3) -> Vector3 {
    Vector3::new(0.0, 2.0 * v.y, 2.0 * v.z)
}
