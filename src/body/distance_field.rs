//! Signed distance to the body on two grids, smooth enough to differentiate.
//!
//! Exact closest points cost twenty times what a particle's springs cost; the grids cost about as
//! much as they do. Between the nodes a quadratic B-spline interpolates, so that the gradient is
//! continuous: the kinks of trilinear interpolation would stop a minimizer. A spline over the
//! distances themselves would round curved surfaces off, for which the coefficients make up (see
//! `sharpened`).
//!
//! Near the surface the cells have the size that is asked for; elsewhere they are twice as large. A
//! quadratic B-spline on the coarse grid is one on the fine grid as well, whose coefficients are the
//! coarse ones interpolated linearly at the fine nodes (Chaikin's corner cutting):
//!
//! ```text
//!     coarse      o-------------------o          a coarse node stands in the middle
//!     fine            x         x                between fine nodes: weights 3/4 and 1/4
//! ```
//!
//! The field is thus *one* spline on the fine grid; where all coefficients around a point come from
//! the coarse grid, it is evaluated there. Fine coefficients lie in bricks of 4³ nodes with a rim of one
//! node, so that a sample reads from one brick, and exist near the surface only.
//!
//! Nodes near the surface get exact distances (`facet`), those of the coarse grid that are farther
//! away the distance to the triangle that is nearest to a neighbour (`spread`). Inside and outside
//! are told by winding numbers along the grids' lines (`lines`).
//!
//! Not promised: distances to better than a tenth of a coarse cell deep inside, where they only have to lead
//! out; distances farther outside than [`DistanceField::band`], and accuracy where
//! features are smaller than two cells (fingers, ears). Clearances that must hold are checked with
//! [`Body::signed_distance`].

mod facet;
mod grid;
mod lines;
mod spread;

use super::Body;
use crate::geometry::{Vector3, closest_on_triangle};
use facet::{Facet, Layers};
use grid::{Grid, by_slab};
use lines::Lines;
use rayon::prelude::*;
use spread::{Nearest, UNKNOWN};
use std::ops::Range;

/// Distance and its gradient at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// m, negative inside.
    pub distance: f64,
    /// ∂distance/∂position, about a unit vector; points away from the body.
    pub gradient: Vector3,
}

/// Signed distances to a body, inside it and in a band around it.
///
/// Rounding the spline coefficients, m, to single precision moves the surface by a nanometre and
/// leaves it smooth.
pub struct DistanceField {
    /// Side of a fine cell, m.
    cell: f64,
    /// How far outside the distances hold, m.
    band: f64,
    /// What the coefficients of the coarse grid are where nothing is known, m: no point whose nearest node
    /// is that far away is within the band.
    beyond: f64,
    /// Of cells of twice the side; its extent along each axis is even.
    coarse: Grid,
    /// One per node of the coarse grid.
    coefficients: Vec<f32>,
    /// Per brick, ordered as the nodes of the coarse grid are: where its coefficients begin.
    bricks: Vec<u32>,
    /// The coefficients of the bricks, rim included, x fastest, then z, then y.
    fine: Vec<f32>,
}

/// The field's distance grows by at most this many metres a metre. That of a body grows by one; the
/// spline overshoots a little over creases.
pub const STEEPEST: f64 = 1.3;

/// Fine nodes of a brick along an axis, without its rim and with it.
const BRICK: usize = 4;
const RIMMED: usize = BRICK + 2;
/// There are no fine coefficients: the coarse ones serve.
const NO_BRICK: u32 = u32::MAX;
/// Up to this distance, in cells, fine nodes have exact distances. Half of that is what cloth in
/// contact samples; two cells go into sharpening and into the passage to the coarse grid.
const FINE_REACH: f64 = 2.5;
/// The same for the nodes of the coarse grid, from where distances spread.
const COARSE_REACH: f64 = 1.5;
/// By how many coarse cells distances are computed past the band, so that samples within it are good.
const PAST_BAND: f64 = 1.0;
/// Empty coarse cells around what is computed, so that a sample and its neighbours lie within the grid.
const MARGIN: f64 = 3.0;
/// Layers of nodes to a piece of parallel work.
const COARSE_SLAB: usize = 8;
const FINE_SLAB: usize = 4 * BRICK;
/// Layers below and above a slab of fine nodes that its coefficients need: a rim and sharpening.
const OVERLAP: usize = 2;

