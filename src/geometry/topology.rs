//! Who shares what in a triangle mesh.

use std::ops::Deref;

/// An edge of a mesh and the triangles on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The two ends, the smaller index first.
    pub ends: [u32; 2],
    /// Index of each triangle on the edge, ascending: one at a border, two inside, more where the
    /// mesh is not a manifold.
    pub triangles: Beside,
}

/// The triangles on an edge: nearly always one or two, which need no memory of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Beside {
    One([u32; 1]),
    Two([u32; 2]),
    More(Box<[u32]>),
}

impl Deref for Beside {
    type Target = [u32];
    fn deref(&self) -> &[u32] {
        match self {
            Self::One(one) => one,
            Self::Two(two) => two,
            Self::More(more) => more,
        }
    }
}

/// The edges of a triangle mesh, sorted by their ends.
pub struct EdgeTable {
    pub edges: Vec<Edge>,
}

impl EdgeTable {
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let sides = || triangles.iter().zip(0..).flat_map(|(&[a, b, c], t)| [[a, b], [b, c], [c, a]].map(|s| (s, t)));
        // Sides into places by their smaller end, then those of each end by the other: linear in all.
        let lowest = triangles.iter().flatten().copied().min().unwrap_or(0);
        let vertices = triangles.iter().flatten().max().map_or(0, |&last| (last - lowest) as usize + 1);
        let mut place = vec![0u32; vertices + 1];
        sides().for_each(|([i, j], _)| place[(i.min(j) - lowest) as usize + 1] += 1);
        (0..vertices).for_each(|v| place[v + 1] += place[v]);
        let mut sorted = vec![(0, 0); 3 * triangles.len()];
        for ([i, j], t) in sides() {
            let place = &mut place[(i.min(j) - lowest) as usize];
            sorted[*place as usize] = (i.max(j), t);
            *place += 1;
        }
        // Each end's place is now where the next one's begin.
        let mut edges = Vec::with_capacity(sorted.len() / 2 + 1);
        let mut first = 0;
        for (end, &next) in (lowest..lowest + vertices as u32).zip(&place) {
            let sides = &mut sorted[first as usize..next as usize];
            sides.sort_unstable();
            edges.extend(sides.chunk_by(|a, b| a.0 == b.0).map(|same| Edge {
                ends: [end, same[0].0],
                triangles: match *same {
                    [a] => Beside::One([a.1]),
                    [a, b] => Beside::Two([a.1, b.1]),
                    _ => Beside::More(same.iter().map(|s| s.1).collect()),
                },
            }));
            first = next;
        }
        Self { edges }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_those_that_sorting_all_sides_finds() {
        // Vertices that do not begin at zero, and an edge of three triangles.
        let mut triangles: Vec<[u32; 3]> = (0..40).map(|k| [7 + k * 5 % 11, 20 + k * 3 % 13, 40 + k % 9]).collect();
        triangles.extend([[7, 20, 60], [20, 7, 61], [7, 20, 62]]);
        let mut sides: Vec<([u32; 2], u32)> = triangles
            .iter()
            .zip(0..)
            .flat_map(|(&[a, b, c], t)| [[a, b], [b, c], [c, a]].map(|[i, j]| ([i.min(j), i.max(j)], t)))
            .collect();
        sides.sort_unstable();
        let plain: Vec<([u32; 2], Vec<u32>)> =
            sides.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same.iter().map(|s| s.1).collect())).collect();
        let ours: Vec<([u32; 2], Vec<u32>)> =
            EdgeTable::new(&triangles).edges.iter().map(|e| (e.ends, e.triangles.to_vec())).collect();
        assert_eq!(ours, plain);
        assert!(plain.iter().any(|e| e.1.len() > 2));
        assert!(EdgeTable::new(&[]).edges.is_empty());
    }

    #[test]
    fn two_triangles_share_one_edge() {
        let table = EdgeTable::new(&[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(table.edges.len(), 5);
        let shared: Vec<_> = table.edges.iter().filter(|e| e.triangles.len() == 2).collect();
        assert_eq!(shared, [&Edge { ends: [1, 2], triangles: Beside::Two([0, 1]) }]);
    }
}
