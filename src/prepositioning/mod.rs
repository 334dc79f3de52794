//! Pre-positioning: from flat panels to a garment of low energy, clear of the body and of itself.
//!
//! The method of Le Thanh and Gagalowicz (2007): relax a coarse discretization, prolong its
//! positions to a finer one, relax that, and so on. Seams close first, without gravity, on the
//! coarsest level; `docs/theory.md` tells where and why we depart from the paper.

pub mod comparison;
mod finish;
mod hessian;
mod outcome;
mod problem;
mod prolongation;
mod relaxing;
mod settings;
mod sewing;

pub use hessian::Hessian;
pub use outcome::{CurvePoint, Event, LevelSummary, Observer, Outcome};
pub use problem::{Relaxation, Residual};
pub use settings::{COARSEST_LEVEL, DEFAULT_CLEARANCE, FinishLine, Settings};

use crate::Error;
use crate::arrangement::{Arrangement, Care, SIGHT_MARGIN, arrange, check_placement};
use crate::assess::assess;
use crate::body::{Body, DistanceField};
use crate::garment::Garment;
use crate::geometry::Vector3;
use crate::pattern::{Fabric, Pattern};

/// Side of a cell of the body's distance field near the skin, m: a third of a finger.
const FIELD_CELL: f64 = 0.006;
/// How far outside the body the field reaches beyond the clearance, m.
const FIELD_BAND: f64 = 0.01;

/// Sews the pattern around the body and relaxes it, level by level.
pub fn preposition(
    pattern: &Pattern,
    fabric: &Fabric,
    body: &Body,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Outcome, Error> {
    preposition_from(pattern, fabric, body, settings, &|_| (), observer)
}

/// The same, from positions that `disturb` has changed after the panels were arranged: one per point of
/// the open coarsest level, m, world.
fn preposition_from(
    pattern: &Pattern,
    fabric: &Fabric,
    body: &Body,
    settings: &Settings,
    disturb: &(dyn Fn(&mut [Vector3]) + Sync),
    observer: &mut dyn Observer,
) -> Result<Outcome, Error> {
    settings.check()?;
    check_placement(pattern, body)?;
    // Parallel work that is begun outside the pool wakes a thread and waits for it, each time.
    rayon::scope(|_| sew_and_relax(pattern, fabric, body, settings, disturb, observer))
}

fn sew_and_relax(
    pattern: &Pattern,
    fabric: &Fabric,
    body: &Body,
    settings: &Settings,
    disturb: &(dyn Fn(&mut [Vector3]) + Sync),
    observer: &mut dyn Observer,
) -> Result<Outcome, Error> {
    let (garment, field) =
        rayon::join(|| Garment::build(pattern, &settings.resolutions), || distance_field(body, settings.clearance));
    let garment = garment?;
    let scene = Scene { pattern, fabric, garment: &garment, body, field: &field, settings };
    let (arrangement, sewn) = sew(&scene, disturb, observer);
    let mut positions = garment.weld(&sewn.positions);
    let mut levels = Vec::new();
    for level in 0..garment.levels.len() {
        if level > 0 {
            positions = prolongation::prolong(&garment, level, &positions);
        }
        levels.push(relaxing::relax(&scene, level, &arrangement, &mut positions, observer));
    }
    let finest = &garment.levels[garment.levels.len() - 1];
    let assessment = assess(pattern, finest, &positions, body, settings.clearance);
    Ok(Outcome {
        positions,
        shifts: arrangement.shifts,
        sewing_evaluations: sewn.evaluations,
        welded_gap: sewn.largest_gap,
        levels,
        assessment,
        garment,
    })
}

/// Arranges the panels and closes their seams. Where that did not go well, as it does not for panels that start beside
/// the limbs they are to enclose, it is tried once more with more care; the better one is taken.
fn sew(
    scene: &Scene,
    disturb: &(dyn Fn(&mut [Vector3]) + Sync),
    observer: &mut dyn Observer,
) -> (Arrangement, sewing::Sewn) {
    let mut with = |care: Care| {
        let mut arrangement = arrange(scene.pattern, &scene.garment.open, scene.body, scene.field, care);
        disturb(&mut arrangement.positions);
        observer.event(&Event::Arranged { shifts: &arrangement.shifts });
        let sewn = sewing::close_seams(scene, &arrangement, observer);
        let trouble = sewing::Trouble::of(scene, &sewn);
        (trouble, arrangement, sewn)
    };
    let (trouble, arrangement, mut sewn) = with(Care::Seams);
    if trouble.is_none() {
        return (arrangement, sewn);
    }
    let (other_trouble, other_arrangement, mut other_sewn) = with(Care::SeamsAndOpenings);
    // Both were paid for.
    let evaluations = sewn.evaluations + other_sewn.evaluations;
    (sewn.evaluations, other_sewn.evaluations) = (evaluations, evaluations);
    match other_trouble < trouble {
        true => (other_arrangement, other_sewn),
        false => (arrangement, sewn),
    }
}

/// The distances that a fit with this clearance, m, asks for: one field serves the search for a start, which
/// looks farther, and contact, which looks closer.
pub fn distance_field(body: &Body, clearance: f64) -> DistanceField {
    DistanceField::new(body, FIELD_CELL, SIGHT_MARGIN.max(clearance + FIELD_BAND))
}

/// What all stages look at and none changes.
struct Scene<'a> {
    pattern: &'a Pattern,
    fabric: &'a Fabric,
    garment: &'a Garment,
    body: &'a Body,
    field: &'a DistanceField,
    settings: &'a Settings,
}
