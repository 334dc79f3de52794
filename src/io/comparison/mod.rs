//! `comparison.json`: what the schedule and its rivals did on one problem, with all curves, so that table
//! and pictures can be made of it again.
//!
//! Everything but the object `times` is the same, byte for byte, for the same input, on any number of
//! threads. A number that is not finite is `null`. `docs/formats.md` tells the fields one by one.

mod charts;
mod parts;
mod table;

pub use charts::{energy, residual, strain};
pub use parts::*;
pub use table::{heading, table};

use super::report::{Host, settings_part, termination_word};
use super::settings_toml::{finish_line_word, minimizer_word};
use super::toml_keys::remedy_for_key;
use crate::Error;
use crate::assess::{LARGEST_STRAIN_MEAN, LARGEST_STRAIN_P99};
use crate::prepositioning::comparison::{Contest, Course, Line, Reached, Spent};
use crate::prepositioning::{FinishLine, LevelSummary, Settings};

const FORMAT: &str = "toile comparison";
const VERSION: u32 = 2;

/// What a comparison is made of.
pub struct Facts<'a> {
    pub pattern_name: &'a str,
    /// Hexadecimal, of the pattern file.
    pub pattern_sha256: &'a str,
    pub body_name: &'a str,
    /// Hexadecimal, of the body file.
    pub body_sha256: &'a str,
    pub fabric_name: &'a str,
    /// As asked for; the runs differ from them by levels, minimizer and cap.
    pub settings: &'a Settings,
    pub contest: &'a Contest,
    pub courses: &'a [Course],
    pub host: &'a Host,
}

/// The comparison of some runs.
pub fn comparison(facts: &Facts) -> Comparison {
    let settings = facts.settings;
    let lowest = facts.courses.iter().map(Course::final_energy).fold(f64::INFINITY, f64::min);
    let hand_off = settings.until == FinishLine::HandOff;
    let names = names(facts.courses);
    let first = facts.courses.first();
    Comparison {
        format: FORMAT.to_owned(),
        version: VERSION,
        toile_version: env!("CARGO_PKG_VERSION").to_owned(),
        inputs: InputsPart {
            pattern: InputPart { name: facts.pattern_name.to_owned(), sha256: facts.pattern_sha256.to_owned() },
            body: InputPart { name: facts.body_name.to_owned(), sha256: facts.body_sha256.to_owned() },
            fabric: facts.fabric_name.to_owned(),
        },
        settings: serde_json::to_value(settings_part(settings)).expect("a struct of numbers and words is JSON"),
        finish_line: FinishPart {
            until: finish_line_word(settings.until).to_owned(),
            residual_weights: (!hand_off).then_some(settings.equilibrium_residual),
            strain_p99: hand_off.then_some(LARGEST_STRAIN_P99),
            strain_mean: hand_off.then_some(LARGEST_STRAIN_MEAN),
            settled_energy_j: first.filter(|_| hand_off).map(|c| c.settled_energy),
            allowance_m: hand_off.then_some(facts.contest.allowance),
        },
        cap: facts.contest.cap,
        whole: facts.contest.whole,
        perturbation: facts.contest.perturbation.map(|p| PerturbationPart { seed: p.seed, amplitude_m: p.amplitude }),
        weight_n: first.map_or(f64::NAN, |c| c.weight),
        lowest_energy_j: lowest,
        runs: facts.courses.iter().zip(&names).map(|(course, name)| run_part((course, name), first, lowest)).collect(),
        times: TimesPart {
            host: facts.host.clone(),
            runs: facts.courses.iter().zip(names).map(|(course, name)| times_part(course, name, first)).collect(),
        },
    }
}

/// The text of the file.
pub fn to_json(comparison: &Comparison) -> String {
    // serde_json writes what is not finite as null.
    serde_json::to_string_pretty(comparison).expect("structs of numbers and strings are JSON") + "\n"
}

/// Reads a file of [`to_json`] back.
pub fn parse(text: &str) -> Result<Comparison, Error> {
    let again = "Name the folder of a finished comparison, or make the comparison again.";
    let read: Comparison = serde_json::from_str(text.trim_start_matches('\u{feff}'))
        .map_err(|e| Error::new(format!("It is no comparison that toile wrote: {e}."), again))?;
    if read.format != FORMAT {
        return Err(Error::new(format!("It is no comparison, but says that it is {:?}.", read.format), again));
    }
    if read.version != VERSION {
        return Err(Error::new(
            format!("It is of version {}, of which this toile knows nothing.", read.version),
            format!("Use the toile {:?} that wrote it, or make the comparison again.", read.toile_version),
        ));
    }
    read.check().map_err(|problem| Error::new(problem, again))?;
    Ok(read)
}

