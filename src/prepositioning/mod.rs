//! Pre-positioning: from flat panels to a garment of low energy, clear of the body and of itself.
//!
//! The method of Le Thanh and Gagalowicz (2007): relax a coarse discretization, prolong its
//! positions to a finer one, relax that, and so on. Seams close first, without gravity, on the
//! coarsest level; `docs/theory.md` tells where and why we depart from the paper.

mod finish;
mod problem;
mod prolongation;
mod relaxing;
mod sewing;

pub use problem::{Relaxation, Residual};

use crate::Error;
use crate::arrangement::{arrange, check_placement};
use crate::assess::{Assessment, assess};
use crate::body::{Body, DistanceField};
use crate::contact::{SelfContact, SelfContactSettings};
use crate::energy::{Model, Terms};
use crate::garment::{COARSEST_RESOLUTION, Garment, Level};
use crate::geometry::Vector3;
use crate::minimize::{Settings as Steps, Termination};
use crate::pattern::{Fabric, Pattern};

/// When the finest level is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FinishLine {
    /// A simulator can take over: nothing drifts any more, though small forces are left.
    #[default]
    HandOff,
    /// The forces are in balance: rms residual at most [`Settings::equilibrium_residual`].
    Equilibrium,
}

/// How a garment is pre-positioned. Lengths in metres.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Of the levels, coarsest first.
    pub resolutions: Vec<f64>,
    /// Distance to be kept from the body.
    pub clearance: f64,
    pub model: Model,
    pub until: FinishLine,
    /// Root mean square of the residual at which [`FinishLine::Equilibrium`] is reached, in particle
    /// weights.
    pub equilibrium_residual: f64,
    /// Evaluations granted to each level but the finest; in proportion to the resolution below 20 mm.
    pub coarse_evaluations: usize,
    /// Evaluations granted to the finest level until hand-off.
    pub finest_evaluations: usize,
    /// Evaluations granted to the finest level until equilibrium.
    pub equilibrium_evaluations: usize,
}

/// Distance kept from the body unless another is asked for, m: little more than the thickness of
/// cloth. A fit is falsified by more (three millimetres all around are two centimetres of girth);
/// with less, more triangles have to be moved off what comes through between their corners.
pub const DEFAULT_CLEARANCE: f64 = 0.0007;
/// The coarsest level has at most this resolution, m: a sleeve has ten particles around it.
pub const COARSEST_LEVEL: f64 = 0.045;

impl Default for Settings {
    fn default() -> Self {
        Self::for_resolution(0.01)
    }
}

impl Settings {
    /// Levels that halve their resolution down to `resolution`, m.
    pub fn for_resolution(resolution: f64) -> Self {
        let mut resolutions = vec![resolution];
        while 2.0 * resolutions[0] <= COARSEST_LEVEL.min(COARSEST_RESOLUTION) {
            resolutions.insert(0, 2.0 * resolutions[0]);
        }
        Self {
            resolutions,
            clearance: DEFAULT_CLEARANCE,
            model: Model::default(),
            until: FinishLine::HandOff,
            equilibrium_residual: 0.1,
            coarse_evaluations: 1200,
            finest_evaluations: finest_evaluations(resolution),
            equilibrium_evaluations: 20_000,
        }
    }

    /// Are the figures possible?
    pub fn check(&self) -> Result<(), Error> {
        if !(0.0..=0.05).contains(&self.clearance) {
            return Err(Error::new(
                format!("A clearance of {} mm cannot be kept.", self.clearance * 1e3),
                "Give one from 0 mm to 50 mm.",
            ));
        }
        if self.equilibrium_residual <= 0.0 || self.equilibrium_residual.is_nan() {
            return Err(Error::new("The residual of the equilibrium is not positive.", "Give one such as 0.1."));
        }
        Ok(())
    }

    /// Contact is as stiff as the membrane: stiffer would slow the minimizer down, softer would let
    /// tight cloth sink in.
    fn contact_stiffness(&self, fabric: &Fabric) -> f64 {
        fabric.stretch.warp.max(fabric.stretch.weft).max(fabric.shear)
    }

    fn steps(&self, level: &Level) -> Steps {
        Steps { evaluations: 0, largest_move: LARGEST_MOVE * level.resolution, restart_after: RESTART_AFTER }
    }

    /// Contact of a level with itself at `positions`, which should be free of intersections.
    fn self_contact(&self, level: &Level, classes: Vec<u32>, fabric: &Fabric, positions: &[Vector3]) -> SelfContact {
        let settings = SelfContactSettings {
            // Coarse cloth keeps farther apart, which leaves room for the finer.
            clearance: fabric.thickness.max(SELF_CLEARANCE * level.resolution),
            stiffness: SELF_STIFFNESS * self.contact_stiffness(fabric),
            reach: SELF_REACH * level.resolution,
        };
        let mut cloth = SelfContact::new(level, classes, settings);
        cloth.rebuild(positions);
        cloth
    }
}

