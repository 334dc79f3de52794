//! Garments that are worn one over the other: do they cross, and how near do they come to each other?

use crate::geometry::{RunTree, Vector3, triangle_distance, triangles_intersect};
use std::collections::BTreeMap;

/// What was measured between garments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Pairs of triangles that cross, by the two garments, the inner one first.
    pub crossing: BTreeMap<[u32; 2], usize>,
    /// The least distance between two garments, m, by exact distances of triangles; zero where some cross, `None` where
    /// they are farther apart than was looked.
    pub least_distance: Option<f64>,
    /// Triangles that cross others, ascending.
    pub triangles: Vec<u32>,
}

impl Layers {
    /// Of triangles by their corners among the positions, m, world, and the garments they belong to. Distances beyond
    /// `within`, m, are not looked for.
    pub fn of(triangles: &[[u32; 3]], garment_of: &[u32], positions: &[Vector3], within: f64) -> Self {
        if garment_of.first() == garment_of.last() {
            return Self::default();
        }
        let corners = |t: u32| triangles[t as usize].map(|p| positions[p as usize]);
        let grown = Vector3::repeat(0.5 * within);
        let tree = RunTree::new((0..triangles.len() as u32).map(|t| {
            let [a, b, c] = corners(t);
            (a.inf(&b).inf(&c) - grown, a.sup(&b).sup(&c) + grown)
        }));
        let near = tree.collect_pairs(|t, u, found: &mut Vec<([u32; 2], [u32; 2], f64)>| {
            let garments = [garment_of[t as usize], garment_of[u as usize]];
            if garments[0] == garments[1] {
                return;
            }
            let (one, other) = (corners(t), corners(u));
            let distance = if triangles_intersect(one, other) { 0.0 } else { triangle_distance(one, other) };
            if distance <= within {
                found.push(([garments[0].min(garments[1]), garments[0].max(garments[1])], [t, u], distance));
            }
        });
        let mut layers = Self::default();
        for (garments, pair, distance) in near {
            if distance == 0.0 {
                layers.triangles.extend(pair);
                *layers.crossing.entry(garments).or_default() += 1;
            }
            layers.least_distance = Some(layers.least_distance.map_or(distance, |least| least.min(distance)));
        }
        layers.triangles.sort_unstable();
        layers.triangles.dedup();
        layers
    }

    /// Pairs of triangles that cross, in all.
    pub fn pairs(&self) -> usize {
        self.crossing.values().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two level triangles of two garments, the second `above` the first, m, its last corner lower by `dip`.
    fn stacked(above: f64, dip: f64) -> Layers {
        let flat = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]];
        let at = |[x, z]: [f64; 2], y: f64| Vector3::new(x, y, z);
        let mut positions: Vec<Vector3> = flat.iter().map(|&p| at(p, 0.0)).collect();
        positions.extend(flat.map(|[x, z]| at([x + 0.01, z + 0.01], above)));
        positions[3].y -= dip;
        Layers::of(&[[0, 1, 2], [3, 4, 5]], &[0, 1], &positions, 0.01)
    }

    #[test]
    fn distances_between_garments_are_exact_and_crossings_are_counted() {
        let apart = stacked(0.004, 0.0);
        assert_eq!(apart.pairs(), 0);
        assert!((apart.least_distance.unwrap() - 0.004).abs() < 1e-15);
        assert_eq!(stacked(0.02, 0.0), Layers::default());
        let crossing = stacked(0.004, 0.006);
        assert_eq!((crossing.crossing[&[0, 1]], crossing.least_distance), (1, Some(0.0)));
    }

    #[test]
    fn one_garment_has_no_layers() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector3::from);
        assert_eq!(Layers::of(&[[0, 1, 2]], &[0], &positions, 1.0), Layers::default());
    }
}