/// The minimizers that a list such as `lbfgs, dynamic-relaxation` names; none for `none`.
pub fn minimizers(list: &str) -> Result<Vec<crate::minimize::Method>, Error> {
    if list.trim() == NOBODY {
        return Ok(Vec::new());
    }
    let mut methods = Vec::new();
    for word in list.split(',').map(str::trim) {
        let method = super::settings_toml::minimizer(word).map_err(|_| {
            let known: Vec<&str> =
                crate::minimize::Method::ALL.map(minimizer_word).into_iter().chain([NOBODY]).collect();
            Error::new(format!("The minimizer \"{word}\" is not known."), remedy_for_key(word, &known))
        })?;
        if methods.contains(&method) {
            return Err(Error::new(format!("The minimizer \"{word}\" is named twice."), "Name each once."));
        }
        methods.push(method);
    }
    Ok(methods)
}

/// The word for an empty list of minimizers.
const NOBODY: &str = "none";

/// What to call a run.
pub fn run_name(course: &crate::prepositioning::comparison::Entry) -> String {
    let levels = if course.schedule { "multi-resolution" } else { "single resolution" };
    format!("{levels}, {}", minimizer_word(course.settings.minimizer))
}

fn names(courses: &[Course]) -> Vec<String> {
    courses.iter().map(|course| run_name(&course.entry)).collect()
}

/// What is told of each finish line, of what is known where it was met, and where the first schedule met it.
fn lines<T>(course: &Course, first: Option<&Course>, told: impl Fn(Reached, Option<Reached>) -> T) -> LinesPart<T> {
    let until = course.entry.settings.until;
    let at = |line: Line| {
        let reached = Line::of(until).contains(&line).then(|| course.reached(line)).flatten()?;
        Some(told(reached, first.and_then(|first| first.reached(line))))
    };
    LinesPart { strain: at(Line::Strain), settled: at(Line::Settled), equilibrium: at(Line::Equilibrium) }
}

fn run_part((course, name): (&Course, &str), first: Option<&Course>, lowest: f64) -> RunPart {
    let gap = course.final_energy() - lowest;
    let above = course.final_energy() - first.map_or(f64::NAN, Course::final_energy);
    let failed = course.hand_off.iter().filter(|check| !check.passed);
    let mut curve = CurvePart::default();
    for point in kept(course) {
        curve.level.push(point.level);
        curve.evaluations.push(point.at.evaluations);
        curve.fine_equivalent.push(course.fine_equivalent(point.level, point.at.evaluations));
        curve.energy_j.push(point.at.energy);
        curve.residual_weights.push(point.at.residual);
    }
    let mut strain = StrainCurvePart::default();
    for point in &course.looks {
        strain.evaluations.push(point.evaluations);
        strain.fine_equivalent.push(course.fine_equivalent(course.levels.len() - 1, point.evaluations));
        strain.mean.push(point.strain.mean);
        strain.p99.push(point.strain.p99);
        strain.max.push(point.strain.max);
        strain.within_limits.push(point.is_within_limits());
        strain.energy_j.push(point.energy);
        strain.settled.push(point.is_settled(course.settled_energy));
    }
    RunPart {
        name: name.to_owned(),
        schedule: course.entry.schedule,
        minimizer: minimizer_word(course.entry.settings.minimizer).to_owned(),
        sewing: SewingPart {
            particles: course.sewing.particles,
            evaluations: course.sewing.evaluations,
            curvatures: course.sewing.curvatures,
            welded_gap_m: course.sewing.largest_gap,
        },
        levels: course.levels.iter().map(level_part).collect(),
        fine_equivalent: course.whole_fine_equivalent(),
        reached: lines(course, first, |Reached { evaluations, fine_equivalent, .. }, first| ReachedPart {
            evaluations,
            fine_equivalent,
            ratio: first.map(|first| fine_equivalent / first.fine_equivalent),
        }),
        end: EndPart {
            energy_j: course.final_energy(),
            energy_gap_j: gap,
            energy_gap_height_m: gap / course.weight,
            above_schedule_m: above / course.weight,
            residual_weights: course.finest().residual.rms,
            strain_mean: course.strain.mean,
            strain_p99: course.strain.p99,
            strain_max: course.strain.max,
            failed_checks: failed.map(|check| check.name.to_owned()).collect(),
        },
        curve,
        strain,
    }
}

