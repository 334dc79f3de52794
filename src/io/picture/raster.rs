//! What the camera sees: for every sample of a tile the nearest triangle or line.

use super::camera::Camera;
use super::scene::Mesh;
use crate::geometry::coverage::{Budget, Corner, Coverage, Rect, SAMPLES, sample_offset};

/// Edge of a tile, pixels. Small enough that the sample buffers of a tile (128 kB) stay in the cache.
pub(super) const TILE: i64 = 32;

const PIXELS_PER_TILE: usize = (TILE * TILE) as usize;

/// Lines are drawn this much nearer than the cloth they lie on, m: enough for cloth that turns away steeply, less
/// than anything that may lie over it.
const LINE_LIFT: f64 = 0.0015;

/// Triangle or line, by its index in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Primitive {
    Triangle(usize),
    Line(usize),
}

/// Part of a pixel that shows one primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fragment {
    pub(super) primitive: Primitive,
    /// Part of the pixel's area, 0 to 1.
    pub(super) area: f32,
    /// Middle of the covered samples, pixels; inside the primitive.
    pub(super) x: f64,
    pub(super) y: f64,
}

/// A mesh on the picture plane, sorted into tiles.
pub(super) struct Raster<'a> {
    mesh: &'a Mesh,
    /// One per vertex.
    projected: Vec<Corner>,
    /// Half the width of a line, pixels.
    half_line: f64,
    tiles_across: i64,
    /// For each tile, row by row, the primitives that may touch it, in the order of the mesh. They are numbered
    /// through: triangles first, then lines.
    bins: Vec<Vec<u32>>,
}

impl<'a> Raster<'a> {
    pub(super) fn new(mesh: &'a Mesh, camera: &Camera, size: [u32; 2], line_width: f64) -> Self {
        let [tiles_across, tiles_down] = size.map(|side| i64::from(side.div_ceil(TILE as u32)));
        let mut raster = Self {
            mesh,
            projected: mesh.positions.iter().map(|position| camera.project(position)).collect(),
            half_line: 0.5 * line_width,
            tiles_across,
            bins: vec![Vec::new(); (tiles_across * tiles_down) as usize],
        };
        let picture = Rect { x0: 0, y0: 0, x1: i64::from(size[0]), y1: i64::from(size[1]) };
        let mut budget = Budget::new(picture);
        for number in 0..mesh.triangles.len() + mesh.lines.len() {
            raster.sort_in(number as u32, picture, &mut budget);
        }
        raster
    }

    pub(super) fn tile_count(&self) -> usize {
        self.bins.len()
    }

    pub(super) fn is_empty(&self, tile: usize) -> bool {
        self.bins[tile].is_empty()
    }

    /// The pixels of a tile; those of the last column and row may lie beyond the picture.
    pub(super) fn tile_rect(&self, tile: usize) -> Rect {
        let x0 = tile as i64 % self.tiles_across * TILE;
        let y0 = tile as i64 / self.tiles_across * TILE;
        Rect { x0, y0, x1: x0 + TILE, y1: y0 + TILE }
    }

    fn primitive(&self, number: u32) -> Primitive {
        let index = number as usize;
        match index.checked_sub(self.mesh.triangles.len()) {
            None => Primitive::Triangle(index),
            Some(line) => Primitive::Line(line),
        }
    }

    fn sort_in(&mut self, number: u32, picture: Rect, budget: &mut Budget) {
        for coverage in self.coverages(number).into_iter().flatten() {
            let pixels = coverage.bounds.intersection(picture);
            if pixels.area() == 0 || !budget.spend(pixels) {
                continue;
            }
            let touched = Rect {
                x0: pixels.x0 / TILE,
                y0: pixels.y0 / TILE,
                x1: (pixels.x1 - 1) / TILE + 1,
                y1: (pixels.y1 - 1) / TILE + 1,
            };
            for y in touched.y0..touched.y1 {
                for x in touched.x0..touched.x1 {
                    let bin = &mut self.bins[(y * self.tiles_across + x) as usize];
                    // The two halves of a line come one after the other and are kept as one.
                    if bin.last() != Some(&number) {
                        bin.push(number);
                    }
                }
            }
        }
    }

