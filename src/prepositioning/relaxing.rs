//! One level: gravity, contact, and the minimizer.

use super::finish;
use super::hessian::Hessian;
use super::problem::{Relaxation, Residual};
use super::waist_line::Waist;
use super::{CurvePoint, Event, FinishLine, LevelSummary, Observer, Scene};
use crate::assess::{LARGEST_STRAIN_MEAN, LARGEST_STRAIN_P99, Strain, cloth_intersections, gather_allowance};
use crate::contact::{BodyContact, BodyContactSettings};
use crate::energy::{Energy, GRAVITY};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::{Iterate, Method, Minimizer, Newton, Problem, Settings as Steps, Termination};

/// Evaluations of one run of the minimizer; between two runs contact is corrected and anchors of
/// friction are moved. Where neither is needed, starting afresh so often still finds lower energies
/// than long runs do: the directions of a buckling garment are soon out of date.
const RUN_LENGTH: usize = 40;
/// The same for Newton's method, which gets farther with one.
const NEWTON_RUN_LENGTH: usize = 20;
/// A coarse level is done at this rms residual, in particle weights: what is left is far below what
/// the prolongation to the next level brings.
const COARSE_RESIDUAL: f64 = 0.3;
/// It is done too when a run lowers the energy by less than the garment's sinking by this height, m.
const COARSE_SINKING: f64 = 1e-4;
/// The same on the finest level, where a run is dear and friction is to have the last word, m.
const SETTLED_SINKING: f64 = 1e-3;
/// Cloth that slides by Newton's method has slid when a run lowers the energy by less than the garment's sinking by this height, m.
const SLID_SINKING: f64 = 1e-4;
/// Shares of the hand-off's limits below which the strain is clearly within them, and beyond which it would not stay within
/// them: clearing the body adds 1 to 6 % of the limit.
const CLEARLY: f64 = 0.92;
const BARELY: f64 = 0.97;
/// Strain is not expected to fall faster than in the last run by more than this factor.
const BEST_PACE: f64 = 2.0;
/// Share of the finest level's evaluations in which cloth slides without friction: a garment is
/// smoothed by the hand before it is left to itself.
const SLIDING: f64 = 0.75;

/// Relaxes a level in place; `crossing` tells how many pairs of triangles cross at its start, where that is known. Also
/// returns whether it is known that none crosses at its end.
pub fn relax(
    scene: &Scene,
    level: usize,
    waists: &[Waist],
    crossing: Option<usize>,
    positions: &mut Vec<Vector3>,
    observer: &mut dyn Observer,
) -> (LevelSummary, bool) {
    let cloth = &scene.garment.levels[level];
    let finest = level + 1 == scene.garment.levels.len();
    let budget = match (finest, scene.settings.until) {
        (false, _) => coarse_evaluations(scene.settings.coarse_evaluations, cloth.resolution),
        (true, FinishLine::HandOff) => scene.settings.finest_evaluations,
        (true, FinishLine::Equilibrium) => scene.settings.equilibrium_evaluations,
    };
    announce(scene, level, budget, observer);
    let (starting_intersections, mut problem) = rayon::join(
        || crossing.unwrap_or_else(|| cloth_intersections(cloth, positions).len()),
        || problem(scene, level, waists, positions),
    );
    let mut run = Run::new(scene, cloth);
    let termination = if finest {
        settle(scene, level, &mut problem, &mut run, positions, budget, observer)
    } else {
        coarsely(scene, level, &mut problem, &mut run, positions, budget, observer)
    };
    let residual = residual_at(&mut problem, positions);
    let summary = LevelSummary {
        resolution: cloth.resolution,
        particles: cloth.particle_count,
        triangles: cloth.triangles.len(),
        evaluations: run.evaluations,
        curvatures: run.curvatures + run.minimizer.curvatures(),
        energies: problem.terms,
        residual,
        termination,
        starting_intersections,
        curve: run.curve,
    };
    observer.event(&Event::LevelDone { level, summary: &summary, cloth, positions });
    (summary, run.uncrossed)
}

