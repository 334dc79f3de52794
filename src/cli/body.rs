//! `toile body`: what is recognized in a body.

use super::arguments::{Align, Body};
use super::inputs::BodyInput;
use super::{Failure, Status};
use crate::Error;
use crate::body::{Alignment, Landmarks};
use crate::geometry::Vector3;
use crate::io::atomic;
use crate::io::picture::{BodyView, Marks, measured};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::io::Write as _;

pub fn run(asked: &Body) -> Result<Status, Failure> {
    let input = BodyInput::open(&asked.body, Align::Auto)?;
    let alignment = input.alignment.as_ref().expect("it was asked for");
    let landmarks = Landmarks::find(&input.body).map_err(|e| e.within(asked.body.display()))?;
    if let Some(file) = &asked.picture {
        atomic::write(file, &picture(&input, &landmarks))?;
    }
    let told = if asked.json { json(&input, alignment, &landmarks) } else { words(&input, alignment, &landmarks) };
    match std::io::stdout().lock().write_all(told.as_bytes()) {
        // Whoever closed the pipe has read enough.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(format!("The findings cannot be written ({e})."), "Make room, or write them elsewhere.")
                .into())
        }
        _ => Ok(Status::Fine),
    }
}

/// The body with every third section of its limbs, its named girths and its points.
fn picture(input: &BodyInput, landmarks: &Landmarks) -> Vec<u8> {
    let limbs = landmarks.arms.iter().chain(&landmarks.legs);
    let mut marks = Marks::default();
    // The first section of a limb is its joint, inside the body.
    limbs.for_each(|limb| marks.sections.extend(limb.outlines.iter().skip(1).step_by(3).cloned()));
    let levels = landmarks.torso.axis.iter().zip(&landmarks.torso.outlines);
    for y in [landmarks.bust, landmarks.underbust, landmarks.waist, landmarks.hip] {
        let nearest = levels.clone().min_by(|a, b| (a.0.y - y).abs().total_cmp(&(b.0.y - y).abs()));
        marks.girths.extend(nearest.map(|(_, outline)| outline.clone()));
    }
    marks.girths.extend(landmarks.neck_column.outlines.last().cloned());
    marks.points = landmarks.points().into_iter().flat_map(|(_, points)| points).collect();
    let skin = BodyView { positions: bytemuck::cast_slice(input.body.positions()), triangles: input.body.triangles() };
    measured(&marks, &skin)
}

fn words(input: &BodyInput, alignment: &Alignment, landmarks: &Landmarks) -> String {
    let mut text = format!(
        "body {}: {} vertices, {} triangles, {:.3} m tall\nit is {}\n",
        input.name,
        input.body.positions().len(),
        input.body.triangles().len(),
        landmarks.height(),
        alignment.describe()
    );
    // Writing to a string cannot fail.
    let _ = writeln!(text, "points, m (x to its left, y up, z to the front):");
    for (name, points) in landmarks.points() {
        let places: Vec<String> = points.iter().map(|p| format!("({:.3}, {:.3}, {:.3})", p.x, p.y, p.z)).collect();
        let _ = writeln!(text, "  {name:<12} {}", places.join("  "));
    }
    let _ = writeln!(text, "heights above the floor, cm:");
    for (name, y) in landmarks.heights() {
        let _ = writeln!(text, "  {name:<12} {:.1}", 100.0 * (y - landmarks.floor));
    }
    let _ = writeln!(text, "girths of a taut tape, cm:");
    for (name, girth) in landmarks.girths() {
        let _ = writeln!(text, "  {name:<12} {:.1}", 100.0 * girth);
    }
    for warning in &input.warnings {
        let _ = writeln!(text, "- {warning} {}", warning.0.remedy());
    }
    text
}

fn json(input: &BodyInput, alignment: &Alignment, landmarks: &Landmarks) -> String {
    let place = |p: &Vector3| json!([p.x, p.y, p.z]);
    let points: Map<String, Value> = landmarks
        .points()
        .into_iter()
        .map(|(name, points)| (name.replace(' ', "_"), points.iter().map(place).collect()))
        .collect();
    let lengths = |list: Vec<(&str, f64)>| -> Map<String, Value> {
        list.into_iter().map(|(name, length)| (name.replace(' ', "_"), json!(length))).collect()
    };
    let told = json!({
        "format": "toile body",
        "version": 1,
        "body": {"name": input.name, "sha256": input.sha256, "height_m": landmarks.height()},
        "alignment": {
            "unit": alignment.unit,
            "up": alignment.up,
            "facing": alignment.facing,
            "scale": alignment.scale,
            "world_from_file": alignment.world_from_file(),
        },
        "points_m": points,
        "heights_m": lengths(landmarks.heights()),
        "girths_m": lengths(landmarks.girths()),
    });
    format!("{told:#}\n")
}
