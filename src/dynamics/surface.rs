//! The surface of a body that moves: where each triangle is within a frame, and how fast.
//!
//! Between two frames every vertex moves on a straight line at a constant speed, so that cloth meets a body that goes
//! where it goes, at whatever step. Volumes around triangles hold for a whole frame: they enclose the paths.

use super::broad_phase::{Volumes, enclosing};
use super::depth_maps::{Maps, Unsure};
use super::settings::BroadPhase;
use crate::body::winding_number;
use crate::geometry::{BoxTree, Incidence, Vector3, closest_on_triangle};
use rayon::prelude::*;
use std::cell::Cell;

/// A closed triangle mesh on its way from one frame to the next.
pub struct Surface {
    triangles: Vec<[u32; 3]>,
    /// Triangles around each vertex.
    around: Incidence,
    start: Vec<Vector3>,
    end: Vec<Vector3>,
    /// m, world.
    now: Vec<Vector3>,
    /// s.
    duration: f64,
    /// m/s, of the fastest vertex.
    largest_speed: f64,
    volumes: Enclosures,
    broad_phase: BroadPhase,
}

/// What is searched for the nearest triangle.
enum Enclosures {
    Tree(BoxTree),
    Parts(Volumes),
    /// The maps, and what is asked where they are not sure.
    Maps(Box<Maps>, BoxTree),
}

/// How the nearest triangle was found.
#[derive(Clone, Copy, Debug)]
pub struct Looked {
    pub triangle: Option<u32>,
    /// Distances of triangles that were computed.
    pub tests: usize,
    /// Why a map did not know it.
    pub unsure: Option<Unsure>,
}

/// The place of a surface that is nearest to a point.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub triangle: u32,
    /// Barycentric.
    pub weights: [f64; 3],
    /// m, world.
    pub point: Vector3,
    /// Away from the body, of length one.
    pub normal: Vector3,
    /// m, negative inside.
    pub distance: f64,
}

/// Points nearer to the surface than this have the direction of the triangle's normal, m: rounding decides their own.
const ON_THE_SKIN: f64 = 1e-6;
/// Places of two triangles are one, an edge or a corner that both share, if they are this near to each other, m.
const SHARED: f64 = 1e-9;
/// Cosine of the angle beyond which skin faces another way.
const ANOTHER_WAY: f64 = 0.3;
/// Cosine of the angle between their normals below which two skins face each other, as in a fold of less than a right angle.
const FACING: f64 = 0.0;
/// Triangles that a place is followed over in one step, at most: a particle moves by less than one.
const LONGEST_WALK: usize = 16;

impl Surface {
    /// A surface that rests at `positions`, m.
    pub fn new(positions: &[Vector3], triangles: &[[u32; 3]], broad_phase: BroadPhase) -> Self {
        let mut surface = Self {
            around: Incidence::new(positions.len(), triangles.iter().copied()),
            triangles: triangles.to_vec(),
            start: positions.to_vec(),
            end: positions.to_vec(),
            now: positions.to_vec(),
            duration: 1.0,
            largest_speed: 0.0,
            volumes: Enclosures::Tree(BoxTree::new(std::iter::empty())),
            broad_phase,
        };
        surface.enclose();
        surface
    }

    /// From where it is now the surface moves to `end`, one position per vertex, m, within `duration`, s.
    pub fn move_to(&mut self, end: &[Vector3], duration: f64) {
        assert_eq!(end.len(), self.start.len(), "a body keeps its vertices");
        self.start.copy_from_slice(&self.now);
        self.end.copy_from_slice(end);
        self.duration = duration;
        let squared = self.start.iter().zip(&self.end).map(|(a, b)| (b - a).norm_squared()).fold(0.0, f64::max);
        let stood = self.largest_speed == 0.0;
        self.largest_speed = squared.sqrt() / duration;
        if !(stood && self.largest_speed == 0.0) {
            self.enclose();
        }
    }

