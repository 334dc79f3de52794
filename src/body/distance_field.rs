//! Signed distance to the body on a grid, smooth enough to differentiate.
//!
//! Exact closest points cost twenty times what a particle's springs cost; the grid costs about as
//! much as they do. It holds distances in bricks near the surface only. Between the nodes a
//! quadratic B-spline interpolates, so that the gradient is continuous: the kinks of trilinear
//! interpolation would stop a minimizer. A spline smooths curvature away, for which the
//! coefficients make up (see `sharpen`).
//!
//! Not promised: distances farther from the surface than [`DistanceField::band`], and
//! accuracy where features are smaller than two cells (fingers, ears). Clearances that must hold
//! are checked with [`Body::signed_distance`].

use super::Body;
use super::winding::crossing_sense;
use crate::geometry::{Vector3, closest_on_triangle};
use rayon::prelude::*;

/// Cells along the side of a brick.
const BRICK: usize = 16;
/// Nodes along the side of a stored brick: one more on each side than the cells need, so that a
/// sample reads one brick only.
const STORED: usize = BRICK + 2;
/// Nodes along the side of a brick while it is computed: one more again, for sharpening.
const WORK: usize = BRICK + 4;
/// No brick here, and outside the body.
const NONE: u32 = u32::MAX;
/// No brick here, and inside the body.
const INSIDE: u32 = u32::MAX - 1;

/// Distance and its gradient at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// m, negative inside.
    pub distance: f64,
    /// ∂distance/∂position, about a unit vector; points away from the body.
    pub gradient: Vector3,
}

/// Signed distances to a body near its surface.
pub struct DistanceField {
    /// Side of a cell, m.
    cell: f64,
    /// How far from the surface the distances hold, m.
    band: f64,
    /// World position of the first node of the first brick.
    origin: Vector3,
    /// Bricks along each axis.
    extent: [usize; 3],
    /// Index into `coefficients`, or `NONE` or `INSIDE`.
    brick_of: Vec<u32>,
    /// Spline coefficients, m; `STORED`³ for each brick. Rounding them to single precision moves the
    /// surface by a nanometre and leaves it smooth.
    coefficients: Vec<f32>,
}

impl DistanceField {
    /// Distances within `band` of the surface on a grid of `cell`, m.
    pub fn new(body: &Body, cell: f64, band: f64) -> Self {
        let reach = band + 2.0 * cell;
        let side = BRICK as f64 * cell;
        let (low, high) = body.bounds();
        let origin = low - Vector3::repeat(reach + 0.5 * cell);
        let extent = (high - origin + Vector3::repeat(reach)).map(|e| (e / side).ceil() as usize + 1);
        let mut field = Self { cell, band, origin, extent: extent.into(), brick_of: Vec::new(), coefficients: Vec::new() };
        let lists = field.triangles_near_bricks(body, reach);
        let columns = Columns::new(body, &field);
        let bricks: Vec<usize> = (0..lists.len()).filter(|&b| !lists[b].is_empty()).collect();
        let computed: Vec<Vec<f32>> = bricks
            .par_iter()
            .map(|&brick| field.brick_coefficients(body, &columns, brick, &lists[brick], reach))
            .collect();
        field.brick_of = (0..lists.len()).map(|b| if field.is_inside(&columns, b) { INSIDE } else { NONE }).collect();
        for (k, &brick) in bricks.iter().enumerate() {
            field.brick_of[brick] = k as u32;
        }
        field.coefficients = computed.concat();
        field
    }

    pub fn band(&self) -> f64 {
        self.band
    }

    /// Side of a cell, m.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Is the point inside, farther than the band from the surface?
    pub fn is_deep_inside(&self, point: Vector3) -> bool {
        self.brick_at(point).is_some_and(|brick| self.brick_of[brick] == INSIDE)
    }

    /// The brick of the node nearest to a point.
    fn brick_at(&self, point: Vector3) -> Option<usize> {
        let brick = ((point - self.origin) / self.cell).map(|c| ((c + 0.5).floor() / BRICK as f64).floor());
        if brick.iter().zip(&self.extent).any(|(&b, &n)| !(b >= 0.0 && b < n as f64)) {
            return None;
        }
        Some((brick.z as usize * self.extent[1] + brick.y as usize) * self.extent[0] + brick.x as usize)
    }

