//! What a run is measured by on its way.

use super::{SLIDING, Spent};
use crate::assess::{LARGEST_STRAIN_MEAN, LARGEST_STRAIN_P99, Strain, gather_allowance};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::Termination;
use crate::pattern::Pattern;
use crate::prepositioning::{CurvePoint, Event, FinishLine, LevelSummary, Observer, Settings};

/// An accepted step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub level: usize,
    /// Evaluations on the level, energy (J, contact included) and residual.
    pub at: CurvePoint,
    pub spent: Spent,
}

/// A look at the finest level, after a run of the minimizer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// On the finest level.
    pub evaluations: usize,
    /// Less gathers.
    pub strain: Strain,
    /// While the cloth slides, J, contact included. NaN from when friction holds it and its waist line is let
    /// go: what is added then, and what is missing, makes energies no longer comparable.
    pub energy: f64,
    pub spent: Spent,
}

impl Look {
    /// Is the strain within the limits of the hand-off? All else that it asks for (clearance, nothing
    /// inside the body) is what the end of the finest level sees to.
    pub fn is_within_limits(&self) -> bool {
        self.is_within(1.0)
    }

    /// And does the garment hang as low as it is to, with at most this energy, J?
    pub fn is_settled(&self, energy: f64) -> bool {
        self.is_within_limits() && self.energy <= energy
    }

    fn is_within(&self, share: f64) -> bool {
        self.strain.p99 <= share * LARGEST_STRAIN_P99 && self.strain.mean <= share * LARGEST_STRAIN_MEAN
    }
}

/// When a run comes to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// As if nobody watched.
    Own,
    /// At the first look at which it is well within the strain's limits and has at most this energy, J.
    Settled { energy: f64, cap: usize },
    /// After so many evaluations on the finest level.
    Cap(usize),
}

/// A settled run is ended when its strain is within this share of the limits: clearing the body, which follows,
/// adds a little. The finish line itself is the limits.
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
    ending: Ending,
    until: FinishLine,
    /// Evaluations of the finest level in which the cloth slides, unless it comes to rest before.
    sliding: usize,
    /// The last step's energy, J.
    energy: f64,
    clock: &'a mut (dyn FnMut() -> Spent + Send),
    watcher: &'a mut dyn Observer,
    allowance: Option<Vec<f64>>,
    began: Spent,
    /// Spent in here, which is not the run's.
    own: Spent,
    pub set_up: Spent,
    pub sewing: Sewing,
    pub points: Vec<Point>,
    pub looks: Vec<Look>,
    /// When each level ended.
    pub level_ends: Vec<Spent>,
}

impl<'a> Recorder<'a> {
    pub fn new(
        pattern: &'a Pattern,
        ending: Ending,
        settings: &Settings,
        clock: &'a mut (dyn FnMut() -> Spent + Send),
        watcher: &'a mut dyn Observer,
    ) -> Self {
        let began = clock();
        Self {
            pattern,
            ending,
            until: settings.until,
            sliding: (SLIDING * settings.finest_evaluations as f64) as usize,
            energy: f64::NAN,
            clock,
            watcher,
            allowance: None,
            began,
            own: Spent::default(),
            set_up: Spent::default(),
            sewing: Sewing::default(),
            points: Vec::new(),
            looks: Vec::new(),
            level_ends: Vec::new(),
        }
    }

    fn strain(&mut self, cloth: &Level, positions: &[Vector3]) -> Strain {
        let allowance = self.allowance.get_or_insert_with(|| gather_allowance(self.pattern, cloth));
        Strain::of(cloth, positions, allowance)
    }

    fn record(&mut self, event: &Event, spent: Spent) {
        match *event {
            Event::GarmentStarted { .. } | Event::TogetherStarted { .. } => {}
            Event::Arranged { .. } => self.set_up = spent,
            // Where panels are arranged a second time both attempts count.
            Event::Sewn { open, evaluations, curvatures, largest_gap } => {
                let particles = open.particle_count;
                let (evaluations, curvatures) =
                    (evaluations + self.sewing.evaluations, curvatures + self.sewing.curvatures);
                self.sewing = Sewing { particles, evaluations, curvatures, largest_gap, spent };
            }
            Event::Step { level, point } => {
                self.energy = point.energy;
                self.points.push(Point { level, at: point, spent });
            }
            Event::Checked { evaluations, cloth, positions, .. } => {
                let strain = self.strain(cloth, positions);
                let energy = if self.slides() { self.energy } else { f64::NAN };
                self.looks.push(Look { evaluations, strain, energy, spent });
            }
            // Who ended because it had settled was held by friction in its last run.
            Event::LevelDone { summary, .. }
                if self.until == FinishLine::HandOff && summary.termination == Termination::Converged =>
            {
                self.looks.iter_mut().next_back().into_iter().for_each(|look| look.energy = f64::NAN);
                self.level_ends.push(spent);
            }
            Event::LevelDone { .. } => self.level_ends.push(spent),
            Event::Sewing { .. } | Event::LevelStarted { .. } => {}
        }
    }

    /// Did the cloth slide in the run of the minimizer that has just ended? It does until the look at which it
    /// has had its share, or until a run that stalled: one shorter than the first, as all have the same length.
    fn slides(&self) -> bool {
        let ends: Vec<usize> = self.looks.iter().map(|look| look.evaluations).collect();
        let length = ends.first().copied().unwrap_or(0);
        let stalled = ends.windows(2).any(|pair| pair[1] - pair[0] < length);
        !stalled && ends.last().is_none_or(|&end| end < self.sliding)
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
        let Some(look) = self.looks.last() else { return false };
        match self.ending {
            Ending::Own => false,
            Ending::Settled { energy, cap } => {
                look.evaluations >= cap || look.is_settled(energy) && look.is_within(MARGIN)
            }
            Ending::Cap(cap) => look.evaluations >= cap,
        }
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