/// Evaluations that bring the finest level to hand-off. They fall with the resolution, m: the finer
/// the level before, the nearer to its rest the cloth starts (counts for the stretch to settle within
/// a tenth of a per cent on garments at 10 mm and 5 mm).
fn finest_evaluations(resolution: f64) -> usize {
    (340.0 * (resolution / 0.005).powf(2.1)).clamp(300.0, 1500.0) as usize
}

/// The farthest that a particle moves in one step, in resolutions.
const LARGEST_MOVE: f64 = 0.17;
/// Steps of conjugate gradients until the direction is the gradient again.
const RESTART_AFTER: usize = 200;
/// Clearance between layers of cloth, in resolutions, where the fabric is thinner.
const SELF_CLEARANCE: f64 = 0.1;
/// Stiffness of cloth against cloth over that of cloth against the body.
const SELF_STIFFNESS: f64 = 0.4;
/// Pairs nearer than this, in resolutions, are followed: less than the height of a triangle, so that
/// flat cloth has none.
const SELF_REACH: f64 = 0.7;

/// What happens during a run, for whoever watches.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// How far the panels were moved to clear the body from their seams, m, one per panel.
    Arranged { shifts: &'a [Vector3] },
    /// A step of closing the seams ended with this largest gap, m.
    Sewing { step: usize, closing_steps: usize, largest_gap: f64, open: &'a Level, positions: &'a [Vector3] },
    /// Work on a level began.
    LevelStarted { level: usize, levels: usize, resolution: f64, particles: usize, evaluations: usize },
    /// A step was accepted.
    Step { level: usize, point: CurvePoint },
    /// Work on a level ended.
    LevelDone { level: usize, summary: &'a LevelSummary, cloth: &'a Level, positions: &'a [Vector3] },
}

/// Watches a run, from one of the threads that work on it.
pub trait Observer: Send {
    fn event(&mut self, event: &Event);
}

/// Watches nothing.
impl Observer for () {
    fn event(&mut self, _: &Event) {}
}

/// A point of the convergence curve of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Evaluations on this level so far.
    pub evaluations: usize,
    /// J, contact included.
    pub energy: f64,
    /// Root mean square of the residual, in particle weights.
    pub residual: f64,
}

/// The figures of one level.
#[derive(Clone, Debug)]
pub struct LevelSummary {
    /// m.
    pub resolution: f64,
    pub particles: usize,
    pub triangles: usize,
    pub evaluations: usize,
    pub energies: Terms,
    pub residual: Residual,
    pub termination: Termination,
    /// Intersecting pairs that the level started with, after prolongation was made safe.
    pub starting_intersections: usize,
    pub curve: Vec<CurvePoint>,
}

/// All that a run gives.
pub struct Outcome {
    pub garment: Garment,
    /// One per particle of the finest level, m, world.
    pub positions: Vec<Vector3>,
    /// How far each panel was moved before its seams closed, m.
    pub shifts: Vec<Vector3>,
    /// Evaluations spent on closing the seams.
    pub sewing_evaluations: usize,
    /// Largest gap of the stitches when they were welded, m.
    pub welded_gap: f64,
    /// One per level, coarsest first.
    pub levels: Vec<LevelSummary>,
    pub assessment: Assessment,
}

impl Outcome {
    pub fn finest(&self) -> &Level {
        self.garment.levels.last().expect("a garment has at least one level")
    }

    /// How the finest level ended.
    pub fn termination(&self) -> Termination {
        self.levels.last().expect("a garment has at least one level").termination
    }
}

/// Side of a cell of the body's distance field, m: a third of a finger.
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
    settings.check()?;
    check_placement(pattern, body)?;
    // Parallel work that is begun outside the pool wakes a thread and waits for it, each time.
    rayon::scope(|_| sew_and_relax(pattern, fabric, body, settings, observer))
}

fn sew_and_relax(
    pattern: &Pattern,
    fabric: &Fabric,
    body: &Body,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Outcome, Error> {
    let garment = Garment::build(pattern, &settings.resolutions)?;
    let field = DistanceField::new(body, FIELD_CELL, settings.clearance + FIELD_BAND);
    let arrangement = arrange(pattern, &garment.open, body);
    observer.event(&Event::Arranged { shifts: &arrangement.shifts });
    let scene = Scene { pattern, fabric, garment: &garment, body, field: &field, settings };

    let sewn = sewing::close_seams(&scene, &arrangement, observer);
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

/// What all stages look at and none changes.
struct Scene<'a> {
    pattern: &'a Pattern,
    fabric: &'a Fabric,
    garment: &'a Garment,
    body: &'a Body,
    field: &'a DistanceField,
    settings: &'a Settings,
}
