//! The triangles of one panel: its outline as given, a hexagonal lattice inside, and a constrained
//! Delaunay triangulation of both (by spade).

use super::outline::Outline;
use crate::Error;
use crate::geometry::{Vector2, cross};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use std::collections::HashMap;

/// Lattice points stay this far from the outline, in resolutions: nearer ones would make needles,
/// farther ones leave the rim too coarse.
const RIM: f64 = 0.6;

/// One panel cut into triangles.
pub struct PanelMesh {
    /// The outline's points first, in its order, then those inside; m.
    pub points: Vec<Vector2>,
    /// Counter-clockwise on the panel.
    pub triangles: Vec<[u32; 3]>,
}

struct Vertex {
    position: Point2<f64>,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// Cuts the area within `outline` into triangles with edges of about `resolution`.
pub fn triangulate(outline: &Outline, resolution: f64) -> Result<PanelMesh, Error> {
    let rim = outline.points.len();
    let mut points = outline.points.clone();
    points.extend(lattice(&outline.points, resolution));
    let vertices = points.iter().map(|p| Vertex { position: Point2::new(p.x, p.y) }).collect();
    let edges = (0..rim).map(|i| [i, (i + 1) % rim]).collect();
    let mut conflicts = 0;
    let cdt = ConstrainedDelaunayTriangulation::<Vertex>::try_bulk_load_cdt(vertices, edges, |_| conflicts += 1);
    let faulty = || {
        Error::new(
            "Its outline touches or crosses itself at this resolution.",
            "Ask for a finer resolution, or widen the narrow part of the outline.",
        )
    };
    let cdt = cdt.map_err(|_| faulty())?;
    if conflicts > 0 || cdt.num_vertices() != points.len() {
        return Err(faulty());
    }
    let triangles = inner_triangles(&cdt);
    Ok(PanelMesh { points, triangles })
}

/// The faces that a walk from the outside reaches by crossing the outline an odd number of times.
fn inner_triangles(cdt: &ConstrainedDelaunayTriangulation<Vertex>) -> Vec<[u32; 3]> {
    const UNSEEN: u8 = 2;
    let mut inside = vec![UNSEEN; cdt.num_all_faces()];
    let outer = cdt.outer_face().fix().index();
    inside[outer] = 0;
    let mut stack: Vec<_> = cdt
        .convex_hull()
        .map(|edge| {
            let inner = edge.rev();
            (inner.face().fix(), u8::from(edge.is_constraint_edge()))
        })
        .collect();
    while let Some((face, side)) = stack.pop() {
        if inside[face.index()] != UNSEEN {
            continue;
        }
        inside[face.index()] = side;
        let Some(inner) = cdt.face(face).as_inner() else { continue };
        for edge in inner.adjacent_edges() {
            let next = edge.rev().face().fix();
            stack.push((next, side ^ u8::from(edge.is_constraint_edge())));
        }
    }
    cdt.inner_faces()
        .filter(|face| inside[face.fix().index()] == 1)
        .map(|face| face.vertices().map(|v| v.fix().index() as u32))
        .collect()
}

/// Points of a lattice of equilateral triangles, one side along the weft, that lie inside the
/// polygon and not too near its rim. Symmetric about the middle of the polygon's box, so that a
/// panel and its mirror image get mirrored lattices.
fn lattice(polygon: &[Vector2], side: f64) -> Vec<Vector2> {
    let low = polygon.iter().fold(Vector2::repeat(f64::INFINITY), |a, p| a.inf(p));
    let high = polygon.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
    let row_height = side * 0.75f64.sqrt();
    let rows = ((high.y - low.y) / row_height).floor() as i64;
    let columns = ((high.x - low.x) / side).floor() as i64 + 2;
    let middle = (low + high) / 2.0;
    let near = RimGrid::new(polygon, RIM * side);
    let mut points = Vec::new();
    for row in 0..=rows {
        let y = middle.y + (row as f64 - 0.5 * rows as f64) * row_height;
        let crossings = row_crossings(polygon, y);
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        // Between a crossing and the next the row is inside.
        for inside in crossings.chunks_exact(2) {
            let column_at = |x: f64| ((x - middle.x) / side + 0.25 - shift) as i64 + columns / 2;
            for column in column_at(inside[0]) - 1..=column_at(inside[1]) + 1 {
                let x = middle.x + ((column - columns / 2) as f64 + shift - 0.25) * side;
                let point = Vector2::new(x, y);
                if inside[0] < x && x <= inside[1] && !near.touches(point) {
                    points.push(point);
                }
            }
        }
    }
    points
}

/// Where a horizontal line crosses the polygon, ascending.
fn row_crossings(polygon: &[Vector2], y: f64) -> Vec<f64> {
    let n = polygon.len();
    let mut crossings: Vec<f64> = (0..n)
        .filter_map(|i| {
            let (a, b) = (polygon[i], polygon[(i + 1) % n]);
            ((a.y <= y) != (b.y <= y)).then(|| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x))
        })
        .collect();
    crossings.sort_unstable_by(f64::total_cmp);
    crossings
}

