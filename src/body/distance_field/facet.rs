//! Distances from a triangle to all nodes near it, a row of nodes at a time.
//!
//! All that a triangle's plane and sides need to know of a point, its height over the one, where it is
//! along and across the others, is linear in the point: along a row of nodes each of these numbers
//! grows evenly. The loop over a row has no branches, so that compilers make vectors of it.

use super::grid::Grid;
use crate::geometry::Vector3;
use std::ops::Range;

/// Nodes to a vector.
const LANES: usize = 8;
/// A triangle thinner than this share of its length is as good as its sides.
const FLAT: f64 = 1e-6;
/// A row of more nodes than this is long.
const LONG: f32 = 12.0;
/// What is found within the reach is found in spite of rounding.
const ROUNDING: f32 = 1.001;

/// A linear function of a point relative to a facet's first corner: a constant and the slopes along x,
/// y, z. Single precision is enough for the few centimetres that are asked for.
#[derive(Clone, Copy, Default)]
struct Linear([f32; 4]);

impl Linear {
    fn new(constant: f64, slope: Vector3) -> Self {
        Self([constant as f32, slope.x as f32, slope.y as f32, slope.z as f32])
    }

    /// The same on a row along x: its value at x = 0, and its slope.
    #[inline(always)]
    fn on_row(&self, y: f32, z: f32) -> [f32; 2] {
        [self.0[0] + self.0[2] * y + self.0[3] * z, self.0[1]]
    }
}

/// A triangle, made ready for distances to many points.
pub struct Facet {
    corners: [Vector3; 3],
    /// A ball around the triangle, from the first corner.
    middle: [f32; 3],
    radius: f32,
    /// Height over its plane, m.
    height: Linear,
    /// A point lies over the triangle if it is farther than this inside each side, m.
    least_inside: f32,
    sides: [Side; 3],
}

/// The nearest point of a side is off by the distance across it, and along it by as much as a point lies
/// before its start or past its end.
#[derive(Clone, Copy)]
struct Side {
    length: f32,
    /// From the start, m.
    along: Linear,
    /// Positive on the side of the triangle, m.
    across: Linear,
}

/// The nodes of some layers of a grid, and how near a triangle is to each.
pub struct Layers<'a> {
    pub grid: &'a Grid,
    pub range: Range<usize>,
    /// One per node of these layers, m².
    pub squared: &'a mut [f32],
    /// The nearest triangle of each node; empty if nobody asks.
    pub nearest: &'a mut [u32],
}

impl Facet {
    pub fn new(corners: [Vector3; 3]) -> Self {
        let [a, b, c] = corners;
        let across = (b - a).cross(&(c - a));
        let longest = (b - a).norm_squared().max((c - a).norm_squared()).max((c - b).norm_squared());
        let flat = across.norm() <= FLAT * longest;
        let normal = if flat { perpendicular([b - a, c - a]) } else { across.normalize() };
        let sides = [[a, b], [b, c], [c, a]].map(|[p, q]| {
            let along = (q - p).try_normalize(0.0).unwrap_or_else(|| perpendicular([normal, normal]));
            let across = normal.cross(&along);
            let from = p - a;
            Side {
                length: (q - p).norm() as f32,
                along: Linear::new(-along.dot(&from), along),
                across: Linear::new(-across.dot(&from), across),
            }
        });
        let middle = (a + b + c) / 3.0;
        let radius = corners.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        let middle = middle - a;
        Self {
            corners,
            middle: [middle.x as f32, middle.y as f32, middle.z as f32],
            radius: radius as f32,
            height: Linear::new(0.0, normal),
            least_inside: if flat { f32::INFINITY } else { 0.0 },
            sides,
        }
    }