impl DistanceField {
    /// Distances inside and up to `band` outside, on a grid of `cell` near the surface, m.
    pub fn new(body: &Body, cell: f64, band: f64) -> Self {
        Self::fine_at(f64::NEG_INFINITY..f64::INFINITY, body, cell, band)
    }

    /// The same with fine bricks at these heights alone, m; the coarse grid serves below and above.
    pub fn fine_at(heights: Range<f64>, body: &Body, cell: f64, band: f64) -> Self {
        let (low, high) = body.bounds();
        let side = 2.0 * cell;
        let margin = Vector3::repeat(band + (PAST_BAND + MARGIN) * side);
        let origin = low - margin;
        let extent = (high + margin - origin).map(|e| ((e / side).ceil() as usize + 1).next_multiple_of(2));
        let coarse = Grid { origin, cell: side, extent: extent.into() };
        let skin = body.exposed();
        let facets: Vec<Facet> = skin.par_iter().map(|&corners| Facet::new(corners)).collect();
        let beyond = band + PAST_BAND * side;
        let coefficients = coarse_coefficients(body, &skin, &facets, &coarse, beyond);
        let beyond = f64::from(beyond as f32);
        let mut field = Self { cell, band, beyond, coarse, coefficients, bricks: Vec::new(), fine: Vec::new() };
        field.add_bricks(body, &facets, heights);
        field
    }

    /// The fine grid: each coarse node lies in the middle of eight of its nodes.
    fn fine_grid(&self) -> Grid {
        let origin = self.coarse.origin - Vector3::repeat(0.5 * self.cell);
        Grid { origin, cell: self.cell, extent: self.coarse.extent.map(|n| 2 * n) }
    }

    fn add_bricks(&mut self, body: &Body, facets: &[Facet], worn: Range<f64>) {
        let grid = self.fine_grid();
        let height = |layer: usize| grid.position([0, layer, 0]).y;
        let wanted = |slab: usize| height(slab * FINE_SLAB) < worn.end && height((slab + 1) * FINE_SLAB) > worn.start;
        let reach = FINE_REACH * self.cell;
        let around = reach + OVERLAP as f64 * self.cell;
        let near = by_slab(&grid, FINE_SLAB, facets.iter().map(|f| grown(f, around)));
        let overlap = OVERLAP as f64 * self.cell;
        let crossing = by_slab(&grid, FINE_SLAB, heights(body, overlap));
        let slabs: Vec<(Vec<usize>, Vec<f32>)> = near
            .par_iter()
            .zip(&crossing)
            .enumerate()
            .map(|(slab, (near, crossing))| {
                if !wanted(slab) {
                    return (Vec::new(), Vec::new());
                }
                let near: Vec<&Facet> = near.iter().map(|&f| &facets[f as usize]).collect();
                self.slab_of_bricks(body, &grid, slab * FINE_SLAB, &near, crossing)
            })
            .collect();
        self.bricks = vec![NO_BRICK; self.coefficients.len() / 8];
        self.fine = Vec::with_capacity(slabs.iter().map(|(_, coefficients)| coefficients.len()).sum());
        for (places, coefficients) in slabs {
            for (k, place) in places.into_iter().enumerate() {
                self.bricks[place] = (self.fine.len() + k * RIMMED.pow(3)) as u32;
            }
            self.fine.extend(coefficients);
        }
    }