    /// A triangle as such; a line as two triangles that make a ribbon of constant width on the picture.
    fn coverages(&self, number: u32) -> [Option<Coverage>; 2] {
        match self.primitive(number) {
            Primitive::Triangle(index) => [Coverage::of_samples(&self.corners(index)), None],
            Primitive::Line(index) => self.ribbon(index).map_or([None, None], |[a, b, c, d]| {
                [Coverage::of_samples(&[a, b, c]), Coverage::of_samples(&[a, c, d])]
            }),
        }
    }

    /// The projected corners of a triangle.
    pub(super) fn corners(&self, triangle: usize) -> [Corner; 3] {
        self.mesh.triangles[triangle].map(|vertex| self.projected[vertex as usize])
    }

    /// The projected ends of a line.
    pub(super) fn ends(&self, line: usize) -> [Corner; 2] {
        self.mesh.lines[line].map(|vertex| self.projected[vertex as usize])
    }

    fn ribbon(&self, line: usize) -> Option<[Corner; 4]> {
        let ends = self.ends(line);
        if ends.iter().any(Corner::is_outside) {
            return None;
        }
        let [p, q] = ends.each_ref().map(Corner::pixels);
        let along = [q[0] - p[0], q[1] - p[1]];
        let length = along[0].hypot(along[1]);
        if length <= 0.0 {
            return None;
        }
        let [u, v] = along.map(|part| part / length * self.half_line);
        // Half a width is added at the ends so that neighbours meet without a gap at their outer side.
        let corner = |end: usize, forward: f64, aside: f64| {
            let [x, y] = [p, q][end];
            let depth = ends[end].depth / (1.0 - LINE_LIFT * ends[end].depth).max(0.5);
            Corner::new(x + forward * u - aside * v, y + forward * v + aside * u, depth)
        };
        Some([corner(0, -1.0, -1.0), corner(1, 1.0, -1.0), corner(1, 1.0, 1.0), corner(0, -1.0, 1.0)])
    }

    /// Decides the visibility of every sample of a tile.
    pub(super) fn tile(&self, tile: usize) -> Tile<'_> {
        let mut samples = Tile {
            raster: self,
            rect: self.tile_rect(tile),
            inverse_depths: vec![[0.0; SAMPLES]; PIXELS_PER_TILE],
            numbers: vec![[NOTHING; SAMPLES]; PIXELS_PER_TILE],
        };
        for &number in &self.bins[tile] {
            for coverage in self.coverages(number).into_iter().flatten() {
                samples.draw(number, &coverage);
            }
        }
        samples
    }
}

/// In place of a primitive's number: the background.
const NOTHING: u32 = u32::MAX;

/// The samples of a tile.
pub(super) struct Tile<'a> {
    raster: &'a Raster<'a>,
    rect: Rect,
    /// 1/m, of the nearest primitive on each sample so far.
    inverse_depths: Vec<[f32; SAMPLES]>,
    /// That primitive's number.
    numbers: Vec<[u32; SAMPLES]>,
}

