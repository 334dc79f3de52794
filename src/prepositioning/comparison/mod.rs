//! The schedule of levels against one level alone, to the same finish line.
//!
//! What is compared: the same pattern, body, fabric and settings, once through all levels and then on the
//! finest level alone, by one minimizer after the other. Seams close on the coarsest level there is, so
//! for a rival on the finest. All count from flat panels; an evaluation counts by the particles of
//! its level. What is measured on the way (strain, the clock itself) is not charged to the run.
//!
//! The finish line of [`FinishLine::HandOff`] is the first state, looked at every forty evaluations of the
//! finest level, whose strain is within the limits of the hand-off; then the end of the level sees to the
//! rest, and is judged too. That of [`FinishLine::Equilibrium`] is what ends such a run by itself.

mod perturbation;
mod recorder;

pub use perturbation::{LARGEST_AMPLITUDE, Perturbation};
pub use recorder::{Point, Sewing, StrainPoint};

use super::{FinishLine, LevelSummary, Observer, Outcome, Settings, preposition_from};
use crate::Error;
use crate::assess::{Check, Strain, hand_off};
use crate::body::Body;
use crate::energy::GRAVITY;
use crate::minimize::{Method, Termination};
use crate::pattern::{Fabric, Pattern};
use recorder::{Recorder, fine_equivalent};

/// Processor seconds of all threads, and seconds of the clock on the wall. NaN where the system does not tell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    pub cpu: f64,
    pub wall: f64,
}

impl Spent {
    pub fn since(self, earlier: Spent) -> Spent {
        Spent { cpu: self.cpu - earlier.cpu, wall: self.wall - earlier.wall }
    }

    fn and(self, more: Spent) -> Spent {
        Spent { cpu: self.cpu + more.cpu, wall: self.wall + more.wall }
    }
}

/// Who runs, and how far.
#[derive(Clone, Debug)]
pub struct Contest {
    /// Minimizers that go through all levels.
    pub schedules: Vec<Method>,
    /// Minimizers that have the finest level alone.
    pub rivals: Vec<Method>,
    /// Evaluations on the finest level after which a run is given up.
    pub cap: usize,
    /// Does a run go on to the cap after the finish line of the hand-off, for whole curves?
    pub whole: bool,
    pub perturbation: Option<Perturbation>,
}

/// One run to be made.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Through all levels, rather than on the finest alone?
    pub schedule: bool,
    pub settings: Settings,
}

impl Contest {
    pub fn check(&self) -> Result<(), Error> {
        if self.cap == 0 {
            return Err(Error::new("With no evaluation nothing moves.", "Give a cap from 1, such as 20000."));
        }
        self.perturbation.map_or(Ok(()), |perturbation| perturbation.check())
    }

    /// The runs in their order: the schedule by each minimizer, then the rivals.
    pub fn entries(&self, settings: &Settings) -> Vec<Entry> {
        let entry = |&minimizer: &Method, schedule: bool| {
            let mut settings = Settings { minimizer, equilibrium_evaluations: self.cap, ..settings.clone() };
            if settings.until == FinishLine::HandOff {
                // The sliding that comes before friction takes its share of this: whoever is granted more
                // evaluations may slide longer. On the way to the equilibrium it stays what it is.
                settings.finest_evaluations = self.cap;
            }
            if !schedule {
                settings.resolutions.drain(..settings.resolutions.len() - 1);
            }
            Entry { schedule, settings }
        };
        let schedules = self.schedules.iter().map(|m| entry(m, true));
        schedules.chain(self.rivals.iter().map(|m| entry(m, false))).collect()
    }
}

/// What a run did.
pub struct Course {
    pub entry: Entry,
    pub sewing: Sewing,
    /// Coarsest first.
    pub levels: Vec<LevelSummary>,
    pub points: Vec<Point>,
    pub strains: Vec<StrainPoint>,
    /// From flat panels to where the seams begin to close: meshes, distances, arrangement.
    pub set_up: Spent,
    pub total: Spent,
    /// Of the whole garment, N.
    pub weight: f64,
    /// Where the run ended, less gathers.
    pub strain: Strain,
    pub hand_off: Vec<Check>,
}

/// Where a run met the finish line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// On the finest level.
    pub evaluations: usize,
    /// On all levels and for the seams, see [`Course::fine_equivalent`].
    pub fine_equivalent: f64,
    pub spent: Spent,
}

