//! Fine particles on coarse triangles.
//!
//! Each point of a level is located on the next coarser one: a triangle of the same panel and three
//! barycentric weights (Le Thanh and Gagalowicz 2007, section 4). Curved outlines leave some points
//! outside every coarse triangle. The paper takes the triangle with the nearest centroid, which is
//! the wrong one at a curved rim; we take the triangle that is nearest, and extrapolate from it.

use super::level::{Level, PanelRange};
use crate::geometry::{BoxTree, EdgeTable, Vector2, Vector3, barycentric, closest_on_triangle};
use rayon::prelude::*;

/// A triangle and three barycentric weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    pub triangle: u32,
    /// Sum to one; some are negative where the point is outside.
    pub weights: [f64; 3],
}

/// For each point of a finer level its place on a coarser one.
#[derive(Clone, Debug)]
pub struct Correspondence {
    /// One per point of the finer level.
    pub locations: Vec<Location>,
}

impl Correspondence {
    pub fn new(coarse: &Level, fine: &Level) -> Self {
        let locations: Vec<Vec<Location>> = coarse
            .panels
            .par_iter()
            .zip(&fine.panels)
            .map(|(coarse_panel, fine_panel)| {
                let locator = Locator::new(coarse, coarse_panel);
                let points = fine.rest[fine_panel.points.clone()].par_iter();
                points.with_min_len(CHUNK).map(|&p| locator.locate(p)).collect()
            })
            .collect();
        Self { locations: locations.concat() }
    }

    /// Positions of the finer level's particles on the surface of the coarser level, m, world: what
    /// is affine on the coarse panels is kept. A sewn particle comes to the mean of its points.
    pub fn prolong(&self, coarse: &Level, fine: &Level, positions: &[Vector3]) -> Vec<Vector3> {
        self.mean_of_points(coarse, fine, positions, |weights| weights)
    }

    /// The same without extrapolation: what lies outside the coarse triangles comes to their rim.
    pub fn prolong_within(&self, coarse: &Level, fine: &Level, positions: &[Vector3]) -> Vec<Vector3> {
        self.mean_of_points(coarse, fine, positions, |weights| {
            let inner = weights.map(|w| w.max(0.0));
            let sum: f64 = inner.iter().sum();
            inner.map(|w| w / sum)
        })
    }

    fn mean_of_points(
        &self,
        coarse: &Level,
        fine: &Level,
        positions: &[Vector3],
        weights: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Vec<Vector3> {
        let mut sums = vec![(Vector3::zeros(), 0.0); fine.particle_count];
        for (location, &particle) in self.locations.iter().zip(&fine.particle_of) {
            let corners = coarse.particles(location.triangle as usize).map(|p| positions[p as usize]);
            let [a, b, c] = weights(location.weights);
            let sum = &mut sums[particle as usize];
            sum.0 += corners[0] * a + corners[1] * b + corners[2] * c;
            sum.1 += 1.0;
        }
        sums.into_iter().map(|(sum, count)| sum / count).collect()
    }
}

/// Points to a piece of parallel work.
const CHUNK: usize = 1024;

/// Finds points on the triangles of one panel.
struct Locator<'a> {
    level: &'a Level,
    panel: &'a PanelRange,
    bins: Bins,
    /// Of what is outside all triangles the nearest one has an edge on the outline: those that do.
    rim: Vec<u32>,
    /// A tree over them.
    rim_tree: BoxTree,
}

