//! `toile fit`: a pattern, a body, and the folder that holds the fitted garment afterwards.

use super::arguments::{Fit, Progress, Solving, wants_equilibrium};
use super::inputs::{BodyInput, PatternInput, fabric, settings_text, tell};
use super::progress::Watcher;
use super::stopwatch::Stopwatch;
use super::{Failure, Status, results};
use crate::Error;
use crate::assess::hand_off;
use crate::io::process;
use crate::io::report::{Host, Solve};
use crate::minimize::Termination;
use crate::prepositioning::{Outcome, Settings, preposition};
use std::path::Path;
use std::time::Instant;

pub fn run(asked: &Fit) -> Result<Status, Failure> {
    let started = Instant::now();
    let settings = asked.solving.settings(settings_text(&asked.solving)?.as_deref())?;
    start_threads(asked.solving.threads()?);
    let pattern = PatternInput::open(&asked.pattern)?;
    let body = BodyInput::open(&asked.body)?;
    fit(&pattern, &body, &settings, &asked.solving, &asked.out, started)
}

/// Fits on the threads that were started, writes the results into `out`, and tells how it went.
pub fn fit(
    pattern: &PatternInput,
    body: &BodyInput,
    settings: &Settings,
    solving: &Solving,
    out: &Path,
    started: Instant,
) -> Result<Status, Failure> {
    let fabric = fabric(solving.fabric.as_deref())?;
    // Better to know now than after the work that the results cannot be written.
    results::prepare(out)?;
    let silent = solving.progress == Progress::None;
    let warnings: Vec<_> = pattern.warnings.iter().chain(&body.warnings).collect();
    let warnings = tell(&warnings, silent);

    let mut stopwatch = Stopwatch::start(Watcher::new(solving.progress));
    let outcome = preposition(&pattern.pattern, &fabric, &body.body, settings, &mut stopwatch)
        .map_err(|e| e.within(&pattern.place))?;
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
    let run = results::Run {
        pattern,
        body,
        fabric: &fabric,
        settings,
        warnings: &warnings,
        outcome: &outcome,
        solve: &solve,
    };
    let host = results::write(&run, out, host)?;
    if solving.progress != Progress::None {
        eprintln!("{}", summary(&outcome, settings, &host, out));
    }
    Ok(status(&outcome, settings))
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
        .map(|check| format!("{} is {:.4}, limit {}", check.name.replace('_', " "), check.measured, check.limit))
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

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Usage(error) | Failure::Input(error) => error,
        }
    }
}