    /// The bricks in `FINE_SLAB` layers from `first` on, and their coefficients; `near` is the skin that
    /// reaches there, `crossing` the triangles of the body that do.
    fn slab_of_bricks(
        &self,
        body: &Body,
        grid: &Grid,
        first: usize,
        near: &[&Facet],
        crossing: &[u32],
    ) -> (Vec<usize>, Vec<f32>) {
        let ([nx, ny, nz], reach) = (grid.extent, FINE_REACH * self.cell);
        if near.is_empty() {
            return (Vec::new(), Vec::new());
        }
        let range = first.saturating_sub(OVERLAP)..(first + FINE_SLAB + OVERLAP).min(ny);
        let mut values = vec![f32::INFINITY; range.len() * grid.layer()];
        let mut layers = Layers { grid, range: range.clone(), squared: &mut values, nearest: &mut [] };
        near.iter().for_each(|facet| facet.mark(0, reach, &mut layers));
        let squared_reach = (reach * reach) as f32;
        for value in &mut values {
            *value = if *value <= squared_reach { value.sqrt() } else { f32::INFINITY };
        }
        Lines::new(body, grid, range.clone(), crossing)
            .for_each_inside(grid, |nodes| values[nodes].iter_mut().for_each(|v| *v = -*v));

        // A brick exists where it or its rim has a node that is not coarse alone.
        let coarsest = (reach - self.cell) as f32;
        let per_axis = [nx, ny, nz].map(|n| n / BRICK);
        let mut wanted = vec![false; per_axis[0] * per_axis[2] * (FINE_SLAB / BRICK)];
        let layer = grid.layer();
        let bricks_of = |c: usize| (c - 1) / BRICK..=(c + 1) / BRICK;
        for y in first.max(1) - 1..(first + FINE_SLAB + 1).min(range.end) {
            let ys = (y.max(first + 1) - 1 - first) / BRICK..=(y + 1 - first).min(FINE_SLAB - 1) / BRICK;
            for z in 1..nz - 1 {
                let row = (y - range.start) * layer + z * nx;
                for x in (1..nx - 1).filter(|x| values[row + x].abs() < coarsest) {
                    for by in ys.clone() {
                        for bz in bricks_of(z) {
                            for bx in bricks_of(x) {
                                wanted[(by * per_axis[2] + bz) * per_axis[0] + bx] = true;
                            }
                        }
                    }
                }
            }
        }
        let before = first / BRICK * per_axis[0] * per_axis[2];
        // Each node is in the rims of several bricks: its coefficient is computed when first asked for.
        let mut known = vec![f32::NAN; values.len()];
        let (mut places, mut coefficients) = (Vec::new(), Vec::new());
        for brick in (0..wanted.len()).filter(|&b| wanted[b]) {
            let [bx, bz] = [brick % per_axis[0], brick / per_axis[0] % per_axis[2]];
            let by = brick / (per_axis[0] * per_axis[2]);
            places.push(before + brick);
            // The rim begins one node before the brick. What is near the body is not at the border.
            for y in 0..RIMMED {
                for z in 0..RIMMED {
                    let y = first + by * BRICK + y - 1;
                    let row = (y - range.start) * layer + (bz * BRICK + z - 1) * nx + bx * BRICK - 1;
                    for (x, known) in known[row..row + RIMMED].iter_mut().enumerate() {
                        if known.is_nan() {
                            let node = [bx * BRICK + x - 1, y, bz * BRICK + z - 1];
                            *known = self.fine_coefficient(&values, row + x, node, grid);
                        }
                    }
                    coefficients.extend_from_slice(&known[row..row + RIMMED]);
                }
            }
        }
        (places, coefficients)
    }

    /// The coefficient of a fine node: sharpened exact distances near the surface, the coarse spline
    /// farther away, a mean of both between.
    fn fine_coefficient(&self, values: &[f32], at: usize, [x, y, z]: [usize; 3], grid: &Grid) -> f32 {
        let (layer, row) = (grid.layer(), grid.extent[0]);
        let share = (FINE_REACH as f32 - 1.0 - values[at].abs() / self.cell as f32).min(1.0);
        if share >= 1.0 {
            return sharpened(values, at, [1, layer, row]);
        }
        let coarse = self.halfway(x, y, z);
        if share > 0.0 { coarse + (sharpened(values, at, [1, layer, row]) - coarse) * share } else { coarse }
    }