impl Tile<'_> {
    fn draw(&mut self, number: u32, coverage: &Coverage) {
        let rect = self.rect;
        coverage.for_each_sample_mask(rect, |x, y, mask| {
            let pixel = pixel_in(rect, x, y);
            let nearest = &mut self.inverse_depths[pixel];
            let numbers = &mut self.numbers[pixel];
            for sample in bits(mask) {
                let [dx, dy] = sample_offset(sample);
                let inverse_depth = coverage.depth(x as f64 + dx, y as f64 + dy) as f32;
                // At equal depth the first of the mesh stays.
                if inverse_depth > nearest[sample] {
                    nearest[sample] = inverse_depth;
                    numbers[sample] = number;
                }
            }
        });
    }

    /// Calls `visit` for each primitive that is seen in a pixel, the first sample's first.
    pub(super) fn for_each_fragment(&self, x: i64, y: i64, mut visit: impl FnMut(Fragment)) {
        let numbers = &self.numbers[pixel_in(self.rect, x, y)];
        let mut is_done = 0_u16;
        for first in 0..SAMPLES {
            if numbers[first] == NOTHING || is_done >> first & 1 == 1 {
                continue;
            }
            let same = (first..SAMPLES).filter(|&sample| numbers[sample] == numbers[first]);
            let (mut mask, mut count, mut sum) = (0_u16, 0.0, [0.0; 2]);
            for sample in same {
                let [dx, dy] = sample_offset(sample);
                sum = [sum[0] + dx, sum[1] + dy];
                count += 1.0;
                mask |= 1 << sample;
            }
            is_done |= mask;
            visit(Fragment {
                primitive: self.raster.primitive(numbers[first]),
                area: count as f32 / SAMPLES as f32,
                x: x as f64 + sum[0] / count,
                y: y as f64 + sum[1] / count,
            });
        }
    }
}

fn pixel_in(tile: Rect, x: i64, y: i64) -> usize {
    ((y - tile.y0) * TILE + x - tile.x0) as usize
}

/// The indices of the bits that are set.
fn bits(mut mask: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = (mask != 0).then(|| mask.trailing_zeros() as usize)?;
        mask &= mask - 1;
        Some(lowest)
    })
}

#[cfg(test)]
mod tests {
    use super::super::camera::View;
    use super::super::scene::{Coloring, MISSING_COLOR, Surface};
    use super::*;
    use nalgebra::Point3;

    /// Faces the viewer at a depth z, wider than the picture.
    fn wall(z: f64) -> [Point3<f64>; 3] {
        [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]].map(|[x, y]| Point3::new(x, y, z))
    }

    fn fragments(walls: &[[Point3<f64>; 3]], lines: &[[u32; 2]]) -> Vec<Fragment> {
        let surface = |positions| Surface {
            positions,
            triangles: &[[0, 1, 2]],
            coloring: Coloring::Constant(MISSING_COLOR),
            lines,
        };
        let mesh = Mesh::new(&walls.iter().map(|wall| surface(wall)).collect::<Vec<_>>());
        let view = View { azimuth: 0.0, elevation: 0.0, target: Point3::origin(), distance: 10.0, height: 2.0 };
        let size = [40, 40];
        let raster = Raster::new(&mesh, &Camera::new(&view, size, &mesh.origin), size, 2.0);
        let mut fragments = Vec::new();
        raster.tile(0).for_each_fragment(20, 20, |fragment| fragments.push(fragment));
        fragments
    }

    #[test]
    fn the_nearer_wall_is_seen_in_any_order() {
        for (walls, nearer) in [([wall(0.0), wall(1.0)], 1), ([wall(1.0), wall(0.0)], 0)] {
            let seen = fragments(&walls, &[]);
            let whole = Fragment { primitive: Primitive::Triangle(nearer), area: 1.0, x: 20.5, y: 20.5 };
            assert_eq!(seen, [whole]);
        }
    }

    #[test]
    fn behind_the_camera_nothing_is_seen() {
        assert_eq!(fragments(&[wall(10.5)], &[]), []);
        let [a, b, _] = wall(0.0);
        assert_eq!(fragments(&[[a, b, wall(30.0)[2]]], &[[0, 2]]), []);
    }

    #[test]
    fn a_line_lies_on_its_surface_and_behind_another() {
        // From the middle of the bottom, through the middle of the picture.
        let on = |z| [Point3::new(0.0, -9.0, z), Point3::new(9.0, 9.0, z), Point3::new(-9.0, 9.0, z)];
        let [a, b, c] = on(0.0);
        let middle = nalgebra::center(&b, &c);
        let seen = fragments(&[[a, b, middle], [a, middle, c]], &[[0, 2]]);
        assert!(seen.iter().any(|fragment| matches!(fragment.primitive, Primitive::Line(_))));
        let seen = fragments(&[[a, b, middle], [a, middle, c], wall(1.0)], &[[0, 2]]);
        assert_eq!(seen.len(), 1);
    }
}
