//! The surface that seams make of panels: its pieces, its rims, its handles.
//!
//! Corners that meet are one vertex, sewn edges are one edge, panels are faces. A surface with `b` rims and `h` handles has
//! `V - E + F = 2 - 2h - b` (Euler's characteristic). Garments have rims, which bodies pass through, and no handles: a handle
//! comes about where seams cross, as of sides sewn to the wrong partners.

use super::{Pattern, Seam, SegmentId, Sense};
use crate::geometry::UnionFind;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

/// What seams make of some panels that hang together.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The openings: of each the edges around it that are not sewn, ascending.
    pub rims: Vec<Vec<SegmentId>>,
    /// Of a surface with two sides.
    pub handles: usize,
    /// Of its panels, m².
    area: f64,
}

impl Surface {
    /// Of the panels of one piece, ascending, and of those of the seams that have both sides on them.
    pub fn new(pattern: &Pattern, panels: &[usize], seams: &[Seam]) -> Self {
        let has = |side: SegmentId| panels.binary_search(&side.panel).is_ok();
        let within = || seams.iter().filter(|seam| seam.sides.iter().all(|&side| has(side)));
        let mut corners = Corners::new(pattern, within());
        let sewn: BTreeSet<SegmentId> = within().flat_map(|seam| seam.sides).collect();
        let edges_of =
            |&panel: &usize| (0..pattern.panels[panel].segments.len()).map(move |segment| SegmentId { panel, segment });
        let edges: Vec<SegmentId> = panels.iter().flat_map(edges_of).collect();
        let mut vertices = BTreeSet::new();
        let mut rim_of = UnionFind::new(corners.count);
        for &edge in &edges {
            let ends = corners.vertices(pattern, edge);
            vertices.extend(ends);
            if !sewn.contains(&edge) {
                rim_of.union(ends[0], ends[1]);
            }
        }
        let mut rims: BTreeMap<u32, Vec<SegmentId>> = BTreeMap::new();
        for &edge in edges.iter().filter(|edge| !sewn.contains(edge)) {
            rims.entry(rim_of.find(corners.vertices(pattern, edge)[0])).or_default().push(edge);
        }
        let characteristic = (vertices.len() + panels.len()) as i64 - (edges.len() - sewn.len() / 2) as i64;
        let handles = ((2 - rims.len() as i64 - characteristic) / 2).max(0) as usize;
        let area = panels.iter().map(|&panel| pattern.panels[panel].signed_area().abs()).sum();
        Self { rims: rims.into_values().collect(), handles, area }
    }

    /// Can nothing pass through? It is closed all around, or has one opening alone, which is shorter than any line that lies
    /// flat around so much cloth: of these a circle is the shortest, `L² = 4πA`.
    pub fn is_bag(&self, pattern: &Pattern) -> bool {
        match &self.rims[..] {
            [] => true,
            [rim] => {
                let length: f64 = rim.iter().map(|&edge| pattern.segment(edge).curve.length()).sum();
                length * length < 4.0 * PI * self.area
            }
            _ => false,
        }
    }
}

/// Panels that hang together, the largest piece first; pieces of one size in the order of the pattern. Each ascending.
pub fn pieces(pattern: &Pattern) -> Vec<Vec<usize>> {
    let all: Vec<usize> = (0..pattern.panels.len()).collect();
    let mut pieces = pieces_of(&all, &pattern.seams);
    pieces.sort_by_key(|piece| (usize::MAX - piece.len(), piece[0]));
    pieces
}

/// Those of some panels, ascending, that hang together by seams among them, in the order of their first panels.
pub fn pieces_of(panels: &[usize], seams: &[Seam]) -> Vec<Vec<usize>> {
    let mut sets = UnionFind::new(panels.len());
    let number = |side: SegmentId| panels.binary_search(&side.panel).ok();
    for seam in seams {
        if let [Some(a), Some(b)] = seam.sides.map(number) {
            sets.union(a as u32, b as u32);
        }
    }
    let mut pieces: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    (0..panels.len()).for_each(|k| pieces.entry(sets.find(k as u32)).or_default().push(panels[k]));
    let mut pieces: Vec<Vec<usize>> = pieces.into_values().collect();
    pieces.sort();
    pieces
}

