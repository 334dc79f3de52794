//! `toile check`: all that is wrong or doubtful with the input, before any solving.
//!
//! Findings go to the standard output stream, errors to the standard error stream as those of every command; with `--json` all
//! go to the one document. What is wrong with one input does not hide what is wrong with another.

use super::arguments::Check;
use super::inputs::{BodyInput, PatternInput, fabric};
use super::place::place_all;
use super::{Failure, Status, complaint};
use crate::body::Landmarks;
use crate::check::{Finding, Given, examine, in_order};
use crate::garment::Garment;
use crate::io::findings::{finding_part, seam_ease};
use crate::io::length::describe;
use crate::pattern::Fabric;
use crate::pattern::sewing::{ease_of, plans_of};
use crate::prepositioning::{distance_field, worn_heights};
use crate::{Code, Error, Severity};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::Write as _;

pub fn run(asked: &Check) -> Result<Status, Failure> {
    let looked = look(asked)?;
    let wrong = looked.findings.iter().filter(|finding| finding.severity == Severity::Error);
    if asked.json {
        print(&format!("{:#}\n", looked.json()))?;
    } else {
        wrong.clone().for_each(|finding| complaint::print(&finding.error));
        print(&looked.words())?;
    }
    Ok(if wrong.count() > 0 { Status::InvalidInput } else { Status::Fine })
}

fn print(text: &str) -> Result<(), Error> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        // Whoever closed the pipe has read enough.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(format!("The findings cannot be written ({e})."), "Make room, or write them elsewhere."))
        }
        _ => Ok(()),
    }
}

/// What could be read and built, and all that was found.
struct Looked {
    pattern: Option<PatternInput>,
    garment: Option<Garment>,
    body: Option<BodyInput>,
    findings: Vec<Finding>,
    /// As messages name them.
    files: Vec<String>,
}

fn look(asked: &Check) -> Result<Looked, Failure> {
    let resolutions = asked.resolutions()?;
    let options = asked.reading.options()?;
    let mut findings: Vec<Finding> = Vec::new();
    let fabric = match fabric(asked.fabric.as_deref()) {
        Err(Failure::Input(error)) => {
            findings.extend(Finding::of_error(error, Code::FabricUnusable));
            Fabric::default()
        }
        other => other?,
    };
    let clearance = asked.clearance(&fabric)?;
    let opened = PatternInput::open(&asked.pattern, &options);
    let mut pattern = opened.map_err(|e| findings.extend(Finding::of_error(e, Code::PatternUnreadable))).ok();
    let (mut is_sewn, mut is_placeable) = (true, true);
    if let (Some(input), Some(seams)) = (&mut pattern, asked.seams.as_deref()) {
        let sewn = input.sew(seams).map_err(|e| findings.extend(Finding::of_error(e, Code::SeamUnusable)));
        is_sewn = sewn.is_ok();
    }
    let garment = pattern.as_ref().and_then(|input| {
        let built = Garment::build(&input.pattern, &resolutions).map_err(|e| e.within(&input.place));
        built.map_err(|e| findings.extend(Finding::of_error(e, Code::PanelTooNarrow))).ok()
    });
    let opened = asked.body.as_deref().map(|path| Ok(BodyInput::open(path, asked.align)?.looked_over())).transpose();
    let body = opened.unwrap_or_else(|e: Error| {
        findings.extend(Finding::of_error(e, Code::BodyUnreadable));
        None
    });
    if let (Some(input), Some(body), true) = (&mut pattern, &body, is_sewn)
        && let Err(Failure::Input(e) | Failure::Usage(e)) =
            place_all(std::slice::from_mut(input), body, &asked.placing, true)
    {
        // Placing builds the garment as well, and finds again what cannot be built.
        let found = Finding::of_error(e, Code::PlacingFailed).into_iter();
        let is_known =
            |new: &Finding| findings.iter().any(|old| old.code == new.code && old.error.places() == new.error.places());
        let new: Vec<Finding> = found.filter(|new| !is_known(new)).collect();
        findings.extend(new);
        is_placeable = false;
    }
    if let Some(input) = &pattern {
        let seams = asked.seams.as_ref().map(|path| path.display().to_string());
        for warning in &input.warnings {
            let finding = Finding::of_warning(warning, Code::LeftAside);
            let of_seams = warning.0.places().first() == seams.as_ref() && seams.is_some();
            findings.push(if of_seams { finding } else { finding.with_file(&input.place) });
        }
        let is_placed = input.pattern.is_placed();
        let landmarks = body.as_ref().filter(|_| is_placed).and_then(|body| match Landmarks::find(&body.body) {
            Ok(marks) => Some(marks),
            Err(error) => {
                findings.push(Finding::without_landmarks(&error, &body.name));
                None
            }
        });
        let field = body.as_ref().filter(|_| is_placed);
        let field = field.map(|body| distance_field(&body.body, clearance, worn_heights([&input.pattern])));
        let found = examine(&Given {
            pattern: &input.pattern,
            resolutions: &resolutions,
            garment: garment.as_ref(),
            eased: &input.eased,
            fabric: &fabric,
            clearance,
            body: body.as_ref().map(|body| &body.body),
            landmarks: landmarks.as_ref(),
            field: field.as_ref(),
        });
        // A file of seams that cannot be used has been told of; that nothing is sewn follows. So does, from what hinders placing, that
        // nothing is placed.
        let follows = |finding: &Finding| match finding.code {
            Code::NoSeams => !is_sewn,
            Code::Unplaced => !is_placeable,
            _ => false,
        };
        findings.extend(found.into_iter().filter(|f| !follows(f)).map(|f| f.with_file(&input.place)));
    }
    if let Some(body) = &body {
        findings.extend(body.warnings.iter().map(|w| Finding::of_warning(w, Code::BodyMisplaced)));
    }
    in_order(&mut findings);
    let files = [Some(&asked.pattern), asked.seams.as_ref(), asked.body.as_ref(), asked.placing.arrangement.as_ref()];
    let files = files.into_iter().flatten().map(|path| path.display().to_string()).collect();
    Ok(Looked { pattern, garment, body, findings, files })
}

