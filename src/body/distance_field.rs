//! Signed distance to the body on a grid, smooth enough to differentiate.
//!
//! Exact closest points cost twenty times what a particle's springs cost; the grid costs about as
//! much as they do. Between the nodes a quadratic B-spline interpolates, so that the gradient is
//! continuous: the kinks of trilinear interpolation would stop a minimizer. A spline over the
//! distances themselves would round curved surfaces off, for which the coefficients make up (see
//! `sharpen`).
//!
//! Nodes near the surface get exact distances, the others the distance to the triangle that is
//! nearest to a neighbour, in order of growing distance (closest-feature propagation, as in fast
//! marching). Inside and outside are told by winding numbers along the grid's lines.
//!
//! Not promised: distances farther outside than [`DistanceField::band`], and accuracy where
//! features are smaller than two cells (fingers, ears). Clearances that must hold are checked with
//! [`Body::signed_distance`].

use super::Body;
use super::winding::crossing_sense;
use crate::geometry::{Vector3, closest_on_triangle};
use rayon::prelude::*;

/// Distance and its gradient at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// m, negative inside.
    pub distance: f64,
    /// ∂distance/∂position, about a unit vector; points away from the body.
    pub gradient: Vector3,
}

/// Signed distances to a body, inside it and in a band around it.
pub struct DistanceField {
    /// Side of a cell, m.
    cell: f64,
    /// How far outside the distances hold, m.
    band: f64,
    /// World position of node 0.
    origin: Vector3,
    /// Nodes along each axis.
    extent: [usize; 3],
    /// Spline coefficients, m, x fastest; infinite beyond the band. Rounding them to single
    /// precision moves the surface by a nanometre and leaves it smooth.
    coefficients: Vec<f32>,
}

/// Empty nodes around the body's band, so that a sample and its neighbours lie within the grid.
const MARGIN_CELLS: f64 = 6.0;

/// By how many cells the computed distances reach past the band: a sample's node may lie a cell past
/// it, the node's neighbours √3 cells farther, and sharpening looks one node past those.
const REACH_CELLS: f64 = 4.0;

/// The field's distance grows by at most this many metres a metre. That of a body grows by one; the
/// spline overshoots a little over creases.
pub const STEEPEST: f64 = 1.3;

impl DistanceField {
    /// Distances inside and up to `band` outside, on a grid of `cell`, m.
    pub fn new(body: &Body, cell: f64, band: f64) -> Self {
        let (low, high) = body.bounds();
        let margin = Vector3::repeat(band + MARGIN_CELLS * cell);
        let origin = low - margin;
        let extent = ((high + margin - origin) / cell).map(|e| e.ceil() as usize + 1).into();
        let mut field = Self { cell, band, origin, extent, coefficients: Vec::new() };
        let lines = Lines::new(body, &field);
        let mut distances = Propagation::new(body, &field).run(band + REACH_CELLS * cell, &lines);
        lines.negate_inside(&field, &mut distances);
        field.coefficients = field.sharpen(&distances);
        field
    }

    pub fn band(&self) -> f64 {
        self.band
    }

    /// Side of a cell, m.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Distance and gradient, or `None` farther than the band outside.
    #[inline]
    pub fn sample(&self, point: Vector3) -> Option<Sample> {
        self.sample_below(point, f64::INFINITY).ok()
    }

