//! Landmarks of a body: where a tailor would put pins, found on the bare mesh.
//!
//! Limbs are branches of the surface (`branches`), followed by sections square to them (`limb`); the rest are extremal girths and
//! corners of silhouettes of level sections (`torso`). Names and definitions are those of ISO 8559-1:2017, as far as a surface
//! without bones can show them; a bone that does not show (an elbow of a straight arm, a kneecap) stands where it usually is.
//!
//! Asked of the body: it is upright (y up), faces +z, and its limbs hang free of each other: arms up to 80 degrees below the
//! horizontal, legs together or apart as long as the mesh does not grow together. Number, order and density of vertices do not matter.
//! Not promised: millimetres. A girth is measured exactly where it is measured; where that is, is good to a centimetre or two.

mod branches;
mod geodesic;
mod limb;
mod profile;
mod torso;

pub use limb::Limb;

use super::Body;
use crate::Error;
use crate::geometry::Vector3;
use branches::Branch;
pub(super) use branches::{Limbs, limbs, members};
pub(super) use geodesic::Fans;
use limb::{Station, stations};

/// Points and heights on a body, m, world. Of pairs the first is the body's left, at +x, the second its right.
#[derive(Clone, Debug)]
pub struct Landmarks {
    /// The highest point of the head.
    pub crown: Vector3,
    /// Front of the chin; none where the head has no face.
    pub chin: Option<Vector3>,
    /// Base of the neck: in the pit of the throat, over the seventh vertebra, and at the sides where shoulder seams begin.
    pub neck_front: Vector3,
    pub neck_back: Vector3,
    pub neck_sides: [Vector3; 2],
    /// Where the neck is thinnest, m above the origin.
    pub neck: f64,
    /// Outer ends of the shoulders, where shoulder seams end.
    pub shoulders: [Vector3; 2],
    pub armpits: [Vector3; 2],
    /// On the axes of the arms.
    pub elbows: [Vector3; 2],
    pub wrists: [Vector3; 2],
    pub fingertips: [Vector3; 2],
    /// Heights of level girths, m.
    pub bust: f64,
    pub underbust: f64,
    pub waist: f64,
    pub hip: f64,
    pub crotch: Vector3,
    /// On the axes of the legs.
    pub knees: [Vector3; 2],
    pub ankles: [Vector3; 2],
    pub toes: [Vector3; 2],
    /// The lowest point, m.
    pub floor: f64,
    /// From the crotch to the base of the neck, level sections without the arms.
    pub torso: Limb,
    /// From the base of the neck to where it is thinnest, level sections.
    pub neck_column: Limb,
    /// From shoulder joint to wrist.
    pub arms: [Limb; 2],
    /// From hip joint to ankle.
    pub legs: [Limb; 2],
    /// The part that each vertex belongs to.
    pub parts: Vec<Part>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Torso, neck and head.
    Torso,
    /// Of the left (0) or the right (1), beyond the plane through armpit and shoulder.
    Arm(u8),
    /// Below the crotch.
    Leg(u8),
}

/// Distance of the sections of limbs, as a part of the height: 14 mm.
const SPACING: f64 = 1.0 / 125.0;

/// Fewer sections than this are no limb.
const LEAST_STATIONS: usize = 10;

impl Landmarks {
    /// Finds the landmarks of a body that stands upright and faces +z.
    pub fn find(body: &Body) -> Result<Self, Error> {
        find(body.positions(), body.triangles())
    }

    /// Floor to crown, m.
    pub fn height(&self) -> f64 {
        self.crown.y - self.floor
    }
}

