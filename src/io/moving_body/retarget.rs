//! Motion capture on another skeleton.
//!
//! Joints are paired by name. A paired joint is turned so that its bones point where those of the capture point; what
//! has no pair keeps its place at the joint above it, so that the body keeps its own bones' lengths. What is promised:
//!
//! * directions of bones between paired joints are those of the capture, whatever the two rest poses are, and whichever
//!   way the body faces at rest; twist about a bone is that of the capture counted from its zero pose, which is taken for the
//!   nearest to the body's rest pose;
//! * the hips go as far as in the capture times the ratio of the legs' lengths, which also takes care of its units; they
//!   begin over the place where the body stands at rest, and the lowest paired joint comes as low as the lowest at rest;
//! * nothing is done against feet that slide or fingers that meet: that would be animation. y is up in the capture.

use super::bvh::Capture;
use super::frames_within;
use super::gltf::{Rig, Skeleton, affine};
use crate::body::Motion;
use crate::body::motion::Affine;
use crate::geometry::Vector3;
use crate::{Error, Warning};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use std::collections::BTreeMap;

/// The hips and one joint more; a single pair is no skeleton.
const FEWEST_PAIRS: usize = 2;
/// How much a joint's turn follows that of the joint above it where its bones leave it free; small against one.
const HOLD: f64 = 1e-3;
/// Bones that are shorter have no direction, m or units of the capture.
const SHORTEST: f64 = 1e-6;
/// Joints times frames beyond which a motion would take minutes.
const MOST_WORK: usize = 200_000_000;
/// How many names a message lists.
const MOST_LISTED: usize = 30;

/// Which joint of a capture moves which node of a body, and how the rest poses differ.
pub struct Retargeting {
    skeleton: Skeleton,
    /// For each joint of the capture its node.
    node_of: Vec<Option<usize>>,
    /// For each node its joint.
    joint_of: Vec<Option<usize>>,
    /// For each joint the turn from the body's rest pose to the capture's zero pose.
    alignment: Vec<Rotation3<f64>>,
    /// Length of the body's legs over that of the capture's.
    ratio: f64,
    warnings: Vec<Warning>,
}

impl Retargeting {
    /// Pairs joints by the `names` given (of the capture, of the body), and else by `plain_name`.
    pub fn new(capture: &Capture, rig: &Rig, names: &[(String, String)]) -> Result<Self, Error> {
        let skeleton = rig.skeleton();
        let (node_of, warnings) = pairs(capture, &skeleton, &rig.joints(), names)?;
        let mut joint_of = vec![None; skeleton.parents.len()];
        node_of.iter().enumerate().for_each(|(j, node)| {
            if let Some(node) = node {
                joint_of[*node] = Some(j);
            }
        });
        let above = paired_above(capture, &node_of);
        let zero = zero_pose(capture);
        let place = |j: usize| node_of[j].map(|n| skeleton.globals[n].column(3).into_owned());
        let mut alignment = vec![Rotation3::identity(); capture.joints.len()];
        for j in 0..capture.joints.len() {
            let held = above[j].map_or_else(Rotation3::identity, |a| alignment[a]);
            let bones = (0..capture.joints.len()).filter(|&c| node_of[c].is_some() && above[c] == Some(j));
            let directions = bones.filter_map(|c| {
                let of_body = (place(c)? - place(j)?).try_normalize(SHORTEST)?;
                Some((of_body, (zero[c] - zero[j]).try_normalize(SHORTEST)?))
            });
            alignment[j] = if node_of[j].is_some() { nearest_rotation(directions, held) } else { held };
        }
        let ratio = leg_ratio(&node_of, &above, &zero, &skeleton)?;
        Ok(Self { skeleton, node_of, joint_of, alignment, ratio, warnings })
    }

    /// The body of `rig` moved by the capture, at its frame rate or another.
    pub fn play(self, capture: &Capture, rig: Rig, rate: Option<f64>) -> Result<(Motion, Vec<Warning>), Error> {
        let rate = rate.unwrap_or(capture.frame_rate);
        let frames = frames_within((capture.frame_count - 1) as f64 / capture.frame_rate, rate)?;
        if frames.saturating_mul(self.skeleton.parents.len() + capture.joints.len()) > MOST_WORK {
            let problem = format!("The motion has {frames} frames of too many joints.");
            return Err(Error::new(problem, "Ask for fewer frames a second, or cut it into shots."));
        }
        let frame = |k: usize| (k as f64 * capture.frame_rate / rate).min((capture.frame_count - 1) as f64);
        let lowest = |globals: &[Affine]| {
            let heights = self.node_of.iter().flatten().map(|&n| globals[n][(1, 3)]);
            heights.fold(f64::INFINITY, f64::min)
        };
        let mut globals = Vec::new();
        let mut least = f64::INFINITY;
        for k in 0..frames {
            self.pose(capture, frame(k), 0.0, &mut globals);
            least = least.min(lowest(&globals));
        }
        let lift = lowest(&self.skeleton.globals) - least;
        let (motion, mut warnings) = rig.moved(frames, rate, |k, out, _| self.pose(capture, frame(k), lift, out))?;
        warnings.extend(self.warnings);
        Ok((motion, warnings))
    }