/// Makes one run. `clock` tells what this process has spent so far.
pub fn run(
    contest: &Contest,
    entry: &Entry,
    (pattern, fabric, body): (&Pattern, &Fabric, &Body),
    clock: &mut (dyn FnMut() -> Spent + Send),
    watcher: &mut dyn Observer,
) -> Result<Course, Error> {
    contest.check()?;
    let stop_at_limits = entry.settings.until == FinishLine::HandOff && !contest.whole;
    let mut recorder = Recorder::new(pattern, stop_at_limits, clock, watcher);
    let disturb = |positions: &mut [_]| {
        if let Some(perturbation) = &contest.perturbation {
            perturbation.disturb(positions);
        }
    };
    let outcome: Outcome = preposition_from(pattern, fabric, body, &entry.settings, &disturb, &mut recorder)?;
    let total = recorder.total();
    let Recorder { set_up, sewing, points, strains, .. } = recorder;
    let area: f64 = outcome.finest().particle_areas().iter().sum();
    Ok(Course {
        entry: entry.clone(),
        sewing,
        points,
        strains,
        set_up,
        total,
        weight: area * fabric.areal_density * GRAVITY,
        strain: outcome.assessment.strain_less_gathers,
        hand_off: hand_off(&outcome.assessment),
        levels: outcome.levels,
    })
}

impl Course {
    pub fn finest(&self) -> &LevelSummary {
        self.levels.last().expect("a garment has at least one level")
    }

    /// Evaluations up to some on a level, each counted by the particles that it moves: evaluations on the
    /// finest level that would cost as much. Closing the seams is included.
    pub fn fine_equivalent(&self, level: usize, evaluations: usize) -> f64 {
        fine_equivalent(&self.sewing, &self.levels, level, evaluations)
    }

    /// All evaluations of the run, counted like that.
    pub fn whole_fine_equivalent(&self) -> f64 {
        self.fine_equivalent(self.levels.len() - 1, self.finest().evaluations)
    }

    /// Where the run met its finish line, if it did.
    pub fn reached(&self) -> Option<Reached> {
        let finest = self.levels.len() - 1;
        let (evaluations, spent) = match self.entry.settings.until {
            FinishLine::HandOff => {
                let first = self.strains.iter().find(|point| point.is_within_limits())?;
                (first.evaluations, first.spent)
            }
            FinishLine::Equilibrium => {
                let done = self.finest().termination == Termination::Converged;
                done.then(|| (self.finest().evaluations, self.total))?
            }
        };
        Some(Reached { evaluations, fine_equivalent: self.fine_equivalent(finest, evaluations), spent })
    }

    /// The last energy of the finest level, J, contact included.
    pub fn final_energy(&self) -> f64 {
        self.points.last().map_or(f64::NAN, |point| point.at.energy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contest() -> Contest {
        Contest {
            schedules: vec![Method::ConjugateGradient],
            rivals: vec![Method::Lbfgs, Method::DynamicRelaxation],
            cap: 500,
            whole: false,
            perturbation: None,
        }
    }

    #[test]
    fn rivals_have_the_finest_level_alone_and_all_else_alike() {
        let settings = Settings { clearance: 0.002, ..Settings::for_resolution(0.01) };
        let entries = contest().entries(&settings);
        let levels: Vec<usize> = entries.iter().map(|e| e.settings.resolutions.len()).collect();
        assert_eq!(levels, [3, 1, 1]);
        for entry in &entries {
            assert_eq!(entry.settings.resolutions.last(), Some(&0.01));
            let back = Settings {
                resolutions: settings.resolutions.clone(),
                minimizer: settings.minimizer,
                finest_evaluations: settings.finest_evaluations,
                equilibrium_evaluations: settings.equilibrium_evaluations,
                ..entry.settings.clone()
            };
            assert_eq!(format!("{back:?}"), format!("{settings:?}"));
            assert_eq!((entry.settings.finest_evaluations, entry.settings.equilibrium_evaluations), (500, 500));
        }
        assert!(Contest { cap: 0, ..contest() }.check().is_err());
    }

    #[test]
    fn evaluations_count_by_the_particles_that_they_move() {
        let level = |particles, evaluations| LevelSummary {
            resolution: 0.01,
            particles,
            triangles: 0,
            evaluations,
            curvatures: 0,
            energies: Default::default(),
            residual: Default::default(),
            termination: Termination::Budget,
            starting_intersections: 0,
            curve: Vec::new(),
        };
        let sewing = Sewing { particles: 110, evaluations: 1000, ..Sewing::default() };
        let levels = [level(100, 200), level(400, 50)];
        assert_eq!(fine_equivalent(&sewing, &levels, 0, 20), (110_000.0 + 2_000.0) / 400.0);
        assert_eq!(fine_equivalent(&sewing, &levels, 1, 50), (110_000.0 + 20_000.0 + 20_000.0) / 400.0);
    }
}