    /// The coarse spline's coefficient at a fine node.
    fn halfway(&self, x: usize, y: usize, z: usize) -> f32 {
        // The nearest coarse node and the one on the other side of the fine node.
        let pair = |c: usize| [c / 2, if c.is_multiple_of(2) { c / 2 - 1 } else { c / 2 + 1 }];
        let (nx, nz) = (self.coarse.extent[0], self.coarse.extent[2]);
        let ([x0, x1], [y0, y1], [z0, z1]) = (pair(x), pair(y), pair(z));
        let row = |y: usize, z: usize| {
            let start = (y * nz + z) * nx;
            0.75 * self.coefficients[start + x0] + 0.25 * self.coefficients[start + x1]
        };
        let layer = |y: usize| 0.75 * row(y, z0) + 0.25 * row(y, z1);
        0.75 * layer(y0) + 0.25 * layer(y1)
    }

    pub fn band(&self) -> f64 {
        self.band
    }

    /// Side of a cell near the surface, m.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Distance and gradient, or `None` farther than the band outside.
    #[inline]
    pub fn sample(&self, point: Vector3) -> Option<Sample> {
        self.sample_below(point, f64::INFINITY).ok()
    }

    /// Distance alone; the band where it is beyond that.
    #[inline]
    pub fn distance(&self, point: Vector3) -> f64 {
        self.sample_below(point, f64::NEG_INFINITY).map_or_else(|distance| distance, |sample| sample.distance)
    }

    /// Distance and gradient where the distance is below `most`, m. For the others the gradient is not worth
    /// computing: `Err` has their distance, or the band where they are beyond it.
    #[inline]
    pub fn sample_below(&self, point: Vector3, most: f64) -> Result<Sample, f64> {
        // The nearest node; it and its neighbours carry the spline. What is negative or no number
        // becomes node 0, which has no neighbours.
        let at = ((point - self.coarse.origin) / self.coarse.cell).add_scalar(0.5);
        let [x, y, z] = [at.x, at.y, at.z].map(|c| c as usize);
        let [nx, ny, nz] = self.coarse.extent;
        let within = |c: usize, n: usize| c >= 1 && c < n - 1;
        if !(within(x, nx) && within(y, ny) && within(z, nz)) {
            return Err(self.band);
        }
        let most = most.min(self.band);
        let center = ((y * nz) + z) * nx + x;
        if f64::from(self.coefficients[center]) >= self.beyond {
            return Err(self.band);
        }
        let brick = self.bricks[((y / 2) * (nz / 2) + z / 2) * (nx / 2) + x / 2];
        if brick == NO_BRICK {
            let offset = at - Vector3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5);
            let corner = center - nx * nz - nx - 1;
            return Block::new(&self.coefficients[corner..], nx, nx * nz)
                .sample(offset, self.coarse.cell, most)
                .map_err(|d| d.min(self.band));
        }
        let twice = at * 2.0;
        let [i, j, k] = [twice.x, twice.y, twice.z].map(|c| c as usize);
        let offset = twice - Vector3::new(i as f64 + 0.5, j as f64 + 0.5, k as f64 + 0.5);
        let corner = ((j % BRICK) * RIMMED + k % BRICK) * RIMMED + i % BRICK;
        let block = Block::new(&self.fine[brick as usize + corner..], RIMMED, RIMMED * RIMMED);
        block.sample(offset, self.cell, most).map_err(|d| d.min(self.band))
    }
}

fn grown(facet: &Facet, by: f64) -> [f64; 2] {
    let (low, high) = facet.bounds();
    [low.y - by, high.y + by]
}

