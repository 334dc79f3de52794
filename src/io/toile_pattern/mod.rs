//! Our own pattern format, TOML or JSON: all that a [`Pattern`] holds, to the last bit.
//!
//! `docs/formats.md` describes it, `docs/schema/pattern.schema.json` is its schema for editors. [`write_json`] and
//! [`write_toml`] write metres, so that reading gives the same numbers back; files made by hand may use another unit.

mod file;
mod reading;
mod writing;

use crate::pattern::Pattern;
use crate::{Error, Warning};
use file::File;
use reading::pattern_of;
use writing::file_of;

/// What a file of ours says of itself.
pub const FORMAT: &str = "toile pattern";
const VERSION: u32 = 1;

/// The pattern as JSON, one line.
pub fn write_json(pattern: &Pattern) -> String {
    serde_json::to_string(&file_of(pattern)).expect("all of it can be written")
}

/// The pattern as TOML.
pub fn write_toml(pattern: &Pattern) -> String {
    toml::to_string(&file_of(pattern)).expect("all of it can be written")
}

/// Reads JSON; `name` is what the garment is called if the file does not say.
pub fn parse_json(text: &str, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    let file = serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|e: serde_json::Error| {
        Error::new(
            format!("The pattern cannot be read: {e}."),
            "See docs/formats.md for the form of a pattern of toile.",
        )
    })?;
    pattern_of(file, name)
}

/// Reads TOML; `name` is what the garment is called if the file does not say.
pub fn parse_toml(text: &str, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    let text = text.trim_start_matches('\u{feff}');
    let file = toml::from_str(text).map_err(|e: toml::de::Error| {
        let line = e
            .span()
            .map(|span| 1 + text.as_bytes()[..span.start.min(text.len())].iter().filter(|&&b| b == b'\n').count());
        let error = Error::new(
            format!("The pattern cannot be read: {}.", e.message().trim_end_matches('.').replace('\n', ", ")),
            "See docs/formats.md for the form of a pattern of toile.",
        );
        line.map_or(error.clone(), |line| error.within(format!("line {line}")))
    })?;
    pattern_of(file, name)
}

/// Per seam: does it state its ease? Empty for what cannot be read.
pub fn stated_ease_json(text: &str) -> Vec<bool> {
    serde_json::from_str(text.trim_start_matches('\u{feff}')).map_or_else(|_| Vec::new(), |file| stated_ease(&file))
}

pub fn stated_ease_toml(text: &str) -> Vec<bool> {
    toml::from_str(text.trim_start_matches('\u{feff}')).map_or_else(|_| Vec::new(), |file| stated_ease(&file))
}

fn stated_ease(file: &File) -> Vec<bool> {
    file.seams.iter().map(|seam| seam.ease.is_some()).collect()
}

#[cfg(test)]
mod tests;
