//! Depth maps: what a parallel light sees of the mesh.

use nalgebra::Vector3;

use super::scene::{Mesh, unit_or_zero};
use crate::geometry::coverage::{Budget, Corner, Coverage, Rect};

/// A square window on the mesh along one direction, wide enough for all of it.
///
/// Map coordinates: x and y in texels, and the height toward the light in m.
#[derive(Clone, Copy)]
pub(super) struct Window {
    right: Vector3<f32>,
    up: Vector3<f32>,
    /// Unit vector toward the light.
    pub(super) toward_light: Vector3<f32>,
    /// Texels across and down.
    pub(super) size: usize,
    texels_per_meter: f32,
}

/// Empty texels at the border of a map, so that a lookup next to the mesh's outline finds the emptiness beside it.
const BORDER: f32 = 4.0;

impl Window {
    pub(super) fn new(mesh: &Mesh, toward_light: Vector3<f32>, size: usize) -> Self {
        // Any direction that is not parallel will do as a start.
        let start = if toward_light.y.abs() < 0.9 { Vector3::y() } else { Vector3::x() };
        let right = unit_or_zero(start.cross(&toward_light));
        Self {
            right,
            up: toward_light.cross(&right),
            toward_light,
            size,
            texels_per_meter: (size as f32 - 2.0 * BORDER) / (2.0 * mesh.radius),
        }
    }

    /// Edge of a texel, m.
    pub(super) fn texel(&self) -> f32 {
        1.0 / self.texels_per_meter
    }

    /// Map coordinates of a point that is given around the mesh's origin, m.
    pub(super) fn place(&self, point: &Vector3<f32>) -> Vector3<f32> {
        let middle = 0.5 * self.size as f32;
        Vector3::new(
            middle + self.texels_per_meter * point.dot(&self.right),
            middle + self.texels_per_meter * point.dot(&self.up),
            point.dot(&self.toward_light),
        )
    }

    /// A world direction in map coordinates, all three in m.
    pub(super) fn turn(&self, direction: &Vector3<f32>) -> Vector3<f32> {
        Vector3::new(direction.dot(&self.right), direction.dot(&self.up), direction.dot(&self.toward_light))
    }

    /// Calls `visit(texel index, height)` for every texel that every triangle covers, within the [`Budget`].
    fn for_each_texel(&self, mesh: &Mesh, mut visit: impl FnMut(usize, f32)) {
        let corner = |position| {
            let place = self.place(position).cast::<f64>();
            Corner::new(place.x, place.y, place.z)
        };
        let corners: Vec<_> = mesh.positions.iter().map(corner).collect();
        let side = self.size as i64;
        let clip = Rect { x0: 0, y0: 0, x1: side, y1: side };
        let mut budget = Budget::new(clip);
        for triangle in &mesh.triangles {
            let corners = triangle.map(|vertex| corners[vertex as usize]);
            if let Some(coverage) = Coverage::of_middles(&corners)
                && budget.spend(coverage.bounds.intersection(clip))
            {
                coverage.for_each_pixel(clip, |x, y| {
                    let height = coverage.depth(x as f64 + 0.5, y as f64 + 0.5);
                    visit((y * side + x) as usize, height as f32);
                });
            }
        }
    }

    /// The mesh from the light's side: the greatest height on each texel, −∞ where there is nothing.
    pub(super) fn top(&self, mesh: &Mesh) -> DepthMap {
        let mut top = DepthMap::empty(self.size, f32::NEG_INFINITY);
        self.for_each_texel(mesh, |index, height| {
            top.heights[index] = top.heights[index].max(height);
        });
        top
    }

    /// The mesh from the light's side and from the opposite side: the least height there, +∞ where there is nothing.
    pub(super) fn top_and_bottom(&self, mesh: &Mesh) -> [DepthMap; 2] {
        let mut top = DepthMap::empty(self.size, f32::NEG_INFINITY);
        let mut bottom = DepthMap::empty(self.size, f32::INFINITY);
        self.for_each_texel(mesh, |index, height| {
            top.heights[index] = top.heights[index].max(height);
            bottom.heights[index] = bottom.heights[index].min(height);
        });
        [top, bottom]
    }
}

/// Heights toward the light, m, one per texel.
pub(super) struct DepthMap {
    size: usize,
    heights: Vec<f32>,
}

impl DepthMap {
    fn empty(size: usize, height: f32) -> Self {
        Self { size, heights: vec![height; size * size] }
    }

    /// The texel that holds a place: its height, and its middle relative to the place, texels. Places beside the map
    /// see its border.
    pub(super) fn texel_at(&self, x: f32, y: f32) -> (f32, [f32; 2]) {
        let last = (self.size - 1) as f32;
        let [column, row] = [x, y].map(|place| place.clamp(0.0, last) as usize);
        let offset = [column as f32 + 0.5 - x, row as f32 + 0.5 - y];
        (self.heights[row * self.size + column], offset)
    }

    /// How much of `test` holds around a place, 0 to 1: of the four nearest texels, weighted by their nearness. The
    /// test is given a texel's height and its middle relative to the place, texels.
    ///
    /// Comparing first and mixing afterwards is percentage-closer filtering (W. Reeves, D. Salesin, R. Cook,
    /// "Rendering antialiased shadows with depth maps", SIGGRAPH 1987).
    #[inline]
    pub(super) fn fraction(&self, x: f32, y: f32, test: impl Fn(f32, [f32; 2]) -> bool) -> f32 {
        let last = (self.size - 2) as f32;
        let [x, y] = [x, y].map(|place| (place - 0.5).clamp(0.0, last));
        let [column, row] = [x as usize, y as usize];
        let [right, down] = [x - column as f32, y - row as f32];
        let passes = |across: usize, along: usize| {
            let height = self.heights[(row + along) * self.size + column + across];
            let offset = [across as f32 - right, along as f32 - down];
            f32::from(u8::from(test(height, offset)))
        };
        let upper = passes(0, 0) * (1.0 - right) + passes(1, 0) * right;
        let lower = passes(0, 1) * (1.0 - right) + passes(1, 1) * right;
        upper * (1.0 - down) + lower * down
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene::{Coloring, MISSING_COLOR, Surface};
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn a_square_is_seen_from_both_sides_at_its_own_height() {
        let positions = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Point3::new(x, y, 5.0));
        let mesh = Mesh::new(&[Surface {
            positions: &positions,
            triangles: &[[0, 1, 2], [0, 2, 3]],
            coloring: Coloring::Constant(MISSING_COLOR),
            lines: &[],
        }]);
        let window = Window::new(&mesh, Vector3::z(), 64);
        let [top, bottom] = window.top_and_bottom(&mesh);
        let middle = window.place(&Vector3::zeros());
        assert_eq!(top.texel_at(middle.x, middle.y).0, 0.0);
        assert_eq!(bottom.texel_at(middle.x, middle.y).0, 0.0);
        assert_eq!(top.fraction(middle.x, middle.y, |height, _| height < 0.5), 1.0);
        let beside = window.place(&Vector3::new(1.3, 0.0, 0.0));
        assert_eq!(top.texel_at(beside.x, beside.y).0, f32::NEG_INFINITY);
        assert_eq!(bottom.texel_at(beside.x, beside.y).0, f32::INFINITY);
        // Half the weight of the four texels at the rim is on the square.
        let rim = window.place(&Vector3::new(1.0, 0.0, 0.0));
        let fraction = top.fraction(rim.x, rim.y, |height, _| height.is_finite());
        assert!((0.2..0.8).contains(&fraction), "{fraction}");
    }
}
