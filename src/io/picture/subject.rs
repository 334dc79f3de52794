//! What a picture is about: a garment on a body, and what has to be seen of them.

use nalgebra::Point3;

use super::color::Color;
use super::scene::{Coloring, Surface, is_drawable};

/// A garment as it is to be seen, borrowed.
#[derive(Clone, Copy, Debug, Default)]
pub struct GarmentView<'a> {
    /// One per particle, m, world. Best welded: normals are smooth only across shared particles.
    pub positions: &'a [Point3<f64>],
    /// Particle indices, counter-clockwise seen from the right side of the fabric.
    pub triangles: &'a [[u32; 3]],
    /// The panel that each triangle belongs to, for a slightly different tint each; may be empty.
    pub panels: &'a [u32],
    /// Edges of the mesh on which panels are sewn, drawn as thin lines; may be empty.
    pub seams: &'a [[u32; 2]],
    /// One color per triangle in place of the tints, for instance to mark intersections; may be empty.
    pub colors: &'a [Color],
}

/// A body as it is to be seen, borrowed; empty slices for none.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodyView<'a> {
    /// One per vertex, m, world.
    pub positions: &'a [Point3<f64>],
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
}

impl<'a> BodyView<'a> {
    pub(super) fn surface(&self, color: Color) -> Surface<'a> {
        Surface {
            positions: self.positions,
            triangles: self.triangles,
            coloring: Coloring::Constant(color),
            lines: &[],
        }
    }

    /// Height of the lowest vertex, m.
    pub(super) fn floor(&self) -> Option<f64> {
        bounds(self.positions).map(|[low, _]| low.y)
    }
}

/// Head or feet are shown whole if that adds less than this part to the height of the garment.
const CONTEXT_ABOVE: f64 = 0.6;

/// A hand is shown whole if that adds less than this part to the width: the views stand side by side, so width is dear.
const CONTEXT_BESIDE: f64 = 0.24;

/// Points (m, world) that have to be seen.
pub(super) struct Focus(pub(super) Vec<Point3<f64>>);

impl Focus {
    /// The garment with a part of the body for context; the body alone when there is no garment.
    pub(super) fn new(garment: &GarmentView, body: &BodyView) -> Self {
        let mut points = corners(garment.positions, garment.triangles);
        let (Some(cloth), Some(skin)) = (bounds(&points), bounds(body.positions)) else {
            points.extend(corners(body.positions, body.triangles));
            return Self(points);
        };
        points.extend(context(cloth, skin, body.positions));
        Self(points)
    }
}

/// Head, feet and hands, as far as they are close enough to the garment to be shown with it.
fn context(cloth: [Point3<f64>; 2], skin: [Point3<f64>; 2], body: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let [low, high] = cloth;
    let room_above = CONTEXT_ABOVE * (high.y - low.y);
    let room_beside = CONTEXT_BESIDE * (high.x - low.x);
    let middle = nalgebra::center(&low, &high);
    let mut points = Vec::new();
    for (gap, end) in [(skin[1].y - high.y, skin[1].y), (low.y - skin[0].y, skin[0].y)] {
        if gap < room_above {
            points.push(Point3::new(middle.x, end, middle.z));
        }
    }
    let is_close = |hand: &&Point3<f64>| {
        let is_beside = hand.y > low.y - room_above && hand.y < high.y + room_above;
        is_beside && (low.x - hand.x).max(hand.x - high.x) < room_beside
    };
    let hands = [skin[0].x, skin[1].x].map(|end| body.iter().find(|point| point.x == end));
    points.extend(hands.into_iter().flatten().filter(is_close));
    points
}

/// The corners of all triangles, without vertices that no triangle uses.
fn corners(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Point3<f64>> {
    let mut is_used = vec![false; positions.len()];
    for &vertex in triangles.as_flattened() {
        if let Some(is_used) = is_used.get_mut(vertex as usize) {
            *is_used = true;
        }
    }
    positions.iter().zip(is_used).filter(|(_, is_used)| *is_used).map(|(&position, _)| position).collect()
}

/// Lowest and highest corner of the bounding box.
fn bounds(points: &[Point3<f64>]) -> Option<[Point3<f64>; 2]> {
    let mut points = points.iter().filter(|point| is_drawable(point));
    let first = *points.next()?;
    Some(points.fold([first; 2], |[low, high], point| [low.inf(point), high.sup(point)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of a box, m.
    fn cuboid(low: [f64; 3], high: [f64; 3]) -> Vec<Point3<f64>> {
        let end = |index: usize, axis: usize| if index >> axis & 1 == 0 { low[axis] } else { high[axis] };
        (0..8).map(|index| Point3::new(end(index, 0), end(index, 1), end(index, 2))).collect()
    }

    const ALL: [[u32; 3]; 4] = [[0, 1, 2], [3, 4, 5], [6, 7, 0], [1, 2, 3]];

    fn framed_heights(low: f64, high: f64) -> [f64; 2] {
        let body = cuboid([-0.6, 0.0, -0.1], [0.6, 1.7, 0.1]);
        let cloth = cuboid([-0.3, low, -0.2], [0.3, high, 0.2]);
        let focus = Focus::new(
            &GarmentView { positions: &cloth, triangles: &ALL, ..GarmentView::default() },
            &BodyView { positions: &body, triangles: &ALL },
        );
        bounds(&focus.0).unwrap().map(|corner| corner.y)
    }

    #[test]
    fn a_shirt_is_shown_with_the_head_and_trousers_with_the_feet() {
        assert_eq!(framed_heights(0.9, 1.45), [0.9, 1.7]);
        assert_eq!(framed_heights(0.1, 1.0), [0.0, 1.0]);
        assert_eq!(framed_heights(0.5, 1.05), [0.5, 1.05]);
        assert_eq!(framed_heights(0.2, 1.5), [0.0, 1.7]);
    }

    #[test]
    fn vertices_without_triangles_do_not_count() {
        let mut cloth = cuboid([0.0; 3], [1.0; 3]);
        cloth.push(Point3::new(0.0, 99.0, 0.0));
        let garment = GarmentView { positions: &cloth, triangles: &ALL, ..GarmentView::default() };
        let focus = Focus::new(&garment, &BodyView::default());
        assert_eq!(bounds(&focus.0).unwrap()[1].y, 1.0);
    }

    #[test]
    fn without_a_garment_the_body_is_shown() {
        let body = cuboid([0.0; 3], [1.0; 3]);
        let focus = Focus::new(&GarmentView::default(), &BodyView { positions: &body, triangles: &ALL });
        assert_eq!(focus.0, body);
        assert!(Focus::new(&GarmentView::default(), &BodyView::default()).0.is_empty());
    }
}