    /// Nodes to world at a frame of the capture, all `lift` higher, m.
    fn pose(&self, capture: &Capture, frame: f64, lift: f64, out: &mut Vec<Affine>) {
        let mut turned: Vec<UnitQuaternion<f64>> = Vec::with_capacity(capture.joints.len());
        for (j, joint) in capture.joints.iter().enumerate() {
            let local = capture.pose_at(j, frame).rotation;
            turned.push(joint.parent.map_or(local, |parent| turned[parent] * local));
        }
        let rest = &self.skeleton.globals;
        let place = |n: usize| rest[n].column(3).into_owned();
        out.clone_from(rest);
        let mut turns = vec![Rotation3::identity(); rest.len()];
        for &n in &self.skeleton.order {
            let parent = self.skeleton.parents[n];
            let mut at = parent.map_or(place(n), |p| out[p].column(3) + turns[p] * (place(n) - place(p)));
            turns[n] = parent.map_or_else(Rotation3::identity, |p| turns[p]);
            if let Some(j) = self.joint_of[n] {
                turns[n] = turned[j].to_rotation_matrix() * self.alignment[j];
                if capture.joints[j].parent.is_none() {
                    let went = (capture.pose_at(j, frame).translation - capture.pose(j, 0).translation) * self.ratio;
                    at = place(n) + went + Vector3::y() * lift;
                }
            }
            out[n] = affine(turns[n].matrix() * rest[n].fixed_view::<3, 3>(0, 0), at);
        }
    }
}

/// A name without what programs put around it: prefixes up to a colon, `mixamorig`, case, and all but letters and digits.
/// `mixamorig:LeftUpLeg`, `left_up_leg` and `LeftUpLeg` are the same.
pub fn plain_name(name: &str) -> String {
    let last = name.rsplit(':').next().unwrap_or(name);
    let plain: String = last.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
    plain
        .strip_prefix("mixamorig")
        .map_or(plain.clone(), |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()).to_owned())
}

/// For each joint of the capture the node that it moves.
fn pairs(
    capture: &Capture,
    skeleton: &Skeleton,
    joints: &[usize],
    names: &[(String, String)],
) -> Result<(Vec<Option<usize>>, Vec<Warning>), Error> {
    let listed = |names: Vec<&str>| {
        let more = if names.len() > MOST_LISTED { ", …" } else { "" };
        let some: Vec<String> = names.iter().take(MOST_LISTED).map(|n| n.escape_debug().to_string()).collect();
        some.join(", ") + more
    };
    let of_body = || listed(joints.iter().map(|&n| skeleton.names[n].as_str()).filter(|n| !n.is_empty()).collect());
    let mut by_name: BTreeMap<String, usize> = BTreeMap::new();
    for &n in joints.iter().filter(|&&n| !skeleton.names[n].is_empty()) {
        by_name.entry(plain_name(&skeleton.names[n])).or_insert(n);
    }
    let mut node_of = vec![None; capture.joints.len()];
    let mut taken = vec![false; skeleton.parents.len()];
    for (joint, node) in names {
        let j = capture.joints.iter().position(|j| !j.name.is_empty() && j.name == *joint).ok_or_else(|| {
            let there = listed(capture.joints.iter().map(|j| j.name.as_str()).filter(|n| !n.is_empty()).collect());
            Error::new(
                format!("The motion has no joint \"{}\".", joint.escape_debug()),
                format!("Its joints are: {there}."),
            )
        })?;
        let n = joints.iter().copied().find(|&n| skeleton.names[n] == *node).ok_or_else(|| {
            Error::new(
                format!("The body has no joint \"{}\".", node.escape_debug()),
                format!("Its joints are: {}.", of_body()),
            )
        })?;
        if node_of[j].is_some() || std::mem::replace(&mut taken[n], true) {
            let problem = format!("\"{}\" or \"{}\" is paired twice.", joint.escape_debug(), node.escape_debug());
            return Err(Error::new(problem, "Pair each joint once."));
        }
        node_of[j] = Some(n);
    }
    for (j, joint) in capture.joints.iter().enumerate().filter(|(_, joint)| !joint.name.is_empty()) {
        if let Some(&n) = by_name.get(&plain_name(&joint.name)).filter(|&&n| node_of[j].is_none() && !taken[n]) {
            (node_of[j], taken[n]) = (Some(n), true);
        }
    }
    let missing = |j: &usize| !capture.joints[*j].name.is_empty() && node_of[*j].is_none();
    let unpaired: Vec<&str> = (0..node_of.len()).filter(missing).map(|j| capture.joints[j].name.as_str()).collect();
    if node_of[0].is_none() || node_of.iter().flatten().count() < FEWEST_PAIRS {
        return Err(Error::new(
            format!("These joints of the motion have no joint of the same name in the body: {}.", listed(unpaired)),
            format!("Tell which moves which, at least for the hips and the legs. The body has: {}.", of_body()),
        ));
    }
    let mut warnings = Vec::new();
    if !unpaired.is_empty() {
        warnings.push(Warning(Error::new(
            format!("These joints of the motion move nothing: {}.", listed(unpaired)),
            "Tell which joints of the body they move, if they matter.",
        )));
    }
    Ok((node_of, warnings))
}