fn level_part(level: &LevelSummary) -> LevelPart {
    LevelPart {
        resolution_m: level.resolution,
        particles: level.particles,
        evaluations: level.evaluations,
        curvatures: level.curvatures,
        termination: termination_word(level.termination).to_owned(),
    }
}

fn times_part(course: &Course, name: String, first: Option<&Course>) -> RunTimesPart {
    let part = |spent: Spent| SpentPart { cpu_seconds: spent.cpu, wall_seconds: spent.wall };
    let columns = |spent: Vec<Spent>| SpentColumns {
        cpu_seconds: spent.iter().map(|s| s.cpu).collect(),
        wall_seconds: spent.iter().map(|s| s.wall).collect(),
    };
    RunTimesPart {
        name,
        set_up: part(course.set_up),
        sewn: part(course.sewing.spent),
        reached: lines(course, first, |reached, first| ReachedTimesPart {
            spent: part(reached.spent),
            cpu_ratio: first.map(|first| reached.spent.cpu / first.spent.cpu),
        }),
        total: part(course.total),
        curve: columns(kept(course).map(|point| point.spent).collect()),
        strain: columns(course.looks.iter().map(|point| point.spent).collect()),
    }
}

/// The points of a curve that a file keeps: all at first, then those by which evaluations of a level have
/// grown by a hundredth; what is seen on a logarithmic scale.
fn kept(course: &Course) -> impl Iterator<Item = &crate::prepositioning::comparison::Point> {
    const GROWTH: f64 = 1.01;
    let points = &course.points;
    let mut last: Option<(usize, usize)> = None;
    points.iter().enumerate().filter_map(move |(k, point)| {
        let (level, evaluations) = (point.level, point.at.evaluations);
        let ends = points.get(k + 1).is_none_or(|next| next.level != level);
        let far = last.is_none_or(|(l, e)| l != level || evaluations as f64 >= GROWTH * e as f64);
        (ends || far).then(|| {
            last = Some((level, evaluations));
            point
        })
    })
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Two runs: a schedule that reached its line, and a rival that did not.
    pub fn example() -> Comparison {
        let level = |resolution_m, particles, evaluations| LevelPart {
            resolution_m,
            particles,
            evaluations,
            curvatures: evaluations - 1,
            termination: "budget".to_owned(),
        };
        let reached =
            |evaluations, fine_equivalent, ratio| ReachedPart { evaluations, fine_equivalent, ratio: Some(ratio) };
        let run = |schedule: bool| {
            let count = if schedule { 3 } else { 4 };
            RunPart {
                name: if schedule { "multi-resolution, lbfgs" } else { "single resolution, lbfgs" }.to_owned(),
                schedule,
                minimizer: "lbfgs".to_owned(),
                sewing: SewingPart { particles: 110, evaluations: 1000, curvatures: 990, welded_gap_m: 1e-4 },
                levels: if schedule {
                    vec![level(0.02, 100, 300), level(0.01, 400, 40)]
                } else {
                    vec![level(0.01, 400, 500)]
                },
                fine_equivalent: if schedule { 390.0 } else { 1500.0 },
                // The rival has little strain soon, but hangs too high.
                reached: LinesPart {
                    strain: Some(if schedule { reached(40, 390.0, 1.0) } else { reached(20, 1020.0, 2.6154) }),
                    settled: schedule.then(|| reached(40, 390.0, 1.0)),
                    equilibrium: None,
                },
                end: EndPart {
                    energy_j: -1.0,
                    energy_gap_j: if schedule { 0.0 } else { 2.5e-3 },
                    energy_gap_height_m: if schedule { 0.0 } else { 1e-3 },
                    above_schedule_m: if schedule { 0.0 } else { 1e-3 },
                    residual_weights: f64::NAN,
                    strain_mean: 0.004,
                    strain_p99: 0.03,
                    strain_max: 0.06,
                    failed_checks: if schedule { Vec::new() } else { vec!["particles_inside".to_owned()] },
                },
                curve: CurvePart {
                    level: (0..count).map(|k| usize::from(schedule && k > 0)).collect(),
                    evaluations: (0..count).map(|k| 1 + 10 * k).collect(),
                    fine_equivalent: (0..count).map(|k| 350.0 + 10.0 * k as f64).collect(),
                    energy_j: (0..count).map(|k| -1.0 + 0.1 / (k + 1) as f64).collect(),
                    residual_weights: (0..count).map(|k| 10.0 / (k + 1) as f64).collect(),
                },
                strain: StrainCurvePart {
                    evaluations: vec![20, 40],
                    fine_equivalent: vec![370.0, 390.0],
                    mean: vec![if schedule { 0.02 } else { 0.005 }, 0.004],
                    p99: vec![if schedule { 0.08 } else { 0.04 }, 0.03],
                    max: vec![0.2, 0.06],
                    within_limits: vec![!schedule, true],
                    energy_j: vec![-0.9, if schedule { -1.0 } else { f64::NAN }],
                    settled: vec![false, schedule],
                },
            }
        };
        let times = |name: &str, points: usize, strain: f64, settled: Option<f64>| {
            let at = |s: f64| SpentPart { cpu_seconds: s, wall_seconds: 0.6 * s };
            let columns = |count: usize| SpentColumns {
                cpu_seconds: (0..count).map(|k| 1.0 + k as f64).collect(),
                wall_seconds: (0..count).map(|k| 0.6 + k as f64).collect(),
            };
            RunTimesPart {
                name: name.to_owned(),
                set_up: at(0.1),
                sewn: at(0.5),
                reached: LinesPart {
                    strain: Some(ReachedTimesPart { spent: at(strain), cpu_ratio: Some(strain / 3.0) }),
                    settled: settled.map(|s| ReachedTimesPart { spent: at(s), cpu_ratio: Some(s / 3.0) }),
                    equilibrium: None,
                },
                total: at(5.0),
                curve: columns(points),
                strain: columns(2),
            }
        };
        Comparison {
            format: FORMAT.to_owned(),
            version: VERSION,
            toile_version: "0.1.0".to_owned(),
            inputs: InputsPart {
                pattern: InputPart { name: "tee".to_owned(), sha256: "ab".to_owned() },
                body: InputPart { name: "ball".to_owned(), sha256: "cd".to_owned() },
                fabric: "neutral".to_owned(),
            },
            settings: serde_json::json!({"clearance_m": 0.0007}),
            finish_line: FinishPart {
                until: "handoff".to_owned(),
                residual_weights: None,
                strain_p99: Some(0.05),
                strain_mean: Some(0.01),
                settled_energy_j: Some(-0.99875),
                allowance_m: Some(5e-4),
            },
            cap: 500,
            whole: false,
            perturbation: None,
            weight_n: 2.5,
            lowest_energy_j: -1.0,
            runs: vec![run(true), run(false)],
            times: TimesPart {
                host: Host { threads: 2, ..Host::default() },
                runs: vec![
                    times("multi-resolution, lbfgs", 3, 3.0, Some(3.0)),
                    times("single resolution, lbfgs", 4, 4.5, None),
                ],
            },
        }
    }

    #[test]
    fn a_comparison_reads_back_as_it_was_written() {
        let text = to_json(&example());
        assert_eq!(to_json(&parse(&text).unwrap()), text);
        assert!(text.contains("\"residual_weights\": null"));
    }

    #[test]
    fn what_is_no_comparison_is_refused_with_a_reason() {
        let text = to_json(&example());
        let cases = [
            (text[..text.len() / 2].to_owned(), "EOF"),
            (String::new(), "EOF"),
            ("[]".to_owned(), "comparison"),
            (text.replacen("toile comparison", "toile report", 1), "toile report"),
            (text.replacen("\"version\": 2", "\"version\": 7", 1), "version 7"),
            (text.replacen("\"within_limits\": [", "\"within_limits\": [true, ", 1), "lengths"),
            (text.replacen("\"level\": [\n", "\"level\": [99, \n", 1), "lengths"),
        ];
        for (bad, word) in cases {
            let error = parse(&bad).unwrap_err();
            assert!(error.problem().contains(word), "{word}: {error}");
            assert!(!error.remedy().is_empty());
        }
    }

    #[test]
    fn lists_of_minimizers_are_read_or_told_how() {
        use crate::minimize::Method;
        assert_eq!(minimizers("lbfgs, argmin-lbfgs").unwrap(), [Method::Lbfgs, Method::ArgminLbfgs]);
        assert!(minimizers("none").unwrap().is_empty());
        assert!(minimizers("lbgfs").unwrap_err().remedy().contains("lbfgs"));
        assert!(minimizers("").unwrap_err().remedy().contains("conjugate-gradient"));
        assert!(minimizers("lbfgs,lbfgs").is_err());
    }
}