/// Lowest and highest y of each triangle of a body, m, with a margin.
fn heights(body: &Body, margin: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..body.triangles().len() as u32).map(move |t| {
        let [a, b, c] = body.corners(t);
        [a.y.min(b.y).min(c.y) - margin, a.y.max(b.y).max(c.y) + margin]
    })
}

/// Spline coefficients of the coarse grid: inside, and up to `reach` outside; `reach` beyond.
fn coarse_coefficients(body: &Body, skin: &[[Vector3; 3]], facets: &[Facet], grid: &Grid, reach: f64) -> Vec<f32> {
    let count: usize = grid.extent.iter().product();
    let mut nearest = Nearest { squared: vec![f32::INFINITY; count], triangle: vec![UNKNOWN; count] };
    let mut inside = vec![false; count];
    let exact = COARSE_REACH * grid.cell;
    let near = by_slab(grid, COARSE_SLAB, facets.iter().map(|f| grown(f, exact)));
    let crossing = by_slab(grid, COARSE_SLAB, heights(body, 0.0));
    let slab = COARSE_SLAB * grid.layer();
    nearest
        .squared
        .par_chunks_mut(slab)
        .zip(nearest.triangle.par_chunks_mut(slab))
        .zip(inside.par_chunks_mut(slab))
        .zip(near.par_iter().zip(&crossing))
        .enumerate()
        .for_each(|(k, (((squared, nearest), inside), (near, crossing)))| {
            let range = k * COARSE_SLAB..k * COARSE_SLAB + squared.len() / grid.layer();
            let mut layers = Layers { grid, range: range.clone(), squared, nearest };
            near.iter().for_each(|&t| facets[t as usize].mark(t, exact, &mut layers));
            Lines::new(body, grid, range, crossing).for_each_inside(grid, |nodes| inside[nodes].fill(true));
        });
    nearest.spread(grid, &inside, exact, reach, |t, point| {
        let corners = skin[t as usize];
        let [a, b, c] = closest_on_triangle(point, corners);
        (corners[0] * a + corners[1] * b + corners[2] * c - point).norm_squared()
    });
    let mut values = nearest.squared;
    values.par_iter_mut().zip(&inside).for_each(|(value, &inside)| {
        let distance = value.sqrt();
        *value = if inside { -distance } else { distance.min(reach as f32) };
    });
    // What is inside and was not reached has no neighbours that were: it is no place of the body.
    let layer = grid.layer();
    let mut coefficients = vec![reach as f32; count];
    coefficients.par_chunks_mut(layer).enumerate().for_each(|(y, out)| {
        if y == 0 || y + 1 == grid.extent[1] {
            return;
        }
        let row = grid.extent[0];
        for (at, out) in out.iter_mut().enumerate().take(layer - row - 1).skip(row + 1) {
            *out = sharpened(&values, y * layer + at, [1, layer, row]);
        }
    });
    coefficients
}

/// The spline coefficient of a node, from the values there and at its six neighbours.
///
/// A quadratic B-spline over the values themselves returns `f + h²/8 ∇²f`: it rounds every curved
/// surface off. Coefficients `f - ∇²f/8` (second differences) cancel that to fourth order.
#[inline]
fn sharpened(values: &[f32], at: usize, strides: [usize; 3]) -> f32 {
    let around: f32 = strides.iter().map(|d| values[at - d] + values[at + d]).sum();
    values[at] - (around - 6.0 * values[at]) / 8.0
}

/// The coefficients around a point: the first node's in front, strides to the next row and layer.
struct Block<'a> {
    coefficients: &'a [f32],
    row: usize,
    layer: usize,
}

impl<'a> Block<'a> {
    #[inline(always)]
    fn new(coefficients: &'a [f32], row: usize, layer: usize) -> Self {
        Self { coefficients: &coefficients[..2 * layer + 2 * row + 3], row, layer }
    }