/// Relaxes the coarsest level of a garment that was sewn over others, which keep still, and takes it out of them. Returns
/// the evaluations that it took.
pub fn relax_over(scene: &Scene, waist: &Option<Waist>, positions: &mut Vec<Vector3>) -> usize {
    let cloth = &scene.garment.levels[0];
    let mut problem = problem(scene, 0, waist, positions);
    let mut run = Run::new(scene, cloth);
    let budget = coarse_evaluations(scene.settings.coarse_evaluations, cloth.resolution);
    coarsely(scene, 0, &mut problem, &mut run, positions, budget, &mut ());
    residual_at(&mut problem, positions);
    run.evaluations + finish::clear_body(scene, 0, &mut problem, &mut run.minimizer, positions).evaluations
}

fn announce(scene: &Scene, level: usize, evaluations: usize, observer: &mut dyn Observer) {
    let cloth = &scene.garment.levels[level];
    observer.event(&Event::LevelStarted {
        level,
        levels: scene.garment.levels.len(),
        resolution: cloth.resolution,
        particles: cloth.particle_count,
        evaluations,
    });
}

/// Evaluations in which the finest level slides, at most.
fn sliding_evaluations(scene: &Scene) -> usize {
    (SLIDING * scene.settings.finest_evaluations as f64) as usize
}

/// Relaxes a level but the finest: sliding, and as far as the prolongation can make use of.
fn coarsely(
    scene: &Scene,
    level: usize,
    problem: &mut Relaxation,
    run: &mut Run,
    positions: &mut Vec<Vector3>,
    budget: usize,
    observer: &mut dyn Observer,
) -> Termination {
    let cloth = &scene.garment.levels[level];
    let mut termination = Termination::Budget;
    while run.evaluations < budget && termination == Termination::Budget {
        let most = RUN_LENGTH.min(budget - run.evaluations);
        termination = run.steps(scene, level, problem, positions, most, observer);
        if run.fallen < COARSE_SINKING * weight(problem) {
            break;
        }
    }
    if level == 0 && scene.settings.minimizer == Method::Newton && termination != Termination::Converged {
        termination = run.swing(scene, problem, positions, observer);
    }
    if termination == Termination::Converged || scene.settings.minimizer != Method::Newton {
        return termination;
    }
    if ends_by_newton(scene) {
        // The nearer a level starts to its rest, the fewer dear steps it takes to get there.
        run.by_newton(scene, level, problem);
        termination = run.steps(scene, level, problem, positions, COARSE_NEWTON_EVALUATIONS, observer);
    } else if cloth.resolution < COARSELY_CLIMBING_RESOLUTION {
        if is_too_tight(scene, level, positions) {
            run.climb_to_fit(scene, level, problem, positions, observer);
        }
    } else if strain_excess(scene, level, positions) > TIGHT {
        termination = run.climb(scene, level, problem, positions, observer);
    }
    termination
}

/// Evaluations in which the coarsest level swings to where it hangs, at most, and steps that are remembered there. A
/// skirt whose panels stood out around the legs has a quarter of a circle to go, along a valley that is curved and
/// shallow: conjugate gradients end on its side, and what is left there no finer level makes up for.
const SWING_EVALUATIONS: usize = 800;
const SWING_MEMORY: usize = 20;
/// It hangs when so many evaluations lower it by less than this, m.
const SWING_WINDOW: usize = 100;
const SWING_SINKING: f64 = 3e-4;

/// Evaluations of Newton's method on a level but the finest, on the way to equilibrium, and at most where tight cloth climbs.
const COARSE_NEWTON_EVALUATIONS: usize = 400;