    /// The same where the distance is below `most`, m. For the others the gradient is not worth
    /// computing: `Err` has their distance, or the band where they are beyond it.
    #[inline]
    pub fn sample_below(&self, point: Vector3, most: f64) -> Result<Sample, f64> {
        let at = (point - self.origin) / self.cell;
        // The nearest node; it and its neighbours carry the spline. What is negative or no number
        // becomes node 0, which has no neighbours.
        let node = at.map(|c| (c + 0.5) as usize);
        let [nx, ny, nz] = self.extent;
        let within = |c: usize, n: usize| c >= 1 && c < n - 1;
        if !(within(node.x, nx) && within(node.y, ny) && within(node.z, nz)) {
            return Err(self.band);
        }
        let base = (node.z * ny + node.y) * nx + node.x;
        if f64::from(self.coefficients[base]) > self.band + self.cell {
            return Err(self.band);
        }
        let offset = at - node.map(|c| c as f64);
        let [wx, wy, wz] = [offset.x, offset.y, offset.z].map(spline_weights);
        let corner = base - (ny + 1) * nx - 1;
        let row = |j: usize, k: usize| {
            let start = corner + (k * ny + j) * nx;
            let row = &self.coefficients[start..start + 3];
            [f64::from(row[0]), f64::from(row[1]), f64::from(row[2])]
        };
        let mut distance = 0.0;
        let mut along = [[0.0; 3]; 3];
        for k in 0..3 {
            for j in 0..3 {
                let row = row(j, k);
                along[k][j] = row[0] * wx[0] + row[1] * wx[1] + row[2] * wx[2];
                distance += along[k][j] * wy[j] * wz[k];
            }
        }
        if distance >= most {
            return Err(distance);
        }
        let [dx, dy, dz] = [offset.x, offset.y, offset.z].map(spline_slopes);
        let mut slope = Vector3::zeros();
        for k in 0..3 {
            for j in 0..3 {
                let (row, along) = (row(j, k), along[k][j]);
                let across = row[0] * dx[0] + row[1] * dx[1] + row[2] * dx[2];
                slope += Vector3::new(across * wy[j] * wz[k], along * dy[j] * wz[k], along * wy[j] * dz[k]);
            }
        }
        Ok(Sample { distance, gradient: slope / self.cell })
    }

    fn node(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.extent[1] + y) * self.extent[0] + x
    }

    fn node_position(&self, [x, y, z]: [usize; 3]) -> Vector3 {
        self.origin + Vector3::new(x as f64, y as f64, z as f64) * self.cell
    }

    /// Spline coefficients of nodal values.
    ///
    /// A quadratic B-spline over the values themselves returns `f + h²/8 ∇²f`: it rounds every
    /// curved surface off. Coefficients `f - ∇²f/8` (second differences) cancel that to fourth order.
    fn sharpen(&self, values: &[f32]) -> Vec<f32> {
        let [nx, ny, _] = self.extent;
        let plane = nx * ny;
        let mut coefficients = vec![f32::INFINITY; values.len()];
        coefficients.par_chunks_mut(plane).enumerate().for_each(|(z, out)| {
            if z == 0 || (z + 1) * plane >= values.len() {
                return;
            }
            for (at, out) in out.iter_mut().enumerate().take(plane - nx - 1).skip(nx + 1) {
                let here = z * plane + at;
                let center = values[here];
                if center.is_finite() {
                    let around: f32 = [1, nx, plane].iter().map(|d| values[here - d] + values[here + d]).sum();
                    // At the rim of what was computed a neighbour is infinite; nobody samples there.
                    *out = if around.is_finite() { center - (around - 6.0 * center) / 8.0 } else { center };
                }
            }
        });
        coefficients
    }
}

/// Weights of the three nodes around a point that is `offset` cells from the middle one.
#[inline]
fn spline_weights(offset: f64) -> [f64; 3] {
    [0.5 * (0.5 - offset).powi(2), 0.75 - offset * offset, 0.5 * (0.5 + offset).powi(2)]
}

/// Derivatives of [`spline_weights`], per cell.
#[inline]
fn spline_slopes(offset: f64) -> [f64; 3] {
    [offset - 0.5, -2.0 * offset, offset + 0.5]
}

/// Distances that spread from the surface, nearest nodes first.
struct Propagation<'a> {
    field: &'a DistanceField,
    /// Corners of each triangle of the body and its unit normal; zero where it has no area.
    triangles: Vec<([Vector3; 3], Vector3)>,
    squared: Vec<f32>,
    nearest: Vec<u32>,
}

