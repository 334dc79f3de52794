//! Seams first: the flat panels are drawn together around the body, without gravity.
//!
//! The seams of the open coarsest level close at one pace: the length from which each stitch pulls
//! falls from its gap to zero in equal steps. Meanwhile the body is thought thinner, so that narrow
//! panels close around its core and not beside it; then it grows to its size and pushes the sewn
//! garment outwards.

use super::hems::{draw_up, lengthened};
use super::problem::Relaxation;
use super::{Event, Observer, Scene};
use crate::arrangement::Arrangement;
use crate::assess::cloth_intersections;
use crate::contact::{BodyContact, BodyContactSettings, SELF_STIFFNESS};
use crate::energy::{Energy, Hold, Stitches};
use crate::garment::Level;
use crate::geometry::{Edge, EdgeTable, Vector3};
use crate::minimize::{Iterate, Minimizer, Settings as Steps};
use crate::pattern::{Pattern, SegmentLabel};
use std::ops::Range;

/// Steps in which the seams close.
const CLOSING_STEPS: usize = 12;
/// Stiffness of a stitch while the seams close, N/m: with the largest lag a newton, ten times the
/// weight of a sleeve, a tenth of what strains cloth by a per cent.
const CLOSING_STIFFNESS: f64 = 50.0;
/// Contact is at least this stiff meanwhile, N/m: ten times a stitch, or seams of soft cloth close through a limb.
const LEAST_CONTACT_STIFFNESS: f64 = 500.0;
/// At the end the stiffness grows by this factor in each of some steps, until the gaps are gone.
const TIGHTENING: f64 = 3.0;
const MOST_TIGHTENING_STEPS: usize = 6;
/// Evaluations for each step, at most.
const EVALUATIONS_PER_STEP: usize = 80;
/// A step of closing is over when no stitch lags behind by more than this share of what the widest seam closes in a
/// step: the next one pulls in the same direction, so that the last of the lag can wait until the end.
const LAG_SHARE: f64 = 0.25;
/// A step of growing is over when the latest [`GAIN_EVALUATIONS`] lowered the energy by no more than this share of what
/// the step has lowered it by: what is left the relaxation of the level does.
const GAIN_SHARE: f64 = 0.05;
const GAIN_EVALUATIONS: usize = 10;
/// A seam is closed when its largest gap is below this, m: welding then moves nobody noticeably.
const CLOSED: f64 = 5e-4;
/// How much thinner the body is thought while the seams close, m: less than the radius of a wrist.
const SHRINKAGE: f64 = 0.01;
/// Steps in which it grows back.
const GROWING_STEPS: usize = 6;
/// Steps in which hems that were drawn up get their length back.
const LENGTHENING_STEPS: usize = 12;
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
    let shorter = draw_up(scene.body, open, &mut positions);
    let mut problem = problem(scene, shorter.as_ref().unwrap_or(open), &positions);
    let mut minimizer = Minimizer::new(settings.minimizer, positions.len());
    let steps = Steps { evaluations: EVALUATIONS_PER_STEP, ..settings.steps(open) };
    let mut evaluations = 0;
    let gaps = problem.energy.stitches.gaps(&positions);
    let pace = largest(&gaps) / CLOSING_STEPS as f64;
    let mut tightening = 0;
    for step in 1.. {
        let open_share = 1.0 - (step as f64 / CLOSING_STEPS as f64).min(1.0);
        let stitches = &mut problem.energy.stitches;
        stitches.lengths = gaps.iter().map(|gap| gap * open_share).collect();
        stitches.stiffness = CLOSING_STIFFNESS * TIGHTENING.powi(tightening as i32);
        let (stitches, enough) = (stitches.clone(), if step < CLOSING_STEPS { LAG_SHARE * pace } else { CLOSED });
        problem.update_diagonal();
        let done = |iterate: &Iterate| largest_lag(&stitches, iterate.points) < enough;
        evaluations += minimizer.run(&mut problem, &mut positions, &steps, done).2;
        let gap = largest(&problem.energy.stitches.gaps(&positions));
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
        problem.body.settings.clearance = settings.coarse_clearance() - thin;
        let mut gain = Gain::default();
        evaluations += minimizer.run(&mut problem, &mut positions, &steps, |iterate| gain.is_little(iterate)).2;
    }
    if let Some(shorter) = &shorter {
        for left in (0..LENGTHENING_STEPS).rev() {
            let level = lengthened(open, shorter, left as f64 / LENGTHENING_STEPS as f64);
            let before = std::mem::replace(&mut problem.energy, Energy::new(&level, scene.cut, settings.model));
            problem.energy.gravity = before.gravity;
            (problem.energy.stitches, problem.energy.holds) = (before.stitches, before.holds);
            problem.update_diagonal();
            let mut gain = Gain::default();
            evaluations += minimizer.run(&mut problem, &mut positions, &steps, |iterate| gain.is_little(iterate)).2;
        }
    }
    let mut largest_gap = largest(&problem.energy.stitches.gaps(&positions));
    // What has grown may have opened seams again.
    while largest_gap >= CLOSED && tightening < MOST_TIGHTENING_STEPS {
        tightening += 1;
        problem.energy.stitches.stiffness = CLOSING_STIFFNESS * TIGHTENING.powi(tightening as i32);
        let stitches = problem.energy.stitches.clone();
        problem.update_diagonal();
        let done = |iterate: &Iterate| largest_lag(&stitches, iterate.points) < CLOSED;
        evaluations += minimizer.run(&mut problem, &mut positions, &steps, done).2;
        largest_gap = largest(&problem.energy.stitches.gaps(&positions));
    }
    observer.event(&Event::Sewn { open, evaluations, curvatures: minimizer.curvatures(), largest_gap });
    Sewn { positions, largest_gap, evaluations }
}

