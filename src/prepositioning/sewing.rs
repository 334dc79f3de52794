//! Seams first: the flat panels are drawn together around the body, without gravity.
//!
//! The seams of the open coarsest level close at one pace: the length from which each stitch pulls
//! falls from its gap to zero in equal steps. Meanwhile the body is thought thinner, so that narrow
//! panels close around its core and not beside it; then it grows to its size and pushes the sewn
//! garment outwards.

use super::problem::Relaxation;
use super::{Event, Observer, Scene};
use crate::arrangement::Arrangement;
use crate::contact::{BodyContact, BodyContactSettings};
use crate::energy::{Energy, Hold};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::{Minimizer, Settings as Steps};
use crate::pattern::{Pattern, SegmentLabel};

/// Steps in which the seams close.
const CLOSING_STEPS: usize = 12;
/// Stiffness of a stitch while the seams close, N/m: with the largest lag a newton, ten times the
/// weight of a sleeve, a tenth of what strains cloth by a per cent.
const CLOSING_STIFFNESS: f64 = 50.0;
/// At the end the stiffness grows by this factor in each of some steps, until the gaps are gone.
const TIGHTENING: f64 = 3.0;
const MOST_TIGHTENING_STEPS: usize = 6;
/// Evaluations for each step.
const EVALUATIONS_PER_STEP: usize = 80;
/// A seam is closed when its largest gap is below this, m: welding then moves nobody noticeably.
const CLOSED: f64 = 5e-4;
/// How much thinner the body is thought while the seams close, m: less than the radius of a wrist.
const SHRINKAGE: f64 = 0.01;
/// Steps in which it grows back.
const GROWING_STEPS: usize = 6;
/// The upper part of the garment that is kept from sinking where the pattern names no part, m.
const UPPER_PART: f64 = 0.05;

/// The open level with its seams closed.
pub struct Sewn {
    /// One per particle of the open level, m, world.
    pub positions: Vec<Vector3>,
    /// m.
    pub largest_gap: f64,
    pub evaluations: usize,
}

/// Closes all seams of the open level.
pub fn close_seams(scene: &Scene, arrangement: &Arrangement, observer: &mut dyn Observer) -> Sewn {
    let (settings, open) = (scene.settings, &scene.garment.open);
    let mut positions = arrangement.positions.clone();
    let mut problem = problem(scene, &positions);
    let mut minimizer = Minimizer::new(settings.minimizer, positions.len());
    let steps = Steps { evaluations: EVALUATIONS_PER_STEP, ..settings.steps(open) };
    let mut evaluations = 0;
    let gaps = problem.energy.stitches.gaps(&positions);
    let mut tightening = 0;
    for step in 1.. {
        let open_share = 1.0 - (step as f64 / CLOSING_STEPS as f64).min(1.0);
        let stitches = &mut problem.energy.stitches;
        stitches.lengths = gaps.iter().map(|gap| gap * open_share).collect();
        stitches.stiffness = CLOSING_STIFFNESS * TIGHTENING.powi(tightening as i32);
        problem.update_diagonal();
        evaluations += minimizer.run(&mut problem, &mut positions, &steps, |_| false).2;
        let gap = problem.energy.stitches.gaps(&positions).into_iter().fold(0.0, f64::max);
        observer.event(&Event::Sewing {
            step,
            closing_steps: CLOSING_STEPS,
            largest_gap: gap,
            open,
            positions: &positions,
        });
        if step >= CLOSING_STEPS {
            if gap < CLOSED || tightening == MOST_TIGHTENING_STEPS {
                break;
            }
            tightening += 1;
        }
    }
    for step in 1..=GROWING_STEPS {
        let thin = SHRINKAGE * (1.0 - step as f64 / GROWING_STEPS as f64);
        problem.body.settings.clearance = settings.clearance - thin;
        evaluations += minimizer.run(&mut problem, &mut positions, &steps, |_| false).2;
    }
    let largest_gap = problem.energy.stitches.gaps(&positions).into_iter().fold(0.0, f64::max);
    observer.event(&Event::Sewn { open, evaluations, curvatures: minimizer.curvatures(), largest_gap });
    Sewn { positions, largest_gap, evaluations }
}

fn problem<'a>(scene: &Scene<'a>, positions: &[Vector3]) -> Relaxation<'a> {
    let (settings, open) = (scene.settings, &scene.garment.open);
    let mut energy = Energy::new(open, scene.fabric, settings.model);
    energy.gravity = 0.0;
    energy.holds = holds(scene.pattern, open, positions);
    let contact = BodyContactSettings {
        clearance: settings.clearance - SHRINKAGE,
        stiffness: settings.contact_stiffness(scene.fabric),
        friction: 0.0,
    };
    let contact = BodyContact::new(scene.body, scene.field, open, contact);
    // Particles that will be sewn to one are neighbours already.
    let classes = scene.garment.levels[0].particle_of.clone();
    let cloth = settings.self_contact(open, classes, scene.fabric, positions);
    Relaxation::new(energy, contact, cloth)
}

/// What keeps the garment from sinking while its shoulders are still open: its waist line and
/// collars, or what is uppermost where the pattern names no collar.
fn holds(pattern: &Pattern, open: &Level, positions: &[Vector3]) -> Vec<Hold> {
    let held = |label| hold(pattern, open, label, positions);
    let upper: Vec<Hold> = [SegmentLabel::Collar, SegmentLabel::StraplessTop].into_iter().filter_map(held).collect();
    let mut holds: Vec<Hold> = held(SegmentLabel::LowerInterface).into_iter().collect();
    if upper.is_empty() {
        let top = positions.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
        let upper = (0..positions.len() as u32).filter(|&p| positions[p as usize].y > top - UPPER_PART);
        holds.extend(anchored(upper.collect(), positions));
    }
    holds.extend(upper);
    holds
}

/// A hold on the particles along all segments with a label, at their present mean height.
pub fn hold(pattern: &Pattern, level: &Level, label: SegmentLabel, positions: &[Vector3]) -> Option<Hold> {
    let mut particles: Vec<u32> = Vec::new();
    for (panel, segments) in pattern.panels.iter().zip(&level.segments) {
        for (segment, points) in panel.segments.iter().zip(segments) {
            if segment.label == Some(label) {
                particles.extend(points.iter().map(|&p| level.particle_of[p as usize]));
            }
        }
    }
    particles.sort_unstable();
    particles.dedup();
    anchored(particles, positions)
}

/// Stiffness of a hold, N/m: a garment of half a kilogram sinks a centimetre.
const HOLD_STIFFNESS: f64 = 500.0;

fn anchored(particles: Vec<u32>, positions: &[Vector3]) -> Option<Hold> {
    if particles.is_empty() {
        return None;
    }
    let height = particles.iter().map(|&p| positions[p as usize].y).sum::<f64>() / particles.len() as f64;
    Some(Hold { particles, height, stiffness: HOLD_STIFFNESS })
}