/// The sides of a polygon in square bins, for asking whether a point is near one. Only bins that
/// hold a side exist: a narrow panel drawn aslant has a large box, nearly all of it empty.
struct RimGrid<'a> {
    polygon: &'a [Vector2],
    margin: f64,
    bins: HashMap<[i64; 2], Vec<u32>>,
}

impl<'a> RimGrid<'a> {
    fn new(polygon: &'a [Vector2], margin: f64) -> Self {
        let mut grid = Self { polygon, margin, bins: HashMap::new() };
        for i in 0..polygon.len() {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            // Every bin within one margin of the side.
            let first = grid.cell(a.inf(&b) - Vector2::repeat(margin));
            let last = grid.cell(a.sup(&b) + Vector2::repeat(margin));
            for row in first[1]..=last[1] {
                for column in first[0]..=last[0] {
                    grid.bins.entry([column, row]).or_default().push(i as u32);
                }
            }
        }
        grid
    }

    fn cell(&self, point: Vector2) -> [i64; 2] {
        [point.x, point.y].map(|c| (c / self.margin).floor() as i64)
    }

    fn touches(&self, point: Vector2) -> bool {
        let n = self.polygon.len();
        self.bins.get(&self.cell(point)).is_some_and(|sides| {
            sides.iter().any(|&i| {
                let (a, b) = (self.polygon[i as usize], self.polygon[(i as usize + 1) % n]);
                let along = ((point - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                (a + (b - a) * along - point).norm() < self.margin
            })
        })
    }
}

impl PanelMesh {
    /// Does the mesh keep what it promises? Called by tests and debug builds.
    pub fn sanity_check(&self) {
        for &[a, b, c] in &self.triangles {
            let [a, b, c] = [a, b, c].map(|i| self.points[i as usize]);
            assert!(cross(b - a, c - a) > 0.0, "a triangle of a panel is flat or clockwise");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::signed_area;

    fn polygon(corners: &[[f64; 2]], per_side: usize) -> Outline {
        let n = corners.len();
        let points = (0..n * per_side)
            .map(|k| {
                let (a, b) = (Vector2::from(corners[k / per_side]), Vector2::from(corners[(k / per_side + 1) % n]));
                a.lerp(&b, (k % per_side) as f64 / per_side as f64)
            })
            .collect();
        Outline { points, segments: (0..n).map(|k| (k * per_side, per_side)).collect() }
    }

    fn area(mesh: &PanelMesh) -> f64 {
        mesh.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.points[i as usize]);
                signed_area(a, b, c)
            })
            .sum()
    }

    #[test]
    fn a_notched_panel_is_covered_exactly_and_evenly() {
        let outline =
            polygon(&[[0.0, 0.0], [0.4, 0.0], [0.4, 0.3], [0.21, 0.3], [0.2, 0.1], [0.19, 0.3], [0.0, 0.3]], 10);
        let mesh = triangulate(&outline, 0.02).unwrap();
        mesh.sanity_check();
        assert!((area(&mesh) - (0.12 - 0.5 * 0.02 * 0.2)).abs() < 1e-12);
        let smallest = mesh.triangles.iter().map(|t| {
            let p = t.map(|i| mesh.points[i as usize]);
            (0..3).map(|k| (p[(k + 1) % 3] - p[k]).angle(&(p[(k + 2) % 3] - p[k]))).fold(f64::INFINITY, f64::min)
        });
        let small = smallest.filter(|a| a.to_degrees() < 20.0).count();
        assert!(small < mesh.triangles.len() / 50, "{small} of {} triangles are needles", mesh.triangles.len());
    }

    #[test]
    fn a_clockwise_outline_is_cut_the_same() {
        let mesh = triangulate(&polygon(&[[0.0, 0.0], [0.0, 0.1], [0.1, 0.1], [0.1, 0.0]], 4), 0.025).unwrap();
        mesh.sanity_check();
        assert!((area(&mesh) - 0.01).abs() < 1e-15);
    }

    #[test]
    fn a_crossing_outline_is_an_error_and_not_a_panic() {
        let bow_tie = polygon(&[[0.0, 0.0], [0.1, 0.0], [0.0, 0.1], [0.1, 0.1]], 1);
        assert!(triangulate(&bow_tie, 0.02).is_err());
    }
}
