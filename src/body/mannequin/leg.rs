//! The left leg, from the leg opening to the toes.

use super::cage::Cage;
use super::grading::{Grading, Part};
use super::section::{Radii, add_ring, cap, join, narrow, superellipse};
use super::skeleton::Limb;
use crate::geometry::Vector3;

/// A section square to the leg. Lengths in m on the drawn figure.
struct Section {
    /// Of its center.
    height: f64,
    /// Its center, before (behind, if negative) the straight axis.
    forward: f64,
    radii: Radii,
}

const fn section(height: f64, forward: f64, [outward, inward]: [f64; 2], [front, back]: [f64; 2]) -> Section {
    Section { height, forward, radii: Radii { outward, inward, front, back } }
}

const SECTIONS: [Section; 8] = [
    section(0.735, -0.006, [0.0810, 0.0820], [0.0960, 0.0960]),
    section(0.625, 0.002, [0.0715, 0.0730], [0.0850, 0.0840]),
    section(0.540, 0.003, [0.0600, 0.0610], [0.0700, 0.0660]),
    section(0.475, 0.002, [0.0550, 0.0560], [0.0630, 0.0590]),
    section(0.420, -0.005, [0.0530, 0.0525], [0.0560, 0.0600]),
    section(0.345, -0.013, [0.0550, 0.0535], [0.0520, 0.0660]),
    section(0.225, -0.020, [0.0390, 0.0400], [0.0420, 0.0470]),
    section(0.115, -0.024, [0.0310, 0.0330], [0.0370, 0.0390]),
];

/// Inner thigh below the crotch: behind, at the crotch, in front, m.
const INNER_THIGH: [[f64; 3]; 3] = [[0.020, 0.772, -0.050], [0.0105, 0.768, -0.004], [0.020, 0.776, 0.042]];

/// Rings of the foot, m: distance outward of the ankle, height, distance forward of the ankle. From the inner side over
/// the instep to the outer side, and back below the sole.
const FOOT: [[[f64; 3]; 6]; 5] = [
    [
        [-0.034, 0.070, 0.000],
        [-0.014, 0.086, 0.050],
        [0.014, 0.084, 0.048],
        [0.034, 0.066, -0.002],
        [0.015, 0.050, -0.045],
        [-0.015, 0.050, -0.045],
    ],
    [
        [-0.033, 0.034, 0.016],
        [-0.017, 0.064, 0.090],
        [0.012, 0.060, 0.086],
        [0.034, 0.028, 0.014],
        [0.017, 0.006, -0.033],
        [-0.017, 0.006, -0.033],
    ],
    [
        [-0.036, 0.028, 0.080],
        [-0.020, 0.047, 0.126],
        [0.013, 0.042, 0.122],
        [0.037, 0.020, 0.078],
        [0.021, 0.001, 0.058],
        [-0.018, 0.002, 0.058],
    ],
    [
        [-0.043, 0.017, 0.142],
        [-0.023, 0.033, 0.162],
        [0.017, 0.030, 0.158],
        [0.044, 0.014, 0.134],
        [0.025, -0.001, 0.130],
        [-0.022, -0.001, 0.136],
    ],
    [
        [-0.037, 0.012, 0.184],
        [-0.019, 0.020, 0.192],
        [0.013, 0.018, 0.184],
        [0.034, 0.010, 0.168],
        [0.018, 0.001, 0.180],
        [-0.018, 0.001, 0.190],
    ],
];

/// Tips of the toes, inner and outer, as in [`FOOT`], m.
const TOES: [[f64; 3]; 2] = [[-0.015, 0.0095, 0.204], [0.011, 0.0085, 0.196]];

/// How far the feet point outward, degrees.
const TOE_OUT: f64 = 6.0;

pub(super) fn build(cage: &mut Cage, grading: &Grading, opening: &[u32; 8]) {
    let rings: [[u32; 6]; SECTIONS.len()] = std::array::from_fn(|i| add_section(cage, grading, &SECTIONS[i]));
    let inner = INNER_THIGH.map(|point| cage.add(grading.torso_point(point, INNER_THIGH[1][2])));
    narrow(cage, opening, &rings[0], &inner);
    for pair in rings.windows(2) {
        join(cage, &pair[0], &pair[1]);
    }
    let mut above = rings[rings.len() - 1];
    for points in &FOOT {
        let ring = add_ring(cage, |i| foot_point(grading, points[i]));
        join(cage, &above, &ring);
        above = ring;
    }
    cap(cage, &above, 0, TOES.map(|point| foot_point(grading, point)));
}

/// From the inner side over the front.
fn add_section(cage: &mut Cage, grading: &Grading, section: &Section) -> [u32; 6] {
    let factor = grading.factor(Part::Leg, section.height);
    let center = grading.skeleton.leg_axis(section.height) + Limb::FORWARD * section.forward;
    add_ring(cage, |i| {
        let (outward, forward) = superellipse(section.radii, 2.0, 180.0 - 60.0 * i as f64);
        center + grading.skeleton.leg.outward * (outward * factor) + Limb::FORWARD * (forward * factor)
    })
}

fn foot_point(grading: &Grading, [outward, height, forward]: [f64; 3]) -> Vector3 {
    let ankle = SECTIONS[SECTIONS.len() - 1].height;
    let center = grading.skeleton.leg_axis(ankle) + Limb::FORWARD * SECTIONS[SECTIONS.len() - 1].forward;
    let (sin, cos) = TOE_OUT.to_radians().sin_cos();
    let scale = grading.foot_scale;
    let x = center.x + scale * (outward * cos + forward * sin);
    let z = center.z + scale * (forward * cos - outward * sin);
    Vector3::new(x, grading.skeleton.height(height), z)
}
