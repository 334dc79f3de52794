//! `toile place`, and what `fit` and `check` do with panels that have no place.

use super::arguments::{Place, PlaceBy, Placing};
use super::inputs::{BodyInput, PatternInput};
use super::{Failure, Status, complaint};
use crate::arrangement::placed;
use crate::arrangement::placing::{Override, Report, place};
use crate::body::Landmarks;
use crate::garment::Garment;
use crate::io::picture::{BodyView, GarmentView, preview};
use crate::io::{arrangement_toml, atomic, read};
use crate::{Code, Error};
use std::path::Path;

/// Resolution of the panels in the picture, m.
const PICTURE_RESOLUTION: f64 = 0.02;

pub fn run(asked: &Place) -> Result<Status, Failure> {
    let mut input = PatternInput::open_sewn(&asked.pattern, asked.seams.as_deref(), &asked.reading.options()?)?;
    let body = BodyInput::open(&asked.body, asked.align)?;
    let overrides = overrides(&input, asked.arrangement.as_deref())?;
    let report = place_one(&mut input, &body, &overrides)?;
    atomic::write(&asked.out, arrangement_toml::write(&input.pattern, &report).as_bytes())?;
    if let Some(file) = &asked.picture {
        atomic::write(file, &picture(&input, &body)?)?;
    }
    report.warnings.iter().for_each(complaint::print_warning);
    eprint!("{}", told(&input, &report));
    Ok(Status::Fine)
}

/// Places the panels of those patterns that need it, or for which it was asked, and tells so.
pub fn place_all(
    patterns: &mut [PatternInput],
    body: &BodyInput,
    asked: &Placing,
    silent: bool,
) -> Result<(), Failure> {
    if let (Some(file), [_, _, ..]) = (&asked.arrangement, &*patterns) {
        return Err(Failure::Usage(
            Error::new(
                "One arrangement file cannot be for several patterns.",
                "Fit the garments one after the other, with --over.",
            )
            .within(file.display()),
        ));
    }
    for input in patterns {
        let lacks = input.pattern.panels.iter().any(|panel| panel.placement.is_none());
        if asked.place == Some(PlaceBy::Pattern) || !(lacks || asked.place.is_some() || asked.arrangement.is_some()) {
            continue;
        }
        let overrides = overrides(input, asked.arrangement.as_deref())?;
        let report = place_one(input, body, &overrides)?;
        if !silent {
            eprint!("{}", told(input, &report));
        }
        input.warnings.extend(report.warnings);
    }
    Ok(())
}

fn overrides(input: &PatternInput, file: Option<&Path>) -> Result<Vec<Option<Override>>, Error> {
    let Some(file) = file else { return Ok(vec![None; input.pattern.panels.len()]) };
    let text = read::text(file).map_err(|e| e.coded(Code::PlacingFailed))?;
    let within = |e: Error| e.coded(Code::PlacingFailed).within(file.display());
    arrangement_toml::parse(&text, &input.pattern).map_err(within)
}

fn place_one(input: &mut PatternInput, body: &BodyInput, overrides: &[Option<Override>]) -> Result<Report, Error> {
    let failed = |e: Error| e.coded(Code::PlacingFailed);
    let marks = Landmarks::find(&body.body).map_err(|e| failed(e).within(format!("body \"{}\"", body.name)))?;
    place(&mut input.pattern, &body.body, &marks, overrides).map_err(|e| failed(e).within(&input.place))
}

/// A line for each panel.
fn told(input: &PatternInput, report: &Report) -> String {
    let mut text = format!(
        "{}: panels placed by themselves; seams close over {:.0} mm on average\n",
        input.pattern.name,
        report.mean_gap * 1e3
    );
    for placed in &report.panels {
        let stands = &placed.stands;
        let bent =
            stands.bend.map_or_else(String::new, |radius| format!(", bent to a radius of {:.0} mm", radius * 1e3));
        text += &format!(
            "  {}: {}, {:.2} m above the floor, faces {}{bent}\n",
            input.pattern.panels[placed.panel].name,
            placed.limb.name(),
            stands.height.unwrap_or(placed.middle.y),
            facing(placed.face),
        );
    }
    text
}

/// The word for a direction.
fn facing(face: crate::geometry::Vector3) -> &'static str {
    let words = [("left", "right"), ("up", "down"), ("front", "back")];
    let axis = face.iamax();
    if face[axis] > 0.0 { words[axis].0 } else { words[axis].1 }
}

fn picture(input: &PatternInput, body: &BodyInput) -> Result<Vec<u8>, Error> {
    let open = Garment::build(&input.pattern, &[PICTURE_RESOLUTION])?.open;
    let positions = placed(&input.pattern, &open);
    let garment = GarmentView {
        positions: bytemuck::cast_slice(&positions),
        triangles: &open.particle_triangles(),
        panels: &open.panel_of_triangle(),
        seams: &open.seam_edges(),
        colors: &[],
    };
    let skin = BodyView { positions: bytemuck::cast_slice(body.body.positions()), triangles: body.body.triangles() };
    Ok(preview(&garment, &skin))
}
