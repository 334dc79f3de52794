//! Who shares what in a triangle mesh.

/// An edge of a mesh and the triangles on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The two ends, the smaller index first.
    pub ends: [u32; 2],
    /// Index of each triangle on the edge, ascending: one at a border, two inside, more where the
    /// mesh is not a manifold.
    pub triangles: Vec<u32>,
}

/// The edges of a triangle mesh, sorted by their ends.
pub struct EdgeTable {
    pub edges: Vec<Edge>,
}

impl EdgeTable {
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let mut sides: Vec<([u32; 2], u32)> = triangles
            .iter()
            .zip(0..)
            .flat_map(|(&[a, b, c], t)| [[a, b], [b, c], [c, a]].map(|[i, j]| ([i.min(j), i.max(j)], t)))
            .collect();
        sides.sort_unstable();
        let mut edges: Vec<Edge> = Vec::with_capacity(sides.len() / 2);
        for (ends, triangle) in sides {
            match edges.last_mut() {
                Some(last) if last.ends == ends => last.triangles.push(triangle),
                _ => edges.push(Edge { ends, triangles: vec![triangle] }),
            }
        }
        Self { edges }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_share_one_edge() {
        let table = EdgeTable::new(&[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(table.edges.len(), 5);
        let shared: Vec<_> = table.edges.iter().filter(|e| e.triangles.len() == 2).collect();
        assert_eq!(shared, [&Edge { ends: [1, 2], triangles: vec![0, 1] }]);
    }
}
