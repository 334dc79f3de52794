//! A bounding-volume hierarchy over boxes: parry's, at the edge to nalgebra.

use super::Vector3;
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode, TraversalAction};

/// Axis-aligned boxes with their indices `0..n`, for finding those that meet a box.
pub struct BoxTree {
    tree: Bvh,
}

/// parry's vector of ours.
pub fn parry_vector(v: Vector3) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

fn boxed(low: Vector3, high: Vector3) -> Aabb {
    Aabb::new(parry_vector(low), parry_vector(high))
}

impl BoxTree {
    /// A tree over the boxes `(low, high)`.
    pub fn new(boxes: impl Iterator<Item = (Vector3, Vector3)>) -> Self {
        let boxes: Vec<Aabb> = boxes.map(|(low, high)| boxed(low, high)).collect();
        Self { tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes) }
    }

    /// A tree over the triangles `corners`, each box grown by `margin`.
    pub fn of_triangles(corners: impl Iterator<Item = [Vector3; 3]>, margin: f64) -> Self {
        let margin = Vector3::repeat(margin);
        Self::new(corners.map(|[a, b, c]| (a.inf(&b).inf(&c) - margin, a.sup(&b).sup(&c) + margin)))
    }

    /// Calls `visit` with the index of every box that meets the box `low..high`.
    pub fn for_each_meeting(&self, low: Vector3, high: Vector3, mut visit: impl FnMut(u32)) {
        let query = boxed(low, high);
        self.tree.traverse(|node| {
            if !node.aabb().intersects(&query) {
                return TraversalAction::Prune;
            }
            if let Some(index) = node.leaf_data() {
                visit(index);
            }
            TraversalAction::Continue
        });
    }

    /// The box within `reach` of `point` whose content is nearest, with its squared distance as
    /// `squared_distance` tells it.
    pub fn nearest(&self, point: Vector3, reach: f64, squared_distance: impl Fn(u32) -> f64) -> Option<(u32, f64)> {
        let point = parry_vector(point);
        let to_box = |node: &BvhNode, _| {
            let outside = (node.mins() - point).max(point - node.maxs()).max(ParryVector::ZERO);
            outside.length_squared()
        };
        self.tree.find_best(reach * reach, to_box, |index, _| Some(squared_distance(index)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_boxes_that_meet_and_the_nearest() {
        let corner = |i: usize| Vector3::new(i as f64, 0.0, 0.0);
        let tree = BoxTree::new((0..100).map(|i| (corner(i), corner(i).add_scalar(0.5))));
        let mut met = Vec::new();
        tree.for_each_meeting(corner(10).add_scalar(0.2), corner(12).add_scalar(0.2), |i| met.push(i));
        met.sort_unstable();
        assert_eq!(met, [10, 11, 12]);
        let query = Vector3::new(41.8, 0.0, 0.0);
        let near = tree.nearest(query, 1.0, |i| (corner(i as usize) - query).norm_squared());
        assert_eq!(near.map(|(i, _)| i), Some(42));
        assert!(tree.nearest(query, 0.1, |i| (corner(i as usize) - query).norm_squared()).is_none());
    }
}
