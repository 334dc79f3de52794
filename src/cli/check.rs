//! `toile check`: what is wrong or doubtful with the input, before any solving.
//!
//! A first form: what the readers and the discretization find, seams of unequal lengths, and how the
//! panels stand to the body. Findings go to the standard output stream.

use super::arguments::Check;
use super::inputs::{BodyInput, PatternInput};
use super::place::place_all;
use super::{Failure, Status, complaint};
use crate::arrangement::{Care, arrange, check_placement, placed};
use crate::garment::Garment;
use crate::geometry::Vector3;
use crate::io::length::describe;
use crate::pattern::Pattern;
use crate::prepositioning::{DEFAULT_CLEARANCE, distance_field};
use crate::{Error, Warning};
use std::fmt::Write as _;
use std::io::Write as _;

/// Sides of a seam that differ by more than this share are mentioned: the one is gathered or eased.
const UNEQUAL: f64 = 0.01;
/// Panels that have to be moved farther than this to clear the body are mentioned, m.
const FAR_MOVE: f64 = 0.03;

pub fn run(asked: &Check) -> Result<Status, Failure> {
    let resolutions = asked.resolutions()?;
    // What is wrong with the one file must not hide what is wrong with the other.
    let mut errors: Vec<Error> = Vec::new();
    let mut sound = |result: Result<_, Error>| result.map_err(|e| errors.push(e)).ok();
    let options = asked.reading.options()?;
    let opened = sound(PatternInput::open_sewn(&asked.pattern, asked.seams.as_deref(), &options).and_then(|input| {
        let built = Garment::build(&input.pattern, &resolutions).map_err(|e| e.within(&input.place));
        built.map(|garment| (input, garment))
    }));
    let body = match asked.body.as_deref().map(|path| Ok(BodyInput::open(path, asked.align)?.looked_over())).transpose()
    {
        Ok(body) => body,
        Err(e) => {
            errors.push(e);
            None
        }
    };
    let mut opened = opened;
    if let (Some((input, _)), Some(body)) = (&mut opened, &body)
        && let Err(Failure::Input(e) | Failure::Usage(e)) =
            place_all(std::slice::from_mut(input), body, &asked.placing, true)
    {
        errors.push(e);
    } else if let (Some((input, _)), Some(body)) = (&opened, &body)
        && input.pattern.is_placed()
        && let Err(e) = check_placement(&input.pattern, &body.body)
    {
        errors.push(e.within(&input.place));
    }
    errors.iter().for_each(complaint::print);
    match opened {
        Some((input, garment)) if errors.is_empty() => findings(&input, &garment, body.as_ref()),
        _ => Ok(Status::InvalidInput),
    }
}

/// Tells what the input is, and what is doubtful about it.
fn findings(input: &PatternInput, garment: &Garment, body: Option<&BodyInput>) -> Result<Status, Failure> {
    let pattern = &input.pattern;
    let mut text = String::new();
    describe_pattern(&mut text, pattern);
    for level in &garment.levels {
        let _ = writeln!(
            text,
            "  at {}: {} particles, {} triangles",
            describe(level.resolution),
            level.particle_count,
            level.triangles.len()
        );
    }
    let mut doubts: Vec<String> = input.warnings.iter().map(told).collect();
    doubts.extend(unfinished(pattern));
    doubts.extend(unequal_seams(pattern));
    if let Some(body) = body {
        doubts.extend(body.warnings.iter().map(told));
        let (low, high) = body.body.bounds();
        let _ = writeln!(
            text,
            "body {}: {} vertices, {} triangles, {:.2} m tall",
            body.name,
            body.body.positions().len(),
            body.body.triangles().len(),
            high.y - low.y
        );
        if let Some(alignment) = &body.alignment {
            let _ = writeln!(text, "  aligned: it is {}", alignment.describe());
        }
        if pattern.is_placed() {
            doubts.extend(standing(pattern, garment, body));
        }
    }
    let verdict = match doubts.len() {
        0 => "nothing wrong, nothing doubtful".to_owned(),
        1 => "nothing wrong, 1 thing to know:".to_owned(),
        n => format!("nothing wrong, {n} things to know:"),
    };
    let _ = writeln!(text, "{verdict}");
    for doubt in &doubts {
        let _ = writeln!(text, "  - {doubt}");
    }
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        // Whoever closed the pipe has read enough.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(format!("The findings cannot be written ({e})."), "Make room, or write them elsewhere.")
                .into())
        }
        _ => Ok(Status::Fine),
    }
}

fn told(warning: &Warning) -> String {
    format!("{warning} {}", warning.0.remedy())
}

fn describe_pattern(text: &mut String, pattern: &Pattern) {
    let area: f64 = pattern.panels.iter().map(|p| p.signed_area().abs()).sum();
    let seam = pattern.seams.iter().map(|s| pattern.seam_lengths(s)[0]).fold(0.0, |sum, length| sum + length);
    let _ = writeln!(
        text,
        "pattern {}: {} panels of {area:.2} m² in all, {} seams of {seam:.2} m",
        pattern.name,
        pattern.panels.len(),
        pattern.seams.len(),
    );
}

/// What a drawing does not hold, and a fit needs.
fn unfinished(pattern: &Pattern) -> Vec<String> {
    let mut doubts = Vec::new();
    let lying = pattern.panels.iter().filter(|p| p.placement.is_none()).count();
    if lying > 0 {
        doubts.push(format!(
            "{lying} of {} panels lie in the plane as drawn, without a place around the body; the pattern cannot be fitted yet.",
            pattern.panels.len()
        ));
    }
    if pattern.seams.is_empty() {
        doubts.push("The pattern has no seams: nothing will be sewn.".to_owned());
    }
    doubts
}

fn unequal_seams(pattern: &Pattern) -> impl Iterator<Item = String> + '_ {
    pattern.seams.iter().filter_map(|seam| {
        let [a, b] = pattern.seam_lengths(seam);
        let (longer, shorter) = (a.max(b), a.min(b));
        (longer > shorter * (1.0 + UNEQUAL)).then(|| {
            format!(
                "{}: {:.1} cm is sewn to {:.1} cm; the longer side is gathered by {:.0} %.",
                pattern.seam_name(seam),
                longer * 100.0,
                shorter * 100.0,
                (longer / shorter - 1.0) * 100.0
            )
        })
    })
}

/// How the panels stand to the body, and how far the arrangement will move them.
fn standing(pattern: &Pattern, garment: &Garment, body: &BodyInput) -> Vec<String> {
    let mut doubts = Vec::new();
    let positions = placed(pattern, &garment.open);
    for (panel, range) in pattern.panels.iter().zip(&garment.open.panels) {
        let inside = |p: &&Vector3| body.body.contains(**p);
        let count = positions[range.points.clone()].iter().filter(inside).count();
        if count > 0 {
            let of = range.points.len();
            doubts.push(format!("panel \"{}\": {count} of {of} particles start inside the body.", panel.name));
        }
    }
    let field = distance_field(&body.body, DEFAULT_CLEARANCE);
    let shifts = arrange(pattern, &garment.open, &body.body, &field, Care::Seams).shifts;
    for (panel, shift) in pattern.panels.iter().zip(shifts) {
        if shift.norm() > FAR_MOVE {
            doubts.push(format!(
                "panel \"{}\" will be moved by ({:.0}, {:.0}, {:.0}) mm first, so that its seams clear the body.",
                panel.name,
                shift.x * 1e3,
                shift.y * 1e3,
                shift.z * 1e3
            ));
        }
    }
    doubts
}