/// The landmarks of a closed mesh that stands upright and faces +z, in any unit.
fn find(positions: &[Vector3], triangles: &[[u32; 3]]) -> Result<Landmarks, Error> {
    let fans = Fans::new(positions.len(), triangles);
    let found = limbs(positions, triangles, &fans, Vector3::y())?;
    let at = |v: u32| positions[v as usize];
    let crown = at(found.crown);
    let floor = triangles.iter().flatten().map(|&v| at(v).y).fold(f64::INFINITY, f64::min);
    let height = crown.y - floor;

    let left_first = |[a, b]: [Branch; 2]| if at(a.tip).x >= at(b.tip).x { [a, b] } else { [b, a] };
    let (arm_branches, leg_branches) = (left_first(found.arms.clone()), left_first(found.legs.clone()));
    let armpits = arm_branches.each_ref().map(|b| at(b.saddle));
    let arm_members = arm_branches.each_ref().map(|b| members(triangles, &fans, &found.from_crown, b));
    let leg_members = leg_branches.each_ref().map(|b| members(triangles, &fans, &found.from_crown, b));
    let crotch = at(found.crotch);

    let middle = 0.5 * (armpits[0].x + armpits[1].x);
    let arm_guesses =
        [0, 1].map(|s| centers_by_distance(positions, &found.from_crown, &arm_members[s], &arm_branches[s], height));
    let torso = torso::find(&torso::Known {
        positions,
        triangles,
        fans: &fans,
        crown,
        floor,
        armpits,
        shoulder_sides: [0, 1].map(|s| shoulder_side(armpits[s], &arm_guesses[s])),
        fingertips: arm_branches.each_ref().map(|b| b.tip),
        crotch,
        middle,
    })?;

    let spacing = SPACING * height;
    let arm_stations = [0, 1].map(|s| {
        let among = near(positions, triangles, &arm_members[s], height);
        let joint = (torso.shoulders[s] + armpits[s]) * 0.5;
        stations(positions, triangles, &among, Some(joint), &arm_guesses[s], spacing)
    });
    let leg_stations = [0, 1].map(|s| {
        let guess = centers_by_height(positions, &leg_members[s], floor, crotch.y, height);
        stations(positions, triangles, &near(positions, triangles, &leg_members[s], height), None, &guess, spacing)
    });
    for (stations, name) in
        arm_stations.iter().zip(["left arm", "right arm"]).chain(leg_stations.iter().zip(["left leg", "right leg"]))
    {
        if stations.len() < LEAST_STATIONS {
            return Err(Error::new(
                format!("The {name} cannot be followed from end to end."),
                "Check that it is one closed tube of the mesh, and that nothing passes through it.",
            ));
        }
    }

    let arms: [_; 2] = [0, 1].map(|s| arm(&arm_stations[s], torso.shoulders[s], armpits[s], height));
    let legs: [_; 2] = [0, 1].map(|s| leg(&leg_stations[s], torso.hip, crotch, floor, height));
    let mut parts = vec![Part::Torso; positions.len()];
    for s in [0, 1] {
        for (v, part) in parts.iter_mut().enumerate() {
            if torso.arm_members[s][v] {
                *part = Part::Arm(s as u8);
            } else if leg_members[s][v] && positions[v].y < crotch.y {
                *part = Part::Leg(s as u8);
            }
        }
    }
    let [(left_arm, left_elbow, left_wrist), (right_arm, right_elbow, right_wrist)] = arms;
    let [(left_leg, left_knee, left_ankle), (right_leg, right_knee, right_ankle)] = legs;
    Ok(Landmarks {
        crown,
        chin: torso.chin,
        neck_front: torso.neck_front,
        neck_back: torso.neck_back,
        neck_sides: torso.neck_sides,
        neck: torso.neck,
        shoulders: torso.shoulders,
        armpits,
        elbows: [left_elbow, right_elbow],
        wrists: [left_wrist, right_wrist],
        fingertips: arm_branches.each_ref().map(|b| at(b.tip)),
        bust: torso.bust,
        underbust: torso.underbust,
        waist: torso.waist,
        hip: torso.hip,
        crotch,
        knees: [left_knee, right_knee],
        ankles: [left_ankle, right_ankle],
        toes: leg_branches.each_ref().map(|b| at(b.tip)),
        floor,
        torso: torso.limb,
        neck_column: torso.neck_column,
        arms: [left_arm, right_arm],
        legs: [left_leg, right_leg],
        parts,
    })
}

/// The x at which a shoulder ends, m. Over the armpit when the arm is level; the more it hangs, the more the armpit lies inside of the
/// shoulder, by up to the radius of the arm. Half of that agrees with shoulder breadths of surveys (biacromial breadth 0.23 of
/// the height, C. C. Gordon et al., ANSUR, 1989).
fn shoulder_side(armpit: Vector3, guess: &[Vector3]) -> f64 {
    let [first, .., _] = guess else { return armpit.x };
    let along = (guess[guess.len() / 3] - first).try_normalize(0.0).unwrap_or(Vector3::x());
    let on_axis = first + along * (armpit - first).dot(&along);
    0.5 * (armpit.x + on_axis.x)
}

/// The triangles that a section across a limb may cut: those in its box and a little around it.
fn near(positions: &[Vector3], triangles: &[[u32; 3]], members: &[bool], height: f64) -> Vec<u32> {
    let inside = || positions.iter().zip(members).filter(|(_, inside)| **inside).map(|(p, _)| p);
    let margin = Vector3::repeat(0.06 * height);
    let low = inside().fold(Vector3::repeat(f64::INFINITY), |a, p| a.inf(p)) - margin;
    let high = inside().fold(Vector3::repeat(f64::NEG_INFINITY), |a, p| a.sup(p)) + margin;
    let within = |v: u32| {
        let p = positions[v as usize];
        (0..3).all(|k| p[k] >= low[k] && p[k] <= high[k])
    };
    (0..).zip(triangles).filter(|(_, t)| t.iter().all(|&v| within(v))).map(|(k, _)| k).collect()
}

/// First guess of an arm's centerline: middles of bands of equal distance from the crown.
fn centers_by_distance(
    positions: &[Vector3],
    from_crown: &[f64],
    members: &[bool],
    branch: &Branch,
    height: f64,
) -> Vec<Vector3> {
    let bands = 16;
    let (start, end) = (from_crown[branch.saddle as usize] + 0.02 * height, from_crown[branch.tip as usize]);
    let band = |d: f64| (((d - start) / (end - start) * f64::from(bands)) as usize).min(bands as usize - 1);
    let mut boxes = vec![(Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)); bands as usize];
    for (v, p) in positions.iter().enumerate() {
        if members[v] && from_crown[v] >= start {
            let (low, high) = &mut boxes[band(from_crown[v])];
            (*low, *high) = (low.inf(p), high.sup(p));
        }
    }
    boxes.iter().filter(|(low, _)| low.x.is_finite()).map(|(low, high)| (low + high) * 0.5).collect()
}