    #[inline(always)]
    fn row(&self, y: usize, z: usize) -> [f64; 3] {
        let start = y * self.layer + z * self.row;
        let row = &self.coefficients[start..start + 3];
        [f64::from(row[0]), f64::from(row[1]), f64::from(row[2])]
    }

    /// The spline at `offset` cells from the middle node, if it is below `most`.
    #[inline(always)]
    fn sample(&self, offset: Vector3, cell: f64, most: f64) -> Result<Sample, f64> {
        let [wx, wy, wz] = [offset.x, offset.y, offset.z].map(spline_weights);
        // Sums along x; then those along z, one per layer; then the value.
        let mut along_x = [[0.0; 3]; 3];
        let mut along_z = [0.0; 3];
        let mut distance = 0.0;
        for y in 0..3 {
            for z in 0..3 {
                let row = self.row(y, z);
                along_x[y][z] = row[0] * wx[0] + row[1] * wx[1] + row[2] * wx[2];
                along_z[y] += along_x[y][z] * wz[z];
            }
            distance += along_z[y] * wy[y];
        }
        if distance >= most {
            return Err(distance);
        }
        let [dx, dy, dz] = [offset.x, offset.y, offset.z].map(spline_slopes);
        let mut slope = Vector3::zeros();
        for y in 0..3 {
            let (mut across, mut across_z) = (0.0, 0.0);
            for z in 0..3 {
                let row = self.row(y, z);
                across += (row[0] * dx[0] + row[1] * dx[1] + row[2] * dx[2]) * wz[z];
                across_z += along_x[y][z] * dz[z];
            }
            slope += Vector3::new(across * wy[y], along_z[y] * dy[y], across_z * wy[y]);
        }
        Ok(Sample { distance, gradient: slope / cell })
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
            // Where the cells are twice as large it is less exact.
            let tolerance = if exact.abs() < CELL { 2e-4 } else { 1.5e-3 };
            assert!((sample.distance - exact).abs() < tolerance, "{} against {exact}", sample.distance);
            let tolerance = if exact.abs() < CELL { 0.05 } else { 0.1 };
            assert!((sample.gradient.norm() - 1.0).abs() < tolerance, "{} at {exact}", sample.gradient.norm());
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
                let slope = difference / (2.0 * step);
                assert!((slope - sample.gradient[axis]).abs() < 1e-5, "{slope} {} at {point}", sample.gradient[axis]);
            }
        }
    }

    /// Bricks meet each other and the coarse grid without a step in value or slope.
    #[test]
    fn the_field_is_smooth_where_bricks_end() {
        let (_, field) = ball();
        let side = 2.0 * field.coarse.cell;
        for point in points(0.029) {
            for axis in 0..3 {
                let border = ((point[axis] - field.coarse.origin[axis]) / side + 0.25).round() - 0.25;
                let mut sides = [point; 2];
                for (side_point, by) in sides.iter_mut().zip([-1e-9, 1e-9]) {
                    side_point[axis] = field.coarse.origin[axis] + border * side + by;
                }
                let [Some(a), Some(b)] = sides.map(|p| field.sample(p)) else { continue };
                assert!((a.distance - b.distance).abs() < 2e-8, "{} {} at {point}", a.distance, b.distance);
                assert!((a.gradient - b.gradient).norm() < 1e-5, "{} {}", a.gradient, b.gradient);
            }
        }
    }

    #[test]
    fn where_nothing_is_worn_the_coarse_grid_serves() {
        let (body, field) = ball();
        let part = DistanceField::fine_at(0.4..0.5, &body, CELL, 0.03);
        assert!(part.fine.len() < field.fine.len() / 2);
        for at in points(0.02) {
            let (whole, part) = (field.sample(at).unwrap(), part.sample(at).unwrap());
            assert!((0.4..0.5).contains(&at.y) <= (whole == part), "{at}");
            assert!((whole.distance - part.distance).abs() < 0.05 * CELL, "{at}: {} {}", whole.distance, part.distance);
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