/// For each joint the nearest joint above it that is paired.
fn paired_above(capture: &Capture, node_of: &[Option<usize>]) -> Vec<Option<usize>> {
    let mut above: Vec<Option<usize>> = Vec::with_capacity(node_of.len());
    for joint in &capture.joints {
        above.push(joint.parent.and_then(|p| if node_of[p].is_some() { Some(p) } else { above[p] }));
    }
    above
}

/// Where the joints of the capture are when nothing is turned, in its units.
fn zero_pose(capture: &Capture) -> Vec<Vector3> {
    let mut places: Vec<Vector3> = Vec::with_capacity(capture.joints.len());
    for joint in &capture.joints {
        places.push(joint.parent.map_or(joint.offset, |p| places[p] + joint.offset));
    }
    places
}

/// The rotation that best turns the first direction of each pair into the second; as far as these leave it free,
/// the nearest to `held`. It minimizes `Σ |R a − b|² + ε |R − held|²` (Wahba 1965), by singular values (Kabsch 1976).
fn nearest_rotation(pairs: impl Iterator<Item = (Vector3, Vector3)>, held: Rotation3<f64>) -> Rotation3<f64> {
    let mut pairs = pairs.peekable();
    if pairs.peek().is_none() {
        return held;
    }
    let sum = pairs.fold(held.matrix() * HOLD, |sum, (a, b)| sum + b * a.transpose());
    let svd = sum.svd(true, true);
    let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return held };
    // Singular values are sorted: of all reflections that of the last direction costs the least.
    let sign = (u * v).determinant().signum();
    Rotation3::from_matrix_unchecked(u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v)
}

/// How much longer the body's legs are than those of the capture: from the root to its lowest joint.
fn leg_ratio(
    node_of: &[Option<usize>],
    above: &[Option<usize>],
    zero: &[Vector3],
    skeleton: &Skeleton,
) -> Result<f64, Error> {
    let paired = (0..node_of.len()).filter(|&j| node_of[j].is_some());
    let lowest = paired.min_by(|&a, &b| zero[a].y.total_cmp(&zero[b].y));
    let (mut of_body, mut of_capture) = (0.0, 0.0);
    let mut joint = lowest;
    while let Some(j) = joint {
        joint = above[j];
        if let (Some(a), Some(n), Some(m)) = (joint, node_of[j], joint.and_then(|a| node_of[a])) {
            of_capture += (zero[j] - zero[a]).norm();
            of_body += (skeleton.globals[n].column(3) - skeleton.globals[m].column(3)).norm();
        }
    }
    let ratio: f64 = of_body / of_capture;
    if of_capture > SHORTEST && of_body > SHORTEST && ratio.is_finite() {
        return Ok(ratio);
    }
    Err(Error::new(
        "The legs have no length: no joint below the hips is paired.",
        "Tell which joints of the motion move the legs of the body.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_compared_without_what_programs_put_around_them() {
        for name in ["mixamorig:LeftUpLeg", "mixamorig1:LeftUpLeg", "left_up_leg", "mixamorigLeftUpLeg", "Left.UpLeg"] {
            assert_eq!(plain_name(name), "leftupleg");
        }
        assert_ne!(plain_name("LeftLeg"), plain_name("RightLeg"));
    }

    #[test]
    fn the_nearest_rotation_turns_what_it_is_given_and_holds_the_rest() {
        let turn = Rotation3::from_euler_angles(0.4, -2.0, 0.7);
        let axes = [Vector3::x(), Vector3::y(), Vector3::new(0.6, 0.0, 0.8)];
        let found = nearest_rotation(axes.iter().map(|&a| (a, turn * a)), Rotation3::identity());
        assert!(found.angle_to(&turn) < 2e-3);
        // One direction: a quarter turn about z, and no twist.
        let found = nearest_rotation([(Vector3::x(), Vector3::y())].into_iter(), Rotation3::identity());
        assert!(found.angle_to(&Rotation3::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2)) < 5e-3);
        // As well as singular values of a small matrix converge.
        assert!(nearest_rotation(std::iter::empty(), turn).angle_to(&turn) < 2e-3);
    }
}
