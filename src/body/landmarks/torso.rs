//! Neck, shoulders, bust, waist and hips: extremal girths and corners of silhouettes.

use super::geodesic::Fans;
use super::limb::Limb;
use super::profile::{Level, corner, levels};
use crate::Error;
use crate::geometry::Vector3;

/// What is known before.
pub struct Known<'a> {
    pub positions: &'a [Vector3],
    pub triangles: &'a [[u32; 3]],
    pub fans: &'a Fans,
    pub crown: Vector3,
    /// m.
    pub floor: f64,
    pub armpits: [Vector3; 2],
    /// x at which the shoulders end, m.
    pub shoulder_sides: [f64; 2],
    /// Vertices.
    pub fingertips: [u32; 2],
    pub crotch: Vector3,
    /// x of the plane of symmetry, m.
    pub middle: f64,
}

pub struct Torso {
    pub chin: Option<Vector3>,
    pub neck: f64,
    pub neck_front: Vector3,
    pub neck_back: Vector3,
    pub neck_sides: [Vector3; 2],
    pub shoulders: [Vector3; 2],
    pub bust: f64,
    pub underbust: f64,
    pub waist: f64,
    pub hip: f64,
    pub limb: Limb,
    pub neck_column: Limb,
    /// Vertices beyond the plane through armpit and shoulder.
    pub arm_members: [Vec<bool>; 2],
}

/// Distance of level sections, as a part of the height: 4 mm.
const STEP: f64 = 1.0 / 400.0;
/// The neck is looked for below this part of the height, where the head is widest or below that.
const HEAD: f64 = 0.95;

pub fn find(known: &Known) -> Result<Torso, Error> {
    let height = known.crown.y - known.floor;
    let part = |fraction: f64| known.floor + fraction * height;
    let armpit = 0.5 * (known.armpits[0].y + known.armpits[1].y);
    let heights = |from: f64, to: f64| {
        let count = ((to - from) / (STEP * height)).max(0.0) as u32;
        (0..=count).map(move |k| from + f64::from(k) * STEP * height)
    };
    let no_arms = vec![false; known.positions.len()];
    let upper = levels(known.positions, known.triangles, &no_arms, known.middle, heights(armpit, known.crown.y));

    // From the head's widest down to the armpits: the neck is the least girth between.
    let column = upper.iter().filter(|l| l.y < part(HEAD) && l.y > armpit + 0.03 * height);
    let neck = column.min_by(|a, b| a.tape.total_cmp(&b.tape));
    let Some(neck) = neck.filter(|l| l.y > armpit + 0.05 * height) else {
        return Err(Error::new(
            "No neck can be found between the shoulders and the head.",
            "Landmarks are found on bodies with a neck that is thinner than head and shoulders; take off hair and collars.",
        ));
    };
    let below: Vec<&Level> = upper.iter().rev().filter(|l| l.y <= neck.y).collect();
    let sides = [0, 1].map(|s| shoulder_line(&below, s, known.shoulder_sides[s], neck));
    let [Some((left_side, left_shoulder)), Some((right_side, right_shoulder))] = sides else {
        return Err(Error::new(
            "The shoulders cannot be found between the neck and the armpits.",
            "Landmarks are found on bodies whose arms hang 0 to 80 degrees below the horizontal.",
        ));
    };
    let shoulders = [left_shoulder, right_shoulder];
    let arm_members = [0, 1].map(|s| beyond(known, s, shoulders[s]));
    let is_arm: Vec<bool> = (0..known.positions.len()).map(|v| arm_members[0][v] || arm_members[1][v]).collect();
    let all = levels(known.positions, known.triangles, &is_arm, known.middle, heights(known.crotch.y, known.crown.y));
    let base = 0.5 * (left_side.y + right_side.y);
    let (neck_front, neck_back) = neck_base(&all, neck.y, base, known.middle, height);
    let chin = chin(&all, neck.y, known.middle, height);

    let trunk: Vec<&Level> = all.iter().filter(|l| l.y < armpit + 0.02 * height).collect();
    let between = |low: f64, high: f64| trunk.iter().filter(move |l| l.y >= low && l.y <= high);
    let bust = bust(&trunk, part(BUST[0]), armpit).unwrap_or(part(BUST_USUAL));
    let waist = least(between(part(WAIST[0]), part(WAIST[1]).min(bust - 0.03 * height))).unwrap_or(part(WAIST_USUAL));
    let rearmost = |l: &Level| l.hull.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let seat = between(known.crotch.y, waist).min_by(|a, b| rearmost(a).total_cmp(&rearmost(b)));
    let hip = seat.map_or(known.crotch.y, |l| l.y);
    let underbust = underbust(&trunk, bust, waist, height);

    let mut limb = Limb::default();
    let coarse = 4;
    for level in all.iter().filter(|l| l.y <= base).step_by(coarse) {
        limb.push(level.center, level.hull.clone());
    }
    let mut neck_column = Limb::default();
    for level in all.iter().filter(|l| l.y >= base && l.y <= neck.y) {
        neck_column.push(level.center, level.hull.clone());
    }
    Ok(Torso {
        chin,
        neck: neck.y,
        neck_front,
        neck_back,
        neck_sides: [left_side, right_side],
        shoulders,
        bust,
        underbust,
        waist,
        hip,
        limb,
        neck_column,
        arm_members,
    })
}