/// Triangles in square bins, every triangle in each bin that its box meets.
struct Bins {
    low: Vector2,
    /// Side of a bin, m.
    side: f64,
    /// Bins along x and y.
    extent: [usize; 2],
    /// Per bin, x fastest: where its triangles begin in `triangles`; one more at the end.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

/// Side of a bin in resolutions: a few triangles meet it.
const BIN: f64 = 1.0;
/// The most bins for each triangle: a narrow panel drawn aslant has a large box, nearly all of it empty.
const MOST_BINS: f64 = 4.0;
/// A point is in a triangle if no weight is below this: on an edge rounding may put it outside both.
const INSIDE: f64 = -1e-9;

impl Bins {
    fn new(corners: impl Fn(u32) -> [Vector2; 3], count: u32, side: f64) -> Self {
        let bounds = |t: u32| {
            let [a, b, c] = corners(t);
            (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
        };
        let infinity = Vector2::repeat(f64::INFINITY);
        let (low, high) = (0..count).map(bounds).fold((infinity, -infinity), |(l, h), (a, b)| (l.inf(&a), h.sup(&b)));
        let size = high - low;
        let side = side.max((size.x * size.y / (MOST_BINS * f64::from(count))).sqrt()).max(size.max() / 1e6);
        let extent = [size.x, size.y].map(|s| (s / side) as usize + 1);
        let mut bins = Self { low, side, extent, starts: vec![0; extent[0] * extent[1] + 1], triangles: Vec::new() };
        let each = |t: u32, visit: &mut dyn FnMut(usize)| {
            let (low, high) = bounds(t);
            let ([x0, y0], [x1, y1]) = (bins.at(low), bins.at(high));
            (y0..=y1).for_each(|y| (x0..=x1).for_each(|x| visit(y * extent[0] + x)));
        };
        let mut starts = vec![0u32; extent[0] * extent[1] + 1];
        (0..count).for_each(|t| each(t, &mut |bin| starts[bin + 1] += 1));
        (1..starts.len()).for_each(|bin| starts[bin] += starts[bin - 1]);
        let mut next = starts.clone();
        let mut triangles = vec![0; starts[starts.len() - 1] as usize];
        for t in 0..count {
            each(t, &mut |bin| {
                triangles[next[bin] as usize] = t;
                next[bin] += 1;
            });
        }
        (bins.starts, bins.triangles) = (starts, triangles);
        bins
    }

    /// The bin of a point, or the nearest one.
    fn at(&self, point: Vector2) -> [usize; 2] {
        let at = (point - self.low) / self.side;
        [(at.x as usize).min(self.extent[0] - 1), (at.y as usize).min(self.extent[1] - 1)]
    }

    /// The triangles whose boxes may hold a point.
    fn around(&self, point: Vector2) -> &[u32] {
        let [x, y] = self.at(point);
        let bin = y * self.extent[0] + x;
        &self.triangles[self.starts[bin] as usize..self.starts[bin + 1] as usize]
    }
}

fn lifted(p: Vector2) -> Vector3 {
    Vector3::new(p.x, p.y, 0.0)
}

impl<'a> Locator<'a> {
    fn new(level: &'a Level, panel: &'a PanelRange) -> Self {
        let first = panel.triangles.start;
        let corners = |t: u32| level.rest_corners(first + t as usize);
        let bins = Bins::new(corners, panel.triangles.len() as u32, BIN * level.resolution);
        let edges = EdgeTable::new(&level.triangles[panel.triangles.clone()]).edges;
        let mut rim: Vec<u32> = edges.iter().filter(|e| e.triangles.len() == 1).map(|edge| edge.triangles[0]).collect();
        rim.sort_unstable();
        rim.dedup();
        let rim_tree = BoxTree::of_triangles(rim.iter().map(|&t| corners(t).map(lifted)), 0.0);
        Self { level, panel, bins, rim, rim_tree }
    }

    fn corners(&self, index: u32) -> [Vector2; 3] {
        self.level.rest_corners(self.panel.triangles.start + index as usize)
    }

    fn locate(&self, point: Vector2) -> Location {
        let located = |index: u32, weights| Location { triangle: self.panel.triangles.start as u32 + index, weights };
        // On an edge the triangle that the point is deeper in, of equals the first.
        let mut best: Option<(f64, Location)> = None;
        for &index in self.bins.around(point) {
            let weights = barycentric(point, self.corners(index));
            let least = weights[0].min(weights[1]).min(weights[2]);
            if least >= INSIDE && best.is_none_or(|(most, _)| least > most) {
                best = Some((least, located(index, weights)));
            }
        }
        best.map_or_else(|| self.nearest(point), |(_, location)| location)
    }

