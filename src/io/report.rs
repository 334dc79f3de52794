//! `report.json`: what a run was given, what it did and how good the garment is.
//!
//! Everything but the object `run` is the same, byte for byte, for the same input, on any number of
//! threads. A number that is not finite is `null`. Fields are added without a new version; when one
//! changes its meaning or goes, the version grows. `docs/formats.md` tells them one by one.

use super::fabric_toml::figures;
use super::findings::{FindingPart, finding_part};
use super::settings_toml::{bending_word, finish_line_word, membrane_word, minimizer_word};
use crate::assess::{Assessment, Check, Strain, Tight, hand_off};
use crate::body::Alignment;
use crate::check::Finding;
use crate::energy::Terms;
use crate::geometry::Vector3;
use crate::minimize::Termination;
use crate::pattern::{Fabric, Pattern};
use crate::prepositioning::{CurvePoint, LevelSummary, Outcome, Settings};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Points of a convergence curve that a report keeps for each level: as many as a picture shows.
pub const MOST_CURVE_POINTS: usize = 200;

/// What a report is made of.
pub struct RunFacts<'a> {
    pub pattern: &'a Pattern,
    /// Hexadecimal, of the pattern file.
    pub pattern_sha256: &'a str,
    pub body_name: &'a str,
    /// Hexadecimal, of the body file.
    pub body_sha256: &'a str,
    /// How the body was brought into our frame, if that was asked for.
    pub alignment: Option<&'a Alignment>,
    /// Names and digests of the garments that the body wears, innermost first.
    pub worn: Vec<[&'a str; 2]>,
    pub fabric: &'a Fabric,
    pub settings: &'a Settings,
    /// What was doubtful about the input.
    pub warnings: &'a [String],
    /// The same with codes and places.
    pub findings: &'a [Finding],
    pub outcome: &'a Outcome,
    pub solve: &'a Solve,
    pub host: &'a Host,
}

/// What the work took from the parsed pattern and the parsed mesh of the body to the outcome: everything but
/// reading and writing files and drawing pictures. Differs from run to run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solve {
    /// All of it, in its order.
    pub stages: Vec<Stage>,
    /// The most memory that was resident at once until the outcome was there.
    pub peak_memory_bytes: Option<u64>,
}

/// A part of the work and what it took.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Stage {
    /// `body`, `start-up`, `sewing`, `layering`, `level 1` and so on, `assessment`.
    pub name: String,
    pub wall_seconds: f64,
    /// Of all threads.
    pub cpu_seconds: Option<f64>,
}

/// What differs from run to run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Host {
    pub wall_seconds: f64,
    /// Of all threads.
    pub cpu_seconds: Option<f64>,
    pub peak_memory_bytes: Option<u64>,
    pub threads: usize,
    /// The processor as its maker calls it.
    pub cpu: Option<String>,
    /// Operating system and kind of processor.
    pub system: String,
}

/// The report, field by field as in the file.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    pub format: &'static str,
    pub version: u32,
    pub toile_version: &'static str,
    pub inputs: Inputs,
    pub settings: SettingsPart,
    pub fabric: FabricPart,
    pub warnings: Vec<String>,
    /// The same with codes and places.
    pub findings: Vec<FindingPart>,
    pub hand_off_ready: bool,
    pub hand_off_checks: Vec<Check>,
    /// How the finest level ended.
    pub termination: &'static str,
    pub assessment: AssessmentPart,
    /// Panels that are stretched beyond the limit of the fabric.
    pub tight: Vec<TightPart>,
    pub sewing: SewingPart,
    /// Coarsest first.
    pub levels: Vec<LevelPart>,
    /// All that differs from run to run.
    pub run: RunPart,
}

#[derive(Clone, Debug, Serialize)]
pub struct Inputs {
    pub pattern: PatternPart,
    pub body: BodyPart,
}

#[derive(Clone, Debug, Serialize)]
pub struct PatternPart {
    pub name: String,
    pub sha256: String,
    pub panels: usize,
    pub seams: usize,
}

