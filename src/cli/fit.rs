//! `toile fit`: patterns, a body, and the folder that holds the fitted garments afterwards.

use super::arguments::{Fit, Progress, Solving, wants_equilibrium};
use super::inputs::{BodyInput, PatternInput, fabrics, settings_text, tell};
use super::place::place_all;
use super::progress::Watcher;
use super::stopwatch::Stopwatch;
use super::{Failure, Status, complaint, results};
use crate::assess::{Tight, hand_off};
use crate::check::{Finding, Given, examine, in_order};
use crate::io::process;
use crate::io::report::{Host, Solve};
use crate::minimize::Termination;
use crate::pattern::{Fabric, Pattern};
use crate::prepositioning::{Outcome, Outfit, Settings, preposition_outfit};
use crate::{Code, Error, Severity, Warning};
use std::path::Path;
use std::time::Instant;

pub fn run(asked: &Fit) -> Result<Status, Failure> {
    let started = Instant::now();
    let fabrics = fabrics(asked.solving.fabric.as_deref(), asked.patterns.len())?;
    let settings = asked.solving.settings(settings_text(&asked.solving)?.as_deref(), &fabrics[0])?;
    start_threads(asked.solving.threads()?);
    let options = asked.reading.options()?;
    if !asked.seams.is_empty() && asked.seams.len() != asked.patterns.len() {
        let problem = format!("{} files of seams are given for {} patterns.", asked.seams.len(), asked.patterns.len());
        return Err(Failure::Usage(
            Error::new(problem, "Give one for each, in the order of the patterns.").within("--seams"),
        ));
    }
    let seams = asked.seams.iter().map(|path| Some(path.as_path())).chain(std::iter::repeat(None));
    let mut patterns: Vec<PatternInput> = asked
        .patterns
        .iter()
        .zip(seams)
        .map(|(path, seams)| PatternInput::open_sewn(path, seams, &options))
        .collect::<Result<_, _>>()?;
    let mut body = BodyInput::open(&asked.body, asked.align)?;
    asked.over.iter().try_for_each(|worn| body.put_on(worn))?;
    let silent = asked.solving.progress == Progress::None;
    patterns.iter().try_for_each(PatternInput::check_sewn)?;
    place_all(&mut patterns, &body, &asked.placing, silent)?;
    fit(&patterns, &fabrics, &body, &settings, &asked.solving, &asked.out, started)
}

