//! How thick the figure is: one factor for each place where the tape measure goes.
//!
//! The tables hold sections of the right shape and nearly the right size. A factor at each station brings the girth to
//! the one asked for; sections between two stations take a factor in between.

use super::skeleton::{SHOULDER_POINT, Skeleton, WRIST, interpolate};
use super::{Measurements, Mesh, tape};
use crate::geometry::Vector3;

/// Part of the body whose sections share a run of factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Hips to crown; places are drawn heights.
    Torso,
    /// Places are drawn heights.
    Leg,
    /// Places are drawn distances from the shoulder joint.
    Arm,
}

/// A place where a girth is taken.
struct Tape {
    name: &'static str,
    part: Part,
    /// On the drawn figure, m.
    place: f64,
    girth: fn(&Measurements) -> f64,
}

/// Four fifths of the way up from knee to crotch, on the drawn figure, m: a hand's breadth below the crotch.
const THIGH: f64 = 0.735;
/// Above the brow, on the drawn figure, m.
const HEAD: f64 = 1.655;
/// A quarter of the way from shoulder joint to wrist, m.
const UPPER_ARM: f64 = 0.1415;
/// Five eighths of the way from shoulder joint to wrist, m.
const FOREARM: f64 = 0.354;

const DRAWN: Measurements = Measurements::DEFAULT;

/// In ascending places within each part.
const TAPES: [Tape; 13] = [
    Tape { name: "hip", part: Part::Torso, place: DRAWN.hip_height, girth: |m| m.hip_girth },
    Tape { name: "waist", part: Part::Torso, place: DRAWN.waist_height, girth: |m| m.waist_girth },
    Tape { name: "underbust", part: Part::Torso, place: DRAWN.underbust_height, girth: |m| m.underbust_girth },
    Tape { name: "bust", part: Part::Torso, place: DRAWN.bust_height, girth: |m| m.bust_girth },
    Tape { name: "neck", part: Part::Torso, place: DRAWN.neck_height, girth: |m| m.neck_girth },
    Tape { name: "head", part: Part::Torso, place: HEAD, girth: |m| m.head_girth },
    Tape { name: "ankle", part: Part::Leg, place: DRAWN.ankle_height, girth: |m| m.ankle_girth },
    Tape { name: "calf", part: Part::Leg, place: DRAWN.calf_height, girth: |m| m.calf_girth },
    Tape { name: "knee", part: Part::Leg, place: DRAWN.knee_height, girth: |m| m.knee_girth },
    Tape { name: "thigh", part: Part::Leg, place: THIGH, girth: |m| m.thigh_girth },
    Tape { name: "upper arm", part: Part::Arm, place: UPPER_ARM, girth: |m| m.upper_arm_girth },
    Tape { name: "forearm", part: Part::Arm, place: FOREARM, girth: |m| m.forearm_girth },
    Tape { name: "wrist", part: Part::Arm, place: WRIST, girth: |m| m.wrist_girth },
];

/// A girth, and where on the finished mannequin it is taken.
#[derive(Clone, Debug)]
pub struct Station {
    /// In words, as in [`Measurements`]: `upper arm` for `upper_arm_girth`.
    pub name: &'static str,
    /// On the axis of the torso, of the left leg or of the left arm, m.
    pub origin: Vector3,
    /// Of the plane of the tape, unit length.
    pub normal: Vector3,
    /// As asked for in the measurements, m.
    pub girth: f64,
}

impl Station {
    /// Is the girth of the mesh here as asked for, within this part of itself?
    pub fn is_met(&self, mesh: &Mesh, tolerance: f64) -> bool {
        (self.measure(mesh) / self.girth - 1.0).abs() <= tolerance
    }

    /// The girth of the mesh here, m.
    pub fn measure(&self, mesh: &Mesh) -> f64 {
        tape::girth(mesh, &self.origin, &self.normal)
    }
}

/// Where each girth of these measurements is taken.
pub fn stations(measurements: &Measurements) -> Vec<Station> {
    let skeleton = Skeleton::new(measurements);
    let station = |tape: &Tape| {
        let (origin, normal) = match tape.part {
            Part::Torso => (Vector3::new(0.0, skeleton.height(tape.place), 0.0), Vector3::y()),
            Part::Leg => (skeleton.leg_axis(tape.place), skeleton.leg.along),
            Part::Arm => (skeleton.arm_axis(tape.place), skeleton.arm.along),
        };
        Station { name: tape.name, origin, normal, girth: (tape.girth)(measurements) }
    };
    TAPES.iter().map(station).collect()
}

/// The skeleton and the factors of one figure.
pub(super) struct Grading {
    pub skeleton: Skeleton,
    /// Wanted over drawn size of the hand.
    pub hand_scale: f64,
    /// Wanted over drawn size of the foot.
    pub foot_scale: f64,
    /// Wanted over drawn width of the shoulders.
    shoulder_scale: f64,
    /// One per tape.
    factors: [f64; TAPES.len()],
}

impl Grading {
    pub fn new(measurements: &Measurements) -> Self {
        Self {
            skeleton: Skeleton::new(measurements),
            hand_scale: measurements.hand_length / DRAWN.hand_length,
            foot_scale: measurements.foot_length / DRAWN.foot_length,
            shoulder_scale: measurements.shoulder_width / DRAWN.shoulder_width,
            factors: TAPES.map(|tape| (tape.girth)(measurements) / (tape.girth)(&DRAWN)),
        }
    }

    /// The factor of a section between two stations; the nearest one's beyond them.
    pub fn factor(&self, part: Part, place: f64) -> f64 {
        let mut known: Vec<(f64, f64)> = Vec::with_capacity(TAPES.len());
        for (tape, &factor) in TAPES.iter().zip(&self.factors) {
            if tape.part == part {
                known.push((tape.place, factor));
            }
        }
        if part == Part::Torso {
            let above = known.partition_point(|pair| pair.0 < SHOULDER_POINT[1]);
            known.insert(above, (SHOULDER_POINT[1], self.shoulder_scale));
        }
        let (first, last) = (known[0].0, known[known.len() - 1].0);
        interpolate(&known, place.clamp(first, last))
    }

    /// Where a drawn point of torso or head goes. Its depth scales about the middle of its section.
    pub fn torso_point(&self, [x, y, z]: [f64; 3], middle: f64) -> Vector3 {
        let factor = self.factor(Part::Torso, y);
        Vector3::new(x * factor, self.skeleton.height(y), middle + (z - middle) * factor)
    }

    /// Takes all girths and corrects the factors. Returns the largest relative error found before.
    pub fn correct(&mut self, mesh: &Mesh, stations: &[Station]) -> f64 {
        let mut worst: f64 = 0.0;
        for (factor, station) in self.factors.iter_mut().zip(stations) {
            let measured = station.measure(mesh);
            worst = worst.max((measured / station.girth - 1.0).abs());
            *factor *= station.girth / measured;
        }
        worst
    }
}
