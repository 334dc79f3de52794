//! `toile compare --dynamics`: how long the explicit simulator takes to come to rest from where it is started.

use super::arguments::Compare;
use super::inputs::{BodyInput, PatternInput};
use super::{Failure, Status, results};
use crate::Error;
use crate::arrangement::placed;
use crate::dynamics::{MOVING_CLEARANCE, Resting, Settings as Dynamics, Simulation, Surface, come_to_rest, sew};
use crate::garment::{Garment, Level};
use crate::geometry::Vector3;
use crate::io::{atomic, length};
use crate::minimize::Method;
use crate::pattern::Fabric;
use crate::prepositioning::{FinishLine, Settings, preposition, waist_line};
use serde_json::json;
use std::fmt::Write as _;
use std::io::Write as _;

/// The longest that cloth is waited for, simulated s.
const MOST: f64 = 12.0;

/// One start and what came of it.
struct Start {
    name: &'static str,
    /// Evaluations of the energy before the release: all levels together, and of those on the finest.
    evaluations: usize,
    finest: usize,
    /// Steps in which seams were sewn by dynamics.
    sewing_steps: usize,
    /// Why it did not get so far as to be released.
    failed: Option<String>,
    resting: Option<Resting>,
}

impl Start {
    fn steps(&self) -> Option<usize> {
        self.resting.filter(|r| r.at_rest).map(|r| self.sewing_steps + r.steps)
    }
}

pub fn run(
    asked: &Compare,
    pattern: &PatternInput,
    body: &BodyInput,
    fabric: &Fabric,
    settings: &Settings,
) -> Result<Status, Failure> {
    let out = asked.out.as_ref().expect("clap asks for it");
    results::prepare(out)?;
    let dynamics = Dynamics { clearance: settings.clearance.max(MOVING_CLEARANCE), ..Dynamics::default() };
    let surface = || Surface::new(body.body.positions(), body.body.triangles(), dynamics.broad_phase);
    let release = |level: &Level, positions: Vec<Vector3>, fitted: bool| {
        let mut surface = surface();
        let waist = waist_line(&pattern.pattern, level, &positions);
        let mut simulation = Simulation::new(level, fabric, fabric, settings.model, &dynamics, positions);
        if fitted {
            simulation.take_over(&surface);
        }
        simulation.hold_waist(&surface, &waist);
        come_to_rest(&mut simulation, &mut surface, dynamics.settle, MOST)
    };
    let finest = *settings.resolutions.last().expect("there is a level");
    let single = |minimizer: Method| Settings { minimizer, ..with_levels(settings, vec![finest]) };
    let fits = [
        ("all levels", settings.clone()),
        ("all levels, to equilibrium", Settings { until: FinishLine::Equilibrium, ..settings.clone() }),
        ("one level", single(settings.minimizer)),
        ("one level by mass-scaled dynamic relaxation", single(Method::DynamicRelaxation)),
    ];
    let mut starts = Vec::new();
    for (name, settings) in fits {
        eprintln!("{name}");
        let outcome = preposition(&pattern.pattern, fabric, &body.body, &settings, &mut ())
            .map_err(|e| e.within(&pattern.place))?;
        let evaluations = outcome.levels.iter().map(|l| l.evaluations).sum::<usize>() + outcome.sewing_evaluations;
        let alone = outcome.levels.len() == 1;
        let of_finest = outcome.levels.last().map_or(0, |l| l.evaluations);
        starts.push(Start {
            name,
            evaluations,
            finest: of_finest + if alone { outcome.sewing_evaluations } else { 0 },
            sewing_steps: 0,
            failed: None,
            resting: Some(release(outcome.finest(), outcome.positions.clone(), true)),
        });
    }
    eprintln!("panels as they are placed");
    let garment = Garment::build(&pattern.pattern, &[finest]).map_err(|e| e.within(&pattern.place))?;
    let start = placed(&pattern.pattern, &garment.open);
    let sewing = sew(&garment, fabric, settings.model, &dynamics, &mut surface(), start, MOST);
    let finite = sewing.positions.iter().all(|p| p.iter().all(|x| x.is_finite()));
    let failed = match (sewing.closed, finite) {
        (true, true) => None,
        (_, false) => Some("it flew apart while the seams closed".to_owned()),
        (false, _) => Some(format!("a seam stayed open by {:.0} mm", sewing.largest_gap * 1e3)),
    };
    starts.push(Start {
        name: "panels as they are placed",
        evaluations: 0,
        finest: 0,
        sewing_steps: sewing.steps,
        resting: failed.is_none().then(|| release(&garment.levels[0], sewing.positions.clone(), false)),
        failed,
    });
    conclude(pattern, body, fabric, finest, &starts, out)
}

