//! Pre-positioning: from flat panels to a garment of low energy, clear of the body and of itself.
//!
//! The method of Le Thanh and Gagalowicz (2007): relax a coarse discretization, prolong its
//! positions to a finer one, relax that, and so on. Seams close first, without gravity, on the
//! coarsest level; `docs/theory.md` tells where and why we depart from the paper.

pub mod comparison;
mod finish;
mod hems;
mod hessian;
mod layering;
mod outcome;
mod outfit;
mod problem;
mod prolongation;
mod relaxing;
mod settings;
mod sewing;
mod smoothing;
mod waist_line;

pub use hessian::Hessian;
pub use outcome::{CurvePoint, Event, LevelSummary, Observer, Outcome};
pub use outfit::{Garments, Outfit};
pub use problem::{Relaxation, Residual};
pub use settings::{COARSEST_LEVEL, FinishLine, Settings, resting_clearance};
pub use waist_line::waist_line;

use crate::Error;
use crate::arrangement::placing::place;
use crate::arrangement::{Arrangement, Care, SIGHT_MARGIN, arrange, check_placement};
use crate::body::{Body, DistanceField, Landmarks};
use crate::garment::Garment;
use crate::geometry::Vector3;
use crate::pattern::{Cut, Fabric, Pattern};
use layering::bring_into_order;
use outfit::{Relaxed, Together, sew_in_turn, take_apart};
use std::ops::Range;

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

