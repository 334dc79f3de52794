//! What a run tells on its way, and what it gives.

use super::Residual;
use crate::assess::{Assessment, Tight};
use crate::energy::Terms;
use crate::garment::{Garment, Level};
use crate::geometry::Vector3;
use crate::minimize::Termination;

/// What happens during a run, for whoever watches.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// Work on one of several garments began, the innermost being the first.
    GarmentStarted { garment: usize, garments: usize, name: &'a str },
    /// All garments are fitted one over the other; now they are relaxed together.
    TogetherStarted { garments: usize },
    /// How far the panels were moved to clear the body from their seams, m, one per panel.
    Arranged { shifts: &'a [Vector3] },
    /// A step of closing the seams ended with this largest gap, m.
    Sewing { step: usize, closing_steps: usize, largest_gap: f64, open: &'a Level, positions: &'a [Vector3] },
    /// All seams are closed, with this largest gap, m, and after so many evaluations and curvatures.
    Sewn { open: &'a Level, evaluations: usize, curvatures: usize, largest_gap: f64 },
    /// Work on a level began.
    LevelStarted { level: usize, levels: usize, resolution: f64, particles: usize, evaluations: usize },
    /// A step was accepted.
    Step { level: usize, point: CurvePoint },
    /// A run of the minimizer on the finest level ended here; the next may follow.
    Checked { level: usize, evaluations: usize, cloth: &'a Level, positions: &'a [Vector3] },
    /// Work on a level ended.
    LevelDone { level: usize, summary: &'a LevelSummary, cloth: &'a Level, positions: &'a [Vector3] },
}

/// Watches a run, from one of the threads that work on it.
pub trait Observer: Send {
    fn event(&mut self, event: &Event);

    /// Asked before each run of the minimizer on the finest level: is it good enough already? The level
    /// then comes to its end at once. What answers by the clock gives up that the same input gives the
    /// same bytes.
    fn enough(&mut self) -> bool {
        false
    }
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
    /// Curvatures along directions that the minimizer asked for, but for those while the body is cleared.
    pub curvatures: usize,
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
    /// Panels that are stretched beyond the limit of the fabric.
    pub tight: Vec<Tight>,
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
