//! `toile convert`: a pattern of any kind in the format of toile.

use super::arguments::Convert;
use super::inputs::{PatternInput, tell};
use super::{Failure, Status};
use crate::Error;
use crate::io::{atomic, toile_pattern};

pub fn run(asked: &Convert) -> Result<Status, Failure> {
    let ending = asked.out.extension().map(|e| e.to_string_lossy().to_lowercase());
    let write = match ending.as_deref() {
        Some("toml") => toile_pattern::write_toml,
        Some("json") => toile_pattern::write_json,
        _ => {
            let error = Error::new(
                format!("The file {} ends neither in .toml nor in .json.", asked.out.display()),
                "Give it one of the two endings.",
            );
            return Err(Failure::Usage(error.within("--out")));
        }
    };
    let input = PatternInput::open(&asked.pattern, &asked.reading.options()?)?;
    tell(&input.warnings.iter().collect::<Vec<_>>(), false);
    atomic::write(&asked.out, write(&input.pattern).as_bytes())?;
    let pattern = &input.pattern;
    eprintln!(
        "{}: {} panels, {} seams, {}; written to {}",
        pattern.name,
        pattern.panels.len(),
        pattern.seams.len(),
        if pattern.is_placed() { "placed around a body" } else { "lying in the plane" },
        asked.out.display()
    );
    Ok(Status::Fine)
}