/// The same for several garments, worn one over the other. An error names the garment.
pub fn preposition_outfit(
    garments: &Garments,
    body: &Body,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Outfit, Error> {
    preposition_all(garments, body, settings, &|_| (), observer)
}

/// The first, from positions that `disturb` has changed after the panels were arranged: one per point of
/// the open coarsest level, m, world.
fn preposition_from(
    pattern: &Pattern,
    fabric: &Fabric,
    body: &Body,
    settings: &Settings,
    disturb: &(dyn Fn(&mut [Vector3]) + Sync),
    observer: &mut dyn Observer,
) -> Result<Outcome, Error> {
    let mut outfit = preposition_all(&[(pattern, fabric)], body, settings, disturb, observer)?;
    Ok(outfit.garments.remove(0))
}

fn preposition_all(
    garments: &Garments,
    body: &Body,
    settings: &Settings,
    disturb: &(dyn Fn(&mut [Vector3]) + Sync),
    observer: &mut dyn Observer,
) -> Result<Outfit, Error> {
    settings.check()?;
    assert!(!garments.is_empty(), "there is something to wear");
    for (pattern, _) in garments {
        check_placement(pattern, body).map_err(|e| named(garments, pattern, e))?;
    }
    // Parallel work that is begun outside the pool wakes a thread and waits for it, each time.
    rayon::scope(|_| sew_and_relax(garments, body, settings, disturb, observer))
}

/// An error of one of several garments.
fn named(garments: &Garments, pattern: &Pattern, error: Error) -> Error {
    if garments.len() > 1 { error.within(format!("garment \"{}\"", pattern.name)) } else { error }
}

fn sew_and_relax(
    garments: &Garments,
    body: &Body,
    settings: &Settings,
    disturb: &(dyn Fn(&mut [Vector3]) + Sync),
    observer: &mut dyn Observer,
) -> Result<Outfit, Error> {
    let build = |&(pattern, _): &(&Pattern, &Fabric)| {
        Garment::build(pattern, &settings.resolutions).map_err(|e| named(garments, pattern, e))
    };
    let (built, field) = rayon::join(
        || garments.iter().map(build).collect::<Result<Vec<_>, _>>(),
        || distance_field(body, settings.clearance, worn_heights(garments.iter().map(|(pattern, _)| *pattern))),
    );
    let built = built?;
    let clothes = sew_in_turn(garments, &built, (body, &field), settings, disturb, observer);
    // One alone is its own whole, and large enough not to be kept twice.
    let mut parts = if garments.len() > 1 { built.clone() } else { Vec::new() };
    let together = Together::new(garments, built);
    let scene = together.scene(garments.len(), body, &field, settings);
    if garments.len() > 1 {
        observer.event(&Event::TogetherStarted { garments: garments.len() });
    }
    let mut relaxed = Relaxed { positions: clothes.positions, levels: Vec::new(), uncrossed: false };
    for level in 0..together.garment.levels.len() {
        let mut crossing = None;
        if level > 0 {
            let (prolonged, pairs) = prolongation::prolong(&together.garment, level, &relaxed.positions);
            (relaxed.positions, crossing) = (prolonged, Some(pairs));
            if garments.len() > 1 {
                bring_into_order((garments, &parts), (body, &field), settings, level, &mut relaxed.positions);
                crossing = None;
            }
        }
        let positions = &mut relaxed.positions;
        let (summary, uncrossed) = relaxing::relax(&scene, level, &clothes.waists, crossing, positions, observer);
        relaxed.levels.push(summary);
        relaxed.uncrossed = uncrossed;
    }
    if garments.len() == 1 {
        parts.push(together.garment);
    }
    Ok(take_apart(garments, parts, clothes.sewn, &relaxed, body, settings))
}

/// Arranges the panels and closes their seams. Where that did not go well, as it does not for panels that start beside
/// the limbs they are to enclose, it is tried once more with more care, and where a limb comes out of the cloth all the same or
/// a seam is open, from places of our own; the best one is taken.
fn sew(
    scene: &Scene,
    disturb: &(dyn Fn(&mut [Vector3]) + Sync),
    observer: &mut dyn Observer,
) -> (Arrangement, sewing::Sewn) {
    let mut with = |pattern: &Pattern, care: Care| {
        let mut arrangement = arrange(pattern, &scene.garment.open, scene.body, scene.field, care);
        disturb(&mut arrangement.positions);
        observer.event(&Event::Arranged { shifts: &arrangement.shifts });
        let sewn = sewing::close_seams(scene, &arrangement, observer);
        let trouble = sewing::Trouble::of(scene, &sewn);
        (trouble, arrangement, sewn)
    };
    let mut best = with(scene.pattern, Care::Seams);
    let mut evaluations = best.2.evaluations;
    if !best.0.is_none() {
        let other = with(scene.pattern, Care::SeamsAndOpenings);
        evaluations += other.2.evaluations;
        if other.0 < best.0 {
            best = other;
        }
    }
    if best.0.is_wrongly_worn()
        && let Some(pattern) = placed_anew(scene)
    {
        let mut other = with(&pattern, Care::Seams);
        evaluations += other.2.evaluations;
        if other.0 < best.0 {
            other.1.since(&best.1, &scene.garment.open);
            best = other;
        }
    }
    let (_, arrangement, sewn) = best;
    // All were paid for.
    (arrangement, sewing::Sewn { evaluations, ..sewn })
}

/// The pattern with places of our own; none on a body whose parts cannot be told.
fn placed_anew(scene: &Scene) -> Option<Pattern> {
    let marks = Landmarks::find(scene.body).ok()?;
    let mut placed = scene.pattern.clone();
    place(&mut placed, scene.body, &marks, &vec![None; scene.pattern.panels.len()]).ok()?;
    // Its labels stay: they name what holds the garment up.
    let mut pattern = scene.pattern.clone();
    pattern.panels.iter_mut().zip(placed.panels).for_each(|(panel, placed)| panel.placement = placed.placement);
    Some(pattern)
}

/// The distances that a fit with this clearance, m, of cloth that is worn at these heights, m, asks for: one field serves the
/// search for a start, which looks farther, and contact, which looks closer.
pub fn distance_field(body: &Body, clearance: f64, heights: Range<f64>) -> DistanceField {
    DistanceField::fine_at(heights, body, FIELD_CELL, SIGHT_MARGIN.max(clearance + FIELD_BAND))
}

/// Lowest and highest height at which patterns that are placed may come to be worn, m: cloth falls farther than it is raised.
pub fn worn_heights<'a>(patterns: impl IntoIterator<Item = &'a Pattern>) -> Range<f64> {
    let panels = patterns.into_iter().flat_map(|pattern| &pattern.panels);
    let points = panels.flat_map(|panel| panel.polygon(OUTLINE_POINTS).into_iter().map(|p| panel.place(p).y));
    let (lowest, highest) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    lowest - MOST_LOWERED..highest + MOST_RAISED
}

/// Points of each side of a panel that tell where it is.
const OUTLINE_POINTS: usize = 4;
/// How far cloth falls, or is placed too high, m: a skirt from the waist to the hips.
const MOST_LOWERED: f64 = 0.15;
/// How far it is raised, m.
const MOST_RAISED: f64 = 0.05;

/// What all stages look at and none changes.
struct Scene<'a> {
    pattern: &'a Pattern,
    /// How the cloth touches: its friction, its thickness, its stiffness.
    fabric: &'a Fabric,
    /// What its panels are cut from.
    cut: Cut<'a>,
    garment: &'a Garment,
    /// How many garments it is made of.
    garments: usize,
    body: &'a Body,
    field: &'a DistanceField,
    settings: &'a Settings,
}
