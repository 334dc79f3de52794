//! The folder of results.

use super::inputs::{BodyInput, PatternInput};
use crate::Error;
use crate::assess::principal_stretches;
use crate::geometry::Vector3;
use crate::io::picture::{BodyView, Curve, CurvePoint, GarmentView, StrainField, convergence, preview, strain};
use crate::io::report::{Host, RunFacts, Solve, report, to_json};
use crate::io::state::{self, State};
use crate::io::{atomic, garment_obj, glb};
use crate::pattern::Fabric;
use crate::prepositioning::{Outcome, Settings};
use nalgebra::Point3;
use std::path::Path;

/// What the results tell of.
pub struct Run<'a> {
    pub pattern: &'a PatternInput,
    pub body: &'a BodyInput,
    pub fabric: &'a Fabric,
    pub settings: &'a Settings,
    pub warnings: &'a [String],
    pub outcome: &'a Outcome,
    pub solve: &'a Solve,
}

/// Makes the folder if it is not there.
pub fn prepare(out: &Path) -> Result<(), Error> {
    let made = std::fs::create_dir_all(out);
    let probe = out.join(format!(".toile-{}", std::process::id()));
    made.and_then(|()| std::fs::write(&probe, b"")).and_then(|()| std::fs::remove_file(&probe)).map_err(|e| {
        Error::new(format!("The folder for the results cannot be written to ({e})."), "Give another folder with --out.")
            .within(out.display())
    })
}

/// Writes all files; the report comes last, so that where it is, all is. `host` is asked just before.
pub fn write(run: &Run, out: &Path, host: impl Fn() -> Host) -> Result<Host, Error> {
    let (pattern, outcome) = (&run.pattern.pattern, run.outcome);
    let (level, positions) = (outcome.finest(), outcome.positions.as_slice());
    atomic::write(&out.join("garment.obj"), garment_obj::write(pattern, level, positions).as_bytes())?;
    atomic::write(&out.join("garment.glb"), &glb::write(pattern, level, positions))?;
    atomic::write(&out.join("state.toile"), &state::write(&state_of(run)))?;
    let pictures = Pictures::new(run);
    atomic::write(&out.join("preview.png"), &preview(&pictures.garment(), &pictures.body()))?;
    let field = StrainField::PerTriangle(&pictures.strain);
    atomic::write(&out.join("strain.png"), &strain(&pictures.garment(), &pictures.body(), field))?;
    atomic::write(&out.join("convergence.svg"), curves(outcome).as_bytes())?;
    let host = host();
    let facts = RunFacts {
        pattern,
        pattern_sha256: &run.pattern.sha256,
        body_name: &run.body.name,
        body_sha256: &run.body.sha256,
        fabric: run.fabric,
        settings: run.settings,
        warnings: run.warnings,
        outcome,
        solve: run.solve,
        host: &host,
    };
    atomic::write(&out.join("report.json"), to_json(&report(&facts)).as_bytes())?;
    Ok(host)
}

fn state_of(run: &Run) -> State {
    State {
        toile_version: env!("CARGO_PKG_VERSION").to_owned(),
        pattern_name: run.pattern.pattern.name.clone(),
        pattern_text: run.pattern.text.clone(),
        pattern_sha256: run.pattern.sha256.clone(),
        body_name: run.body.name.clone(),
        body_sha256: run.body.sha256.clone(),
        fabric: run.fabric.clone(),
        settings: run.settings.clone(),
        positions: run.outcome.positions.clone(),
        shifts: run.outcome.shifts.clone(),
    }
}

/// What pictures of a run are drawn from.
struct Pictures<'a> {
    positions: &'a [Point3<f64>],
    body_positions: &'a [Point3<f64>],
    body_triangles: &'a [[u32; 3]],
    triangles: Vec<[u32; 3]>,
    panels: Vec<u32>,
    seams: Vec<[u32; 2]>,
    /// Per triangle, the principal strain that is farther from zero.
    strain: Vec<f64>,
}

impl<'a> Pictures<'a> {
    fn new(run: &Run<'a>) -> Self {
        let (level, positions) = (run.outcome.finest(), run.outcome.positions.as_slice());
        let worse = |[a, b]: [f64; 2]| if (a - 1.0).abs() > (b - 1.0).abs() { a - 1.0 } else { b - 1.0 };
        let strain = (0..level.triangles.len()).map(|t| {
            let corners: [Vector3; 3] = level.particles(t).map(|p| positions[p as usize]);
            principal_stretches(level.rest_corners(t), corners).map_or(f64::NAN, worse)
        });
        Self {
            positions: bytemuck::cast_slice(positions),
            body_positions: bytemuck::cast_slice(run.body.body.positions()),
            body_triangles: run.body.body.triangles(),
            triangles: level.particle_triangles(),
            panels: level.panel_of_triangle(),
            seams: level.seam_edges(),
            strain: strain.collect(),
        }
    }

    fn garment(&self) -> GarmentView<'_> {
        GarmentView {
            positions: self.positions,
            triangles: &self.triangles,
            panels: &self.panels,
            seams: &self.seams,
            colors: &[],
        }
    }

    fn body(&self) -> BodyView<'_> {
        BodyView { positions: self.body_positions, triangles: self.body_triangles }
    }
}

/// Energy and residual of all levels, one after the other.
fn curves(outcome: &Outcome) -> String {
    let mut before = 0;
    let mut levels: Vec<(String, Vec<CurvePoint>)> = Vec::new();
    for summary in &outcome.levels {
        let point = |p: &crate::prepositioning::CurvePoint| CurvePoint {
            evaluations: (before + p.evaluations) as u64,
            energy: p.energy,
            residual: p.residual,
        };
        levels.push((crate::io::length::describe(summary.resolution), summary.curve.iter().map(point).collect()));
        before += summary.evaluations;
    }
    let curves: Vec<Curve> = levels.iter().map(|(name, points)| Curve { name, points }).collect();
    convergence(&curves)
}
