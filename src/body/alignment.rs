//! In which unit and which way round a body comes, and how it gets into our frame.
//!
//! Our frame: metres, y up, facing +z, its left at +x, feet on y = 0, the crotch over the origin. Recognized are
//! * what is up: of the six directions of the axes the one along which two legs stand below and two arms hang above,
//!   at the heights where people have them (`landmarks::limbs`);
//! * the unit, from the height of people;
//! * left and right, from pairs of armpits, fingertips and toes; front and back, because feet reach farther to the front of the
//!   ankle than behind it;
//! * the place, from the crotch and the soles.
//!
//! What is nearly right is left as it is: somebody has put the body there.

use super::landmarks::{Fans, Limbs, limbs, members};
use crate::Error;
use crate::geometry::Vector3;
use nalgebra::{Matrix3, Matrix4};

/// How the coordinates of a body's file become ours: `rotation * (scale * point) + translation`.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// The unit of the file, in words.
    pub unit: &'static str,
    /// m in a unit of the file.
    pub scale: f64,
    /// What is up in the file, and whereto the body faces, such as `+z`.
    pub up: &'static str,
    pub facing: String,
    pub rotation: Matrix3<f64>,
    /// m.
    pub translation: Vector3,
}

/// Units by their length, m, in the order of what is likelier where two fit.
const UNITS: [(&str, f64); 5] =
    [("metres", 1.0), ("centimetres", 0.01), ("millimetres", 0.001), ("inches", 0.0254), ("feet", 0.3048)];
/// Heights of nearly all grown-ups, m; and of everybody from infants to giants. No two units but feet and decimetres put
/// the same number among grown-ups.
const GROWN_UP: std::ops::RangeInclusive<f64> = 1.3..=2.2;
const ANYBODY: std::ops::RangeInclusive<f64> = 0.45..=2.6;
/// A body that is turned from an axis by no more stands as its author wanted, rad: 2.5 degrees.
const STRAIGHT: f64 = 0.0436;
/// A body that is no farther from its place stands as its author wanted, m.
const IN_PLACE: f64 = 0.05;
/// Pairs that differ from the armpits' direction by more are not held symmetrically, rad: 12 degrees.
const SYMMETRIC: f64 = 0.21;
/// Feet reach at least so much farther to the front than behind, as a part of the height.
const LEAST_FOOT: f64 = 0.004;

const AXES: [(&str, Vector3); 6] = [
    ("+y", Vector3::new(0.0, 1.0, 0.0)),
    ("+z", Vector3::new(0.0, 0.0, 1.0)),
    ("+x", Vector3::new(1.0, 0.0, 0.0)),
    ("-y", Vector3::new(0.0, -1.0, 0.0)),
    ("-z", Vector3::new(0.0, 0.0, -1.0)),
    ("-x", Vector3::new(-1.0, 0.0, 0.0)),
];

impl Alignment {
    /// Recognizes how the mesh of a person stands; the mesh must be closed, in any unit.
    pub fn recognize(positions: &[Vector3], triangles: &[[u32; 3]]) -> Result<Self, Error> {
        let fans = Fans::new(positions.len(), triangles);
        let (up, found) = standing(positions, triangles, &fans)?;
        let (up_name, up) = AXES[up];
        let at = |v: u32| positions[v as usize];
        let floor = triangles.iter().flatten().map(|&v| at(v).dot(&up)).fold(f64::INFINITY, f64::min);
        let height = at(found.crown).dot(&up) - floor;
        let (unit, scale) = unit(height)?;

        let sideways = sideways(positions, &found, up)?;
        let front = front(positions, triangles, &fans, &found, up, floor, height)?;
        let left = if up.cross(&front).dot(&sideways) >= 0.0 { sideways } else { -sideways };
        let left = straightened(left);
        let facing = left.cross(&up);
        let rotation = Matrix3::from_rows(&[left.transpose(), up.transpose(), facing.transpose()]);

        let crotch = rotation * at(found.crotch) * scale;
        let (x, z) = if crotch.x.hypot(crotch.z) <= IN_PLACE { (0.0, 0.0) } else { (-crotch.x, -crotch.z) };
        let y = if (floor * scale).abs() <= IN_PLACE { 0.0 } else { -floor * scale };
        let translation = Vector3::new(x, y, z);
        Ok(Self { unit, scale, up: up_name, facing: direction(facing), rotation, translation })
    }

    /// Does the body stand as it should?
    pub fn is_identity(&self) -> bool {
        self.scale == 1.0 && self.rotation == Matrix3::identity() && self.translation == Vector3::zeros()
    }

    /// A point of the file in our frame, m.
    pub fn apply(&self, point: Vector3) -> Vector3 {
        self.rotation * (point * self.scale) + self.translation
    }

    /// The same as a matrix, row by row, that takes points of the file to ours.
    pub fn world_from_file(&self) -> [[f64; 4]; 4] {
        let mut matrix = Matrix4::identity();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&(self.rotation * self.scale));
        matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation);
        std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
    }

    /// What was recognized and what it takes, in words.
    pub fn describe(&self) -> String {
        let t = self.translation;
        let moved = if t == Vector3::zeros() {
            "not moved".to_owned()
        } else {
            format!("moved by ({:.3}, {:.3}, {:.3}) m", t.x, t.y, t.z)
        };
        let turned = if self.rotation == Matrix3::identity() { "not turned" } else { "turned to y up, facing +z" };
        let scaled = if self.scale == 1.0 { "not scaled".to_owned() } else { format!("scaled by {}", self.scale) };
        format!("in {}, {} up, facing {}: {scaled}, {turned}, {moved}", self.unit, self.up, self.facing)
    }
}