impl<'a> Propagation<'a> {
    /// Exact distances at the nodes around each triangle.
    fn new(body: &'a Body, field: &'a DistanceField) -> Self {
        let [nx, ny, nz] = field.extent;
        let count = nx * ny * nz;
        let triangles = (0..body.triangles().len() as u32).map(|t| {
            let [a, b, c] = body.corners(t);
            ([a, b, c], (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::zeros))
        });
        let triangles = triangles.collect();
        let mut start = Self { field, triangles, squared: vec![f32::INFINITY; count], nearest: vec![u32::MAX; count] };
        for t in 0..body.triangles().len() as u32 {
            let [a, b, c] = body.corners(t);
            let first = ((a.inf(&b).inf(&c) - field.origin) / field.cell).map(|v| v.floor() as usize);
            let last = ((a.sup(&b).sup(&c) - field.origin) / field.cell).map(|v| v.ceil() as usize);
            for z in first.z..=last.z {
                for y in first.y..=last.y {
                    for x in first.x..=last.x {
                        start.improve([x, y, z], t);
                    }
                }
            }
        }
        start
    }

    /// Takes the distance of a node to a triangle if it is the nearest yet; tells whether it was.
    #[inline]
    fn improve(&mut self, at: [usize; 3], triangle: u32) -> bool {
        let node = self.field.node(at);
        let point = self.field.node_position(at);
        let ([a, b, c], normal) = self.triangles[triangle as usize];
        // No point of the triangle is nearer than its plane; a margin for rounding.
        let to_plane = (point - a).dot(&normal);
        if to_plane * to_plane > 1.0001 * f64::from(self.squared[node]) {
            return false;
        }
        let w = closest_on_triangle(point, [a, b, c]);
        let squared = (a * w[0] + b * w[1] + c * w[2] - point).norm_squared() as f32;
        let nearer = squared < self.squared[node];
        if nearer {
            self.squared[node] = squared;
            self.nearest[node] = triangle;
        }
        nearer
    }

    /// Spreads through the inside and outside up to `reach`; returns the distances without sign.
    fn run(mut self, reach: f64, lines: &Lines) -> Vec<f32> {
        let [nx, ny, _] = self.field.extent;
        // Nodes waiting, by distance in quarters of a cell: near enough to sorted.
        let slot = |squared: f32| (f64::from(squared).sqrt() / self.field.cell * 4.0) as usize;
        let mut waiting: Vec<Vec<u32>> = Vec::new();
        let push = |waiting: &mut Vec<Vec<u32>>, node: usize, squared: f32| {
            let slot = slot(squared);
            if slot >= waiting.len() {
                waiting.resize(slot + 1, Vec::new());
            }
            waiting[slot].push(node as u32);
        };
        for (node, &squared) in self.squared.iter().enumerate() {
            if squared.is_finite() {
                push(&mut waiting, node, squared);
            }
        }
        let inside = lines.inside(self.field);
        let mut from = 0;
        while from < waiting.len() {
            for node in std::mem::take(&mut waiting[from]) {
                let node = node as usize;
                if slot(self.squared[node]) < from {
                    continue;
                }
                let triangle = self.nearest[node];
                let at = [node % nx, node / nx % ny, node / (nx * ny)];
                for axis in 0..3 {
                    for along in [at[axis] - 1, at[axis] + 1] {
                        let mut beside = at;
                        beside[axis] = along;
                        let next = self.field.node(beside);
                        let nearer = self.nearest[next] != triangle && self.improve(beside, triangle);
                        if nearer && (inside[next] || f64::from(self.squared[next]) < reach * reach) {
                            push(&mut waiting, next, self.squared[next]);
                        }
                    }
                }
            }
            from += 1;
        }
        self.squared.into_iter().map(f32::sqrt).collect()
    }
}

/// Where lines along x through the grid's nodes cross the body.
struct Lines {
    /// Per line, y faster than z: x of each crossing and its sense, ascending in x.
    crossings: Vec<Vec<(f64, i32)>>,
}