/// Finer levels, whose chords follow the body better, take back some of the strain of a coarse one, but often not as much
/// as this share of its limits beyond them: then the cloth sits where the body is too wide for it.
const TIGHT: f64 = 0.3;
/// It climbs while a run of Newton's method lowers the energy by the garment's sinking by this height, m.
const CLIMBING: f64 = 1e-3;
/// That far only on levels at least as coarse as this, m, where a run takes less than half a second.
const COARSELY_CLIMBING_RESOLUTION: f64 = 0.015;
/// On finer levels than this, m, Newton's method takes longer than all the rest.
const LEAST_CLIMBING_RESOLUTION: f64 = 0.0075;
/// Runs of Newton's method in which cloth on these levels is to come within the limits of strain, at most.
const MOST_CLIMBS: usize = 3;

/// Relaxes the finest level: sliding at first, held by friction in the end, and clear of the body.
///
/// Contact is corrected and anchors are moved between runs of the minimizer, and the balance that is
/// asked for has to hold afterwards.
fn settle(
    scene: &Scene,
    level: usize,
    problem: &mut Relaxation,
    run: &mut Run,
    positions: &mut Vec<Vector3>,
    mut budget: usize,
    observer: &mut dyn Observer,
) -> Termination {
    let settings = scene.settings;
    let sliding = sliding_evaluations(scene);
    let balanced = |problem: &mut Relaxation, positions: &[Vector3]| {
        settings.until == FinishLine::Equilibrium
            && residual_at(problem, positions).rms <= settings.equilibrium_residual
    };
    let (mut let_go, mut settled, mut clearings, mut stalled) = (false, false, 0, 0);
    while run.evaluations < budget && !observer.enough() {
        let most = if run.newton.is_some() { NEWTON_RUN_LENGTH } else { RUN_LENGTH }.min(budget - run.evaluations);
        let termination = run.steps(scene, level, problem, positions, most, observer);
        let cloth = &scene.garment.levels[level];
        observer.event(&Event::Checked { level, evaluations: run.evaluations, cloth, positions });
        // Cloth finds its place by sliding; in the end it stays there by friction alone.
        settled |= !let_go && is_settled(scene, level, problem, run, positions, sliding);
        // Conjugate gradients crawl where tight cloth would climb, and friction would hold it half-way.
        if ends_by_newton(scene) && run.newton.is_none() && run.fallen < SETTLED_SINKING * weight(problem) {
            run.by_newton(scene, level, problem);
        }
        let slid = run.newton.is_some() && run.fallen < SLID_SINKING * weight(problem);
        let settles = settled || slid || run.evaluations >= sliding || termination != Termination::Budget;
        if !let_go && settles {
            let_go = true;
            if is_too_tight(scene, level, positions) {
                run.climb_to_fit(scene, level, problem, positions, observer);
            }
            // What is clear before the last runs finds its balance in them.
            run.evaluations += finish::clear_body(scene, level, problem, &mut run.minimizer, positions).evaluations;
            if settled {
                budget = run.evaluations + RUN_LENGTH;
            }
            problem.body.settings.friction = scene.fabric.friction;
            // Cloth on cloth has no friction: what is worn over something else would slip.
            if scene.garments == 1 {
                problem.energy.holds.clear();
            }
            problem.update_diagonal();
            if ends_by_newton(scene) && run.newton.is_none() {
                run.by_newton(scene, level, problem);
            }
        }
        // The last trial may have been rejected; contact is to be that of the positions.
        residual_at(problem, positions);
        problem.body.correct(positions);
        problem.body.update_anchors(positions);
        if balanced(problem, positions) {
            // In a crease of the body there may be no place that is clear of both its sides; a state in
            // balance that crosses nothing is then the better one.
            if clearings >= MOST_CLEARINGS && finish::is_clear(scene, level, positions) {
                return Termination::Converged;
            }
            let clearing = finish::clear_body(scene, level, problem, &mut run.minimizer, positions);
            run.evaluations += clearing.evaluations;
            if !clearing.moved {
                return Termination::Converged;
            }
            clearings += 1;
        }
        // Corrected contact may give way once more.
        stalled = if termination == Termination::Stalled { stalled + 1 } else { 0 };
        if stalled > MOST_STALLS {
            break;
        }
    }
    run.evaluations += finish::clear_body(scene, level, problem, &mut run.minimizer, positions).evaluations;
    let mut excess = SLIGHT_EXCESS;
    for left in (1..=MOST_SECOND_LOOKS).rev() {
        let before = std::mem::replace(&mut excess, strain_excess(scene, level, positions));
        let hopeless = excess >= BEST_PACE * left as f64 * (before - excess);
        if settings.until != FinishLine::HandOff || excess <= 0.0 || hopeless {
            break;
        }
        finish::let_nearer(scene, level, problem, positions);
        run.steps(scene, level, problem, positions, RUN_LENGTH, observer);
        residual_at(problem, positions);
        problem.body.correct(positions);
        problem.body.update_anchors(positions);
        run.evaluations += finish::clear_body(scene, level, problem, &mut run.minimizer, positions).evaluations;
    }
    run.evaluations += finish::part_layers(scene, level, problem, &mut run.minimizer, positions);
    let (evaluations, uncrossed) = finish::part_crossings(scene, level, problem, &mut run.minimizer, positions);
    run.evaluations += evaluations;
    run.uncrossed = uncrossed;
    match (balanced(problem, positions) || settled, stalled > MOST_STALLS) {
        (true, _) => Termination::Converged,
        (false, true) => Termination::Stalled,
        (false, false) => Termination::Budget,
    }
}