/// Where the shoulder line begins, in the corner between neck and shoulder, and where it ends, at `end`: on the silhouette
/// from the front, from the neck down.
fn shoulder_line(below: &[&Level], side: usize, end: f64, neck: &Level) -> Option<(Vector3, Vector3)> {
    let sign = if side == 0 { 1.0 } else { -1.0 };
    let outermost = |l: &Level| {
        let most = l.hull.iter().map(|p| sign * p.x).fold(f64::NEG_INFINITY, f64::max);
        // Of points that are equally far out, the middle one.
        let near: Vec<f64> = l.hull.iter().filter(|p| sign * p.x > most - 1e-9).map(|p| p.z).collect();
        Vector3::new(sign * most, l.y, near.iter().sum::<f64>() / near.len() as f64)
    };
    let mut line: Vec<Vector3> = Vec::new();
    for level in below {
        let point = outermost(level);
        let reach = sign * (end - neck.center.x);
        if sign * (point.x - neck.center.x) >= reach {
            // Between this level and the one before, where the silhouette reaches the end.
            let before = *line.last()?;
            let t = (end - before.x) / (point.x - before.x);
            line.push(before.lerp(&point, t));
            let k = corner(&line, Vector3::new(-sign, -1.0, 0.0))?;
            return Some((line[k], line[line.len() - 1]));
        }
        line.push(point);
    }
    None
}

/// Vertices of the arm: connected to the fingertip, beyond the plane through armpit and shoulder that runs from front to back.
fn beyond(known: &Known, side: usize, shoulder: Vector3) -> Vec<bool> {
    let armpit = known.armpits[side];
    let mut normal = (shoulder - armpit).cross(&Vector3::z());
    let tip = known.fingertips[side];
    if normal.x * (known.positions[tip as usize].x - known.middle) < 0.0 {
        normal = -normal;
    }
    let outside = |v: u32| (known.positions[v as usize] - armpit).dot(&normal) > 0.0;
    let mut inside = vec![false; known.positions.len()];
    inside[tip as usize] = true;
    let mut open = vec![tip];
    while let Some(v) = open.pop() {
        for &t in known.fans.of(v) {
            for w in known.triangles[t as usize] {
                if !inside[w as usize] && outside(w) {
                    inside[w as usize] = true;
                    open.push(w);
                }
            }
        }
    }
    inside
}

/// How far below the thinnest part of the neck its base is looked for, as a part of the height.
const NECK_BASE: f64 = 0.075;