#[derive(Clone, Debug, Serialize)]
pub struct BodyPart {
    pub name: String,
    pub sha256: String,
    /// Garments that the body wore before, innermost first.
    pub wears: Vec<WornPart>,
    /// How the body was brought into the frame of the results, if that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment: Option<AlignmentPart>,
}

#[derive(Clone, Debug, Serialize)]
pub struct AlignmentPart {
    /// Of the file, as recognized.
    pub unit: &'static str,
    pub up: &'static str,
    pub facing: String,
    pub scale: f64,
    /// Row by row; takes points of the file to those of the results, m.
    pub world_from_file: [[f64; 4]; 4],
}

impl From<&Alignment> for AlignmentPart {
    fn from(alignment: &Alignment) -> Self {
        Self {
            unit: alignment.unit,
            up: alignment.up,
            facing: alignment.facing.clone(),
            scale: alignment.scale,
            world_from_file: alignment.world_from_file(),
        }
    }
}

#[derive(Clone, Debug, Serialize)]
pub struct WornPart {
    pub name: String,
    /// Hexadecimal, of its state file.
    pub sha256: String,
}

#[derive(Clone, Debug, Serialize)]
pub struct SettingsPart {
    pub resolutions_m: Vec<f64>,
    pub clearance_m: f64,
    pub membrane: &'static str,
    pub bending: &'static str,
    pub minimizer: &'static str,
    pub until: &'static str,
    pub equilibrium_residual_weights: f64,
    pub coarse_evaluations: usize,
    pub finest_evaluations: usize,
    pub equilibrium_evaluations: usize,
}

#[derive(Clone, Debug, Serialize)]
pub struct FabricPart {
    pub name: String,
    /// By the keys of a fabric file.
    #[serde(flatten)]
    pub figures: BTreeMap<&'static str, f64>,
}

#[derive(Clone, Debug, Serialize)]
pub struct AssessmentPart {
    pub strain: StrainPart,
    /// Less what unequal seams impose.
    pub strain_less_gathers: StrainPart,
    pub seams: SeamsPart,
    pub clearance: ClearancePart,
    pub intersections: IntersectionsPart,
}

