//! The schedule of levels against one level alone, to the same finish line.
//!
//! What is compared: the same pattern, body, fabric and settings, once through all levels and then on the
//! finest level alone, by one minimizer after the other. Seams close on the coarsest level there is, so
//! for a rival on the finest. All count from flat panels; an evaluation counts by the particles of
//! its level. What is measured on the way (strain, the clock itself) is not charged to the run.
//!
//! On the way to the hand-off there are two finish lines, each met by the first state of the finest level, looked at
//! every forty evaluations, that is beyond it. [`Line::Strain`] asks for strain within the limits of the hand-off
//! alone. A single level meets it when its seams have just closed and nothing hangs yet as it will, so that
//! [`Line::Settled`] asks for the energy besides in which the first schedule ends, but for an allowance. The schedule
//! itself runs as if nobody watched, a rival until it is settled or the cap is reached; the end of the level then
//! sees to the rest, and is judged too. The finish line of the equilibrium is what ends such a run by itself.

mod perturbation;
mod recorder;

pub use perturbation::{LARGEST_AMPLITUDE, Perturbation};
pub use recorder::{Look, Point, Sewing};

use super::{FinishLine, LevelSummary, Observer, Outcome, Settings, preposition_from};
use crate::Error;
use crate::assess::{Check, Strain, hand_off};
use crate::body::Body;
use crate::energy::GRAVITY;
use crate::minimize::{Method, Termination};
use crate::pattern::{Fabric, Pattern};
use recorder::{Ending, Recorder, fine_equivalent};

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
    /// Evaluations on the finest level after which a rival is given up, and a schedule on its way to equilibrium.
    pub cap: usize,
    /// Does a rival go on to the cap after it has settled, for whole curves?
    pub whole: bool,
    /// How much higher than the schedule leaves it a settled garment may hang on average, m: see [`Line::Settled`].
    pub allowance: f64,
    pub perturbation: Option<Perturbation>,
}

/// [`Contest::allowance`] unless another is asked for, m: less than the thickness of cloth shows.
pub const DEFAULT_ALLOWANCE: f64 = 5e-4;

/// Where a run is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// The strain is within the limits of the hand-off.
    Strain,
    /// That, and the energy of the sliding cloth, contact included, is at most that in which the first schedule's
    /// cloth slid last, with an allowance for minima that differ: [`Contest::allowance`] times the weight.
    Settled,
    /// The forces are in balance.
    Equilibrium,
}

impl Line {
    /// Those on the way to a finish line.
    pub fn of(until: FinishLine) -> &'static [Line] {
        match until {
            FinishLine::HandOff => &[Line::Strain, Line::Settled],
            FinishLine::Equilibrium => &[Line::Equilibrium],
        }
    }
}

/// Share of [`Settings::finest_evaluations`] in which the cloth slides: `SLIDING` of `relaxing.rs`.
const SLIDING: f64 = 0.75;

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
        if !(0.0..=LARGEST_ALLOWANCE).contains(&self.allowance) {
            return Err(Error::new(
                format!("With an allowance of {} mm nothing is told apart.", self.allowance * 1e3),
                format!("Give one from 0 mm to {} mm.", LARGEST_ALLOWANCE * 1e3),
            ));
        }
        self.perturbation.map_or(Ok(()), |perturbation| perturbation.check())
    }

    /// The runs in their order: the schedule by each minimizer, then the rivals.
    pub fn entries(&self, settings: &Settings) -> Vec<Entry> {
        let entry = |&minimizer: &Method, schedule: bool| {
            let mut settings = Settings { minimizer, equilibrium_evaluations: self.cap, ..settings.clone() };
            if !schedule {
                if settings.until == FinishLine::HandOff {
                    // Of these the first three quarters are spent sliding: all until the cap, so that energies
                    // can be compared. On the way to the equilibrium they stay what they are.
                    settings.finest_evaluations = self.cap.saturating_mul(2);
                }
                settings.resolutions.drain(..settings.resolutions.len() - 1);
            }
            Entry { schedule, settings }
        };
        let schedules = self.schedules.iter().map(|m| entry(m, true));
        schedules.chain(self.rivals.iter().map(|m| entry(m, false))).collect()
    }
}

/// Above this, m, a garment whose seams have just closed is settled.
const LARGEST_ALLOWANCE: f64 = 0.1;