/// Corners that the seams bring together, one set per vertex.
struct Corners {
    /// Of all panels.
    count: usize,
    /// Per panel: number of its first corner.
    first: Vec<u32>,
    sets: UnionFind,
}

impl Corners {
    fn new<'a>(pattern: &Pattern, seams: impl Iterator<Item = &'a Seam>) -> Self {
        let mut count: u32 = 0;
        let first = pattern.panels.iter().map(|panel| {
            count += panel.segments.len() as u32;
            count - panel.segments.len() as u32
        });
        let first: Vec<u32> = first.collect();
        let count = count as usize;
        let mut corners = Self { count, first, sets: UnionFind::new(count) };
        for seam in seams {
            let [a, b] = seam.sides.map(|side| corners.ends(pattern, side));
            let b = if seam.sense == Sense::Opposed { [b[1], b[0]] } else { b };
            corners.sets.union(a[0], b[0]);
            corners.sets.union(a[1], b[1]);
        }
        corners
    }

    /// Of an edge, its start and its end.
    fn ends(&self, pattern: &Pattern, side: SegmentId) -> [u32; 2] {
        let count = pattern.panels[side.panel].segments.len();
        [side.segment, (side.segment + 1) % count].map(|k| self.first[side.panel] + k as u32)
    }

    /// Of an edge, the vertices at its start and at its end.
    fn vertices(&mut self, pattern: &Pattern, side: SegmentId) -> [u32; 2] {
        self.ends(pattern, side).map(|corner| self.sets.find(corner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::shapes::{polygon, rectangle, tube, two_rectangles};

    /// Front and back of a sleeve, 40 by 50 cm, sewn along these of their edges; they lie on each other, right sides out.
    fn sleeve(edges: &[usize]) -> Pattern {
        let side = |panel, segment| SegmentId { panel, segment };
        let seam = |&edge: &usize| Seam { sides: [side(0, edge), side(1, edge)], sense: Sense::Aligned };
        Pattern {
            name: "sleeve".to_owned(),
            panels: vec![rectangle("front", 0.4, 0.5), rectangle("back", 0.4, 0.5)],
            seams: edges.iter().map(seam).collect(),
        }
    }

    fn surface(pattern: &Pattern) -> Surface {
        let pieces = pieces(pattern);
        Surface::new(pattern, &pieces[0], &pattern.seams)
    }

    #[test]
    fn tubes_have_two_rims_flat_pieces_one_and_bags_none_to_speak_of() {
        for (edges, rims, bag) in [
            (vec![1], 1, false),
            (vec![1, 3], 2, false),
            (vec![1, 2], 1, true),
            (vec![1, 2, 3], 1, true),
            (vec![0, 1, 2, 3], 0, true),
        ] {
            let sewn = sleeve(&edges);
            let made = surface(&sewn);
            assert_eq!((made.rims.len(), made.handles, made.is_bag(&sewn)), (rims, 0, bag), "{edges:?}");
        }
        assert_eq!(surface(&tube(0.5, 0.3)).rims.len(), 2);
        assert!(!surface(&two_rectangles(0.2, 0.3)).is_bag(&two_rectangles(0.2, 0.3)));
    }

    #[test]
    fn opposite_sides_of_a_square_joined_both_ways_are_a_tyre_with_a_hole() {
        let corners = [[0.1, 0.0], [0.3, 0.0], [0.4, 0.1], [0.4, 0.3], [0.3, 0.4], [0.1, 0.4], [0.0, 0.3], [0.0, 0.1]];
        let side = |segment| SegmentId { panel: 0, segment };
        let seam = |a, b| Seam { sides: [side(a), side(b)], sense: Sense::Opposed };
        let tyre = Pattern {
            name: "tyre".to_owned(),
            panels: vec![polygon("square", &corners)],
            seams: vec![seam(0, 4), seam(2, 6)],
        };
        assert_eq!((surface(&tyre).rims.len(), surface(&tyre).handles), (1, 1));
    }
}