/// Is cloth that slides on the finest level ready to be left to itself? It hardly sinks any more, and its strain is
/// clearly within the limits of the hand-off, or so far beyond them that at twice its pace it would not come within
/// them in the evaluations that are left of those for `sliding`: then the garment is too tight.
fn is_settled(
    scene: &Scene,
    level: usize,
    problem: &Relaxation,
    run: &mut Run,
    positions: &[Vector3],
    sliding: usize,
) -> bool {
    if scene.settings.until != FinishLine::HandOff || run.fallen > SETTLED_SINKING * weight(problem) {
        return false;
    }
    let cloth = &scene.garment.levels[level];
    let strain = Strain::of(cloth, positions, &gather_allowance(scene.pattern, cloth));
    let before = run.strain.replace(strain);
    let runs_left = sliding.saturating_sub(run.evaluations) as f64 / RUN_LENGTH as f64;
    let too_tight = |before: f64, now: f64, limit: f64| now - BEST_PACE * runs_left * (before - now) > BARELY * limit;
    let too_tight = before.is_some_and(|before| {
        too_tight(before.p99, strain.p99, LARGEST_STRAIN_P99)
            || too_tight(before.mean, strain.mean, LARGEST_STRAIN_MEAN)
    });
    too_tight || strain.p99 < CLEARLY * LARGEST_STRAIN_P99 && strain.mean < CLEARLY * LARGEST_STRAIN_MEAN
}

/// Would the hand-off fail by the strain, and may Newton's method help?
fn is_too_tight(scene: &Scene, level: usize, positions: &[Vector3]) -> bool {
    scene.settings.until == FinishLine::HandOff
        && scene.settings.minimizer == Method::Newton
        && scene.garment.levels[level].resolution >= LEAST_CLIMBING_RESOLUTION
        && strain_excess(scene, level, positions) > BARELY - 1.0
}

/// By which share of its limits the hand-off's strain is beyond them; negative within.
fn strain_excess(scene: &Scene, level: usize, positions: &[Vector3]) -> f64 {
    let cloth = &scene.garment.levels[level];
    let strain = Strain::of(cloth, positions, &gather_allowance(scene.pattern, cloth));
    (strain.p99 / LARGEST_STRAIN_P99).max(strain.mean / LARGEST_STRAIN_MEAN) - 1.0
}

/// An excess below which cloth that has just been taken out of the body may give way that much: it is worth another run,
/// and one more while the pace of the last would end it. The first gains 0.01 to 0.02, those after it less.
const SLIGHT_EXCESS: f64 = 0.015;
/// How many such runs there are at most.
const MOST_SECOND_LOOKS: usize = 8;

/// N.
fn weight(problem: &Relaxation) -> f64 {
    problem.energy.masses().iter().sum::<f64>() * GRAVITY
}

