//! `toile compare`: the schedule of levels against rivals on one resolution, to the same finish line.

use super::arguments::{Compare, Progress, wants_equilibrium};
use super::fit::start_threads;
use super::inputs::{BodyInput, PatternInput, fabric, settings_text, tell};
use super::progress::Watcher;
use super::{Failure, Status, results};
use crate::Error;
use crate::io::comparison::{self, Comparison, Facts, comparison, minimizers, parse, run_name, to_json};
use crate::io::report::Host;
use crate::io::{atomic, length, process, read};
use crate::pattern::{Fabric, Pattern};
use crate::prepositioning::comparison::{Contest, Course, Entry, Line, Perturbation, Spent, run as run_entry};
use crate::prepositioning::{Observer, Settings};
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

const FILE: &str = "comparison.json";

pub fn run(asked: &Compare) -> Result<Status, Failure> {
    match &asked.replot {
        Some(folder) => replot(folder, asked.out.as_deref().unwrap_or(folder)),
        None => compare(asked),
    }
}

/// Table and pictures of an earlier comparison.
fn replot(folder: &Path, out: &Path) -> Result<Status, Failure> {
    let file = folder.join(FILE);
    let read = parse(&read::text(&file)?).map_err(|e| e.within(file.display()))?;
    results::prepare(out)?;
    show(&read, out)?;
    Ok(Status::Fine)
}

fn compare(asked: &Compare) -> Result<Status, Failure> {
    let started = Instant::now();
    let fabric = fabric(asked.solving.fabric.as_deref())?;
    let (settings, contest) = what_to_do(asked, &fabric)?;
    let [Some(pattern), Some(body), Some(out)] = [&asked.pattern, &asked.body, &asked.out] else {
        unreachable!("clap asks for these three unless something is drawn again");
    };
    let threads = start_threads(asked.solving.threads()?);
    let pattern = PatternInput::open_sewn(pattern, asked.seams.as_deref(), &asked.reading.options()?)?.for_fitting()?;
    let body = BodyInput::open(body, asked.align)?;
    // Better to know now than after the work that the results cannot be written.
    results::prepare(out)?;
    if let Some(alignment) = &body.alignment {
        eprintln!("body {} aligned: it is {}", body.name, alignment.describe());
    }
    let warnings: Vec<_> = pattern.warnings.iter().chain(&body.warnings).collect();
    tell(&warnings, asked.solving.progress == Progress::None);

    if asked.dynamics {
        return super::compare_dynamics::run(asked, &pattern, &body, &fabric, &settings);
    }
    let entries = contest.entries(&settings);
    let mut courses: Vec<Course> = Vec::new();
    for (number, entry) in entries.iter().enumerate() {
        announce(entry, number, entries.len(), asked.solving.progress);
        let problem = (&pattern.pattern, &fabric, &body.body);
        let settled = courses.first().map(|course| course.settled_energy);
        let course = race(&contest, (entry, settled), problem, started, asked.solving.progress);
        let course = course.map_err(|e| e.within(format!("the run \"{}\"", run_name(entry))).within(&pattern.place))?;
        conclude(&course, asked.solving.progress);
        courses.push(course);
    }
    let host = Host {
        wall_seconds: started.elapsed().as_secs_f64(),
        cpu_seconds: process::cpu_seconds(),
        peak_memory_bytes: process::peak_memory_bytes(),
        threads,
        cpu: process::cpu_name(),
        system: process::system_name(),
    };
    let made = comparison(&Facts {
        pattern_name: &pattern.pattern.name,
        pattern_sha256: &pattern.sha256,
        body_name: &body.name,
        body_sha256: &body.sha256,
        fabric_name: &fabric.name,
        settings: &settings,
        contest: &contest,
        courses: &courses,
        host: &host,
    });
    // First, so that whatever happens to the pictures they can be drawn again.
    atomic::write(&out.join(FILE), to_json(&made).as_bytes())?;
    show(&made, out)?;
    let line = Line::of(settings.until)[0];
    let reached = courses.iter().filter(|c| c.entry.schedule).all(|course| course.reached(line).is_some());
    Ok(match (reached, wants_equilibrium(&settings)) {
        (true, _) => Status::Fine,
        (false, true) => Status::BudgetSpent,
        (false, false) => Status::GateFailed,
    })
}

