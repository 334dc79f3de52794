//! One discretization of the garment. A level never changes once it is built; the state of a run is
//! one vector of positions, one per particle.

use crate::geometry::{EdgeTable, Vector2, Vector3, signed_area};
use std::ops::Range;

/// The garment at one resolution.
///
/// A *point* is a place on a panel; a *particle* is a mass point. Sewn points of several panels are
/// one particle once their seam is closed, so that rest positions belong to points and positions to
/// particles.
#[derive(Clone, Debug)]
pub struct Level {
    /// Target distance between particles, m.
    pub resolution: f64,
    pub particle_count: usize,
    /// Per panel of the pattern, in its order.
    pub panels: Vec<PanelRange>,
    /// Rest position of each point, m, panel-local.
    pub rest: Vec<Vector2>,
    /// Particle of each point.
    pub particle_of: Vec<u32>,
    /// Points of each triangle, wound so that its normal faces away from the body.
    pub triangles: Vec<[u32; 3]>,
    /// Pairs of particles to be sewn together; empty once they are welded.
    pub stitches: Vec<[u32; 2]>,
    /// Pairs of triangles that share an edge, within a panel and across closed seams.
    pub hinges: Vec<Hinge>,
    /// Per seam of the pattern: the points along both its sides, partner by partner.
    pub seams: Vec<[Vec<u32>; 2]>,
    /// Per panel and segment: the points along it, both corners included.
    pub segments: Vec<Vec<Vec<u32>>>,
    /// Edges that are sewn to shorter ones.
    pub eased: Vec<Eased>,
}

/// A triangle's edge on the longer side of a seam: the shorter side imposes its length, and what is
/// too long lies in gathers finer than the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eased {
    pub triangle: u32,
    /// The corner opposite to the edge.
    pub tip: u8,
    /// Length of the shorter side over that of the longer, below one.
    pub ratio: f64,
}

/// Where the points and triangles of a panel stand in the arrays of its level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PanelRange {
    pub points: Range<usize>,
    pub triangles: Range<usize>,
}

/// Two triangles across an edge.
///
/// ```text
///          1                 ends: the edge 0-1
///        / | \               tips: 2 in the first triangle, 3 in the second
///       2  |  3
///        \ | /
///          0
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hinge {
    pub triangles: [u32; 2],
    /// In each triangle, which of its corners is the tip.
    pub tips: [u8; 2],
}

impl Level {
    /// Particles of a triangle.
    pub fn particles(&self, triangle: usize) -> [u32; 3] {
        self.triangles[triangle].map(|p| self.particle_of[p as usize])
    }

    /// Rest positions of a triangle's corners, m, panel-local.
    pub fn rest_corners(&self, triangle: usize) -> [Vector2; 3] {
        self.triangles[triangle].map(|p| self.rest[p as usize])
    }

    /// Triangles of particles, for whoever needs the sewn mesh.
    pub fn particle_triangles(&self) -> Vec<[u32; 3]> {
        (0..self.triangles.len()).map(|t| self.particles(t)).collect()
    }

    /// Rest area of each triangle, m², positive.
    pub fn rest_areas(&self) -> Vec<f64> {
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.rest_corners(t);
                signed_area(a, b, c).abs()
            })
            .collect()
    }

    /// The rest area that each particle stands for, m²: a third of its triangles'.
    pub fn particle_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.particle_count];
        for (t, area) in self.rest_areas().into_iter().enumerate() {
            for p in self.particles(t) {
                areas[p as usize] += area / 3.0;
            }
        }
        areas
    }

    /// Mass of each particle, kg, where `density` tells that of a panel, kg/m².
    pub fn particle_masses(&self, density: impl Fn(usize) -> f64) -> Vec<f64> {
        let areas = self.rest_areas();
        let mut masses = vec![0.0; self.particle_count];
        for (panel, range) in self.panels.iter().enumerate() {
            for t in range.triangles.clone() {
                for p in self.particles(t) {
                    masses[p as usize] += areas[t] / 3.0 * density(panel);
                }
            }
        }
        masses
    }

    /// The panel of each triangle.
    pub fn panel_of_triangle(&self) -> Vec<u32> {
        let mut panel_of = vec![0; self.triangles.len()];
        for (panel, range) in self.panels.iter().enumerate() {
            panel_of[range.triangles.clone()].fill(panel as u32);
        }
        panel_of
    }

    /// Position of each point, given those of the particles, m, world.
    pub fn point_positions(&self, positions: &[Vector3]) -> Vec<Vector3> {
        self.particle_of.iter().map(|&p| positions[p as usize]).collect()
    }

    /// Edges between particles that several panels share: the sewn seam lines.
    pub fn seam_edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::new();
        for [side, _] in &self.seams {
            edges.extend(side.windows(2).map(|w| [self.particle_of[w[0] as usize], self.particle_of[w[1] as usize]]));
        }
        edges
    }

    /// Does the level keep what it promises? Called by tests and debug builds.
    pub fn sanity_check(&self) {
        assert_eq!(self.rest.len(), self.particle_of.len());
        let mut named = vec![false; self.particle_count];
        for &p in &self.particle_of {
            named[p as usize] = true;
        }
        assert!(named.iter().all(|&n| n), "a particle belongs to no point");
        for (panel, range) in self.panels.iter().enumerate() {
            for t in range.triangles.clone() {
                assert!(self.triangles[t].iter().all(|&p| range.points.contains(&(p as usize))), "panel {panel}");
            }
        }
        for t in 0..self.triangles.len() {
            let [a, b, c] = self.particles(t);
            assert!(a != b && b != c && c != a, "sewing folds triangle {t} onto itself");
        }
        for hinge in &self.hinges {
            let ends = |k: usize| {
                let corners = self.particles(hinge.triangles[k] as usize);
                let tip = hinge.tips[k] as usize;
                let mut ends = [corners[(tip + 1) % 3], corners[(tip + 2) % 3]];
                ends.sort_unstable();
                ends
            };
            assert_eq!(ends(0), ends(1), "the triangles of a hinge share no edge");
        }
    }
}

/// What is on each side of the edges of one panel.
pub struct PanelEdges {
    /// The hinges inside the panel.
    pub hinges: Vec<Hinge>,
    /// The edges along its outline, by their points.
    pub rim: Vec<RimEdge>,
}

/// An edge with a triangle on one side only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RimEdge {
    /// Points, the smaller first.
    pub ends: [u32; 2],
    pub triangle: u32,
    /// The corner of the triangle that is off the edge.
    pub tip: u8,
}

/// The edges of a panel, given its triangles; the first of them has the index `first_triangle` in its level.
pub fn panel_edges(triangles: &[[u32; 3]], first_triangle: u32) -> PanelEdges {
    let tip = |triangle: u32, ends: [u32; 2]| {
        let corners = triangles[triangle as usize];
        corners.iter().position(|c| !ends.contains(c)).expect("a triangle has a corner off each of its edges") as u8
    };
    let mut edges = PanelEdges { hinges: Vec::with_capacity(triangles.len() * 3 / 2), rim: Vec::new() };
    for edge in EdgeTable::new(triangles).edges {
        match *edge.triangles {
            [a] => {
                edges.rim.push(RimEdge { ends: edge.ends, triangle: a + first_triangle, tip: tip(a, edge.ends) });
            }
            [a, b] => edges.hinges.push(Hinge {
                triangles: [a + first_triangle, b + first_triangle],
                tips: [tip(a, edge.ends), tip(b, edge.ends)],
            }),
            _ => {}
        }
    }
    edges
}