    /// Distance and gradient, or `None` farther than the band from the surface, inside or outside.
    pub fn sample(&self, point: Vector3) -> Option<Sample> {
        let at = (point - self.origin) / self.cell;
        // The nearest node; it and its neighbours carry the spline.
        let node = at.map(|c| (c + 0.5).floor());
        let brick = node.map(|n| (n / BRICK as f64).floor());
        if brick.iter().zip(&self.extent).any(|(&b, &n)| !(b >= 0.0 && b < n as f64)) {
            return None;
        }
        let [bx, by, bz] = [brick.x as usize, brick.y as usize, brick.z as usize];
        let index = self.brick_of[(bz * self.extent[1] + by) * self.extent[0] + bx];
        if index >= INSIDE {
            return None;
        }
        let [ix, iy, iz] = [node.x as usize - bx * BRICK, node.y as usize - by * BRICK, node.z as usize - bz * BRICK];
        let base = index as usize * STORED.pow(3) + (iz * STORED + iy) * STORED + ix;
        let offset = at - node;
        let [wx, wy, wz] = [offset.x, offset.y, offset.z].map(spline_weights);
        let [dx, dy, dz] = [offset.x, offset.y, offset.z].map(spline_slopes);
        let mut distance = 0.0;
        let mut slope = Vector3::zeros();
        for k in 0..3 {
            for j in 0..3 {
                let start = base + (k * STORED + j) * STORED;
                let row = &self.coefficients[start..start + 3];
                let row = [f64::from(row[0]), f64::from(row[1]), f64::from(row[2])];
                let along = row[0] * wx[0] + row[1] * wx[1] + row[2] * wx[2];
                let across = row[0] * dx[0] + row[1] * dx[1] + row[2] * dx[2];
                distance += along * wy[j] * wz[k];
                slope += Vector3::new(across * wy[j] * wz[k], along * dy[j] * wz[k], along * wy[j] * dz[k]);
            }
        }
        Some(Sample { distance, gradient: slope / self.cell })
    }

    /// For each brick the triangles within `reach` of it, ascending.
    fn triangles_near_bricks(&self, body: &Body, reach: f64) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.extent.iter().product()];
        let side = BRICK as f64 * self.cell;
        // A brick's computed nodes reach two cells past its cells.
        let margin = Vector3::repeat(reach + 2.5 * self.cell);
        for t in 0..body.triangles().len() as u32 {
            let [a, b, c] = body.corners(t);
            let first = ((a.inf(&b).inf(&c) - margin - self.origin) / side).map(|v| v.floor().max(0.0) as usize);
            let last = ((a.sup(&b).sup(&c) + margin - self.origin) / side).map(|v| v.floor().max(0.0) as usize);
            for z in first.z..=last.z.min(self.extent[2] - 1) {
                for y in first.y..=last.y.min(self.extent[1] - 1) {
                    for x in first.x..=last.x.min(self.extent[0] - 1) {
                        lists[(z * self.extent[1] + y) * self.extent[0] + x].push(t);
                    }
                }
            }
        }
        lists
    }

    /// Grid index of the first computed node of a brick, which may be -2 along an axis.
    fn first_node(&self, brick: usize) -> [i64; 3] {
        let [nx, ny, _] = self.extent;
        [brick % nx, brick / nx % ny, brick / (nx * ny)].map(|b| (b * BRICK) as i64 - 2)
    }

    /// Is the middle of a brick inside the body?
    fn is_inside(&self, columns: &Columns, brick: usize) -> bool {
        let [x, y, z] = self.first_node(brick).map(|n| n + (WORK / 2) as i64);
        winding(columns.at(y, z), self.origin.x + x as f64 * self.cell) > 0
    }

    fn brick_coefficients(&self, body: &Body, columns: &Columns, brick: usize, triangles: &[u32], reach: f64) -> Vec<f32> {
        let first = self.first_node(brick);
        let node_at = |i: usize, axis: usize| self.origin[axis] + (first[axis] + i as i64) as f64 * self.cell;
        let mut squared = vec![reach * reach; WORK.pow(3)];
        for &t in triangles {
            let corners = body.corners(t);
            let [a, b, c] = corners;
            let range = |axis: usize| {
                let low = a[axis].min(b[axis]).min(c[axis]) - reach - node_at(0, axis);
                let high = a[axis].max(b[axis]).max(c[axis]) + reach - node_at(0, axis);
                let first = (low / self.cell).ceil().max(0.0) as usize;
                let last = (high / self.cell).floor().min((WORK - 1) as f64);
                first..if last < 0.0 { 0 } else { last as usize + 1 }
            };
            let (rx, ry, rz) = (range(0), range(1), range(2));
            for k in rz {
                for j in ry.clone() {
                    for i in rx.clone() {
                        let node = Vector3::new(node_at(i, 0), node_at(j, 1), node_at(k, 2));
                        let w = closest_on_triangle(node, corners);
                        let distance = (a * w[0] + b * w[1] + c * w[2] - node).norm_squared();
                        let best = &mut squared[(k * WORK + j) * WORK + i];
                        *best = best.min(distance);
                    }
                }
            }
        }
        let mut signed: Vec<f64> = squared.into_iter().map(f64::sqrt).collect();
        for k in 0..WORK {
            for j in 0..WORK {
                let crossings = columns.at(first[1] + j as i64, first[2] + k as i64);
                for i in 0..WORK {
                    if winding(crossings, node_at(i, 0)) > 0 {
                        let value = &mut signed[(k * WORK + j) * WORK + i];
                        *value = -*value;
                    }
                }
            }
        }
        sharpen(&signed)
    }
}