/// The settings and the contest that were asked for.
fn what_to_do(asked: &Compare, fabric: &Fabric) -> Result<(Settings, Contest), Failure> {
    let usage = |option: &'static str| move |e: Error| Failure::Usage(e.within(option));
    let mut settings = asked.solving.settings(settings_text(&asked.solving)?.as_deref(), fabric)?;
    if let Some(residual) = asked.residual {
        settings.equilibrium_residual = residual;
        settings.check().map_err(usage("--residual"))?;
    }
    let schedules = match &asked.minimizer {
        Some(list) => minimizers(list).map_err(usage("--minimizer"))?,
        None => vec![settings.minimizer],
    };
    if schedules.is_empty() {
        let nobody = Error::new("There is no schedule to compare the rivals with.", "Name a minimizer.");
        return Err(usage("--minimizer")(nobody));
    }
    let rivals = minimizers(&asked.rivals).map_err(usage("--rivals"))?;
    let amplitude = length::parse_or_zero(&asked.perturb).map_err(usage("--perturb"))?;
    let perturbation = asked.seed.map(|seed| Perturbation { seed, amplitude });
    perturbation.map_or(Ok(()), |p| p.check()).map_err(usage("--perturb"))?;
    let allowance = length::parse_or_zero(&asked.allowance).map_err(usage("--allowance"))?;
    let contest = Contest { schedules, rivals, cap: asked.cap, whole: asked.whole, allowance, perturbation };
    contest.check().map_err(usage(if asked.cap == 0 { "--cap" } else { "--allowance" }))?;
    Ok((settings, contest))
}

/// Makes one run, from the same processor time on as if it were alone.
fn race(
    contest: &Contest,
    (entry, settled_energy): (&Entry, Option<f64>),
    problem: (&Pattern, &Fabric, &crate::body::Body),
    started: Instant,
    progress: Progress,
) -> Result<Course, Error> {
    let mut clock = || Spent { cpu: process::cpu_seconds().unwrap_or(f64::NAN), wall: started.elapsed().as_secs_f64() };
    let mut watcher = Watcher::new(progress);
    let course = run_entry(contest, entry, settled_energy, problem, &mut clock, &mut watcher as &mut dyn Observer);
    watcher.finish();
    course
}

fn announce(entry: &Entry, number: usize, of: usize, progress: Progress) {
    match progress {
        Progress::None => {}
        Progress::Json => {
            let (name, run) = (run_name(entry), number + 1);
            eprintln!("{}", serde_json::json!({"event": "run_started", "run": run, "runs": of, "name": name}));
        }
        Progress::Auto => eprintln!("run {} of {of}: {}", number + 1, run_name(entry)),
    }
}

fn conclude(course: &Course, progress: Progress) {
    if progress != Progress::Auto {
        return;
    }
    for &line in Line::of(course.entry.settings.until) {
        let name = match line {
            Line::Strain => "little strain",
            Line::Settled => "settled",
            Line::Equilibrium => "equilibrium",
        };
        match course.reached(line) {
            Some(at) => eprintln!(
                "{name} after {:.0} fine-equivalent evaluations, {:.2} s of processor time",
                at.fine_equivalent, at.spent.cpu
            ),
            None => eprintln!(
                "{name}: not reached in {:.0} fine-equivalent evaluations, {:.2} s of processor time",
                course.whole_fine_equivalent(),
                course.total.cpu
            ),
        }
    }
}

/// Writes table and pictures, and prints the table.
fn show(made: &Comparison, out: &Path) -> Result<(), Error> {
    let page = page(made);
    atomic::write(&out.join("comparison.md"), page.as_bytes())?;
    atomic::write(&out.join("energy.svg"), comparison::energy(made).as_bytes())?;
    atomic::write(&out.join("residual.svg"), comparison::residual(made).as_bytes())?;
    atomic::write(&out.join("strain.svg"), comparison::strain(made).as_bytes())?;
    match std::io::stdout().lock().write_all(comparison::table(made).as_bytes()) {
        // Whoever closed the pipe has read enough.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(format!("The table cannot be written ({e})."), "Make room, or write it elsewhere."))
        }
        _ => Ok(()),
    }
}

/// The table with what it is of.
fn page(made: &Comparison) -> String {
    format!("{}\n{}", comparison::heading(made), comparison::table(made))
}