impl Lines {
    fn new(body: &Body, field: &DistanceField) -> Self {
        let [_, ny, nz] = field.extent;
        let mut lines = Self { crossings: vec![Vec::new(); ny * nz] };
        for t in 0..body.triangles().len() as u32 {
            let corners = body.corners(t);
            let [a, b, c] = corners;
            let first = ((a.inf(&b).inf(&c) - field.origin) / field.cell).map(|v| v.floor() as usize);
            let last = ((a.sup(&b).sup(&c) - field.origin) / field.cell).map(|v| v.ceil() as usize);
            let normal = (b - a).cross(&(c - a));
            for z in first.z..=last.z {
                for y in first.y..=last.y {
                    let (py, pz) = (field.origin.y + y as f64 * field.cell, field.origin.z + z as f64 * field.cell);
                    let sense = crossing_sense(Vector3::new(0.0, py, pz), corners);
                    if sense != 0 {
                        let x = a.x - ((py - a.y) * normal.y + (pz - a.z) * normal.z) / normal.x;
                        // Of a sliver seen on edge the division is worth nothing, its extent is.
                        let x = if x.is_nan() { a.x } else { x.clamp(a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x)) };
                        lines.crossings[z * ny + y].push((x, sense));
                    }
                }
            }
        }
        for line in &mut lines.crossings {
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        lines
    }

    /// Calls `visit` with the range of nodes of each stretch inside the body.
    fn for_each_inside(&self, field: &DistanceField, line: usize, mut visit: impl FnMut(std::ops::Range<usize>)) {
        let to_node = |x: f64| ((x - field.origin.x) / field.cell).ceil() as usize;
        let mut winding = 0;
        let mut entry = 0;
        for &(x, sense) in &self.crossings[line] {
            // A surface that faces -x is entered.
            let before = winding;
            winding -= sense;
            if before <= 0 && winding > 0 {
                entry = to_node(x);
            } else if before > 0 && winding <= 0 {
                visit(entry..to_node(x));
            }
        }
    }

    /// One per node.
    fn inside(&self, field: &DistanceField) -> Vec<bool> {
        let nx = field.extent[0];
        let mut inside = vec![false; field.extent.iter().product()];
        inside.par_chunks_mut(nx).enumerate().for_each(|(line, row)| {
            self.for_each_inside(field, line, |nodes| row[nodes].fill(true));
        });
        inside
    }

    fn negate_inside(&self, field: &DistanceField, distances: &mut [f32]) {
        let nx = field.extent[0];
        distances.par_chunks_mut(nx).enumerate().for_each(|(line, row)| {
            self.for_each_inside(field, line, |nodes| row[nodes].iter_mut().for_each(|d| *d = -*d));
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    const CELL: f64 = 0.01;

    fn ball() -> (Body, DistanceField) {
        let body = shapes::ball();
        let field = DistanceField::new(&body, CELL, 0.03);
        (body, field)
    }

    /// Points around the ball, up to `far` from its surface.
    fn points(far: f64) -> impl Iterator<Item = Vector3> {
        (0..400).map(move |i| {
            let t = f64::from(i);
            let direction = Vector3::new((t * 1.7).sin(), (t * 0.9).cos(), (t * 2.3).sin()).normalize();
            Vector3::new(0.0, 0.5, 0.0) + direction * (0.5 + far * (t * 0.37).sin())
        })
    }

    #[test]
    fn agrees_with_exact_distances() {
        let (body, field) = ball();
        for point in points(0.025).chain(points(0.025).map(|p| Vector3::new(0.0, 0.5, 0.0).lerp(&p, 0.6))) {
            let sample = field.sample(point).unwrap();
            let exact = body.signed_distance(point);
            assert!((sample.distance - exact).abs() < 2e-4, "{} against {exact}", sample.distance);
            assert!((sample.gradient.norm() - 1.0).abs() < 0.05);
        }
    }

    #[test]
    fn the_gradient_is_the_derivative_everywhere() {
        let (_, field) = ball();
        let step = 1e-6;
        for point in points(0.02) {
            let sample = field.sample(point).unwrap();
            for axis in 0..3 {
                let mut forward = point;
                let mut back = point;
                forward[axis] += step;
                back[axis] -= step;
                let difference = field.sample(forward).unwrap().distance - field.sample(back).unwrap().distance;
                assert!((difference / (2.0 * step) - sample.gradient[axis]).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn far_points_have_no_distance() {
        let (_, field) = ball();
        assert_eq!(field.sample(Vector3::new(0.0, 0.5, 0.55)), None);
        assert_eq!(field.sample(Vector3::new(3.0, 0.5, 0.0)), None);
        assert_eq!(field.sample(Vector3::repeat(f64::NAN)), None);
    }
}