    fn enclose(&mut self) {
        let path = |t: &[u32; 3]| enclosing(t.iter().flat_map(|&v| [self.start[v as usize], self.end[v as usize]]));
        let tree = || BoxTree::new(self.triangles.iter().map(path));
        self.volumes = match self.broad_phase {
            BroadPhase::Tree => Enclosures::Tree(tree()),
            BroadPhase::Maps => {
                let maps = (self.largest_speed == 0.0).then(|| Maps::draw(&self.start, &self.triangles)).flatten();
                maps.map_or_else(|| Enclosures::Tree(tree()), |maps| Enclosures::Maps(Box::new(maps), tree()))
            }
            kind => Enclosures::Parts(Volumes::new(kind, &self.triangles, &self.start, &self.end)),
        };
    }

    /// Moves on to this share of the frame.
    pub fn advance(&mut self, share: f64) {
        if self.largest_speed == 0.0 {
            return;
        }
        // At its end, exactly the end.
        let way = |(a, b): (&Vector3, &Vector3)| if share >= 1.0 { *b } else { a + (b - a) * share };
        self.now.par_iter_mut().zip(self.start.par_iter().zip(&self.end)).for_each(|(now, ends)| *now = way(ends));
    }

    pub fn positions(&self) -> &[Vector3] {
        &self.now
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// m/s, of the fastest vertex in this frame.
    pub fn largest_speed(&self) -> f64 {
        self.largest_speed
    }

    fn corners(&self, triangle: u32) -> [Vector3; 3] {
        self.triangles[triangle as usize].map(|v| self.now[v as usize])
    }

    /// Velocity of the skin at a place, m/s.
    pub fn velocity(&self, place: &Place) -> Vector3 {
        let corners = self.triangles[place.triangle as usize];
        let moved: Vector3 =
            corners.iter().zip(place.weights).map(|(&v, w)| (self.end[v as usize] - self.start[v as usize]) * w).sum();
        moved / self.duration
    }

    /// The place nearest to a point, if one is within `reach`, m.
    pub fn nearest(&self, point: Vector3, reach: f64) -> Option<Place> {
        let to = |t: u32| (self.foot(t, point).1 - point).norm_squared();
        let (triangle, _) = self.search(point, reach, to);
        // A map may know of a place beyond the reach.
        triangle.map(|triangle| self.refine(point, triangle)).filter(|place| place.distance.abs() < reach)
    }

    /// The place nearest to a point, within `reach`, m, of skin that faces skin with this normal.
    pub fn nearest_facing(&self, point: Vector3, reach: f64, normal: Vector3) -> Option<Place> {
        let to = |t: u32| match self.normal(t).dot(&normal) < FACING {
            true => (self.foot(t, point).1 - point).norm_squared(),
            false => f64::INFINITY,
        };
        // No map knows which way skin faces.
        let found = match &self.volumes {
            Enclosures::Tree(tree) | Enclosures::Maps(_, tree) => tree.nearest(point, reach, to),
            Enclosures::Parts(volumes) => volumes.nearest(point, reach, to),
        };
        // No walk to nearer neighbours: they face another way.
        found.map(|(triangle, _)| self.place(point, triangle))
    }

    /// Do the skins at two places face each other?
    pub fn face(one: &Place, other: &Place) -> bool {
        one.normal.dot(&other.normal) < FACING
    }

    /// How often the surface winds around a point, where it is now: 0 outside, 1 inside, 2 where two parts overlap.
    pub fn winding_number(&self, point: Vector3) -> i32 {
        winding_number(point, |low, high, visit| match &self.volumes {
            Enclosures::Tree(tree) | Enclosures::Maps(_, tree) => {
                tree.for_each_meeting(low, high, |t| visit(self.corners(t)));
            }
            Enclosures::Parts(_) => (0..self.triangles.len() as u32).for_each(|t| visit(self.corners(t))),
        })
    }

    /// The triangle that the search begins with to find [`Self::nearest`], and what that took.
    pub fn look(&self, point: Vector3, reach: f64) -> Looked {
        let tests = Cell::new(0);
        let to = |t: u32| {
            tests.set(tests.get() + 1);
            (self.foot(t, point).1 - point).norm_squared()
        };
        let (triangle, unsure) = self.search(point, reach, to);
        Looked { triangle, tests: tests.get(), unsure }
    }

    fn search(&self, point: Vector3, reach: f64, to: impl Fn(u32) -> f64) -> (Option<u32>, Option<Unsure>) {
        match &self.volumes {
            Enclosures::Tree(tree) => (tree.nearest(point, reach, to).map(|(t, _)| t), None),
            Enclosures::Parts(volumes) => (volumes.nearest(point, reach, to).map(|(t, _)| t), None),
            Enclosures::Maps(maps, tree) => match maps.nearest(point, &to) {
                Ok(triangle) => (Some(triangle), None),
                Err(unsure) => (tree.nearest(point, reach, to).map(|(t, _)| t), Some(unsure)),
            },
        }
    }

    /// A place that was computed before, where its triangle has taken it, as a point sees it now. Its normal is kept, and
    /// the distance is measured along it: good for a few steps.
    #[inline]
    pub fn carried(&self, point: Vector3, place: &Place) -> Place {
        let corners = self.corners(place.triangle);
        let [a, b, c] = place.weights;
        let foot = corners[0] * a + corners[1] * b + corners[2] * c;
        Place { point: foot, distance: (point - foot).dot(&place.normal), ..*place }
    }

    /// The place nearest to a point that a walk from `triangle` to ever nearer neighbours finds.
    pub fn refine(&self, point: Vector3, triangle: u32) -> Place {
        let squared = |t: u32| (self.foot(t, point).1 - point).norm_squared();
        let mut nearest = (squared(triangle), triangle);
        for _ in 0..LONGEST_WALK {
            let from = nearest.1;
            for t in self.ring(from) {
                let now = squared(t);
                if now < nearest.0 {
                    nearest = (now, t);
                }
            }
            if nearest.1 == from {
                break;
            }
        }
        let mut best = self.place(point, nearest.1);
        if best.weights.iter().any(|&w| w <= 0.0) {
            // An edge or a corner, where triangles meet. The side is told by that which the point is most above or
            // below of: others see it edge-on.
            for t in self.ring(nearest.1) {
                let other = self.place(point, t);
                let shared = (other.point - best.point).norm_squared() <= SHARED * SHARED;
                if shared && self.height(point, &other).abs() > self.height(point, &best).abs() {
                    best = other;
                }
            }
        }
        best
    }

    /// Triangles that share a corner with one.
    fn ring(&self, triangle: u32) -> impl Iterator<Item = u32> + '_ {
        let corners = self.triangles[triangle as usize].into_iter();
        corners.flat_map(|v| self.around.slots(v as usize)).map(|slot| slot / 3).filter(move |&t| t != triangle)
    }