    /// Lowest and highest coordinates, m.
    pub fn bounds(&self) -> (Vector3, Vector3) {
        let [a, b, c] = self.corners;
        (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
    }

    /// Makes every node within `reach`, m, know this triangle. Farther nodes may come to know it.
    pub fn mark(&self, index: u32, reach: f64, layers: &mut Layers) {
        let grid = layers.grid;
        let (low, high) = self.bounds();
        let [xs, ys, zs] = [0, 1, 2].map(|axis| grid.nodes(axis, low[axis] - reach, high[axis] + reach));
        let row = grid.extent[0];
        if xs.is_empty() {
            return;
        }
        // From the first corner to the first node of the box: the same for whatever layers are asked for, so
        // that overlapping slabs agree to the last bit.
        let start = grid.position([xs.start, ys.start, zs.start]) - self.corners[0];
        let [x0, y0, z0] = [start.x as f32, start.y as f32, start.z as f32];
        let (cell, last) = (grid.cell as f32, (xs.len() - 1) as f32);
        let (scale, near) = (1.0 / cell, reach as f32 * ROUNDING);
        let far = (near + self.radius) * (near + self.radius);
        let slope = self.height.0[1].abs();
        for y in ys.start.max(layers.range.start)..ys.end.min(layers.range.end) {
            let py = y0 + (y - ys.start) as f32 * cell;
            let dy = py - self.middle[1];
            for z in zs.clone() {
                let pz = z0 + (z - zs.start) as f32 * cell;
                let dz = pz - self.middle[2];
                let left = far - dy * dy - dz * dz;
                // Beyond the reach of the ball around the triangle, or of its plane.
                if left < 0.0 {
                    continue;
                }
                let half = left.sqrt();
                let [constant, along] = self.height.on_row(py, pz);
                if (constant + along * self.middle[0]).abs() > near + slope * half {
                    continue;
                }
                let mut first = larger((self.middle[0] - half - x0) * scale, 0.0);
                let mut end = smaller((self.middle[0] + half - x0) * scale, last);
                // Of a long row only what is near the plane is worth the divisions.
                if end - first > LONG && slope > 1e-3 {
                    let (middle, half) = (-constant / along - x0, near / slope);
                    first = larger((middle - half) * scale, first);
                    end = smaller((middle + half) * scale, end);
                    if first > end {
                        continue;
                    }
                }
                // A cast rounds down; at worst a node too many.
                let (first, end) = (xs.start + first as u32 as usize, xs.start + end as u32 as usize + 2);
                let count = (end - first).next_multiple_of(LANES).min(row);
                let from = first.min(row - count);
                let node = ((y - layers.range.start) * grid.extent[2] + z) * row + from;
                let px = x0 + (from as f32 - xs.start as f32) * cell;
                let squared = &mut layers.squared[node..node + count];
                if layers.nearest.is_empty() {
                    self.row::<false>(index, [px, py, pz], cell, squared, &mut []);
                } else {
                    self.row::<true>(index, [px, py, pz], cell, squared, &mut layers.nearest[node..node + count]);
                }
            }
        }
    }

    /// A row of nodes along x, the first at `[px, py, pz]` from the first corner.
    #[inline]
    fn row<const NEAREST: bool>(
        &self,
        index: u32,
        [px, py, pz]: [f32; 3],
        cell: f32,
        mut squared: &mut [f32],
        mut nearest: &mut [u32],
    ) {
        let (height, least_inside) = (self.height.on_row(py, pz), self.least_inside);
        let sides = self.sides.map(|s| (s.length, s.along.on_row(py, pz), s.across.on_row(py, pz)));
        let mut start = px;
        while !squared.is_empty() {
            let mut found = [0.0f32; LANES];
            for (k, found) in found.iter_mut().enumerate() {
                let x = start + k as f32 * cell;
                let [d0, d1, d2] = sides.map(|(length, [from, step], [off, step_off])| {
                    let along = from + step * x;
                    let past = along - smaller(larger(along, 0.0), length);
                    let across = off + step_off * x;
                    (past * past + across * across, across)
                });
                let to_sides = smaller(smaller(d0.0, d1.0), d2.0);
                let inside = smaller(smaller(d0.1, d1.1), d2.1);
                let height = height[0] + height[1] * x;
                *found = height * height + if inside > least_inside { 0.0 } else { to_sides };
            }
            let count = squared.len().min(LANES);
            let (here, after) = squared.split_at_mut(count);
            if NEAREST {
                let (ids, ids_after) = nearest.split_at_mut(count);
                for ((squared, nearest), &found) in here.iter_mut().zip(ids).zip(&found) {
                    // Of equally near ones the first, whatever the order in which they come.
                    let nearer = found < *squared || (found == *squared && index < *nearest);
                    *nearest = if nearer { index } else { *nearest };
                    *squared = smaller(found, *squared);
                }
                nearest = ids_after;
            } else if let Ok(here) = <&mut [f32; LANES]>::try_from(&mut *here) {
                here.iter_mut().zip(&found).for_each(|(squared, &found)| *squared = smaller(found, *squared));
            } else {
                here.iter_mut().zip(&found).for_each(|(squared, &found)| *squared = smaller(found, *squared));
            }
            squared = after;
            start += LANES as f32 * cell;
        }
    }
}

/// A unit vector across the longer of two.
fn perpendicular([p, q]: [Vector3; 2]) -> Vector3 {
    let along = if p.norm_squared() > q.norm_squared() { p } else { q };
    let axis = if along.x.abs() < along.y.abs() { Vector3::x() } else { Vector3::y() };
    along.cross(&axis).try_normalize(0.0).unwrap_or_else(Vector3::z)
}

/// Unlike `f32::min`, one instruction: there are no NaN.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{closest_between_segments, closest_on_triangle};
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vector3> {
        [0.0..0.2, 0.0..0.1, 0.0..0.15f64].prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn nodes_within_reach_know_their_distance(a in point(), b in point(), c in point(), kind in 0..4) {
            // Some triangles have no area, some a side without length.
            let c = match kind { 0 => a, 1 => a.lerp(&b, 0.3), _ => c };
            let cell = 0.01;
            let grid = Grid { origin: Vector3::repeat(-0.06), cell, extent: [40, 30, 34] };
            let count = grid.extent.iter().product();
            let (mut squared, mut nearest) = (vec![f32::INFINITY; count], vec![u32::MAX; count]);
            let reach = 0.025;
            let half = grid.extent[1] / 2;
            let (first, second) = squared.split_at_mut(half * grid.layer());
            let (first_nearest, second_nearest) = nearest.split_at_mut(half * grid.layer());
            let facet = Facet::new([a, b, c]);
            facet.mark(7, reach, &mut Layers { grid: &grid, range: 0..half, squared: first, nearest: first_nearest });
            let rest = half..grid.extent[1];
            facet.mark(7, reach, &mut Layers { grid: &grid, range: rest, squared: second, nearest: second_nearest });
            for node in 0..count {
                let [x, y, z] = [node % 40, node / grid.layer(), node / 40 % 34];
                let at = grid.position([x, y, z]);
                // Of a triangle without area the face may miss the nearest side.
                let w = closest_on_triangle(at, [a, b, c]);
                let to_face = (a * w[0] + b * w[1] + c * w[2] - at).norm();
                let sides = [[a, b], [b, c], [c, a]].map(|side| {
                    let t = closest_between_segments([at, at], side).t;
                    (side[0].lerp(&side[1], t) - at).norm()
                });
                let exact = sides.into_iter().fold(to_face, f64::min);
                if exact < reach || nearest[node] == 7 {
                    prop_assert!((f64::from(squared[node].sqrt()) - exact).abs() < 1e-5, "{} {exact}", squared[node].sqrt());
                    prop_assert_eq!(nearest[node], 7);
                }
            }
        }
    }
}
