//! What placing asks of a body: girths, axes, and how far things reach.

use crate::body::{Body, Landmarks, Part};
use crate::geometry::Vector3;
use std::f64::consts::TAU;

/// A body with its landmarks, as the panels see it.
pub struct Figure<'a> {
    pub marks: &'a Landmarks,
    /// How far torso, neck and legs reach to front, back and sides, m: ranges of z and half the width.
    pub front: f64,
    pub back: f64,
    /// Half the width of the head and its middle depth, m.
    pub head: [f64; 2],
    /// The middle plane, m.
    pub middle: f64,
}

impl<'a> Figure<'a> {
    pub fn new(body: &Body, marks: &'a Landmarks) -> Self {
        let points = marks.torso.outlines.iter().chain(marks.legs.iter().flat_map(|leg| &leg.outlines)).flatten();
        let (mut front, mut back) = (f64::NEG_INFINITY, f64::INFINITY);
        for p in points {
            (front, back) = (front.max(p.z), back.min(p.z));
        }
        let middle = 0.5 * (marks.neck_sides[0].x + marks.neck_sides[1].x);
        let (mut wide, mut low, mut high) = (0.0f64, f64::INFINITY, f64::NEG_INFINITY);
        for (p, part) in body.positions().iter().zip(&marks.parts) {
            if *part == Part::Torso && p.y > marks.neck {
                wide = wide.max((p.x - middle).abs());
                (low, high) = (low.min(p.z), high.max(p.z));
            }
        }
        Self { marks, front, back, head: [wide, 0.5 * (low + high)], middle }
    }

    /// The girth of the torso at a height, m.
    pub fn girth(&self, height: f64) -> f64 {
        let torso = &self.marks.torso;
        TAU * torso.at(height - torso.axis[0].y).2
    }

    /// Where an edge of this length comes to rest on its way down from the waist, m: where the body is as wide.
    pub fn waist_for(&self, length: f64) -> f64 {
        let (waist, hip) = (self.marks.waist, self.marks.hip);
        let step = 0.005;
        let mut height = waist;
        while height > waist - LOWEST_WAIST * (waist - hip) && self.girth(height) < length * WAIST_EASE {
            height -= step;
        }
        height
    }

    /// The point at a length from the side of the neck over the shoulder along an arm, and the direction there.
    pub fn along_arm(&self, side: usize, length: f64) -> (Vector3, Vector3) {
        let (neck, arm) = (self.marks.neck_sides[side], &self.marks.arms[side]);
        let root = arm.axis[0];
        let over = (root - neck).norm();
        let (point, direction, _) = arm.at((length - over).max(0.0));
        match length < over {
            true => (neck.lerp(&root, length / over), (root - neck) / over),
            false => (point + direction * (length - over - arm.length()).max(0.0), direction),
        }
    }

    /// The middle of a leg at a height.
    pub fn leg_at(&self, side: usize, height: f64) -> Vector3 {
        let axis = &self.marks.legs[side].axis;
        let nearest = axis.iter().min_by(|a, b| (a.y - height).abs().total_cmp(&(b.y - height).abs()));
        let nearest = nearest.expect("a leg has sections");
        Vector3::new(nearest.x, height, nearest.z)
    }
}

/// A waist that is too wide is not looked for lower than this part of the way to the hips: legs would not reach.
const LOWEST_WAIST: f64 = 0.4;
/// A waistband may be smaller than the waist by this, and still be held to be made for it.
const WAIST_EASE: f64 = 1.0;