/// What went wrong with the seams, the worst first: compared in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Trouble {
    /// Of the three that follow, how many there are.
    kinds: usize,
    /// Edges of the cloth that pass through the body: a limb comes out of it.
    pierced: usize,
    /// Pairs of triangles that cross once the seams are welded.
    crossing: usize,
    /// Seams that did not close.
    open: usize,
}

/// An edge whose middle is deeper in the body than this does not just cut a curve short, m.
const PIERCED: f64 = 0.01;
/// A seam with a gap beyond this is open, m: welding it would pull its surroundings together.
const OPEN: f64 = 2e-3;

impl Trouble {
    pub fn of(scene: &Scene, sewn: &Sewn) -> Self {
        let open = &scene.garment.open;
        let at = |p: u32| sewn.positions[p as usize];
        let edges = EdgeTable::new(&open.particle_triangles()).edges;
        let is_pierced = |edge: &&Edge| {
            let [a, b] = edge.ends.map(at);
            scene.field.distance((a + b) * 0.5) < -PIERCED
        };
        let pierced = edges.iter().filter(is_pierced).count();
        let crossing = cloth_intersections(&scene.garment.levels[0], &scene.garment.weld(&sewn.positions)).len();
        let open = open.stitches.iter().filter(|&&[a, b]| (at(a) - at(b)).norm() > OPEN).count();
        let kinds = [pierced, crossing, open].iter().filter(|&&count| count > 0).count();
        Self { kinds, pierced, crossing, open }
    }

    pub fn is_none(&self) -> bool {
        self.kinds == 0
    }

    /// Does it look as if the body were not in the garment as it should be? Cloth that merely crosses cloth is mended later.
    pub fn is_wrongly_worn(&self) -> bool {
        self.pierced > 0 || self.open > 0
    }
}

fn largest(lengths: &[f64]) -> f64 {
    lengths.iter().copied().fold(0.0, f64::max)
}

/// How far the stitch that is farthest behind is beyond the length from which it pulls, m, not negative.
fn largest_lag(stitches: &Stitches, positions: &[Vector3]) -> f64 {
    let gaps = stitches.gaps(positions);
    gaps.iter().zip(&stitches.lengths).map(|(gap, length)| gap - length).fold(0.0, f64::max)
}

/// How the lowest energy of a run came down: evaluations and J, as accepted steps went by.
#[derive(Default)]
struct Gain {
    lowest: Vec<(usize, f64)>,
}