impl Looked {
    /// What the input is, and what is doubtful about it; errors are told elsewhere.
    fn words(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        if let Some(PatternInput { pattern, .. }) = &self.pattern {
            let area: f64 = pattern.panels.iter().map(|p| p.signed_area().abs()).sum();
            let seams: f64 = pattern.seams.iter().map(|s| pattern.seam_lengths(s)[0]).sum();
            let counted = |count: usize, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
            let _ = writeln!(
                text,
                "pattern {}: {} of {area:.2} m² in all, {} of {:.2} m",
                pattern.name,
                counted(pattern.panels.len(), "panel"),
                counted(pattern.seams.len(), "seam"),
                seams.abs()
            );
        }
        for level in self.garment.iter().flat_map(|garment| &garment.levels) {
            let (particles, triangles) = (level.particle_count, level.triangles.len());
            let at = describe(level.resolution);
            let _ = writeln!(text, "  at {at}: {particles} particles, {triangles} triangles");
        }
        if let Some(body) = &self.body {
            let (low, high) = body.body.bounds();
            let (vertices, triangles) = (body.body.positions().len(), body.body.triangles().len());
            let tall = high.y - low.y;
            let _ = writeln!(text, "body {}: {vertices} vertices, {triangles} triangles, {tall:.2} m tall", body.name);
            if let Some(alignment) = &body.alignment {
                let _ = writeln!(text, "  aligned: it is {}", alignment.describe());
            }
        }
        let (doubts, wrong): (Vec<&Finding>, Vec<&Finding>) =
            self.findings.iter().partition(|finding| finding.severity == Severity::Warning);
        let things = |count: usize| if count == 1 { "1 thing".to_owned() } else { format!("{count} things") };
        let wrong =
            if wrong.is_empty() { "nothing wrong".to_owned() } else { format!("{} wrong", things(wrong.len())) };
        let _ = match doubts.len() {
            0 => writeln!(text, "{wrong}, nothing doubtful"),
            count => writeln!(text, "{wrong}, {} to know:", things(count)),
        };
        for Finding { code, error, .. } in doubts {
            let _ = writeln!(text, "  - {code} {error}\n      {}", error.remedy());
        }
        text
    }

    fn json(&self) -> Value {
        let count = |severity: Severity| self.findings.iter().filter(|finding| finding.severity == severity).count();
        let findings: Vec<_> = self.findings.iter().map(|finding| finding_part(finding, &self.files)).collect();
        let pattern = self.pattern.as_ref().map(|input| &input.pattern);
        let ease = pattern.map_or(Vec::new(), |pattern| ease_of(pattern, &plans_of(pattern)));
        json!({
            "format": "toile check",
            "version": 1,
            "toile_version": env!("CARGO_PKG_VERSION"),
            "errors": count(Severity::Error),
            "warnings": count(Severity::Warning),
            "findings": findings,
            "pattern": self.pattern.as_ref().map(|input| self.pattern_json(input)),
            "body": self.body.as_ref().map(body_json),
            "seams": ease.iter().map(seam_ease).collect::<Vec<_>>(),
        })
    }

    fn pattern_json(&self, input: &PatternInput) -> Value {
        let levels = self.garment.iter().flat_map(|garment| &garment.levels);
        let level = |level: &crate::garment::Level| {
            json!({
                "resolution_m": level.resolution,
                "particles": level.particle_count,
                "triangles": level.triangles.len(),
            })
        };
        let area: f64 = input.pattern.panels.iter().map(|p| p.signed_area().abs()).sum();
        json!({
            "name": input.pattern.name,
            "sha256": input.sha256,
            "panels": input.pattern.panels.len(),
            "seams": input.pattern.seams.len(),
            "area_m2": area,
            "placed": input.pattern.is_placed(),
            "levels": levels.map(level).collect::<Vec<_>>(),
        })
    }
}

fn body_json(body: &BodyInput) -> Value {
    let (low, high) = body.body.bounds();
    json!({
        "name": body.name,
        "sha256": body.sha256,
        "vertices": body.body.positions().len(),
        "triangles": body.body.triangles().len(),
        "height_m": high.y - low.y,
        "alignment": body.alignment.as_ref().map(crate::io::report::AlignmentPart::from),
    })
}