/// The pit of the throat, and the point over the seventh vertebra, on the middle plane. The vertebra does not show on a smooth
/// mesh: it is taken at the height of the side neck points, where it is within a centimetre on people.
fn neck_base(all: &[Level], neck: f64, sides: f64, middle: f64, height: f64) -> (Vector3, Vector3) {
    let near = all.iter().rev().filter(|l| l.y <= neck && l.y >= neck - NECK_BASE * height);
    let front: Vec<Vector3> = near.filter_map(|l| l.depth.map(|d| Vector3::new(middle, l.y, d[0]))).collect();
    let fallback = Vector3::new(middle, neck, 0.0);
    let pit = corner(&front, Vector3::new(0.0, -1.0, -1.0)).map_or(fallback, |k| front[k]);
    let level = all.iter().min_by(|a, b| (a.y - sides).abs().total_cmp(&(b.y - sides).abs()));
    let nape = level.map_or(fallback, |l| Vector3::new(middle, l.y, l.depth.map_or(l.center.z, |d| d[1])));
    (pit, nape)
}

/// How far above the thinnest part of the neck the face reaches to the nose, as a part of the height.
const FACE: f64 = 0.09;
/// A chin stands out by more than this, as a part of the height.
const LEAST_CHIN: f64 = 0.01;

/// The corner between throat and face.
fn chin(all: &[Level], neck: f64, middle: f64, height: f64) -> Option<Vector3> {
    let near = all.iter().filter(|l| l.y >= neck - 0.02 * height && l.y <= neck + FACE * height);
    let face: Vec<Vector3> = near.filter_map(|l| l.depth.map(|d| Vector3::new(middle, l.y, d[0]))).collect();
    let nose = (0..face.len()).max_by(|&a, &b| face[a].z.total_cmp(&face[b].z))?;
    let towards = Vector3::new(0.0, -1.0, 1.0);
    let k = corner(&face[..=nose], towards)?;
    (face[k].z > face[0].z + LEAST_CHIN * height).then_some(face[k])
}

/// Where the bust is looked for, and where it is if nothing stands out, as parts of the height.
const BUST: [f64; 1] = [0.66];
const BUST_USUAL: f64 = 0.72;
/// Where the waist is looked for, and where it is if the girth has no least value there, as parts of the height.
const WAIST: [f64; 2] = [0.56, 0.69];
const WAIST_USUAL: f64 = 0.63;

/// The height at which the chest stands out farthest to the front, between two heights; none where it does not.
fn bust(trunk: &[&Level], low: f64, high: f64) -> Option<f64> {
    let front: Vec<&&Level> = trunk.iter().filter(|l| l.y >= low && l.y <= high).collect();
    let peak = (0..front.len()).max_by(|&a, &b| front[a].foremost.z.total_cmp(&front[b].foremost.z))?;
    (peak > 0 && peak + 1 < front.len()).then(|| front[peak].y)
}

/// The height of the least girth, if it is not at an end.
fn least<'a>(levels: impl Iterator<Item = &'a &'a Level>) -> Option<f64> {
    let levels: Vec<&&Level> = levels.collect();
    let k = (0..levels.len()).min_by(|&a, &b| levels[a].tape.total_cmp(&levels[b].tape))?;
    (k > 0 && k + 1 < levels.len()).then(|| levels[k].y)
}

/// Below the bust, where the front has fallen back: its corner between bust and waist.
fn underbust(trunk: &[&Level], bust: f64, waist: f64, height: f64) -> f64 {
    let low = waist.max(bust - 0.08 * height);
    let line: Vec<Vector3> =
        trunk.iter().filter(|l| l.y <= bust && l.y >= low).map(|l| Vector3::new(0.0, l.y, l.foremost.z)).collect();
    corner(&line, -Vector3::z()).map_or(bust - 0.04 * height, |k| line[k].y)
}
