//! Vertices that a file splits where textures, normals or materials end, made one again.
//!
//! Only vertices on open edges are looked at, and only those become one that lie at exactly the same place and are moved
//! alike: where the skin touches itself, as at lips, nothing is joined.

use super::surface::{Surface, Vertex};
use crate::body::motion::Morph;
use crate::geometry::Vector3;
use std::collections::BTreeMap;

/// Weights that differ by less are alike; exporters round each copy of a vertex by itself.
const ALIKE: f64 = 1e-3;
/// So many vertices of one place are compared, lest a file in which all lie there takes forever.
const MOST_COMPARED: usize = 16;

impl Surface {
    /// Welds, then drops triangles that have lost their area and vertices that belong to none.
    pub fn weld(&mut self) {
        let mut place: Vec<u32> = (0..self.vertices.len() as u32).collect();
        let displacements = self.displacements();
        let mut met: BTreeMap<[u64; 3], Vec<u32>> = BTreeMap::new();
        for v in self.open_vertices() {
            let vertex = &self.vertices[v as usize];
            // Adding zero makes zero of minus zero.
            let bits = |c: f64| (c + 0.0).to_bits();
            let there = met.entry([0, 1, 2].map(|k| bits(vertex.position[k]))).or_default();
            let alike = |&&other: &&u32| {
                let same = |v: u32| displacements.get(&v);
                moved_alike(vertex, &self.vertices[other as usize]) && same(v) == same(other)
            };
            match there.iter().find(alike) {
                Some(&other) => place[v as usize] = other,
                None if there.len() < MOST_COMPARED => there.push(v),
                None => {}
            }
        }
        self.triangles.iter_mut().flatten().for_each(|v| *v = place[*v as usize]);
        self.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        self.drop_unused();
    }

    /// Vertices on edges that have a triangle on one side only, ascending.
    fn open_vertices(&self) -> Vec<u32> {
        let mut sides: Vec<[u32; 2]> = self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        sides.sort_unstable();
        let open = sides.iter().filter(|[a, b]| sides.binary_search(&[*b, *a]).is_err());
        let mut vertices: Vec<u32> = open.flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// By how much each morph moves each vertex that it moves: number of the target and displacement.
    fn displacements(&self) -> BTreeMap<u32, Vec<(usize, usize, Vector3)>> {
        let mut all: BTreeMap<u32, Vec<(usize, usize, Vector3)>> = BTreeMap::new();
        for (node, target, Morph(moved)) in &self.morphs {
            moved.iter().for_each(|&(v, by)| all.entry(v).or_default().push((*node, *target, by)));
        }
        all
    }

    fn drop_unused(&mut self) {
        let mut used = vec![false; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let mut new = vec![u32::MAX; used.len()];
        let kept = (0..used.len()).filter(|&v| used[v]);
        kept.zip(0..).for_each(|(v, k)| new[v] = k);
        let mut v = 0;
        self.vertices.retain(|_| {
            v += 1;
            used[v - 1]
        });
        self.triangles.iter_mut().flatten().for_each(|v| *v = new[*v as usize]);
        for (_, _, Morph(moved)) in &mut self.morphs {
            moved.retain(|&(v, _)| used[v as usize]);
            moved.iter_mut().for_each(|(v, _)| *v = new[*v as usize]);
        }
    }
}

fn moved_alike(a: &Vertex, b: &Vertex) -> bool {
    let weight = |of: &Vertex, bone: u32| of.influences.iter().find(|i| i.0 == bone).map_or(0.0, |i| i.1);
    let bones = || a.influences.iter().chain(&b.influences).map(|i| i.0);
    bones().all(|bone| (weight(a, bone) - weight(b, bone)).abs() < ALIKE)
}