    /// For what is outside all triangles.
    fn nearest(&self, point: Vector2) -> Location {
        let squared_distance = |k: u32| {
            let corners = self.corners(self.rim[k as usize]).map(lifted);
            let [a, b, c] = closest_on_triangle(lifted(point), corners);
            (corners[0] * a + corners[1] * b + corners[2] * c - lifted(point)).norm_squared()
        };
        let found = self.rim_tree.nearest(lifted(point), f64::INFINITY, squared_distance);
        let (k, _) = found.expect("a panel has a rim");
        let index = self.rim[k as usize];
        let triangle = self.panel.triangles.start as u32 + index;
        Location { triangle, weights: barycentric(point, self.corners(index)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::{Arc, Pattern, Shape, shapes};
    use proptest::prelude::*;

    /// Two rectangles sewn together, one with a round rim that reaches beyond coarse triangles.
    fn garment() -> (Pattern, Garment) {
        let mut pattern = shapes::two_rectangles(0.2, 0.3);
        let rim = &mut pattern.panels[0].segments[3].curve;
        rim.shape = Shape::Arc(Arc::between(rim.start, rim.end, 0.16, false, true));
        let garment = Garment::build(&pattern, &[0.06, 0.023, 0.01]).unwrap();
        (pattern, garment)
    }

    /// Where an affine map of the sewn plane brings the particles; the right panel lies beside the left.
    fn mapped(level: &Level, map: impl Fn(Vector2) -> Vector3) -> Vec<Vector3> {
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        for (k, &p) in level.particle_of.iter().enumerate() {
            let shift = if level.panels[1].points.contains(&k) { 0.2 } else { 0.0 };
            positions[p as usize] = map(level.rest[k] + Vector2::new(shift, 0.0));
        }
        positions
    }

    proptest! {
        #[test]
        fn prolongation_keeps_affine_maps(columns in proptest::array::uniform9(-2.0..2.0f64)) {
            let (_, garment) = garment();
            let [x, y, t] = [0, 3, 6].map(|k| Vector3::new(columns[k], columns[k + 1], columns[k + 2]));
            let affine = |p: Vector2| x * p.x + y * p.y + t;
            for (k, correspondence) in garment.correspondences.iter().enumerate() {
                let (coarse, fine) = (&garment.levels[k], &garment.levels[k + 1]);
                let prolonged = correspondence.prolong(coarse, fine, &mapped(coarse, affine));
                for (ours, exact) in prolonged.iter().zip(mapped(fine, affine)) {
                    prop_assert!((ours - exact).norm() < 1e-12, "{ours} is not {exact}");
                }
            }
        }
    }

    /// Bins and rims find what looking at every triangle finds.
    #[test]
    fn points_are_located_in_the_nearest_triangle() {
        let (_, garment) = garment();
        let (coarse, fine) = (&garment.levels[0], &garment.levels[1]);
        let to = |t: usize, p: Vector2| {
            let corners = coarse.rest_corners(t).map(lifted);
            let [a, b, c] = closest_on_triangle(lifted(p), corners);
            (corners[0] * a + corners[1] * b + corners[2] * c - lifted(p)).norm()
        };
        for (panel, range) in coarse.panels.iter().zip(&fine.panels) {
            for point in range.points.clone() {
                let (at, found) = (fine.rest[point], garment.correspondences[0].locations[point].triangle as usize);
                assert!(panel.triangles.contains(&found));
                let least = panel.triangles.clone().map(|t| to(t, at)).fold(f64::INFINITY, f64::min);
                assert!(to(found, at) < least + 1e-9, "{} and not {least}", to(found, at));
            }
        }
    }

    #[test]
    fn the_round_rim_is_extrapolated_unless_it_must_stay_within() {
        let (_, garment) = garment();
        let (coarse, fine) = (&garment.levels[0], &garment.levels[1]);
        let correspondence = &garment.correspondences[0];
        assert!(correspondence.locations.iter().any(|l| l.weights.iter().any(|&w| w < -0.01)));
        let flat = |p: Vector2| Vector3::new(p.x, p.y, 0.0);
        let positions = mapped(coarse, flat);
        let leftmost = |points: &[Vector3]| points.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
        let within = correspondence.prolong_within(coarse, fine, &positions);
        assert!(leftmost(&within) >= leftmost(&positions) - 1e-12);
        assert!(leftmost(&correspondence.prolong(coarse, fine, &positions)) < leftmost(&positions) - 1e-4);
    }

    #[test]
    fn a_level_prolonged_to_itself_stays_where_it_is() {
        let (_, garment) = garment();
        for level in &garment.levels {
            let positions: Vec<Vector3> =
                (0..level.particle_count).map(|k| Vector3::new(k as f64, (k as f64).sin(), (k as f64).cos())).collect();
            let same = Correspondence::new(level, level).prolong(level, level, &positions);
            assert!(same.iter().zip(&positions).all(|(a, b)| (a - b).norm() < 1e-9));
        }
    }

    #[test]
    fn welded_partners_meet_half_way_and_others_stay() {
        let (_, garment) = garment();
        let open = &garment.open;
        let positions: Vec<Vector3> =
            (0..open.particle_count).map(|k| Vector3::new(k as f64, (k as f64).sin(), 1.0)).collect();
        let welded = garment.weld(&positions);
        let first = &garment.levels[0];
        assert_eq!(open.particle_count - first.particle_count, open.stitches.len());
        let mut sewn = vec![false; open.particle_count];
        for &[a, b] in &open.stitches {
            let particle = first.particle_of[a as usize];
            assert_eq!(particle, first.particle_of[b as usize]);
            let half_way = (positions[a as usize] + positions[b as usize]) / 2.0;
            assert!((welded[particle as usize] - half_way).norm() < 1e-12);
            (sewn[a as usize], sewn[b as usize]) = (true, true);
        }
        for point in (0..open.particle_count).filter(|&p| !sewn[p]) {
            assert_eq!(welded[first.particle_of[point] as usize], positions[point]);
        }
    }
}
