//! The fields of `comparison.json`.

use crate::io::report::Host;
use crate::prepositioning::FinishLine;
use crate::prepositioning::comparison::Line;
use serde::{Deserialize, Deserializer, Serialize};

/// The comparison, field by field as in the file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Comparison {
    pub format: String,
    pub version: u32,
    pub toile_version: String,
    pub inputs: InputsPart,
    /// As in a report.
    pub settings: serde_json::Value,
    pub finish_line: FinishPart,
    pub cap: usize,
    pub whole: bool,
    pub perturbation: Option<PerturbationPart>,
    /// Of the garment.
    #[serde(deserialize_with = "number")]
    pub weight_n: f64,
    /// The lowest energy in which a run ended.
    #[serde(deserialize_with = "number")]
    pub lowest_energy_j: f64,
    pub runs: Vec<RunPart>,
    /// All that differs when the same comparison is made again.
    pub times: TimesPart,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct InputsPart {
    pub pattern: InputPart,
    pub body: InputPart,
    /// The name of the fabric.
    pub fabric: String,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct InputPart {
    pub name: String,
    pub sha256: String,
}

/// Where a run is done: limits of strain and energy for the hand-off, of the residual for the equilibrium.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FinishPart {
    pub until: String,
    pub residual_weights: Option<f64>,
    pub strain_p99: Option<f64>,
    pub strain_mean: Option<f64>,
    /// The most with which a run is settled: that in which the first schedule's cloth slid last, and the allowance.
    pub settled_energy_j: Option<f64>,
    /// Over the schedule's energy, as a mean height of the garment.
    pub allowance_m: Option<f64>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PerturbationPart {
    pub seed: u64,
    pub amplitude_m: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunPart {
    pub name: String,
    pub schedule: bool,
    pub minimizer: String,
    pub sewing: SewingPart,
    /// Coarsest first.
    pub levels: Vec<LevelPart>,
    /// Evaluations of the whole run, in those of its finest level.
    #[serde(deserialize_with = "number")]
    pub fine_equivalent: f64,
    pub reached: LinesPart<ReachedPart>,
    pub end: EndPart,
    pub curve: CurvePart,
    pub strain: StrainCurvePart,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SewingPart {
    pub particles: usize,
    pub evaluations: usize,
    pub curvatures: usize,
    #[serde(deserialize_with = "number")]
    pub welded_gap_m: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LevelPart {
    pub resolution_m: f64,
    pub particles: usize,
    pub evaluations: usize,
    pub curvatures: usize,
    pub termination: String,
}

/// Something for each finish line that was met.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LinesPart<T> {
    pub strain: Option<T>,
    pub settled: Option<T>,
    pub equilibrium: Option<T>,
}

impl<T> LinesPart<T> {
    pub fn at(&self, line: Line) -> Option<&T> {
        match line {
            Line::Strain => self.strain.as_ref(),
            Line::Settled => self.settled.as_ref(),
            Line::Equilibrium => self.equilibrium.as_ref(),
        }
    }
}

/// Where a finish line was met.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReachedPart {
    /// On the finest level.
    pub evaluations: usize,
    /// Of all levels and of sewing.
    pub fine_equivalent: f64,
    /// To that of the first schedule, if it met the line.
    pub ratio: Option<f64>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EndPart {
    #[serde(deserialize_with = "number")]
    pub energy_j: f64,
    /// Over the lowest of all runs.
    #[serde(deserialize_with = "number")]
    pub energy_gap_j: f64,
    /// The same as a height by which the garment hangs above where it could.
    #[serde(deserialize_with = "number")]
    pub energy_gap_height_m: f64,
    /// The same over the first schedule; negative below it.
    #[serde(deserialize_with = "number")]
    pub above_schedule_m: f64,
    #[serde(deserialize_with = "number")]
    pub residual_weights: f64,
    #[serde(deserialize_with = "number")]
    pub strain_mean: f64,
    #[serde(deserialize_with = "number")]
    pub strain_p99: f64,
    #[serde(deserialize_with = "number")]
    pub strain_max: f64,
    /// Of the hand-off.
    pub failed_checks: Vec<String>,
}

/// Columns of equal length, a row for an accepted step; steps are thinned out as their numbers grow.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct CurvePart {
    pub level: Vec<usize>,
    /// On the level.
    pub evaluations: Vec<usize>,
    #[serde(deserialize_with = "numbers")]
    pub fine_equivalent: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub energy_j: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub residual_weights: Vec<f64>,
}

/// Columns of equal length, a row for each look at the finest level.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct StrainCurvePart {
    pub evaluations: Vec<usize>,
    #[serde(deserialize_with = "numbers")]
    pub fine_equivalent: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub mean: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub p99: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub max: Vec<f64>,
    pub within_limits: Vec<bool>,
    /// While the cloth slides.
    #[serde(deserialize_with = "numbers")]
    pub energy_j: Vec<f64>,
    pub settled: Vec<bool>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TimesPart {
    /// Of the whole comparison, and where it was made.
    pub host: Host,
    /// One for each run, in their order.
    pub runs: Vec<RunTimesPart>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunTimesPart {
    pub name: String,
    pub set_up: SpentPart,
    pub sewn: SpentPart,
    pub reached: LinesPart<ReachedTimesPart>,
    pub total: SpentPart,
    pub curve: SpentColumns,
    pub strain: SpentColumns,
}

/// When a finish line was met.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReachedTimesPart {
    #[serde(flatten)]
    pub spent: SpentPart,
    /// Of processor seconds to those of the first schedule, if it met the line.
    pub cpu_ratio: Option<f64>,
}

/// Since the run began, less what measuring took.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SpentPart {
    #[serde(deserialize_with = "number")]
    pub cpu_seconds: f64,
    #[serde(deserialize_with = "number")]
    pub wall_seconds: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SpentColumns {
    #[serde(deserialize_with = "numbers")]
    pub cpu_seconds: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub wall_seconds: Vec<f64>,
}

impl Comparison {
    /// The finish lines that were to be met.
    pub fn lines(&self) -> &'static [Line] {
        Line::of(if self.finish_line.residual_weights.is_some() {
            FinishLine::Equilibrium
        } else {
            FinishLine::HandOff
        })
    }

    /// Do the parts belong together? Says what does not.
    pub fn check(&self) -> Result<(), String> {
        if self.runs.len() != self.times.runs.len() {
            return Err("There are not as many runs as times of runs.".to_owned());
        }
        for (run, times) in self.runs.iter().zip(&self.times.runs) {
            let (curve, strain) = (&run.curve, &run.strain);
            let points = curve.level.len();
            let looks = strain.evaluations.len();
            let curves = [
                curve.evaluations.len(),
                curve.fine_equivalent.len(),
                curve.energy_j.len(),
                curve.residual_weights.len(),
                times.curve.cpu_seconds.len(),
                times.curve.wall_seconds.len(),
            ];
            let strains = [
                strain.fine_equivalent.len(),
                strain.mean.len(),
                strain.p99.len(),
                strain.max.len(),
                strain.within_limits.len(),
                strain.energy_j.len(),
                strain.settled.len(),
                times.strain.cpu_seconds.len(),
                times.strain.wall_seconds.len(),
            ];
            if curves.iter().any(|&n| n != points) || strains.iter().any(|&n| n != looks) {
                return Err(format!("The columns of the run \"{}\" have different lengths.", run.name));
            }
            if run.levels.is_empty() {
                return Err(format!("The run \"{}\" has no level.", run.name));
            }
        }
        Ok(())
    }
}

/// A number, or NaN for `null`.
fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

fn numbers<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    let read: Vec<Option<f64>> = Vec::deserialize(from)?;
    Ok(read.into_iter().map(|n| n.unwrap_or(f64::NAN)).collect())
}