/// Fits on the threads that were started, writes the results into `out`, and tells how it went.
pub fn fit(
    patterns: &[PatternInput],
    fabrics: &[Fabric],
    body: &BodyInput,
    settings: &Settings,
    solving: &Solving,
    out: &Path,
    started: Instant,
) -> Result<Status, Failure> {
    let folders = results::folders(out, patterns);
    // Better to know now than after the work that the results cannot be written.
    folders.iter().try_for_each(|folder| results::prepare(folder))?;
    let silent = solving.progress == Progress::None;
    if let Some(alignment) = &body.alignment {
        // Never silently: where the results are depends on it.
        eprintln!("body {} aligned: it is {}", body.name, alignment.describe());
    }
    let found: Vec<Vec<Finding>> = (0..patterns.len())
        .map(|k| {
            // What is doubtful about the body is told once.
            let of_body: &[Warning] = if k == 0 { &body.warnings } else { &[] };
            findings(&patterns[k], of_body, body, settings, &fabrics[k])
        })
        .collect();
    let told: Vec<Vec<String>> = found
        .iter()
        .map(|findings| {
            let warnings: Vec<Warning> = findings.iter().map(|finding| Warning(finding.error.clone())).collect();
            tell(&warnings.iter().collect::<Vec<_>>(), silent)
        })
        .collect();

    let mut stopwatch = Stopwatch::start(Watcher::new(solving.progress));
    let garments: Vec<(&Pattern, &Fabric)> = patterns.iter().map(|p| &p.pattern).zip(fabrics).collect();
    let settings = &over_what_is_worn(settings, body, &fabrics[0]);
    let outfit = preposition_outfit(&garments, &body.body, settings, &mut stopwatch).map_err(|e| match patterns {
        [only] => e.within(&only.place),
        _ => e,
    })?;
    let (watcher, stages) = stopwatch.stop();
    let solve = Solve {
        stages: [body.stage.clone()].into_iter().chain(stages).collect(),
        peak_memory_bytes: process::peak_memory_bytes(),
    };
    watcher.finish();

    let host = || Host {
        wall_seconds: started.elapsed().as_secs_f64(),
        cpu_seconds: process::cpu_seconds(),
        peak_memory_bytes: process::peak_memory_bytes(),
        threads: rayon::current_num_threads(),
        cpu: process::cpu_name(),
        system: process::system_name(),
    };
    let mut statuses = Vec::new();
    for (k, folder) in folders.iter().enumerate() {
        let outcome = &outfit.garments[k];
        let run = results::Run {
            pattern: &patterns[k],
            body,
            fabric: &fabrics[k],
            settings,
            warnings: &told[k],
            findings: &found[k],
            outcome,
            solve: &solve,
        };
        let host = results::write(&run, folder, host)?;
        if !silent {
            // The verdict is the last word.
            let tight = tight_warnings(outcome, &patterns[k].pattern, &fabrics[k], body);
            tight.iter().for_each(complaint::print_warning);
            let name = if patterns.len() > 1 { format!("{}: ", patterns[k].pattern.name) } else { String::new() };
            eprintln!("{name}{}", summary(outcome, settings, &host, folder));
        }
        statuses.push(status(outcome, settings));
    }
    if patterns.len() > 1 {
        results::write_outfit(patterns, &folders, body, &outfit, out)?;
        if !silent {
            eprintln!("{}", layers_summary(&outfit, out));
        }
        if outfit.layers.pairs() > 0 {
            statuses.push(Status::GateFailed);
        }
    }
    // Of several ends the one that promises least.
    let worst = [Status::BudgetSpent, Status::GateFailed].into_iter().find(|status| statuses.contains(status));
    Ok(worst.unwrap_or(Status::Fine))
}

/// What is doubtful about a pattern and its body, by the code of `toile check`. What would cost more than a hundredth of a fit is
/// left to that: landmarks, and with them girths; where panels start, which the fit tries itself.
fn findings(
    pattern: &PatternInput,
    of_body: &[Warning],
    body: &BodyInput,
    settings: &Settings,
    fabric: &Fabric,
) -> Vec<Finding> {
    let mut findings = examine(&Given {
        pattern: &pattern.pattern,
        resolutions: &settings.resolutions,
        garment: None,
        eased: &pattern.eased,
        fabric,
        clearance: settings.clearance,
        body: Some(&body.body),
        landmarks: None,
        field: None,
    });
    findings.retain(|finding| finding.severity == Severity::Warning);
    findings.extend(pattern.warnings.iter().map(|warning| Finding::of_warning(warning, Code::LeftAside)));
    findings.extend(of_body.iter().map(|warning| Finding::of_warning(warning, Code::BodyMisplaced)));
    in_order(&mut findings);
    findings
}

/// The settings for the innermost garment: it keeps from what the body wears what two fabrics keep from each other.
fn over_what_is_worn(settings: &Settings, body: &BodyInput, fabric: &Fabric) -> Settings {
    let between = body.worn.iter().map(|worn| 0.5 * (worn.thickness + fabric.thickness)).fold(0.0, f64::max);
    Settings { clearance: settings.clearance.max(between), ..settings.clone() }
}

