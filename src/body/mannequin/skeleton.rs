//! Where the limbs are: landmark heights and limb axes, before any thickness.
//!
//! The tables of the figure are drawn for [`Measurements::DEFAULT`]. The skeleton carries their places over to other
//! measurements: heights move with the landmarks around them, limbs keep their joints and change length and direction.

use super::Measurements;
use crate::geometry::Vector3;

/// The drawn figure's hip joint, m; its x is where half the pelvis carries one leg.
const HIP_JOINT: (f64, f64) = (0.0875, 0.87);

/// The drawn figure's shoulder joint, m. 2 cm inside the shoulder point, as the head of the upper arm bone is.
const SHOULDER_JOINT: [f64; 3] = [0.166, 1.368, -0.014];

/// The drawn figure's shoulder point, m, on the skin above the joint.
pub(super) const SHOULDER_POINT: [f64; 3] = [0.190, 1.410, -0.016];

/// How far the drawn figure's wrist lies from the shoulder joint, m.
pub(super) const WRIST: f64 = 0.566;

/// A straight limb axis with two directions square to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limb {
    pub joint: Vector3,
    /// From the joint to hand or foot.
    pub along: Vector3,
    /// Away from the body's middle: outward on a leg, upward on an arm.
    pub outward: Vector3,
}

impl Limb {
    /// The frontal direction, square to both others.
    pub const FORWARD: Vector3 = Vector3::new(0.0, 0.0, 1.0);

    /// A point given by its distances along, outward and forward, m.
    pub fn at(&self, along: f64, outward: f64, forward: f64) -> Vector3 {
        self.joint + self.along * along + self.outward * outward + Self::FORWARD * forward
    }
}

/// Heights and limb axes for some measurements.
#[derive(Clone, Debug)]
pub(super) struct Skeleton {
    /// Pairs of drawn and wanted height, m, ascending.
    landmarks: [(f64, f64); 14],
    /// Left leg, from the hip joint.
    pub leg: Limb,
    /// Left arm, from the shoulder joint.
    pub arm: Limb,
    /// Wanted over drawn distance from the shoulder joint to the wrist.
    pub arm_scale: f64,
}

impl Skeleton {
    pub fn new(measurements: &Measurements) -> Self {
        let landmarks = landmarks(measurements);
        let leg = leg(measurements, &landmarks);
        let (arm, arm_scale) = arm(measurements, &landmarks);
        Self { landmarks, leg, arm, arm_scale }
    }

    /// The height that a drawn height becomes, m.
    pub fn height(&self, drawn: f64) -> f64 {
        interpolate(&self.landmarks, drawn)
    }

    /// The point of the leg's axis at a drawn height.
    pub fn leg_axis(&self, drawn_height: f64) -> Vector3 {
        let drop = self.leg.joint.y - self.height(drawn_height);
        self.leg.joint + self.leg.along * (drop / -self.leg.along.y)
    }

    /// The point of the arm's axis at a drawn distance from the joint.
    pub fn arm_axis(&self, drawn_along: f64) -> Vector3 {
        self.arm.at(drawn_along * self.arm_scale, 0.0, 0.0)
    }
}

/// Linear between the pairs, continued beyond the ends with the slope there.
pub(super) fn interpolate(pairs: &[(f64, f64)], x: f64) -> f64 {
    let next = pairs.partition_point(|pair| pair.0 <= x).clamp(1, pairs.len() - 1);
    let ((x0, y0), (x1, y1)) = (pairs[next - 1], pairs[next]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

/// The floor, then all heights of the measurements.
fn landmarks(measurements: &Measurements) -> [(f64, f64); 14] {
    let (drawn, wanted) = (Measurements::DEFAULT.heights(), measurements.heights());
    std::array::from_fn(|i| if i == 0 { (0.0, 0.0) } else { (drawn[i - 1].1, wanted[i - 1].1) })
}

fn leg(measurements: &Measurements, landmarks: &[(f64, f64)]) -> Limb {
    let tilt = (0.5 * measurements.leg_spread_degrees).to_radians();
    let widening = measurements.hip_girth / Measurements::DEFAULT.hip_girth;
    Limb {
        joint: Vector3::new(HIP_JOINT.0 * widening, interpolate(landmarks, HIP_JOINT.1), 0.0),
        along: Vector3::new(tilt.sin(), -tilt.cos(), 0.0),
        outward: Vector3::new(tilt.cos(), tilt.sin(), 0.0),
    }
}

/// The arm, and the stretch that puts its wrist `arm_length` away from the shoulder point.
fn arm(measurements: &Measurements, landmarks: &[(f64, f64)]) -> (Limb, f64) {
    let widening = measurements.shoulder_width / Measurements::DEFAULT.shoulder_width;
    let place = |[x, y, z]: [f64; 3]| Vector3::new(x * widening, interpolate(landmarks, y), z);
    let angle = measurements.arm_angle_degrees.to_radians();
    let limb = Limb {
        joint: place(SHOULDER_JOINT),
        along: Vector3::new(angle.cos(), -angle.sin(), 0.0),
        outward: Vector3::new(angle.sin(), angle.cos(), 0.0),
    };
    let offset = place(SHOULDER_POINT) - limb.joint;
    let ahead = offset.dot(&limb.along);
    let aside_squared = offset.norm_squared() - ahead * ahead;
    let wrist = ahead + (measurements.arm_length.powi(2) - aside_squared).max(0.0).sqrt();
    (limb, wrist / WRIST)
}