/// Which of the axes is up.
fn standing(positions: &[Vector3], triangles: &[[u32; 3]], fans: &Fans) -> Result<(usize, Limbs), Error> {
    let mut best: Option<(f64, usize, Limbs)> = None;
    let mut first_fault = None;
    let (low, high) = triangles
        .iter()
        .flatten()
        .map(|&v| positions[v as usize])
        .fold((Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)), |(low, high), p| {
            (low.inf(&p), high.sup(&p))
        });
    let size = high - low;
    for (k, (_, up)) in AXES.iter().enumerate() {
        // Nobody's arms are much wider than the body is high.
        if size.dot(&up.abs()) < 0.7 * size.max() {
            continue;
        }
        match limbs(positions, triangles, fans, *up) {
            Ok(found) => {
                let oddity = found.oddity(positions, *up);
                if best.as_ref().is_none_or(|(least, ..)| oddity < *least) {
                    best = Some((oddity, k, found));
                }
            }
            Err(e) => first_fault = first_fault.or(Some(e)),
        }
    }
    let missing = || {
        let fault = first_fault.map_or_else(String::new, |e| format!(" {}", e.problem()));
        Error::new(
            format!("No upright person can be recognized in the body, along none of the axes.{fault}"),
            "Alignment knows people with two arms and two legs along an axis of the file; bring other bodies into metres, y \
             up, facing +z yourself.",
        )
    };
    best.map(|(_, k, found)| (k, found)).ok_or_else(missing)
}

/// The unit in which people are as high as this.
fn unit(height: f64) -> Result<(&'static str, f64), Error> {
    let among = |range: std::ops::RangeInclusive<f64>| {
        UNITS.into_iter().find(move |(_, metres)| range.contains(&(height * metres)))
    };
    among(GROWN_UP).or_else(|| among(ANYBODY)).ok_or_else(|| {
        Error::new(
            format!(
                "The body is {height:.4} high, which no person is in metres, centimetres, millimetres, inches or feet."
            ),
            "Scale the body to metres.",
        )
    })
}

/// A level unit vector from one side of the body to the other.
fn sideways(positions: &[Vector3], found: &Limbs, up: Vector3) -> Result<Vector3, Error> {
    let level = |v: Vector3| v - up * v.dot(&up);
    let pair = |a: u32, b: u32| level(positions[a as usize] - positions[b as usize]);
    let [one, other] = &found.arms;
    let armpits = pair(one.saddle, other.saddle);
    let mut sum = armpits;
    for between in [pair(one.tip, other.tip), pair(found.legs[0].tip, found.legs[1].tip)] {
        let between = if between.dot(&armpits) < 0.0 { -between } else { between };
        if between.angle(&armpits) < SYMMETRIC {
            sum += between;
        }
    }
    sum.try_normalize(0.0).ok_or_else(|| {
        Error::new(
            "Left and right cannot be told apart: both arms begin at the same place.",
            "Take a body whose arms are apart, or bring it into metres, y up, facing +z yourself.",
        )
    })
}

/// The direction in which the feet point, level.
fn front(
    positions: &[Vector3],
    triangles: &[[u32; 3]],
    fans: &Fans,
    found: &Limbs,
    up: Vector3,
    floor: f64,
    height: f64,
) -> Result<Vector3, Error> {
    /// Feet are below, shins above, as parts of the height.
    const FOOT: f64 = 0.04;
    const SHIN: [f64; 2] = [0.06, 0.12];
    let level = |v: Vector3| v - up * v.dot(&up);
    let middle = |members: &[bool], low: f64, high: f64| -> Option<Vector3> {
        let within = |p: &Vector3| (low..high).contains(&((p.dot(&up) - floor) / height));
        let chosen = positions.iter().zip(members).filter(|(p, member)| **member && within(p)).map(|(p, _)| *p);
        let bounds = chosen.fold(None, |bounds: Option<(Vector3, Vector3)>, p| {
            Some(bounds.map_or((p, p), |(low, high)| (low.inf(&p), high.sup(&p))))
        });
        bounds.map(|(low, high)| level(low + high) * 0.5)
    };
    let mut sum = Vector3::zeros();
    for leg in &found.legs {
        let members = members(triangles, fans, &found.from_crown, leg);
        if let (Some(foot), Some(shin)) = (middle(&members, -1.0, FOOT), middle(&members, SHIN[0], SHIN[1])) {
            sum += foot - shin;
        }
    }
    if sum.norm() < 2.0 * LEAST_FOOT * height {
        return Err(Error::new(
            "Front and back cannot be told apart: the body has no feet that point anywhere.",
            "Turn the body yourself: y up, facing +z.",
        ));
    }
    Ok(sum)
}

/// A direction, along an axis if it is nearly.
fn straightened(direction: Vector3) -> Vector3 {
    let near = AXES.iter().find(|(_, axis)| direction.angle(axis) <= STRAIGHT);
    near.map_or(direction, |(_, axis)| *axis)
}

/// The name of a direction: of the nearest axis, and how far it is turned from it if it is.
fn direction(v: Vector3) -> String {
    let nearest = AXES.iter().min_by(|a, b| v.angle(&a.1).total_cmp(&v.angle(&b.1)));
    let (name, axis) = nearest.expect("there are axes");
    match v.angle(axis).to_degrees() {
        angle if angle < 0.05 => (*name).to_owned(),
        angle => format!("{angle:.1} degrees from {name}"),
    }
}
