//! The garment as one surface: its panels sewn together, before it has a place in space.
//!
//! Seams alone say how far anything is from anything along the cloth, and where the cloth ends: at necklines, cuffs and hems.

use crate::Error;
use crate::garment::{Garment, Level};
use crate::geometry::{EdgeTable, UnionFind};
use crate::pattern::Pattern;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Particles that the surface should have: enough for a sleeve, few enough for a thousand sweeps.
const PARTICLES: f64 = 1500.0;
/// Bounds of its resolution, m: a cuff has an edge across it, and a scarf is no fine mesh.
const RESOLUTIONS: [f64; 2] = [0.012, 0.04];

pub struct Surface {
    /// Sewn.
    pub level: Level,
    /// Per particle: those it shares an edge with, and how far they are along the cloth, m.
    pub neighbors: Vec<Vec<(u32, f64)>>,
    /// Per particle: the connected piece of the garment that it belongs to, counted from 0.
    pub piece_of: Vec<usize>,
    pub pieces: usize,
    /// Per triangle.
    pub panel_of: Vec<u32>,
    pub rims: Vec<Rim>,
}

/// A closed line along which nothing is sewn.
pub struct Rim {
    /// In the order in which one walks with the cloth at the left hand, seen from outside; each with the length from the first, m.
    pub particles: Vec<(u32, f64)>,
    /// m.
    pub length: f64,
    /// Length of each panel's part, m; panels in their order.
    pub panels: Vec<(usize, f64)>,
    pub piece: usize,
}

impl Surface {
    pub fn new(pattern: &Pattern) -> Result<Self, Error> {
        let area: f64 = pattern.panels.iter().map(|panel| panel.signed_area().abs()).sum();
        let resolution = (area / PARTICLES).sqrt().clamp(RESOLUTIONS[0], RESOLUTIONS[1]);
        let mut garment = Garment::build(pattern, &[resolution])?;
        let level = garment.levels.remove(0);
        let panel_of = level.panel_of_triangle();
        let triangles = level.particle_triangles();
        let edges = EdgeTable::new(&triangles).edges;
        let mut neighbors = vec![Vec::new(); level.particle_count];
        let mut connected = UnionFind::new(level.particle_count);
        let mut open = Vec::new();
        for edge in &edges {
            let [a, b] = edge.ends;
            let lengths = edge.triangles.iter().map(|&t| rest_length(&level, t as usize, a, b));
            let length = lengths.sum::<f64>() / edge.triangles.len() as f64;
            neighbors[a as usize].push((b, length));
            neighbors[b as usize].push((a, length));
            connected.union(a, b);
            if let [t] = *edge.triangles {
                let corners = triangles[t as usize];
                let forward = (0..3).any(|k| corners[k] == a && corners[(k + 1) % 3] == b);
                let [from, to] = if forward { [a, b] } else { [b, a] };
                open.push(OpenEdge { from, to, length, panel: panel_of[t as usize] as usize });
            }
        }
        let roots: Vec<u32> = (0..level.particle_count as u32).filter(|&p| connected.find(p) == p).collect();
        let piece_of: Vec<usize> =
            (0..level.particle_count as u32).map(|p| roots.partition_point(|&r| r < connected.find(p))).collect();
        let rims = walk(&open, level.particle_count, &piece_of);
        Ok(Self { level, neighbors, piece_of, pieces: roots.len(), panel_of, rims })
    }

    /// How far each particle is from the nearest of some, along edges, m; infinite on other pieces.
    pub fn distances(&self, from: impl Iterator<Item = u32>) -> Vec<f64> {
        let mut distances = vec![f64::INFINITY; self.neighbors.len()];
        // Distances are not negative, so that their bits have their order.
        let mut heap: BinaryHeap<Reverse<(u64, u32)>> = BinaryHeap::new();
        for p in from {
            distances[p as usize] = 0.0;
            heap.push(Reverse((0, p)));
        }
        while let Some(Reverse((bits, p))) = heap.pop() {
            let distance = f64::from_bits(bits);
            if distance > distances[p as usize] {
                continue;
            }
            for &(q, length) in &self.neighbors[p as usize] {
                let through = distance + length;
                if through < distances[q as usize] {
                    distances[q as usize] = through;
                    heap.push(Reverse((through.to_bits(), q)));
                }
            }
        }
        distances
    }
}

impl Rim {
    pub fn indices(&self) -> impl Iterator<Item = u32> + '_ {
        self.particles.iter().map(|&(p, _)| p)
    }
}

struct OpenEdge {
    from: u32,
    to: u32,
    length: f64,
    panel: usize,
}

/// Edges of one triangle, end to end. Where several lines meet in a particle they may be followed in either way.
fn walk(edges: &[OpenEdge], particles: usize, piece_of: &[usize]) -> Vec<Rim> {
    let mut at = vec![Vec::new(); particles];
    for (k, edge) in edges.iter().enumerate() {
        at[edge.from as usize].push(k);
        at[edge.to as usize].push(k);
    }
    let mut used = vec![false; edges.len()];
    let mut rims = Vec::new();
    for first in 0..edges.len() {
        if used[first] {
            continue;
        }
        let (mut line, mut length, mut panels) = (Vec::new(), 0.0, std::collections::BTreeMap::new());
        let (mut edge, mut from) = (first, edges[first].from);
        loop {
            used[edge] = true;
            line.push((from, length));
            length += edges[edge].length;
            *panels.entry(edges[edge].panel).or_insert(0.0) += edges[edge].length;
            from = if edges[edge].from == from { edges[edge].to } else { edges[edge].from };
            let onwards = at[from as usize].iter().filter(|&&k| !used[k]);
            // Folded seams turn the surface over: then the line goes on against the direction of its edges.
            let Some(&next) = onwards.min_by_key(|&&k| edges[k].from != from) else { break };
            edge = next;
        }
        let piece = piece_of[from as usize];
        rims.push(Rim { particles: line, length, panels: panels.into_iter().collect(), piece });
    }
    rims
}

fn rest_length(level: &Level, triangle: usize, a: u32, b: u32) -> f64 {
    let corners = level.particles(triangle);
    let rest = level.rest_corners(triangle);
    let place = |p: u32| rest[corners.iter().position(|&c| c == p).expect("the edge is one of the triangle")];
    (place(a) - place(b)).norm()
}
