//! `toile demo`: the embedded pattern on the embedded body.

use super::arguments::{Demo, Garment};
use super::inputs::{BodyInput, PatternInput, fabrics, settings_text};
use super::{Failure, Status, fit};
use crate::io::{dxf, embedded};
use std::time::Instant;

pub fn run(asked: &Demo) -> Result<Status, Failure> {
    let started = Instant::now();
    let fabrics = fabrics(asked.solving.fabric.as_deref(), 1)?;
    let settings = asked.solving.settings(settings_text(&asked.solving)?.as_deref(), &fabrics[0])?;
    fit::start_threads(asked.solving.threads()?);
    let (name, text) = match asked.garment {
        Garment::Tee => ("tee", embedded::TEE),
        Garment::Dress => ("dress", embedded::DRESS),
    };
    let pattern = PatternInput::parse(text.as_bytes(), name, "the embedded pattern", &dxf::Options::default())?;
    let body = BodyInput::parse(embedded::MANNEQUIN_OBJ, "mannequin")?;
    fit::fit(&[pattern], &fabrics, &body, &settings, &asked.solving, &asked.out, started)
}
