//! What of the surface is exposed.
//!
//! Bodies pass through themselves, at armpits, between toes: triangles of one part lie inside another.
//! Nobody can touch them, and a distance that ends there asks cloth for a place that does not exist.
//! The body that counts is the union of what its parts enclose, its skin the border of that.
//!
//! Triangles that cross others are cut along the planes of those, so that each piece lies on one side
//! of all of them; the rest falls into patches, connected over edges, that cross nothing. A winding
//! number just above its middle tells whether a piece is hidden, a few of them whether a patch is.
//!
//! Not promised: that crossings of triangles which share a vertex are seen (skin folded onto itself), and
//! that triangles are cut by more than the first [`MOST_CUTS`] others that cross them. What is doubtful
//! counts as exposed.

use super::winding::winding_number;
use crate::geometry::{EdgeTable, RunTree, UnionFind, Vector3, triangles_intersect};
use rayon::prelude::*;
use std::ops::Range;

/// The exposed part of a body's surface.
pub struct Skin {
    /// One per triangle.
    exposure: Vec<Exposure>,
    /// What is exposed of triangles that are partly hidden.
    pieces: Vec<[Vector3; 3]>,
}

/// How much of a triangle is exposed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Exposure {
    Whole,
    Hidden,
    /// These of the skin's pieces.
    Partly(Range<u32>),
}

/// How far above the skin it is asked whether the place is inside, m: far more than rounding, far less
/// than anything that matters.
const ABOVE: f64 = 1e-6;
/// Corners nearer to a plane than this, m, lie in it: pieces become no thinner.
const IN_PLANE: f64 = 1e-9;
/// By how many others a triangle is cut at the most. Two or three are usual.
const MOST_CUTS: usize = 16;
/// A patch counts as hidden when so many of its triangles are, evenly chosen.
const PATCH_SAMPLES: usize = 8;

impl Skin {
    /// The skin of a closed mesh: m, world; vertices of each triangle, counter-clockwise from outside.
    pub fn new(positions: &[Vector3], triangles: &[[u32; 3]]) -> Self {
        let surface = Surface::new(positions, triangles);
        let crossings = surface.crossings();
        let mut exposure = vec![Exposure::Whole; triangles.len()];
        for patch in surface.patches(&crossings) {
            let step = patch.len().div_ceil(PATCH_SAMPLES);
            if patch.iter().step_by(step).all(|&t| surface.hides(surface.corners(t), &surface.corners(t))) {
                patch.iter().for_each(|&t| exposure[t as usize] = Exposure::Hidden);
            }
        }
        let crossed: Vec<u32> = (0..triangles.len() as u32).filter(|&t| !crossings[t as usize].is_empty()).collect();
        let cut: Vec<Option<Vec<[Vector3; 3]>>> =
            crossed.par_iter().map(|&t| surface.exposed_pieces(t, &crossings[t as usize])).collect();
        let mut pieces = Vec::new();
        for (t, exposed) in crossed.into_iter().zip(cut) {
            let first = pieces.len() as u32;
            exposure[t as usize] = match exposed {
                None => Exposure::Whole,
                Some(some) if some.is_empty() => Exposure::Hidden,
                Some(some) => {
                    pieces.extend(some);
                    Exposure::Partly(first..pieces.len() as u32)
                }
            };
        }
        Self { exposure, pieces }
    }

    pub fn exposure(&self, triangle: u32) -> &Exposure {
        &self.exposure[triangle as usize]
    }

    pub fn pieces(&self, range: &Range<u32>) -> &[[Vector3; 3]] {
        &self.pieces[range.start as usize..range.end as usize]
    }
}

/// A mesh and a tree over its triangles, which it has in spatial order.
struct Surface<'a> {
    positions: &'a [Vector3],
    triangles: &'a [[u32; 3]],
    order: Vec<u32>,
    tree: RunTree,
}

