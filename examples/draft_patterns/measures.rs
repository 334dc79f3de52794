//! The measures a pattern maker takes, cm. Girths are known from the table; lengths over the curves of the body are
//! taken on the mannequin itself with a taut tape.

use toile::Error;
use toile::body::mannequin::{Measurements, Mesh, sculpt, stations, tape};
use toile::geometry::{Vector2, Vector3};

const CM_PER_M: f64 = 100.0;

/// A shoulder seam lies this far in front of the ridge of the shoulder, cm; behind it, it would show from the back.
const SEAM_BEFORE_RIDGE: f64 = 1.7;

/// Heights and lengths in cm, angles in degrees.
#[derive(Debug)]
pub struct Measures {
    pub bust_girth: f64,
    pub waist_girth: f64,
    pub hip_girth: f64,
    pub upper_arm_girth: f64,
    /// Heights above the floor.
    pub shoulder_height: f64,
    pub waist_height: f64,
    pub hip_height: f64,
    pub knee_height: f64,
    /// Of the fold between arm and torso.
    pub armpit_height: f64,
    /// From the middle to a shoulder point.
    pub half_shoulder_width: f64,
    /// From the middle to a tip of the bust.
    pub bust_point: f64,
    /// From the shoulder seam, above the tip of the bust, over that tip to the waist.
    pub front_waist_length: f64,
    /// From the tip of the bust to the waist.
    pub bust_to_waist: f64,
    /// From the shoulder seam, at the same distance from the middle, over the back to the waist.
    pub back_waist_length: f64,
    /// Below the horizontal.
    pub arm_angle: f64,
    /// Middle of the upper arm: left of the body's middle, and above the floor.
    pub upper_arm: Vector2,
}

impl Measures {
    pub fn taken(measurements: &Measurements) -> Result<Self, Error> {
        let mesh = sculpt(measurements)?;
        let m = measurements;
        let bust_point = bust_point(&mesh, m);
        let upper_arm = stations(m).into_iter().find(|station| station.name == "upper arm");
        let upper_arm = upper_arm.expect("every figure has an upper arm").origin * CM_PER_M;
        let front = down_from_ridge(&mesh, bust_point, m.waist_height, 1.0);
        Ok(Self {
            bust_girth: m.bust_girth * CM_PER_M,
            waist_girth: m.waist_girth * CM_PER_M,
            hip_girth: m.hip_girth * CM_PER_M,
            upper_arm_girth: m.upper_arm_girth * CM_PER_M,
            shoulder_height: m.shoulder_height * CM_PER_M,
            waist_height: m.waist_height * CM_PER_M,
            hip_height: m.hip_height * CM_PER_M,
            knee_height: m.knee_height * CM_PER_M,
            armpit_height: armpit_height(&mesh, m) * CM_PER_M,
            half_shoulder_width: 0.5 * m.shoulder_width * CM_PER_M,
            bust_point: bust_point * CM_PER_M,
            front_waist_length: front - SEAM_BEFORE_RIDGE,
            bust_to_waist: front - down_from_ridge(&mesh, bust_point, m.bust_height, 1.0),
            back_waist_length: down_from_ridge(&mesh, bust_point, m.waist_height, -1.0) + SEAM_BEFORE_RIDGE,
            arm_angle: m.arm_angle_degrees,
            upper_arm: upper_arm.xy(),
        })
    }
}

/// Distance of the frontmost point at bust height from the middle, m.
fn bust_point(mesh: &Mesh, m: &Measurements) -> f64 {
    let level = tape::section(mesh, &Vector3::new(0.0, m.bust_height, 0.0), &Vector3::y());
    let frontmost = level.iter().max_by(|a, b| a.z.total_cmp(&b.z)).expect("the torso has a section at the bust");
    frontmost.x.abs()
}

/// Lowest point of the arm where it leaves the torso, m.
fn armpit_height(mesh: &Mesh, m: &Measurements) -> f64 {
    /// From the middle, as a part of half the shoulder width: just outside the torso.
    const PLACE: f64 = 0.87;
    let origin = Vector3::new(PLACE * 0.5 * m.shoulder_width, m.shoulder_height - 0.05, 0.0);
    let around = tape::section(mesh, &origin, &Vector3::x());
    around.iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
}

/// Length of a taut tape in the plane x = `aside` from the ridge of the shoulder down to a height, cm. `side` is 1 for
/// the front and -1 for the back.
fn down_from_ridge(mesh: &Mesh, aside: f64, height: f64, side: f64) -> f64 {
    let curve = tape::section(mesh, &Vector3::new(aside, height, 0.0), &Vector3::x());
    let ridge = curve.iter().copied().max_by(|a, b| a.y.total_cmp(&b.y)).expect("the torso has such a section");
    let crossing = |pair: (&Vector3, &Vector3)| {
        let (a, b) = pair;
        ((a.y >= height) != (b.y >= height)).then(|| a + (b - a) * ((height - a.y) / (b.y - a.y)))
    };
    let next = curve.iter().cycle().skip(1);
    let end = curve.iter().zip(next).filter_map(crossing).max_by(|a, b| (side * a.z).total_cmp(&(side * b.z)));
    let end = end.expect("the section reaches down to that height");

    // the tape is the part of the convex hull that goes from ridge to end, bulging to the side
    let mut points: Vec<[f64; 2]> = vec![[-ridge.y, side * ridge.z], [-end.y, side * end.z]];
    let between = curve.iter().filter(|p| p.y > height && side * (p.z - ridge.z) > 0.0);
    points.extend(between.map(|p| [-p.y, side * p.z]));
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut taut: Vec<[f64; 2]> = Vec::new();
    for c in points {
        while let [.., a, b] = taut[..] {
            if (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]) {
                break;
            }
            taut.pop();
        }
        taut.push(c);
    }
    let length = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
    taut.windows(2).map(length).sum::<f64>() * CM_PER_M
}