fn ends_by_newton(scene: &Scene) -> bool {
    scene.settings.until == FinishLine::Equilibrium && scene.settings.minimizer == Method::Newton
}

/// How often in succession a run may stall before the level is given up.
const MOST_STALLS: usize = 3;
/// How often a balanced state is moved for the last of its clearance.
const MOST_CLEARINGS: usize = 4;

fn residual_at(problem: &mut Relaxation, positions: &[Vector3]) -> Residual {
    let mut gradient = vec![Vector3::zeros(); positions.len()];
    problem.evaluate(positions, &mut gradient);
    Residual::of(&gradient, problem.energy.masses())
}

/// What is coarse is cheap and has the larger way to go: `most` evaluations from
/// [`FULL_BUDGET`] upwards, and in proportion below.
fn coarse_evaluations(most: usize, resolution: f64) -> usize {
    (most as f64 * (resolution / FULL_BUDGET).min(1.0)).ceil() as usize
}

/// Resolution from which a coarse level has all the evaluations granted, m.
const FULL_BUDGET: f64 = 0.02;

/// What is minimized on a level while cloth slides: without friction, waist lines held.
pub fn problem<'a, 'w>(
    scene: &Scene<'a>,
    level: usize,
    waists: impl IntoIterator<Item = &'w Waist>,
    positions: &[Vector3],
) -> Relaxation<'a> {
    let (settings, cloth) = (scene.settings, &scene.garment.levels[level]);
    let mut energy = Energy::new(cloth, scene.cut, settings.model);
    energy.holds.extend(waists.into_iter().filter_map(|waist| waist.hold(scene, level, positions)));
    let finest = level + 1 == scene.garment.levels.len();
    let contact = BodyContactSettings {
        clearance: if finest { settings.clearance } else { settings.coarse_clearance() },
        stiffness: scene.fabric.contact_stiffness(),
        friction: 0.0,
    };
    let contact = BodyContact::new(scene.body, scene.field, cloth, contact);
    let classes = (0..cloth.particle_count as u32).collect();
    Relaxation::new(energy, contact, settings.self_contact(cloth, classes, scene.fabric, positions))
}

/// The minimizer's memory and what it has done on a level.
struct Run {
    minimizer: Minimizer,
    /// Takes over where the first is too slow.
    newton: Option<Newton>,
    evaluations: usize,
    /// Of minimizers before this one.
    curvatures: usize,
    /// By how much the last run lowered the energy, J.
    fallen: f64,
    /// A run ends when it lowers the energy by less than this in [`SWING_WINDOW`] evaluations, J.
    least_fall: f64,
    /// When it was last measured.
    strain: Option<Strain>,
    /// No cloth crosses cloth any more, as the last look has found.
    uncrossed: bool,
    curve: Vec<CurvePoint>,
}

impl Run {
    fn new(scene: &Scene, cloth: &Level) -> Self {
        let minimizer = Minimizer::new(scene.settings.minimizer, cloth.particle_count);
        Self {
            minimizer,
            newton: None,
            evaluations: 0,
            curvatures: 0,
            fallen: f64::INFINITY,
            least_fall: f64::NEG_INFINITY,
            strain: None,
            uncrossed: false,
            curve: Vec::new(),
        }
    }

    /// Lets the coarsest level hang out, in one long run of L-BFGS.
    fn swing(
        &mut self,
        scene: &Scene,
        problem: &mut Relaxation,
        positions: &mut Vec<Vector3>,
        observer: &mut dyn Observer,
    ) -> Termination {
        let cloth = &scene.garment.levels[0];
        self.curvatures += self.minimizer.curvatures();
        self.minimizer = Minimizer::lbfgs(cloth.particle_count, SWING_MEMORY);
        self.least_fall = SWING_SINKING * weight(problem);
        self.steps(scene, 0, problem, positions, SWING_EVALUATIONS, observer);
        self.least_fall = f64::NEG_INFINITY;
        let balanced = self.curve.last().is_some_and(|point| point.residual <= COARSE_RESIDUAL);
        if balanced { Termination::Converged } else { Termination::Budget }
    }