/// Makes the threads that everything parallel runs on; returns how many. To be called before anything is read:
/// the first parallel work, which may be the making of a body, settles how many there are.
pub fn start_threads(asked: Option<usize>) -> usize {
    if let Some(threads) = asked {
        // The pool is made once in a process; a second call, which only tests could make, keeps it.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    }
    rayon::current_num_threads()
}

fn status(outcome: &Outcome, settings: &Settings) -> Status {
    if wants_equilibrium(settings) && outcome.termination() != Termination::Converged {
        return Status::BudgetSpent;
    }
    let ready = hand_off(&outcome.assessment).iter().all(|check| check.passed);
    if ready { Status::Fine } else { Status::GateFailed }
}

/// How it went, in a few lines.
fn summary(outcome: &Outcome, settings: &Settings, host: &Host, out: &Path) -> String {
    let assessment = &outcome.assessment;
    let strain = &assessment.strain_less_gathers;
    let failed: Vec<String> = hand_off(assessment)
        .iter()
        .filter(|check| !check.passed)
        .map(|check| {
            // Counts are whole.
            let digits = if check.measured.fract() == 0.0 { 0 } else { 4 };
            format!("{} is {:.digits$}, limit {}", check.name.replace('_', " "), check.measured, check.limit)
        })
        .collect();
    let verdict = match failed.as_slice() {
        [] => "Ready for hand-off.".to_owned(),
        failed => format!("Not ready for hand-off: {}.", failed.join("; ")),
    };
    let mut lines = vec![
        verdict,
        format!(
            "  stretch mean {:.2} %, p99 {:.2} %; seams welded from {:.2} mm apart; nearest to the body {:.2} mm; crossings: {} with the body, {} of the cloth",
            strain.mean * 100.0,
            strain.p99 * 100.0,
            outcome.welded_gap.max(assessment.seams.largest) * 1e3,
            assessment.clearance.least * 1e3,
            assessment.intersections.body_pairs,
            assessment.intersections.cloth_pairs,
        ),
    ];
    if wants_equilibrium(settings) {
        let last = outcome.levels.last().expect("a garment has at least one level");
        let word = if last.termination == Termination::Converged { "reached" } else { "not reached" };
        let rms = last.residual.rms;
        lines.push(format!("  equilibrium {word}: rms residual {rms:.3} particle weights"));
    }
    let cpu = host.cpu_seconds.map_or_else(String::new, |s| format!(", {s:.1} s of processor time"));
    lines.push(format!(
        "  {} particles, {:.1} s{cpu}; results in {}",
        outcome.finest().particle_count,
        host.wall_seconds,
        out.display()
    ));
    lines.join("\n")
}

/// What is no farther than this from the middle of the body is in the middle, m.
const MIDDLE: f64 = 0.03;

/// Cloth that is stretched by more than this is not worn but caught.
const CAUGHT: f64 = 0.5;

/// What is too tight, panel by panel, and where.
fn tight_warnings(outcome: &Outcome, pattern: &Pattern, fabric: &Fabric, body: &BodyInput) -> Vec<Warning> {
    let (low, high) = body.body.bounds();
    let middle = (low + high) * 0.5;
    let warning = |tight: &Tight| {
        let side = if tight.place.z > middle.z { "front" } else { "back" };
        let beside = match tight.place.x - middle.x {
            x if x.abs() < MIDDLE => "in the middle".to_owned(),
            x => format!("{:.2} m to the {}", x.abs(), if x > 0.0 { "left" } else { "right" }),
        };
        let remedy = match tight.largest {
            largest if largest > CAUGHT => {
                "No cloth bears so much: it is caught on the body, or sewn to the wrong edge. Look at strain.png, at the seams \
                 around it (`toile seams show`), and at where its panel starts (`toile place`)."
            }
            _ => {
                "The body is larger than the garment there: take a larger size or another body, or a fabric that stretches."
            }
        };
        Warning(
            Error::new(
                format!(
                    "{:.0} % of it is stretched by more than {} bears, {:.1} % ({:.1} % at most): {:.2} m above the floor, \
                     at the {side}, {beside}.",
                    100.0 * tight.share,
                    fabric.name,
                    100.0 * fabric.stretch_limit,
                    100.0 * tight.largest,
                    tight.place.y - low.y,
                ),
                remedy,
            )
            .within(format!("panel \"{}\"", pattern.panels[tight.panel].name)),
        )
    };
    outcome.tight.iter().map(warning).collect()
}

/// How the garments lie on one another.
fn layers_summary(outfit: &Outfit, out: &Path) -> String {
    let crossings = match outfit.layers.pairs() {
        0 => "no crossings between garments".to_owned(),
        pairs => format!("NOT READY: {pairs} pairs of triangles cross between garments"),
    };
    let nearest = match outfit.layers.least_distance {
        Some(distance) => format!("the nearest are {:.2} mm apart", distance * 1e3),
        None => "they lie apart".to_owned(),
    };
    format!("All together: {crossings}; {nearest}; {}", out.display())
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Usage(error) | Failure::Input(error) => error,
        }
    }
}