/// Weights of the three nodes around a point that is `offset` cells from the middle one.
fn spline_weights(offset: f64) -> [f64; 3] {
    [0.5 * (0.5 - offset).powi(2), 0.75 - offset * offset, 0.5 * (0.5 + offset).powi(2)]
}

/// Derivatives of [`spline_weights`], per cell.
fn spline_slopes(offset: f64) -> [f64; 3] {
    [offset - 0.5, -2.0 * offset, offset + 0.5]
}

/// Spline coefficients of nodal values.
///
/// A quadratic B-spline over the values themselves returns `f + h²/8 ∇²f`: it rounds every curved
/// surface off. Coefficients `f - ∇²f/8` (second differences) cancel that to fourth order.
fn sharpen(values: &[f64]) -> Vec<f32> {
    let mut coefficients = Vec::with_capacity(STORED.pow(3));
    let (dy, dz) = (WORK, WORK * WORK);
    for k in 1..=STORED {
        for j in 1..=STORED {
            for i in 1..=STORED {
                let at = k * dz + j * dy + i;
                let center = values[at];
                let around: f64 = [1, dy, dz].iter().map(|d| values[at - d] + values[at + d]).sum();
                coefficients.push((center - (around - 6.0 * center) / 8.0) as f32);
            }
        }
    }
    coefficients
}

/// Where lines along x through the grid's nodes cross the body.
struct Columns {
    /// Index of the first line, which is two nodes before the grid's first.
    first: i64,
    rows: [usize; 2],
    /// Per line: x of each crossing and its sense, ascending in x.
    crossings: Vec<Vec<(f64, i32)>>,
}

impl Columns {
    fn new(body: &Body, field: &DistanceField) -> Self {
        let rows = [1, 2].map(|axis| field.extent[axis] * BRICK + 4);
        let mut columns = Self { first: -2, rows, crossings: vec![Vec::new(); rows[0] * rows[1]] };
        for t in 0..body.triangles().len() as u32 {
            let corners = body.corners(t);
            let [a, b, c] = corners;
            let span = |axis: usize| {
                let to_row = |v: f64| (v - field.origin[axis]) / field.cell + 2.0;
                let low = to_row(a[axis].min(b[axis]).min(c[axis])).floor().max(0.0) as usize;
                let high = to_row(a[axis].max(b[axis]).max(c[axis])).ceil() as usize;
                low..(high + 1).min(rows[axis - 1])
            };
            let normal = (b - a).cross(&(c - a));
            for k in span(2) {
                for j in span(1) {
                    let (y, z) = (
                        field.origin.y + (j as f64 - 2.0) * field.cell,
                        field.origin.z + (k as f64 - 2.0) * field.cell,
                    );
                    let sense = crossing_sense(Vector3::new(0.0, y, z), corners);
                    if sense != 0 {
                        let x = a.x - ((y - a.y) * normal.y + (z - a.z) * normal.z) / normal.x;
                        columns.crossings[k * rows[0] + j].push((x, sense));
                    }
                }
            }
        }
        columns
    }

    fn at(&self, row_y: i64, row_z: i64) -> &[(f64, i32)] {
        let (j, k) = ((row_y - self.first) as usize, (row_z - self.first) as usize);
        if j < self.rows[0] && k < self.rows[1] { &self.crossings[k * self.rows[0] + j] } else { &[] }
    }
}

/// How often the surface winds around a point on a line with the given crossings.
fn winding(crossings: &[(f64, i32)], x: f64) -> i32 {
    crossings.iter().filter(|(at, _)| *at > x).map(|(_, sense)| sense).sum()
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
        for point in points(0.025) {
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
        assert_eq!(field.sample(Vector3::new(0.0, 0.5, 0.0)), None);
        assert_eq!(field.sample(Vector3::new(3.0, 0.5, 0.0)), None);
        assert_eq!(field.sample(Vector3::repeat(f64::NAN)), None);
    }
}