fn with_levels(settings: &Settings, resolutions: Vec<f64>) -> Settings {
    Settings { resolutions, ..settings.clone() }
}

fn conclude(
    pattern: &PatternInput,
    body: &BodyInput,
    fabric: &Fabric,
    resolution: f64,
    starts: &[Start],
    out: &std::path::Path,
) -> Result<Status, Failure> {
    let ours = starts[0].steps();
    let mut table = format!(
        "{} on {}, {}, {}\n\n| start | evaluations before, all levels / finest | steps to rest | simulated | against ours | fastest while it settled, and in 0.1 s after that |\n|---|---|---|---|---|---|\n",
        pattern.pattern.name,
        body.name,
        fabric.name,
        length::describe(resolution)
    );
    for start in starts {
        let (steps, time, speed) = match (&start.failed, start.resting) {
            (Some(failed), _) => (format!("{failed}, after {} steps", start.sewing_steps), "-".into(), "-".into()),
            (None, Some(r)) if r.at_rest => (
                format!("{}", start.sewing_steps + r.steps),
                format!("{:.2} s", r.time),
                format!("{:.2}, {:.2} m/s", r.settling_speed, r.first_speed),
            ),
            (None, Some(r)) => (
                format!("not in {} (still {:.1} mm/s)", start.sewing_steps + r.steps, r.last_speed * 1e3),
                format!("{:.2} s", r.time),
                format!("{:.2}, {:.2} m/s", r.settling_speed, r.first_speed),
            ),
            (None, None) => ("-".into(), "-".into(), "-".into()),
        };
        let ratio = match (ours, start.steps()) {
            (Some(ours), Some(steps)) => format!("{:.1}", steps as f64 / ours.max(1) as f64),
            _ => "-".to_owned(),
        };
        let _ = writeln!(
            table,
            "| {} | {} / {} | {steps} | {time} | {ratio} | {speed} |",
            start.name, start.evaluations, start.finest
        );
    }
    let value = json!({
        "schema": "toile-dynamics-comparison/1",
        "pattern": pattern.pattern.name,
        "body": body.name,
        "fabric": fabric.name,
        "resolution_m": resolution,
        "starts": starts.iter().map(|s| json!({
            "name": s.name,
            "evaluations": s.evaluations,
            "finest_evaluations": s.finest,
            "sewing_steps": s.sewing_steps,
            "failed": s.failed,
            "at_rest": s.resting.map(|r| r.at_rest),
            "steps": s.resting.map(|r| s.sewing_steps + r.steps),
            "simulated_s": s.resting.map(|r| r.time),
            "settling_speed_m_s": s.resting.map(|r| r.settling_speed),
            "first_speed_m_s": s.resting.map(|r| r.first_speed),
            "last_rms_speed_m_s": s.resting.map(|r| r.last_speed),
        })).collect::<Vec<_>>(),
    });
    atomic::write(&out.join("dynamics.json"), format!("{value:#}\n").as_bytes())?;
    atomic::write(&out.join("dynamics.md"), table.as_bytes())?;
    match std::io::stdout().lock().write_all(table.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(format!("The table cannot be written ({e})."), "Make room, or write it elsewhere.").into())
        }
        _ => Ok(if ours.is_some() { Status::Fine } else { Status::BudgetSpent }),
    }
}
