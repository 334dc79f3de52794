//! The folder of results.

use super::inputs::{BodyInput, PatternInput};
use crate::Error;
use crate::assess::principal_stretches;
use crate::check::Finding;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::io::outfit_report::{OutfitGarment, outfit_report};
use crate::io::picture::{
    BodyView, Curve, CurvePoint, GarmentView, StrainField, convergence, crossings, preview, strain,
};
use crate::io::report::{Host, RunFacts, Solve, report, to_json};
use crate::io::state::{self, State};
use crate::io::{atomic, garment_obj, glb, pattern_file};
use crate::pattern::Fabric;
use crate::prepositioning::{Outcome, Outfit, Settings, waist_line};
use nalgebra::Point3;
use std::path::{Path, PathBuf};

/// What the results tell of.
pub struct Run<'a> {
    pub pattern: &'a PatternInput,
    pub body: &'a BodyInput,
    pub fabric: &'a Fabric,
    pub settings: &'a Settings,
    pub warnings: &'a [String],
    pub findings: &'a [Finding],
    pub outcome: &'a Outcome,
    pub solve: &'a Solve,
}

/// The folder of each garment: `out` itself for one alone, else folders in it that are named like the patterns.
pub fn folders(out: &Path, patterns: &[PatternInput]) -> Vec<PathBuf> {
    let [_, _, ..] = patterns else { return vec![out.to_owned()] };
    let mut names: Vec<String> = Vec::new();
    for pattern in patterns {
        let name = &pattern.pattern.name;
        // A pattern that is worn twice, or another one of the same name.
        let numbered = |n: usize| if n == 1 { name.clone() } else { format!("{name}-{n}") };
        let free = (1..).map(numbered).find(|name| !names.contains(name));
        names.push(free.expect("there are more numbers than garments"));
    }
    names.iter().map(|name| out.join(name)).collect()
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
    let aligned = out.join("body_aligned.obj");
    match &run.body.aligned_obj {
        Some(obj) => atomic::write(&aligned, obj.as_bytes())?,
        None => remove_old(&aligned)?,
    }
    let pictures = Pictures::new(run);
    atomic::write(&out.join("preview.png"), &preview(&pictures.garment(), &pictures.body()))?;
    let field = StrainField::PerTriangle(&pictures.strain);
    atomic::write(&out.join("strain.png"), &strain(&pictures.garment(), &pictures.body(), field))?;
    write_crossings(out, &pictures.garment(), &pictures.body(), &outcome.assessment.intersections.triangles)?;
    atomic::write(&out.join("convergence.svg"), curves(outcome).as_bytes())?;
    let host = host();
    let facts = RunFacts {
        pattern,
        pattern_sha256: &run.pattern.sha256,
        body_name: &run.body.name,
        body_sha256: &run.body.sha256,
        alignment: run.body.alignment.as_ref(),
        worn: run.body.worn.iter().map(|worn| [worn.name.as_str(), worn.sha256.as_str()]).collect(),
        fabric: run.fabric,
        settings: run.settings,
        warnings: run.warnings,
        findings: run.findings,
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
        pattern_text: pattern_file::stored(&run.pattern.pattern),
        pattern_sha256: run.pattern.sha256.clone(),
        body_name: run.body.name.clone(),
        body_sha256: run.body.sha256.clone(),
        fabric: run.fabric.clone(),
        settings: run.settings.clone(),
        positions: run.outcome.positions.clone(),
        shifts: run.outcome.shifts.clone(),
        waist: waist_line(&run.pattern.pattern, run.outcome.finest(), &run.outcome.positions),
    }
}

/// A picture of what crosses, where something does; one of an earlier run would be misleading where nothing does.
fn write_crossings(out: &Path, garment: &GarmentView, body: &BodyView, crossing: &[u32]) -> Result<(), Error> {
    let file = out.join("crossings.png");
    if !crossing.is_empty() {
        return atomic::write(&file, &crossings(garment, body, crossing));
    }
    remove_old(&file)
}

/// Removes a file of an earlier run that would be misleading beside the results of this one.
fn remove_old(file: &Path) -> Result<(), Error> {
    match std::fs::remove_file(file) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::new(
            format!("An old file cannot be removed ({e})."),
            "Remove it, or give another folder with --out.",
        )
        .within(file.display())),
        _ => Ok(()),
    }
}

/// Writes what concerns all garments: a picture, and how they lie on one another.
pub fn write_outfit(
    patterns: &[PatternInput],
    folders: &[PathBuf],
    body: &BodyInput,
    outfit: &Outfit,
    out: &Path,
) -> Result<(), Error> {
    let levels: Vec<_> = outfit.garments.iter().map(Outcome::finest).collect();
    let level = Level::together(&levels);
    let positions: Vec<Vector3> = outfit.garments.iter().flat_map(|outcome| &outcome.positions).copied().collect();
    let garment = GarmentView {
        positions: bytemuck::cast_slice(&positions),
        triangles: &level.particle_triangles(),
        panels: &level.panel_of_triangle(),
        seams: &level.seam_edges(),
        colors: &[],
    };
    let skin = BodyView { positions: bytemuck::cast_slice(body.body.positions()), triangles: body.body.triangles() };
    atomic::write(&out.join("preview.png"), &preview(&garment, &skin))?;
    write_crossings(out, &garment, &skin, &outfit.layers.triangles)?;
    let names: Vec<OutfitGarment> = patterns
        .iter()
        .zip(folders)
        .map(|(pattern, folder)| OutfitGarment {
            name: &pattern.pattern.name,
            folder: folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        })
        .collect();
    atomic::write(&out.join("outfit.json"), to_json(&outfit_report(&names, outfit)).as_bytes())
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
