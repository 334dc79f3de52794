//! A shop-window figure made from a table of measurements: the body that demonstrations dress.
//!
//! The figure is drawn once, as a table of points on its surface (modules `torso`, `head`, `arm` and `leg`), for the
//! measurements [`Measurements::DEFAULT`]. For other measurements the table is graded, as a maker of dress forms
//! grades a master form: heights move with the landmarks around them, limbs keep their joints, sections grow or shrink
//! until the tape measure reads what was asked for. A Catmull–Clark surface through the points is the skin.
//!
//! The mesh is closed, of one piece, without handles, oriented outward, and mirror-symmetric to the last bit. It
//! stands on y = 0, faces +z and has its own left at +x. The same measurements give the same bytes.
//!
//! Not promised: a figure far from the drawn one. Within about 15 % of each default value the result is a person;
//! farther away limbs may come to touch each other, until some girth cannot be met, which is an error. Faces and fingers
//! are not modelled, and the foot and hand lengths are met within some millimetres only.
//!
//! ```
//! use toile::body::Body;
//! use toile::body::mannequin::Measurements;
//!
//! let tall = Measurements { height: 1.78, ..Measurements::default() };
//! let body = Body::mannequin(&tall)?;
//! assert!(body.triangles().len() < 20_000);
//! # Ok::<(), toile::Error>(())
//! ```

mod arm;
mod cage;
mod grading;
mod head;
mod leg;
mod measurements;
mod section;
mod skeleton;
pub mod tape;
mod torso;

pub use grading::{Station, stations};
pub use measurements::Measurements;

use super::Body;
use crate::Error;
use crate::geometry::Vector3;
use cage::Cage;
use grading::Grading;

/// A triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices, m.
    pub positions: Vec<Vector3>,
    /// Indices of vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Sections are corrected until no girth is off by more than this part of itself. A millimetre in a metre: finer than
/// any tape is read.
const GIRTH_TOLERANCE: f64 = 1e-3;

/// Corrections at most. Three are usual; without a limit, measurements that no surface can have would never end.
const CORRECTION_LIMIT: usize = 20;

/// Subdivisions of the cage. Two give edges of 15 mm; each one more has four times the triangles.
const SUBDIVISION_COUNT: usize = 2;

/// A girth that is off by more than this part after all corrections cannot be had: the tape has found another limb, or
/// nothing at all.
const GIRTH_LIMIT: f64 = 0.02;

impl Body {
    /// The mannequin with the given measurements.
    pub fn mannequin(measurements: &Measurements) -> Result<Self, Error> {
        let mesh = sculpt(measurements)?;
        Ok(Self::new(mesh.positions, mesh.triangles)?.0)
    }
}

/// The surface of the figure with the given measurements; an error names the measurement that no figure can have.
pub fn sculpt(measurements: &Measurements) -> Result<Mesh, Error> {
    measurements.check()?;
    let stations = stations(measurements);
    let mut grading = Grading::new(measurements);
    let mut mesh = surface(&grading, measurements.height);
    for _ in 0..CORRECTION_LIMIT {
        if grading.correct(&mesh, &stations) <= GIRTH_TOLERANCE {
            break;
        }
        mesh = surface(&grading, measurements.height);
    }
    match stations.iter().find(|station| !station.is_met(&mesh, GIRTH_LIMIT)) {
        None => Ok(mesh),
        Some(missed) => Err(Error::new(
            format!("No figure of these proportions measures {} m around the {}.", missed.girth, missed.name),
            "Keep each measurement within some 15 % of its default.",
        )),
    }
}

/// Table of points → cage → smooth half → whole body.
fn surface(grading: &Grading, height: f64) -> Mesh {
    let mut drawn = Cage::default();
    let torso = torso::build(&mut drawn, grading);
    head::build(&mut drawn, grading, &torso.neck);
    arm::build(&mut drawn, grading, &torso.armhole);
    leg::build(&mut drawn, grading, &torso.leg_opening);

    let mut fine = drawn.fitted();
    for _ in 0..SUBDIVISION_COUNT {
        fine = fine.subdivided();
    }
    fine.positions = fine.limit_positions();
    stand_on_floor(&mut fine, height);
    with_right_half(&fine)
}

/// Soles to y = 0 and crown to the stated height. The fitted surface misses both by a millimetre or two.
fn stand_on_floor(half: &mut Cage, height: f64) {
    let lowest = half.positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let highest = half.positions.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    for position in &mut half.positions {
        position.y = (position.y - lowest) / (highest - lowest) * height;
    }
}

/// The left half in triangles, and its mirror image.
fn with_right_half(left: &Cage) -> Mesh {
    let mut positions = left.positions.clone();
    let mut mirrored = Vec::with_capacity(left.positions.len());
    for (index, position) in left.positions.iter().enumerate() {
        if position.x == 0.0 {
            mirrored.push(index as u32);
        } else {
            mirrored.push(positions.len() as u32);
            positions.push(Vector3::new(-position.x, position.y, position.z));
        }
    }
    let mut triangles: Vec<[u32; 3]> = left.quads.iter().flat_map(|quad| halves(quad, &left.positions)).collect();
    let mirror = |&[a, b, c]: &[u32; 3]| [a, c, b].map(|vertex| mirrored[vertex as usize]);
    let right: Vec<[u32; 3]> = triangles.iter().map(mirror).collect();
    triangles.extend(right);
    Mesh { positions, triangles }
}

/// Cuts a quad along the diagonal whose two triangles have the larger smallest angle.
fn halves(&[a, b, c, d]: &[u32; 4], positions: &[Vector3]) -> [[u32; 3]; 2] {
    let along_ac = [[a, b, c], [a, c, d]];
    let along_bd = [[a, b, d], [b, c, d]];
    let sharpest = |pair: &[[u32; 3]; 2]| largest_cosine(&pair[0], positions).max(largest_cosine(&pair[1], positions));
    if sharpest(&along_ac) <= sharpest(&along_bd) { along_ac } else { along_bd }
}

/// Cosine of the smallest angle of a triangle.
fn largest_cosine(triangle: &[u32; 3], positions: &[Vector3]) -> f64 {
    let at = |i: usize| positions[triangle[i % 3] as usize];
    let cosine = |i: usize| (at(i + 1) - at(i)).normalize().dot(&(at(i + 2) - at(i)).normalize());
    cosine(0).max(cosine(1)).max(cosine(2))
}