impl Gain {
    /// Have the latest evaluations gained next to nothing?
    fn is_little(&mut self, iterate: &Iterate) -> bool {
        let now = self.lowest.last().map_or(iterate.value, |&(_, before)| before.min(iterate.value));
        self.lowest.push((iterate.evaluations, now));
        let before = self.lowest.iter().rev().find(|(at, _)| at + GAIN_EVALUATIONS <= iterate.evaluations);
        before.is_some_and(|(_, before)| before - now <= GAIN_SHARE * (self.lowest[0].1 - now))
    }
}

/// What is minimized while the seams of the open level close.
fn problem<'a>(scene: &Scene<'a>, open: &Level, positions: &[Vector3]) -> Relaxation<'a> {
    let settings = scene.settings;
    let mut energy = Energy::new(open, scene.cut, settings.model);
    energy.gravity = 0.0;
    energy.holds = holds(scene.pattern, open, positions);
    let contact = BodyContactSettings {
        clearance: settings.coarse_clearance() - SHRINKAGE,
        stiffness: scene.fabric.contact_stiffness().max(LEAST_CONTACT_STIFFNESS),
        friction: 0.0,
    };
    let contact = BodyContact::new(scene.body, scene.field, open, contact);
    // Particles that will be sewn to one are neighbours already.
    let classes = scene.garment.levels[0].particle_of.clone();
    let mut cloth = settings.self_contact(open, classes, scene.fabric, positions);
    cloth.settings.stiffness = cloth.settings.stiffness.max(SELF_STIFFNESS * LEAST_CONTACT_STIFFNESS);
    Relaxation::new(energy, contact, cloth)
}

/// What keeps the garment from sinking while its shoulders are still open: its waist line and
/// collars, or what is uppermost where the pattern names no collar.
fn holds(pattern: &Pattern, open: &Level, positions: &[Vector3]) -> Vec<Hold> {
    let held = |label| hold(pattern, open, 0..pattern.panels.len(), label, positions);
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

/// A hold on the particles along all segments of some panels with a label, at their present mean height.
pub fn hold(
    pattern: &Pattern,
    level: &Level,
    panels: Range<usize>,
    label: SegmentLabel,
    positions: &[Vector3],
) -> Option<Hold> {
    let mut particles: Vec<u32> = Vec::new();
    for panel in panels {
        for (segment, points) in pattern.panels[panel].segments.iter().zip(&level.segments[panel]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn iterate(value: f64, evaluations: usize) -> Iterate<'static> {
        Iterate { points: &[], gradient: &[], value, evaluations }
    }

    #[test]
    fn a_step_goes_on_while_it_gains_and_swings_are_no_gain() {
        let mut gain = Gain::default();
        assert!((1..200).all(|k| !gain.is_little(&iterate(-0.01 * k as f64, k))), "a twentieth of 200 is ten");
        let mut gain = Gain::default();
        let fading = |k: usize| 0.8f64.powi(k as i32) + if k % 7 == 3 { 0.5 } else { 0.0 };
        let end = (1..200).find(|&k| gain.is_little(&iterate(fading(k), k))).unwrap();
        assert!((15..30).contains(&end), "{end}");
        // Nothing to gain at all.
        let mut gain = Gain::default();
        assert_eq!((1..200).find(|&k| gain.is_little(&iterate(1.0, k))), Some(1 + GAIN_EVALUATIONS));
    }

    #[test]
    fn fewer_kinds_of_trouble_are_better_than_less_of_each() {
        let one = Trouble { kinds: 1, pierced: 0, crossing: 9, open: 0 };
        let two = Trouble { kinds: 2, pierced: 1, crossing: 1, open: 0 };
        assert!(one < two && Trouble { crossing: 10, ..one } > one && !one.is_none());
    }

    #[test]
    fn the_lag_is_that_of_the_stitch_farthest_behind() {
        let stitches = Stitches { pairs: vec![[0, 1], [1, 2]], lengths: vec![0.5, 3.0], stiffness: 1.0 };
        let at = |y: f64| vec![Vector3::zeros(), Vector3::new(1.0, 0.0, 0.0), Vector3::new(1.0, y, 0.0)];
        assert_eq!([largest_lag(&stitches, &at(2.0)), largest_lag(&stitches, &at(4.0))], [0.5, 1.0]);
        assert_eq!(largest_lag(&Stitches::default(), &[]), 0.0);
    }
}
