//! The left arm, from the armhole to the finger tips, with the fingers as in a mitten.

use super::cage::Cage;
use super::grading::{Grading, Part};
use super::section::{Radii, add_ring, cap, join, narrow, superellipse};
use super::skeleton::WRIST;

/// A section square to the arm. Lengths in m on the drawn figure.
struct Section {
    /// Distance of its plane from the shoulder joint.
    along: f64,
    /// Its center, off the straight axis: a relaxed arm bends forward, a relaxed hand inward.
    outward: f64,
    forward: f64,
    radii: Radii,
    squareness: f64,
}

/// `above` and `below` are the half thickness toward the back of the hand and toward the palm; `half_depth` is square
/// to both.
const fn section(
    along: f64,
    [outward, forward]: [f64; 2],
    [above, below, half_depth]: [f64; 3],
    squareness: f64,
) -> Section {
    let radii = Radii { outward: above, inward: below, front: half_depth, back: half_depth };
    Section { along, outward, forward, radii, squareness }
}

const SECTIONS: [Section; 11] = [
    section(0.074, [0.000, 0.000], [0.0450, 0.0430, 0.0490], 2.0),
    section(0.1415, [0.000, 0.000], [0.0415, 0.0430, 0.0450], 2.0),
    section(0.215, [0.000, 0.000], [0.0385, 0.0395, 0.0410], 2.0),
    section(0.285, [0.000, 0.001], [0.0350, 0.0355, 0.0390], 2.0),
    section(0.354, [0.000, 0.006], [0.0365, 0.0370, 0.0400], 2.0),
    section(0.460, [-0.001, 0.014], [0.0295, 0.0295, 0.0340], 2.0),
    section(WRIST, [-0.002, 0.023], [0.0210, 0.0205, 0.0285], 2.0),
    section(0.601, [-0.004, 0.027], [0.0180, 0.0200, 0.0340], 2.2),
    section(0.660, [-0.007, 0.030], [0.0140, 0.0155, 0.0395], 2.3),
    section(0.706, [-0.013, 0.032], [0.0105, 0.0105, 0.0355], 2.3),
    section(0.737, [-0.018, 0.033], [0.0070, 0.0070, 0.0210], 2.1),
];

/// The ends of the mitten, toward thumb and little finger: along, outward and forward as in [`Section`], m.
const FINGER_TIPS: [[f64; 3]; 2] = [[0.747, -0.0195, 0.040], [0.746, -0.0195, 0.026]];

/// Index of the ring at the wrist among the sections; hand sections follow.
const WRIST_RING: usize = 6;

/// Rings between which the thumb leaves the hand.
const THUMB_RING: usize = 7;

/// The fold of the armpit between torso and arm: behind, deepest point, in front, m. Drawn for arms at 45 degrees.
const ARMPIT: [[f64; 3]; 3] = [[0.168, 1.310, -0.056], [0.164, 1.297, -0.014], [0.168, 1.308, 0.030]];

/// Thumb sections: distance from its root and half thickness, m.
const THUMB: [[f64; 2]; 3] = [[0.021, 0.0125], [0.038, 0.0110], [0.055, 0.0070]];

/// Root of the thumb, along, outward and forward as in [`Section`], m.
const THUMB_ROOT: [f64; 3] = [0.618, -0.008, 0.066];

/// Angle between thumb and hand, degrees.
const THUMB_SPREAD: f64 = 42.0;

pub(super) fn build(cage: &mut Cage, grading: &Grading, armhole: &[u32; 8]) {
    let rings: [[u32; 6]; SECTIONS.len()] = std::array::from_fn(|i| add_section(cage, grading, &SECTIONS[i]));
    let armpit = ARMPIT.map(|point| cage.add(grading.torso_point(point, ARMPIT[1][2])));
    narrow(cage, armhole, &rings[0], &armpit);
    for pair in 0..rings.len() - 1 {
        if pair == THUMB_RING {
            join_around_thumb(cage, grading, &rings[pair], &rings[pair + 1]);
        } else {
            join(cage, &rings[pair], &rings[pair + 1]);
        }
    }
    let tips = FINGER_TIPS
        .map(|[along, outward, forward]| grading.skeleton.arm.at(along_arm(grading, along), outward, forward));
    cap(cage, &rings[rings.len() - 1], 1, tips);
}

/// From the palm side (armpit side) over the front.
fn add_section(cage: &mut Cage, grading: &Grading, section: &Section) -> [u32; 6] {
    let along = along_arm(grading, section.along);
    let in_hand = section.along > SECTIONS[WRIST_RING].along;
    let factor = if in_hand { grading.hand_scale } else { grading.factor(Part::Arm, section.along) };
    add_ring(cage, |i| {
        let (outward, forward) = superellipse(section.radii, section.squareness, 180.0 - 60.0 * i as f64);
        grading.skeleton.arm.at(along, section.outward + outward * factor, section.forward + forward * factor)
    })
}

/// Distance from the shoulder joint that a drawn one becomes, m: the arm follows the arm length, the hand its own.
fn along_arm(grading: &Grading, drawn: f64) -> f64 {
    let wrist = WRIST * grading.skeleton.arm_scale;
    if drawn <= WRIST { drawn * grading.skeleton.arm_scale } else { wrist + (drawn - WRIST) * grading.hand_scale }
}

/// Joins two rings of the hand, but for one quad in front, out of which grows the thumb.
fn join_around_thumb(cage: &mut Cage, grading: &Grading, from: &[u32; 6], to: &[u32; 6]) {
    for i in 0..6 {
        let next = (i + 1) % 6;
        if i != 1 {
            cage.quads.push([from[i], to[i], to[next], from[next]]);
        }
    }
    let scale = grading.hand_scale;
    let (sin, cos) = THUMB_SPREAD.to_radians().sin_cos();
    let root_along = along_arm(grading, THUMB_ROOT[0]);
    let mut below = [from[1], to[1], to[2], from[2]];
    for [distance, half_thickness] in THUMB {
        let ring = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[side, up]: [f64; 2]| {
            // a square whose corners lie on the circle of that radius
            let radius = half_thickness * std::f64::consts::FRAC_1_SQRT_2;
            let along = root_along + scale * (distance * cos + side * radius * sin);
            let forward = THUMB_ROOT[2] + scale * (distance * sin - side * radius * cos);
            cage.add(grading.skeleton.arm.at(along, THUMB_ROOT[1] + scale * up * radius, forward))
        });
        for i in 0..4 {
            let next = (i + 1) % 4;
            cage.quads.push([below[i], below[next], ring[next], ring[i]]);
        }
        below = ring;
    }
    cage.quads.push(below);
}
