//! What a run is measured by on its way.

use super::Spent;
use crate::assess::{LARGEST_STRAIN_MEAN, LARGEST_STRAIN_P99, Strain, gather_allowance};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::pattern::Pattern;
use crate::prepositioning::{CurvePoint, Event, LevelSummary, Observer};

/// An accepted step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub level: usize,
    /// Evaluations on the level, energy (J, contact included) and residual.
    pub at: CurvePoint,
    pub spent: Spent,
}

/// Strain at a moment of the finest level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrainPoint {
    /// On the finest level.
    pub evaluations: usize,
    /// Less gathers.
    pub strain: Strain,
    pub spent: Spent,
}

impl StrainPoint {
    /// Is the strain within the limits of the hand-off? All else that it asks for (clearance, nothing
    /// inside the body) is what the end of the finest level sees to.
    pub fn is_within_limits(&self) -> bool {
        self.is_within(1.0)
    }

    fn is_within(&self, share: f64) -> bool {
        self.strain.p99 <= share * LARGEST_STRAIN_P99 && self.strain.mean <= share * LARGEST_STRAIN_MEAN
    }
}

/// A run is ended when its strain is within this share of the limits: clearing the body, which follows, adds a
/// little. The finish line itself is the limits.
const MARGIN: f64 = 0.98;

/// What closing the seams took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sewing {
    /// Points of the open level.
    pub particles: usize,
    pub evaluations: usize,
    pub curvatures: usize,
    /// When the seams were welded, m.
    pub largest_gap: f64,
    pub spent: Spent,
}

/// Records a run, and ends it at the finish line if it is to.
pub struct Recorder<'a> {
    pattern: &'a Pattern,
    /// Is a state whose strain is well within the limits enough?
    stop_at_limits: bool,
    clock: &'a mut (dyn FnMut() -> Spent + Send),
    watcher: &'a mut dyn Observer,
    allowance: Option<Vec<f64>>,
    began: Spent,
    /// Spent in here, which is not the run's.
    own: Spent,
    pub set_up: Spent,
    pub sewing: Sewing,
    pub points: Vec<Point>,
    pub strains: Vec<StrainPoint>,
    /// When each level ended.
    pub level_ends: Vec<Spent>,
}

impl<'a> Recorder<'a> {
    pub fn new(
        pattern: &'a Pattern,
        stop_at_limits: bool,
        clock: &'a mut (dyn FnMut() -> Spent + Send),
        watcher: &'a mut dyn Observer,
    ) -> Self {
        let began = clock();
        Self {
            pattern,
            stop_at_limits,
            clock,
            watcher,
            allowance: None,
            began,
            own: Spent::default(),
            set_up: Spent::default(),
            sewing: Sewing::default(),
            points: Vec::new(),
            strains: Vec::new(),
            level_ends: Vec::new(),
        }
    }

    fn strain(&mut self, cloth: &Level, positions: &[Vector3]) -> Strain {
        let allowance = self.allowance.get_or_insert_with(|| gather_allowance(self.pattern, cloth));
        Strain::of(cloth, positions, allowance)
    }

    fn record(&mut self, event: &Event, spent: Spent) {
        match *event {
            Event::Arranged { .. } => self.set_up = spent,
            Event::Sewn { open, evaluations, curvatures, largest_gap } => {
                let particles = open.particle_count;
                self.sewing = Sewing { particles, evaluations, curvatures, largest_gap, spent };
            }
            Event::Step { level, point } => self.points.push(Point { level, at: point, spent }),
            Event::Checked { evaluations, cloth, positions, .. } => {
                let strain = self.strain(cloth, positions);
                self.strains.push(StrainPoint { evaluations, strain, spent });
            }
            Event::LevelDone { .. } => self.level_ends.push(spent),
            Event::Sewing { .. } | Event::LevelStarted { .. } => {}
        }
    }

    /// What was spent until the end.
    pub fn total(&self) -> Spent {
        self.level_ends.last().copied().unwrap_or_default()
    }
}

impl Observer for Recorder<'_> {
    fn event(&mut self, event: &Event) {
        let now = (self.clock)();
        self.record(event, now.since(self.began).since(self.own));
        self.watcher.event(event);
        let spent_here = (self.clock)().since(now);
        self.own = self.own.and(spent_here);
    }

    fn enough(&mut self) -> bool {
        self.stop_at_limits && self.strains.last().is_some_and(|point| point.is_within(MARGIN))
    }
}

/// Evaluations on all levels up to `evaluations` on level `level`, sewing included, each counted by the
/// particles that it moves: evaluations on the finest level that would cost as much.
pub fn fine_equivalent(sewing: &Sewing, levels: &[LevelSummary], level: usize, evaluations: usize) -> f64 {
    let finest = levels.last().map_or(1, |l| l.particles.max(1)) as f64;
    let before: f64 = levels[..level].iter().map(|l| (l.evaluations * l.particles) as f64).sum();
    let here = levels.get(level).map_or(0, |l| l.particles) * evaluations;
    ((sewing.evaluations * sewing.particles) as f64 + before + here as f64) / finest
}