    /// Lets cloth that is too tight where it sits find where it is less so. A narrow skirt climbs the hips by
    /// centimetres, all of it at once: conjugate gradients crawl there, by so little that they seem to be done.
    fn climb(
        &mut self,
        scene: &Scene,
        level: usize,
        problem: &mut Relaxation,
        positions: &mut Vec<Vector3>,
        observer: &mut dyn Observer,
    ) -> Termination {
        self.by_newton(scene, level, problem);
        let last = self.evaluations + COARSE_NEWTON_EVALUATIONS;
        loop {
            let termination = self.steps(scene, level, problem, positions, NEWTON_RUN_LENGTH, observer);
            let climbs = self.fallen >= CLIMBING * weight(problem);
            if termination != Termination::Budget || !climbs || self.evaluations >= last {
                return termination;
            }
        }
    }

    /// The same where a run takes as long as all conjugate gradients before it: only while the strain promises to come
    /// within the limits of the hand-off so.
    fn climb_to_fit(
        &mut self,
        scene: &Scene,
        level: usize,
        problem: &mut Relaxation,
        positions: &mut Vec<Vector3>,
        observer: &mut dyn Observer,
    ) {
        self.by_newton(scene, level, problem);
        let mut excess = strain_excess(scene, level, positions);
        for left in (0..MOST_CLIMBS).rev() {
            let termination = self.steps(scene, level, problem, positions, NEWTON_RUN_LENGTH, observer);
            let before = std::mem::replace(&mut excess, strain_excess(scene, level, positions));
            let best = excess - BEST_PACE * left as f64 * (before - excess);
            if termination != Termination::Budget || excess < CLEARLY - 1.0 || best > BARELY - 1.0 {
                break;
            }
        }
        (self.newton, problem.hessian) = (None, None);
    }

    /// From now on steps are Newton's.
    fn by_newton(&mut self, scene: &Scene, level: usize, problem: &mut Relaxation) {
        let cloth = &scene.garment.levels[level];
        problem.hessian = Some(Hessian::new(cloth, scene.cut, scene.settings.model));
        self.newton = Some(Newton::new(cloth.particle_count));
    }

    fn steps(
        &mut self,
        scene: &Scene,
        level: usize,
        problem: &mut Relaxation,
        positions: &mut Vec<Vector3>,
        evaluations: usize,
        observer: &mut dyn Observer,
    ) -> Termination {
        let finest = level + 1 == scene.garment.levels.len();
        let goal = match (finest, scene.settings.until) {
            (false, _) => COARSE_RESIDUAL,
            (true, FinishLine::HandOff) => 0.0,
            // What is corrected between runs disturbs the balance a little.
            (true, FinishLine::Equilibrium) => 0.5 * scene.settings.equilibrium_residual,
        };
        let steps = Steps { evaluations, ..scene.settings.steps(&scene.garment.levels[level]) };
        let masses = problem.energy.masses().clone();
        let before = self.evaluations;
        let first = self.curve.len();
        let (curve, least_fall) = (&mut self.curve, self.least_fall);
        let done = |iterate: &Iterate| {
            let residual = Residual::of(iterate.gradient, &masses).rms;
            let point = CurvePoint { evaluations: before + iterate.evaluations, energy: iterate.value, residual };
            curve.push(point);
            observer.event(&Event::Step { level, point });
            let earlier = || curve[first..].iter().rev().find(|p| p.evaluations + SWING_WINDOW <= point.evaluations);
            residual <= goal
                || least_fall > 0.0 && earlier().is_some_and(|earlier| earlier.energy - point.energy < least_fall)
        };
        let (termination, _, spent) = match &mut self.newton {
            Some(newton) => newton.run(problem, positions, &steps, done),
            None => self.minimizer.run(problem, positions, &steps, done),
        };
        self.evaluations += spent;
        self.fallen = self.curve[first].energy - self.curve[self.curve.len() - 1].energy;
        termination
    }
}