/// First guess of a leg's centerline: middles of slices, from the crotch down to just above the floor.
fn centers_by_height(positions: &[Vector3], members: &[bool], floor: f64, crotch: f64, height: f64) -> Vec<Vector3> {
    let slices = 24;
    let (start, end) = (crotch, floor + 0.03 * height);
    let mut boxes = vec![(Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)); slices];
    for (p, _) in positions.iter().zip(members).filter(|(p, inside)| **inside && p.y <= start && p.y >= end) {
        let slice = (((start - p.y) / (start - end) * slices as f64) as usize).min(slices - 1);
        let (low, high) = &mut boxes[slice];
        (*low, *high) = (low.inf(p), high.sup(p));
    }
    boxes.iter().filter(|(low, _)| low.x.is_finite()).map(|(low, high)| (low + high) * 0.5).collect()
}

/// How far from the fingertips the wrist may be, as parts of the height; 0.108 is usual (R. Drillis, R. Contini, "Body segment
/// parameters", New York University, 1966).
const WRIST: [f64; 2] = [0.06, 0.16];
/// Where the elbow of a straight arm is, between shoulder and wrist (Drillis and Contini: 0.186 and 0.146 of the height).
const ELBOW: f64 = 0.186 / (0.186 + 0.146);

/// The arm from its joint to the wrist; elbow and wrist.
fn arm(stations: &[Station], shoulder: Vector3, armpit: Vector3, height: f64) -> (Limb, Vector3, Vector3) {
    // Lengths from the fingertips.
    let mut from_tip = vec![0.0; stations.len()];
    for k in (0..stations.len() - 1).rev() {
        from_tip[k] = from_tip[k + 1] + (stations[k + 1].center - stations[k].center).norm();
    }
    let range = |k: &usize| (WRIST[0] * height..WRIST[1] * height).contains(&from_tip[*k]);
    let thinnest = |a: &usize, b: &usize| stations[*a].tape.total_cmp(&stations[*b].tape);
    let wrist = (0..stations.len()).filter(range).min_by(thinnest).unwrap_or(stations.len() - 1);
    let joint = (shoulder + armpit) * 0.5;
    let mut limb = Limb::default();
    let across = (shoulder - armpit) * 0.5;
    let depth = Vector3::z() * across.norm();
    let around = (0..16).map(|k| (f64::from(k) * std::f64::consts::TAU / 16.0).sin_cos());
    limb.push(joint, around.map(|(sin, cos)| joint + across * cos + depth * sin).collect());
    let out = (armpit - joint).cross(&Vector3::z());
    let out = if out.dot(&(stations[wrist].center - joint)) < 0.0 { -out } else { out };
    for station in &stations[..=wrist] {
        if (station.center - joint).dot(&out) > 0.0 {
            limb.push(station.center, station.outline.clone());
        }
    }
    let elbow = limb.at(ELBOW * limb.length()).0;
    (limb, elbow, stations[wrist].center)
}

/// Heights between which the thinnest part above the foot is, as parts of the height.
const ANKLE: [f64; 2] = [0.035, 0.11];
/// Height of the kneecap's middle as a part of the height (Drillis and Contini: 0.285).
const KNEE: f64 = 0.285;

/// The leg from its joint to the ankle; knee and ankle.
fn leg(stations: &[Station], hip: f64, crotch: Vector3, floor: f64, height: f64) -> (Limb, Vector3, Vector3) {
    let level = |k: usize| (stations[k].center.y - floor) / height;
    let range = |k: &usize| (ANKLE[0]..ANKLE[1]).contains(&level(*k));
    let thinnest = |a: &usize, b: &usize| stations[*a].tape.total_cmp(&stations[*b].tape);
    let ankle = (0..stations.len()).filter(range).min_by(thinnest).unwrap_or(stations.len() - 1);
    let mut limb = Limb::default();
    let below = stations.iter().position(|s| s.center.y < crotch.y).unwrap_or(0);
    let top = &stations[below];
    // The thigh goes on in its direction up to the height of the hips, where the joint is.
    let rise = (hip - top.center.y).max(0.0);
    let joint = top.center - top.direction * (rise / top.direction.y.abs().max(0.5));
    limb.push(joint, top.outline.iter().map(|p| p + (joint - top.center)).collect());
    for station in &stations[below..=ankle.max(below)] {
        limb.push(station.center, station.outline.clone());
    }
    let knee_height = floor + KNEE * height;
    let knee =
        stations.iter().min_by(|a, b| (a.center.y - knee_height).abs().total_cmp(&(b.center.y - knee_height).abs()));
    let knee = knee.map_or(top.center, |s| s.center);
    (limb, knee, stations[ankle].center)
}