/// What a run did.
pub struct Course {
    pub entry: Entry,
    pub sewing: Sewing,
    /// Coarsest first.
    pub levels: Vec<LevelSummary>,
    pub points: Vec<Point>,
    pub looks: Vec<Look>,
    /// From flat panels to where the seams begin to close: meshes, distances, arrangement.
    pub set_up: Spent,
    pub total: Spent,
    /// Of the whole garment, N.
    pub weight: f64,
    /// The most with which it is settled, J; NaN without a schedule to tell.
    pub settled_energy: f64,
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

/// Makes one run. `settled_energy`, J, is that of the first schedule, none for that schedule itself. `clock` tells
/// what this process has spent so far.
pub fn run(
    contest: &Contest,
    entry: &Entry,
    settled_energy: Option<f64>,
    (pattern, fabric, body): (&Pattern, &Fabric, &Body),
    clock: &mut (dyn FnMut() -> Spent + Send),
    watcher: &mut dyn Observer,
) -> Result<Course, Error> {
    contest.check()?;
    let ending = match (entry.settings.until, contest.whole) {
        _ if entry.schedule => Ending::Own,
        (FinishLine::Equilibrium, _) => Ending::Own,
        (FinishLine::HandOff, true) => Ending::Cap(contest.cap),
        (FinishLine::HandOff, false) => {
            Ending::Settled { energy: settled_energy.unwrap_or(f64::NAN), cap: contest.cap }
        }
    };
    let settings = if ending == Ending::Own { entry.settings.clone() } else { endless(&entry.settings) };
    let mut recorder = Recorder::new(pattern, ending, &settings, clock, watcher);
    let disturb = |positions: &mut [_]| {
        if let Some(perturbation) = &contest.perturbation {
            perturbation.disturb(positions);
        }
    };
    let outcome: Outcome = preposition_from(pattern, fabric, body, &settings, &disturb, &mut recorder)?;
    let total = recorder.total();
    let Recorder { set_up, sewing, points, looks, .. } = recorder;
    let area: f64 = outcome.finest().particle_areas().iter().sum();
    let weight = area * fabric.areal_density * GRAVITY;
    let own = || slid_last(&looks) + contest.allowance * weight;
    Ok(Course {
        settled_energy: settled_energy.unwrap_or_else(own),
        entry: entry.clone(),
        sewing,
        points,
        looks,
        set_up,
        total,
        weight,
        strain: outcome.assessment.strain_less_gathers,
        hand_off: hand_off(&outcome.assessment),
        levels: outcome.levels,
    })
}

/// Settings with which a run on the way to the hand-off is ended by whoever watches it, and not because it sinks but
/// slowly: that is what an equilibrium which is never reached does.
fn endless(settings: &Settings) -> Settings {
    let minimizer = match settings.minimizer {
        // The same, up to the hand-off.
        Method::Newton => Method::ConjugateGradient,
        other => other,
    };
    let never = f64::MIN_POSITIVE;
    Settings { minimizer, until: FinishLine::Equilibrium, equilibrium_residual: never, ..settings.clone() }
}

/// The energy in which cloth slid last, J.
fn slid_last(looks: &[Look]) -> f64 {
    looks.iter().rev().map(|look| look.energy).find(|energy| !energy.is_nan()).unwrap_or(f64::NAN)
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

    /// Where the run met a finish line, if it did.
    pub fn reached(&self, line: Line) -> Option<Reached> {
        let first = |met: &dyn Fn(&Look) -> bool| {
            self.looks.iter().find(|look| met(look)).map(|look| (look.evaluations, look.spent))
        };
        let (evaluations, spent) = match line {
            Line::Strain => first(&Look::is_within_limits)?,
            Line::Settled => first(&|look| look.is_settled(self.settled_energy))?,
            Line::Equilibrium => {
                let done = self.finest().termination == Termination::Converged;
                done.then(|| (self.finest().evaluations, self.total))?
            }
        };
        let finest = self.levels.len() - 1;
        Some(Reached { evaluations, fine_equivalent: self.fine_equivalent(finest, evaluations), spent })
    }

    /// The energy in which the run ended, J, contact included: on the way to the hand-off that in which its cloth
    /// slid last.
    pub fn final_energy(&self) -> f64 {
        match self.entry.settings.until {
            FinishLine::HandOff => slid_last(&self.looks),
            FinishLine::Equilibrium => self.points.last().map_or(f64::NAN, |point| point.at.energy),
        }
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
            allowance: DEFAULT_ALLOWANCE,
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
            // The schedule runs as it would for itself; whoever is alone may slide until the cap.
            let granted = if entry.schedule { settings.finest_evaluations } else { 1000 };
            assert_eq!((entry.settings.finest_evaluations, entry.settings.equilibrium_evaluations), (granted, 500));
        }
        let settings = Settings { until: FinishLine::Equilibrium, ..settings };
        let granted = |entry: &Entry| entry.settings.finest_evaluations == settings.finest_evaluations;
        assert!(contest().entries(&settings).iter().all(granted));
        assert!(Contest { allowance: f64::NAN, ..contest() }.check().is_err());
        assert!(Contest { cap: 0, ..contest() }.check().is_err());
    }

    #[test]
    fn cloth_slides_as_long_as_relaxing_says() {
        let relaxing = include_str!("../relaxing.rs");
        assert!(relaxing.contains(&format!("const SLIDING: f64 = {SLIDING};")));
    }

    /// A look at a moment, within the limits of the strain or not.
    fn look(evaluations: usize, energy: f64, within: bool) -> Look {
        let strain = Strain { p99: if within { 0.01 } else { 0.2 }, ..Strain::default() };
        Look { evaluations, strain, energy, spent: Spent::default() }
    }

    #[test]
    fn settled_is_who_is_low_and_within_the_limits_while_it_slides() {
        assert!(look(40, -1.0, true).is_settled(-1.0));
        assert!(!look(40, -0.9, true).is_settled(-1.0));
        assert!(!look(40, -1.0, false).is_settled(-1.0));
        assert!(!look(40, f64::NAN, true).is_settled(-1.0) && !look(40, -1.0, true).is_settled(f64::NAN));
        assert_eq!(slid_last(&[look(40, -1.0, true), look(80, -2.0, true), look(120, f64::NAN, true)]), -2.0);
        assert!(slid_last(&[]).is_nan());
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