    /// Barycentric weights and place of the point of a triangle that is nearest to `point`.
    #[inline]
    fn foot(&self, triangle: u32, point: Vector3) -> ([f64; 3], Vector3) {
        let corners = self.corners(triangle);
        let weights = closest_on_triangle(point, corners);
        (weights, corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2])
    }

    fn normal(&self, triangle: u32) -> Vector3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
    }

    /// Does the skin at a place face another way than some triangle, which may be none? By more than a right angle less
    /// what a sharp edge turns by.
    pub fn faces_another_way(&self, place: &Place, triangle: u32) -> bool {
        (triangle as usize) < self.triangles.len() && self.normal(triangle).dot(&place.normal) < ANOTHER_WAY
    }

    /// Of a point above the plane of the place's triangle, m.
    fn height(&self, point: Vector3, place: &Place) -> f64 {
        (point - place.point).dot(&self.normal(place.triangle))
    }

    fn place(&self, point: Vector3, triangle: u32) -> Place {
        let (weights, foot) = self.foot(triangle, point);
        let (away, outward) = (point - foot, self.normal(triangle));
        let length = away.norm();
        let outside = away.dot(&outward) >= 0.0;
        let normal = match (length < ON_THE_SKIN, outside) {
            (true, _) => outward,
            (false, true) => away / length,
            (false, false) => -away / length,
        };
        Place { triangle, weights, point: foot, normal, distance: if outside { length } else { -length } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shapes;

    fn ball(broad_phase: BroadPhase) -> Surface {
        let (positions, triangles) = shapes::sphere(Vector3::new(0.0, 0.5, 0.0), 0.5, 16);
        Surface::new(&positions, &triangles, broad_phase)
    }

    #[test]
    fn every_broad_phase_finds_the_same_places() {
        let surfaces: Vec<Surface> = BroadPhase::ALL.iter().map(|&(_, kind)| ball(kind)).collect();
        for k in 0..400 {
            let wave = |step: f64| (f64::from(k) * step).sin();
            let point = Vector3::new(wave(12.9), 0.5 + wave(78.2), wave(37.7)) * 0.7;
            let found: Vec<Option<Place>> = surfaces.iter().map(|s| s.nearest(point, 0.3)).collect();
            let plain =
                surfaces[0].triangles.iter().zip(0..).map(|(_, t)| (surfaces[0].foot(t, point).1 - point).norm());
            let plain = plain.fold(f64::INFINITY, f64::min);
            for place in found {
                match place {
                    Some(place) => assert!((place.distance.abs() - plain).abs() < 1e-12, "{place:?} is not {plain}"),
                    None => assert!(plain > 0.3),
                }
            }
        }
    }

    #[test]
    fn while_a_body_moves_no_map_is_asked() {
        let [mut maps, mut tree] = [BroadPhase::Maps, BroadPhase::Tree].map(ball);
        let point = Vector3::new(0.01, 0.52, 0.505);
        // No map knows what is within the body.
        let asked = |maps: &Surface| maps.look(Vector3::new(0.0, 0.5, 0.0), 1.0).unsure.is_some();
        assert!(maps.look(point, 0.1).unsure.is_none() && asked(&maps));
        let resting = maps.positions().to_vec();
        let end: Vec<Vector3> = resting.iter().map(|p| p - Vector3::new(0.0, 0.0, 0.003)).collect();
        // It moves, stands there, and stands still.
        for (end, moves) in [(&end, true), (&end, false), (&end, false), (&resting, true), (&resting, false)] {
            for surface in [&mut maps, &mut tree] {
                surface.move_to(end, 0.1);
                surface.advance(1.0);
            }
            assert_eq!(asked(&maps), !moves);
            let [found, expected] = [&maps, &tree].map(|surface| surface.nearest(point, 0.1).unwrap());
            assert_eq!(found.distance, expected.distance);
        }
    }

    #[test]
    fn the_side_is_right_at_corners_and_edges_and_within() {
        let surface = ball(BroadPhase::Tree);
        let center = Vector3::new(0.0, 0.5, 0.0);
        for &[a, b, c] in surface.triangles() {
            let [a, b, c] = [a, b, c].map(|v| surface.positions()[v as usize]);
            for on in [a, (a + b) * 0.5, (a + b + c) / 3.0, a * 0.9 + c * 0.1] {
                for (along, outside) in [(1.02, true), (0.98, false)] {
                    let point = center + (on - center) * along;
                    let place = surface.nearest(point, 0.1).unwrap();
                    assert_eq!(place.distance > 0.0, outside, "{point} {place:?}");
                    assert!(place.normal.dot(&(on - center)) > 0.4, "{place:?}");
                }
            }
        }
    }

    #[test]
    fn a_place_moves_as_its_triangle_does() {
        let mut surface = ball(BroadPhase::Tree);
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), 0.01);
        let end: Vec<Vector3> = surface.positions().iter().map(|p| turn * p + Vector3::new(0.0, 0.02, 0.0)).collect();
        surface.move_to(&end, 0.1);
        surface.advance(0.5);
        let point = Vector3::new(0.51, 0.51, 0.0);
        let place = surface.nearest(point, 0.1).unwrap();
        let expected = Vector3::new(0.0, 0.2, -0.05);
        assert!((surface.velocity(&place) - expected).norm() < 2e-3, "{}", surface.velocity(&place));
        surface.advance(1.0);
        assert_eq!(surface.positions(), end);
    }
}