/// Strains as shares of one.
#[derive(Clone, Debug, Serialize)]
pub struct StrainPart {
    pub mean: f64,
    pub p99: f64,
    pub max: f64,
    pub stretch_p99: f64,
    pub stretch_max: f64,
    pub compression_p99: f64,
    pub compression_max: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct SeamsPart {
    pub pairs: usize,
    pub largest_gap_m: f64,
    pub mean_gap_m: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct ClearancePart {
    pub least_m: f64,
    pub particles_inside: usize,
    pub particles_too_near: usize,
    /// The least distance of any point of the cloth, by exact distances of triangles; zero where some cross.
    pub least_of_cloth_m: f64,
    pub triangles_too_near: usize,
}

#[derive(Clone, Debug, Serialize)]
pub struct IntersectionsPart {
    pub body_pairs: usize,
    pub cloth_pairs: usize,
    pub by_panels: Vec<PanelPairs>,
}

#[derive(Clone, Debug, Serialize)]
pub struct PanelPairs {
    pub panel: String,
    /// `None` for the body.
    pub other_panel: Option<String>,
    pub pairs: usize,
}

#[derive(Clone, Debug, Serialize)]
pub struct SewingPart {
    pub evaluations: usize,
    pub welded_gap_m: f64,
    pub shifts: Vec<ShiftPart>,
}

#[derive(Clone, Debug, Serialize)]
pub struct ShiftPart {
    pub panel: String,
    pub shift_m: [f64; 3],
}

#[derive(Clone, Debug, Serialize)]
pub struct TightPart {
    pub panel: String,
    /// Part of its area.
    pub share: f64,
    pub largest_stretch: f64,
    /// The middle of what is stretched so far, world.
    pub place_m: [f64; 3],
}

#[derive(Clone, Debug, Serialize)]
pub struct LevelPart {
    pub resolution_m: f64,
    pub particles: usize,
    pub triangles: usize,
    pub hinges: usize,
    pub evaluations: usize,
    pub termination: &'static str,
    pub energies_j: EnergiesPart,
    pub residual_weights: ResidualPart,
    pub starting_intersections: usize,
    pub curve: CurvePart,
}

/// Contact is not among them; the curve includes it.
#[derive(Clone, Debug, Serialize)]
pub struct EnergiesPart {
    pub membrane: f64,
    pub bending: f64,
    pub sewing: f64,
    pub gravity: f64,
    pub total: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct ResidualPart {
    pub rms: f64,
    pub max: f64,
}

/// Columns of the convergence curve, at most [`MOST_CURVE_POINTS`] long.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CurvePart {
    pub evaluations: Vec<usize>,
    pub energy_j: Vec<f64>,
    pub residual_weights: Vec<f64>,
}

#[derive(Clone, Debug, Serialize)]
pub struct RunPart {
    #[serde(flatten)]
    pub host: Host,
    pub solve_wall_seconds: f64,
    pub solve_cpu_seconds: Option<f64>,
    pub solve_peak_memory_bytes: Option<u64>,
    pub stages: Vec<Stage>,
}

/// The report of a run.
pub fn report(run: &RunFacts) -> Report {
    let (pattern, outcome) = (run.pattern, run.outcome);
    let checks = hand_off(&outcome.assessment);
    Report {
        format: "toile report",
        version: 1,
        toile_version: env!("CARGO_PKG_VERSION"),
        inputs: Inputs {
            pattern: PatternPart {
                name: pattern.name.clone(),
                sha256: run.pattern_sha256.to_owned(),
                panels: pattern.panels.len(),
                seams: pattern.seams.len(),
            },
            body: BodyPart {
                name: run.body_name.to_owned(),
                sha256: run.body_sha256.to_owned(),
                wears: run.worn.iter().map(|worn| WornPart { name: worn[0].into(), sha256: worn[1].into() }).collect(),
                alignment: run.alignment.map(AlignmentPart::from),
            },
        },
        settings: settings_part(run.settings),
        fabric: FabricPart { name: run.fabric.name.clone(), figures: figures(run.fabric).into_iter().collect() },
        warnings: run.warnings.to_vec(),
        findings: run.findings.iter().map(|finding| finding_part(finding, &[])).collect(),
        hand_off_ready: checks.iter().all(|check| check.passed),
        hand_off_checks: checks,
        termination: termination_word(outcome.termination()),
        assessment: assessment_part(pattern, &outcome.assessment),
        sewing: SewingPart {
            evaluations: outcome.sewing_evaluations,
            welded_gap_m: outcome.welded_gap,
            shifts: shifts_part(pattern, &outcome.shifts),
        },
        tight: outcome.tight.iter().map(|tight| tight_part(pattern, tight)).collect(),
        levels: outcome
            .levels
            .iter()
            .zip(&outcome.garment.levels)
            .map(|(s, level)| level_part(s, level.hinges.len()))
            .collect(),
        run: run_part(run.host, run.solve),
    }
}

/// The text of the file.
pub fn to_json(report: &impl Serialize) -> String {
    // serde_json writes what is not finite as null.
    serde_json::to_string_pretty(report).expect("structs of numbers and strings are JSON") + "\n"
}

/// The word for the way a run ended.
pub fn termination_word(termination: Termination) -> &'static str {
    match termination {
        Termination::Converged => "converged",
        Termination::Budget => "budget",
        Termination::Stalled => "stalled",
    }
}

/// The settings as a report tells them.
pub(super) fn settings_part(settings: &Settings) -> SettingsPart {
    let Settings {
        resolutions,
        clearance,
        model,
        minimizer,
        until,
        equilibrium_residual,
        coarse_evaluations,
        finest_evaluations,
        equilibrium_evaluations,
    } = settings;
    SettingsPart {
        resolutions_m: resolutions.clone(),
        clearance_m: *clearance,
        membrane: membrane_word(model.membrane),
        bending: bending_word(model.bending),
        minimizer: minimizer_word(*minimizer),
        until: finish_line_word(*until),
        equilibrium_residual_weights: *equilibrium_residual,
        coarse_evaluations: *coarse_evaluations,
        finest_evaluations: *finest_evaluations,
        equilibrium_evaluations: *equilibrium_evaluations,
    }
}

fn run_part(host: &Host, solve: &Solve) -> RunPart {
    RunPart {
        host: host.clone(),
        solve_wall_seconds: solve.stages.iter().map(|stage| stage.wall_seconds).sum(),
        solve_cpu_seconds: solve.stages.iter().map(|stage| stage.cpu_seconds).sum(),
        solve_peak_memory_bytes: solve.peak_memory_bytes,
        stages: solve.stages.clone(),
    }
}

fn assessment_part(pattern: &Pattern, assessment: &Assessment) -> AssessmentPart {
    let Assessment { strain, strain_less_gathers, seams, clearance, intersections } = assessment;
    let pairs = |(&(panel, other), &pairs): (&(usize, Option<usize>), &usize)| PanelPairs {
        panel: panel_name(pattern, panel),
        other_panel: other.map(|other| panel_name(pattern, other)),
        pairs,
    };
    AssessmentPart {
        strain: strain_part(strain),
        strain_less_gathers: strain_part(strain_less_gathers),
        seams: SeamsPart { pairs: seams.pairs, largest_gap_m: seams.largest, mean_gap_m: seams.mean },
        clearance: ClearancePart {
            least_m: clearance.least,
            particles_inside: clearance.inside,
            particles_too_near: clearance.too_near,
            least_of_cloth_m: clearance.least_of_cloth,
            triangles_too_near: clearance.triangles_too_near,
        },
        intersections: IntersectionsPart {
            body_pairs: intersections.body_pairs,
            cloth_pairs: intersections.cloth_pairs,
            by_panels: intersections.by_panels.iter().map(pairs).collect(),
        },
    }
}

fn strain_part(strain: &Strain) -> StrainPart {
    let &Strain { mean, p99, max, stretch_p99, stretch_max, compression_p99, compression_max } = strain;
    StrainPart { mean, p99, max, stretch_p99, stretch_max, compression_p99, compression_max }
}

fn panel_name(pattern: &Pattern, panel: usize) -> String {
    pattern.panels.get(panel).map_or_else(|| panel.to_string(), |panel| panel.name.clone())
}

fn shifts_part(pattern: &Pattern, shifts: &[Vector3]) -> Vec<ShiftPart> {
    let part =
        |(panel, shift): (usize, &Vector3)| ShiftPart { panel: panel_name(pattern, panel), shift_m: (*shift).into() };
    shifts.iter().enumerate().map(part).collect()
}

fn tight_part(pattern: &Pattern, tight: &Tight) -> TightPart {
    TightPart {
        panel: panel_name(pattern, tight.panel),
        share: tight.share,
        largest_stretch: tight.largest,
        place_m: tight.place.into(),
    }
}

fn level_part(summary: &LevelSummary, hinges: usize) -> LevelPart {
    let Terms { membrane, bending, sewing, gravity } = summary.energies;
    LevelPart {
        resolution_m: summary.resolution,
        particles: summary.particles,
        triangles: summary.triangles,
        hinges,
        evaluations: summary.evaluations,
        termination: termination_word(summary.termination),
        energies_j: EnergiesPart { membrane, bending, sewing, gravity, total: summary.energies.total() },
        residual_weights: ResidualPart { rms: summary.residual.rms, max: summary.residual.max },
        starting_intersections: summary.starting_intersections,
        curve: curve_part(&summary.curve),
    }
}

fn curve_part(curve: &[CurvePoint]) -> CurvePart {
    let mut columns = CurvePart::default();
    for point in thinned(curve) {
        columns.evaluations.push(point.evaluations);
        columns.energy_j.push(point.energy);
        columns.residual_weights.push(point.residual);
    }
    columns
}

/// Points of a curve at even steps, the first and the last among them.
fn thinned(curve: &[CurvePoint]) -> impl Iterator<Item = CurvePoint> + '_ {
    let count = curve.len().min(MOST_CURVE_POINTS);
    (0..count).map(move |k| curve[k * (curve.len() - 1) / (count - 1).max(1)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::{Clearance, Intersections, SeamGaps};
    use crate::garment::Level;
    use crate::io::sample::two_panels;
    use crate::prepositioning::Residual;
    use serde_json::Value;

    fn outcome() -> (Pattern, Outcome) {
        let (pattern, garment, positions) = two_panels();
        let point = |k: usize| CurvePoint { evaluations: 2 * k, energy: -(k as f64), residual: 1.0 / k as f64 };
        let summary = |level: &Level| LevelSummary {
            resolution: level.resolution,
            particles: level.particle_count,
            triangles: level.triangles.len(),
            evaluations: 1000,
            curvatures: 900,
            energies: Terms { membrane: 0.25, bending: 0.5, sewing: 0.0, gravity: -1.0 },
            residual: Residual { rms: 0.2, max: f64::INFINITY },
            termination: Termination::Budget,
            starting_intersections: 0,
            curve: (0..500).map(point).collect(),
        };
        let strain = Strain { mean: 0.004, p99: 0.03, max: 0.06, ..Strain::default() };
        let assessment = Assessment {
            strain,
            strain_less_gathers: strain,
            seams: SeamGaps { pairs: 13, largest: 0.0, mean: 0.0 },
            clearance: Clearance { least: 0.001, inside: 0, too_near: 0, least_of_cloth: 0.001, triangles_too_near: 0 },
            intersections: Intersections {
                cloth_pairs: 3,
                by_panels: [((0, None), 2), ((0, Some(1)), 3)].into(),
                ..Intersections::default()
            },
        };
        let outcome = Outcome {
            tight: vec![Tight { panel: 1, share: 0.1, largest: 0.08, place: Vector3::new(0.0, 1.0, 0.1) }],
            shifts: vec![Vector3::zeros(), Vector3::new(0.0, 0.0, -0.02)],
            sewing_evaluations: 321,
            welded_gap: 3e-4,
            levels: garment.levels.iter().map(summary).collect(),
            assessment,
            positions,
            garment,
        };
        (pattern, outcome)
    }

    fn json(host: &Host) -> String {
        json_of(host, &Solve::default())
    }

    fn json_of(host: &Host, solve: &Solve) -> String {
        let (pattern, outcome) = outcome();
        to_json(&report(&RunFacts {
            pattern: &pattern,
            pattern_sha256: "ab",
            body_name: "ball",
            body_sha256: "cd",
            alignment: None,
            worn: vec![["tee", "ef"]],
            fabric: &Fabric::default(),
            settings: &Settings::default(),
            warnings: &["panel \"front\": odd".to_owned()],
            findings: &[],
            outcome: &outcome,
            solve,
            host,
        }))
    }

    #[test]
    fn figures_stand_where_the_format_says() {
        let text = json(&Host { threads: 2, wall_seconds: 1.5, ..Host::default() });
        assert!(text.ends_with("}\n"));
        let report: Value = serde_json::from_str(&text).unwrap();
        assert_eq!((&report["format"], &report["version"]), (&"toile report".into(), &1.into()));
        assert_eq!(report["inputs"]["pattern"]["panels"], 2);
        assert_eq!(report["settings"]["clearance_m"], crate::prepositioning::Settings::default().clearance);
        assert_eq!(report["fabric"]["areal_density_kg_per_m2"], 0.2);
        assert_eq!(report["sewing"]["shifts"][1]["panel"], "back");
        assert_eq!(report["levels"][1]["energies_j"]["total"], -0.25);
        assert!(report["levels"][1]["hinges"].as_u64().unwrap() > 0);
        assert_eq!(report["assessment"]["strain"]["p99"], 0.03);
        let by_panels = report["assessment"]["intersections"]["by_panels"].as_array().unwrap();
        assert_eq!((&by_panels[0]["other_panel"], &by_panels[1]["other_panel"]), (&Value::Null, &"back".into()));
        assert_eq!(report["termination"], "budget");
        assert_eq!(report["run"]["threads"], 2);
        assert_eq!(report["tight"][0]["panel"], "back");
        assert_eq!(report["inputs"]["body"]["wears"][0]["name"], "tee");
    }

    #[test]
    fn one_crossing_is_enough_to_miss_the_gate() {
        let report: Value = serde_json::from_str(&json(&Host::default())).unwrap();
        assert_eq!(report["hand_off_ready"], false);
        let failed: Vec<&Value> =
            report["hand_off_checks"].as_array().unwrap().iter().filter(|c| c["passed"] == false).collect();
        assert_eq!(failed.len(), 1);
        assert_eq!((&failed[0]["name"], &failed[0]["measured"]), (&"cloth_intersections".into(), &3.0.into()));
    }

    #[test]
    fn what_is_not_finite_is_null() {
        let report: Value = serde_json::from_str(&json(&Host::default())).unwrap();
        assert_eq!(report["levels"][0]["residual_weights"]["max"], Value::Null);
        assert_eq!(report["levels"][0]["curve"]["residual_weights"][0], Value::Null);
    }

    #[test]
    fn only_the_run_differs_between_runs() {
        let strip = |text: String| text[..text.find("\"run\"").unwrap()].to_owned();
        let other = Host { wall_seconds: 9.0, cpu: Some("other".into()), threads: 8, ..Host::default() };
        let stages = vec![Stage { name: "body".into(), wall_seconds: 0.5, cpu_seconds: None }];
        let (first, second) = (json(&Host::default()), json_of(&other, &Solve { stages, ..Solve::default() }));
        assert_ne!(first, second);
        assert_eq!(strip(first), strip(second));
    }

    #[test]
    fn stages_add_up_to_the_solve() {
        let stage = |name: &str, wall_seconds, cpu_seconds| Stage { name: name.into(), wall_seconds, cpu_seconds };
        let mut solve = Solve { peak_memory_bytes: Some(7), ..Solve::default() };
        solve.stages = vec![stage("body", 0.5, Some(1.0)), stage("start-up", 0.25, Some(0.5))];
        let run =
            |solve: &Solve| serde_json::from_str::<Value>(&json_of(&Host::default(), solve)).unwrap()["run"].take();
        let whole = run(&solve);
        assert_eq!((&whole["solve_wall_seconds"], &whole["solve_cpu_seconds"]), (&0.75.into(), &1.5.into()));
        assert_eq!((&whole["wall_seconds"], &whole["solve_peak_memory_bytes"]), (&0.0.into(), &7.into()));
        assert_eq!(whole["stages"][1]["name"], "start-up");
        // A sum of which a part is not known is not known.
        solve.stages[1].cpu_seconds = None;
        assert_eq!(run(&solve)["solve_cpu_seconds"], Value::Null);
    }

    #[test]
    fn curves_are_thinned_with_both_ends() {
        let (_, outcome) = outcome();
        let part = curve_part(&outcome.levels[0].curve);
        assert_eq!(part.evaluations.len(), MOST_CURVE_POINTS);
        assert_eq!((part.evaluations[0], part.evaluations[199]), (0, 998));
        assert!(part.evaluations.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(curve_part(&[]).evaluations.len(), 0);
        assert_eq!(curve_part(&outcome.levels[0].curve[..1]).evaluations, [0]);
    }
}