impl<'a> Surface<'a> {
    fn new(positions: &'a [Vector3], triangles: &'a [[u32; 3]]) -> Self {
        let corners = |t: u32| triangles[t as usize].map(|v| positions[v as usize]);
        let low = positions.iter().fold(Vector3::repeat(f64::INFINITY), |a, p| a.inf(p));
        let high = positions.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
        let scale = f64::from(CELLS - 1) / (high - low).max().max(f64::MIN_POSITIVE);
        let code = |t: u32| {
            let cell = (corners(t).iter().sum::<Vector3>() / 3.0 - low) * scale;
            [cell.x, cell.y, cell.z].iter().zip(0..).fold(0, |code, (&c, axis)| code | (spread(c as u32) << axis))
        };
        let mut codes: Vec<u64> =
            (0..triangles.len() as u32).map(|t| (u64::from(code(t)) << 32) | u64::from(t)).collect();
        codes.sort_unstable();
        let order: Vec<u32> = codes.into_iter().map(|c| c as u32).collect();
        let boxed = |&t: &u32| {
            let [a, b, c] = corners(t);
            (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
        };
        let tree = RunTree::new(order.iter().map(boxed));
        Self { positions, triangles, order, tree }
    }

    fn corners(&self, triangle: u32) -> [Vector3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// Is the skin hidden at the middle of a polygon that lies in a triangle?
    fn hides(&self, triangle: [Vector3; 3], polygon: &[Vector3]) -> bool {
        let [a, b, c] = triangle;
        let Some(up) = (b - a).cross(&(c - a)).try_normalize(0.0) else { return false };
        let point = polygon.iter().sum::<Vector3>() / polygon.len() as f64 + up * ABOVE;
        winding_number(point, |low, high, visit| {
            self.tree.for_each_meeting_box(low, high, |k| visit(self.corners(self.order[k as usize])));
        }) > 0
    }

    /// Per triangle: those that cross it, ascending.
    fn crossings(&self) -> Vec<Vec<u32>> {
        let planes: Vec<Plane> = self.order.iter().map(|&t| Plane::of(self.corners(t))).collect();
        let pairs = self.tree.collect_pairs(|rank, other, pairs: &mut Vec<[u32; 2]>| {
            let (t, u) = (self.order[rank as usize], self.order[other as usize]);
            let mine = self.triangles[t as usize];
            let apart = self.triangles[u as usize].iter().all(|v| !mine.contains(v));
            let (corners, others) = (self.corners(t), self.corners(u));
            if apart && planes[rank as usize].may_cut(&others) && triangles_intersect(corners, others) {
                pairs.push([t, u]);
            }
        });
        let mut crossings = vec![Vec::new(); self.triangles.len()];
        for [t, u] in pairs {
            crossings[t as usize].push(u);
            crossings[u as usize].push(t);
        }
        crossings.iter_mut().for_each(|c| c.sort_unstable());
        crossings
    }

    /// Triangles that cross nothing, connected over edges.
    fn patches(&self, crossings: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let mut sets = UnionFind::new(self.triangles.len());
        let free = |t: &u32| crossings[*t as usize].is_empty();
        for edge in EdgeTable::new(self.triangles).edges {
            for pair in edge.triangles.windows(2).filter(|pair| pair.iter().all(free)) {
                sets.union(pair[0], pair[1]);
            }
        }
        // The first of each set, being the smallest, comes before the others.
        let mut number = vec![0; self.triangles.len()];
        let mut patches: Vec<Vec<u32>> = Vec::new();
        for t in (0..self.triangles.len() as u32).filter(free) {
            let first = sets.find(t);
            if first == t {
                number[t as usize] = patches.len();
                patches.push(Vec::new());
            }
            patches[number[first as usize]].push(t);
        }
        patches
    }

    /// What is exposed of a triangle that others cross; `None` if it is all of it.
    fn exposed_pieces(&self, triangle: u32, crossings: &[u32]) -> Option<Vec<[Vector3; 3]>> {
        let corners = self.corners(triangle);
        let mut polygons = vec![corners.to_vec()];
        for &other in &crossings[..crossings.len().min(MOST_CUTS)] {
            let others = self.corners(other);
            let plane = Plane::of(others);
            let [a, b, c] = others;
            let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
            let meets = |polygon: &[Vector3]| {
                (0..3).all(|axis| {
                    polygon.iter().any(|p| p[axis] >= low[axis]) && polygon.iter().any(|p| p[axis] <= high[axis])
                })
            };
            polygons = polygons
                .into_iter()
                .flat_map(|polygon| {
                    if !meets(&polygon) || !plane.may_cut(&polygon) {
                        return vec![polygon];
                    }
                    let [above, below] = plane.halves(&polygon);
                    [above, below].into_iter().filter(|half| half.len() >= 3).collect()
                })
                .collect();
        }
        let count = polygons.len();
        polygons.retain(|polygon| !self.hides(corners, polygon));
        let fan = |polygon: Vec<Vector3>| {
            (2..polygon.len()).map(|k| [polygon[0], polygon[k - 1], polygon[k]]).collect::<Vec<_>>()
        };
        (polygons.len() < count).then(|| polygons.into_iter().flat_map(fan).collect())
    }
}

struct Plane {
    point: Vector3,
    normal: Vector3,
}

impl Plane {
    /// The plane of a triangle; its normal is zero where the triangle has no area.
    fn of([a, b, c]: [Vector3; 3]) -> Self {
        Self { point: a, normal: (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::zeros) }
    }

    fn height(&self, point: Vector3) -> f64 {
        (point - self.point).dot(&self.normal)
    }

    /// Are there points on both sides, or so near that rounding decides?
    fn may_cut(&self, points: &[Vector3]) -> bool {
        let heights = || points.iter().map(|&p| self.height(p));
        !heights().all(|h| h > IN_PLANE) && !heights().all(|h| h < -IN_PLANE)
    }

    /// The parts of a convex polygon above and below.
    fn halves(&self, polygon: &[Vector3]) -> [Vec<Vector3>; 2] {
        let mut halves = [Vec::new(), Vec::new()];
        for (k, &p) in polygon.iter().enumerate() {
            let q = polygon[(k + 1) % polygon.len()];
            let (at, next) = (self.height(p), self.height(q));
            for (half, sign) in halves.iter_mut().zip([1.0, -1.0]) {
                if at * sign >= -IN_PLANE {
                    half.push(p);
                }
            }
            if (at > IN_PLANE && next < -IN_PLANE) || (at < -IN_PLANE && next > IN_PLANE) {
                let cut = p + (q - p) * (at / (at - next));
                halves.iter_mut().for_each(|half| half.push(cut));
            }
        }
        // A polygon that only touches the plane from one side has nothing but its touch on the other.
        let flat = |half: &[Vector3]| half.iter().all(|&p| self.height(p).abs() <= IN_PLANE);
        if flat(&halves[0]) {
            halves[0].clear();
        } else if flat(&halves[1]) {
            halves[1].clear();
        }
        halves
    }
}

/// Cells along each axis for the spatial order.
const CELLS: u32 = 1 << 10;

/// Puts two zeros between the bits of a number below [`CELLS`].
fn spread(value: u32) -> u32 {
    let mut v = value & (CELLS - 1);
    v = (v | (v << 16)) & 0x0300_00ff;
    v = (v | (v << 8)) & 0x0300_f00f;
    v = (v | (v << 4)) & 0x030c_30c3;
    (v | (v << 2)) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::super::shapes::sphere;
    use super::super::{Body, DistanceField};
    use super::*;

    const CENTERS: [[f64; 3]; 2] = [[0.0, 0.5, 0.0], [0.45, 0.55, 0.05]];
    const RADII: [f64; 2] = [0.4, 0.25];

    fn two_balls() -> Body {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for (center, radius) in CENTERS.into_iter().zip(RADII) {
            let (more, faces) = sphere(Vector3::from(center), radius, 40);
            let offset = positions.len() as u32;
            positions.extend(more);
            triangles.extend(faces.iter().map(|t| t.map(|v| v + offset)));
        }
        Body::new(positions, triangles).unwrap().0
    }

    /// Signed distance to the union of the balls: the nearest place may be on either ball where the
    /// other does not cover it, or on the circle where they meet.
    fn to_union(point: Vector3) -> f64 {
        let centers = CENTERS.map(Vector3::from);
        let outside = |p: Vector3, k: usize| (p - centers[k]).norm() >= RADII[k];
        let mut least = f64::INFINITY;
        for (k, other) in [(0, 1), (1, 0)] {
            let on = centers[k] + (point - centers[k]).normalize() * RADII[k];
            if outside(on, other) {
                least = least.min((on - point).norm());
            }
        }
        let axis = centers[1] - centers[0];
        let apart = axis.norm();
        let along = (apart * apart + RADII[0].powi(2) - RADII[1].powi(2)) / (2.0 * apart);
        let radius = (RADII[0].powi(2) - along * along).sqrt();
        let axis = axis / apart;
        let from = point - centers[0];
        let off = from - axis * from.dot(&axis);
        least = least.min((from.dot(&axis) - along).hypot(off.norm() - radius));
        if outside(point, 0) && outside(point, 1) { least } else { -least }
    }

    fn points() -> impl Iterator<Item = Vector3> {
        let wave = |k: usize, step: f64| 2.0 * (k as f64 * step).fract() - 1.0;
        // About where the balls meet.
        (0..3000).map(move |k| {
            Vector3::new(0.3, 0.53, 0.03) + Vector3::new(wave(k, 0.819_172), wave(k, 0.671_043), wave(k, 0.549_7)) * 0.4
        })
    }

    #[test]
    fn distances_are_those_to_the_union_of_overlapping_balls() {
        let body = two_balls();
        for point in points() {
            let (ours, exact) = (body.signed_distance(point), to_union(point));
            // Chords of the mesh cut the balls by up to half a millimetre.
            assert!((ours - exact).abs() < 1.2e-3, "{point}: {ours} and not {exact}");
            let nearest = body.nearest(point, f64::INFINITY).unwrap();
            assert!(body.signed_distance(nearest.point).abs() < 1e-9);
        }
    }

    #[test]
    fn the_field_is_that_of_the_union() {
        let body = two_balls();
        let field = DistanceField::new(&body, 0.01, 0.04);
        let mut errors: Vec<f64> =
            points().filter_map(|p| Some((field.sample(p)?.distance - to_union(p)).abs())).collect();
        errors.sort_by(f64::total_cmp);
        let (median, most) = (errors[errors.len() / 2], errors[errors.len() - 1]);
        // Splines round off the crease, and the ridge that it casts inside.
        assert!(errors.len() > 1000 && median < 1e-3 && most < 8e-3, "median {median}, most {most}");
    }

    #[test]
    fn a_ball_within_a_ball_is_hidden_and_one_alone_is_not() {
        let (mut positions, mut triangles) = sphere(Vector3::new(0.0, 0.5, 0.0), 0.5, 12);
        assert!(Skin::new(&positions, &triangles).exposure.iter().all(|e| *e == Exposure::Whole));
        let (more, faces) = sphere(Vector3::new(0.1, 0.5, 0.0), 0.2, 12);
        let (offset, count) = (positions.len() as u32, triangles.len());
        positions.extend(more);
        triangles.extend(faces.iter().map(|t| t.map(|v| v + offset)));
        let skin = Skin::new(&positions, &triangles);
        assert!(skin.exposure[..count].iter().all(|e| *e == Exposure::Whole));
        assert!(skin.exposure[count..].iter().all(|e| *e == Exposure::Hidden));
    }

    #[test]
    fn pieces_cover_what_is_exposed_of_their_triangles() {
        let body = two_balls();
        let area = |[a, b, c]: [Vector3; 3]| 0.5 * (b - a).cross(&(c - a)).norm();
        let mut exposed = 0.0;
        for t in 0..body.triangles().len() as u32 {
            match body.skin.exposure(t) {
                Exposure::Whole => exposed += area(body.corners(t)),
                Exposure::Hidden => {}
                Exposure::Partly(range) => {
                    let part: f64 = body.skin.pieces(range).iter().map(|&p| area(p)).sum();
                    assert!(part > 0.0 && part < area(body.corners(t)) * (1.0 + 1e-9));
                    exposed += part;
                }
            }
        }
        // Two spheres less their caps.
        let apart = (Vector3::from(CENTERS[1]) - Vector3::from(CENTERS[0])).norm();
        let along = (apart * apart + RADII[0].powi(2) - RADII[1].powi(2)) / (2.0 * apart);
        let heights = [RADII[0] - along, RADII[1] - (apart - along)];
        let whole: f64 = (0..2).map(|k| std::f64::consts::TAU * RADII[k] * (2.0 * RADII[k] - heights[k])).sum();
        assert!((exposed / whole - 1.0).abs() < 4e-3, "{exposed} of {whole}");
    }
}
