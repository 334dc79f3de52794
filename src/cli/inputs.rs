//! What a command is given, read and checked.

use super::arguments::Solving;
use super::stopwatch::Moment;
use super::{Failure, complaint};
use crate::body::Body;
use crate::io::report::Stage;
use crate::io::{body_obj, fabric_toml, garmentcode, read};
use crate::pattern::{Fabric, Pattern};
use crate::{Error, Warning};
use std::path::Path;

/// A pattern, the text it came from, and what to call it.
pub struct PatternInput {
    pub pattern: Pattern,
    /// The file, for messages.
    pub place: String,
    pub text: String,
    pub sha256: String,
    pub warnings: Vec<Warning>,
}

impl PatternInput {
    /// Reads a pattern file.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let place = path.display().to_string();
        Self::parse(read::text(path)?, &name_of(path), &place).map_err(|e| e.within(place))
    }

    pub fn parse(text: String, name: &str, place: &str) -> Result<Self, Error> {
        let (pattern, warnings) = garmentcode::parse(&text, name)?;
        Ok(Self { pattern, place: place.to_owned(), sha256: read::sha256_hex(text.as_bytes()), text, warnings })
    }
}

/// A body, and what to call it.
pub struct BodyInput {
    pub body: Body,
    pub name: String,
    pub sha256: String,
    pub warnings: Vec<Warning>,
    /// What it took to make the body of its mesh.
    pub stage: Stage,
}

impl BodyInput {
    /// Reads a body file.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Self::parse(&read::bytes(path)?, &name_of(path)).map_err(|e| e.within(path.display()))
    }

    pub fn parse(bytes: &[u8], name: &str) -> Result<Self, Error> {
        let (positions, triangles) = body_obj::mesh(bytes)?;
        let start = Moment::now();
        let (body, warnings) = Body::new(positions, triangles)?;
        let stage = start.stage("body");
        Ok(Self { body, name: name.to_owned(), sha256: read::sha256_hex(bytes), warnings, stage })
    }
}

/// The name of a file without its folder and its ending.
fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

/// The fabric asked for: a file if the word looks like one, else a preset.
pub fn fabric(asked: Option<&str>) -> Result<Fabric, Failure> {
    let Some(asked) = asked else { return Ok(Fabric::default()) };
    let path = Path::new(asked);
    let is_file = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) || path.components().count() > 1;
    if is_file {
        let text = read::text(path)?;
        return Ok(fabric_toml::parse(&text, &name_of(path)).map_err(|e| e.within(path.display()))?);
    }
    Fabric::named(asked).map_err(|e| Failure::Usage(e.within("--fabric")))
}

/// The text of the settings file, if there is one.
pub fn settings_text(solving: &Solving) -> Result<Option<String>, Error> {
    solving.settings.as_deref().map(read::text).transpose()
}

/// Warnings in words, told unless nobody wants to hear.
pub fn tell(warnings: &[&Warning], silent: bool) -> Vec<String> {
    if !silent {
        warnings.iter().for_each(|w| complaint::print_warning(w));
    }
    warnings.iter().map(|w| format!("{w} {}", w.0.remedy())).collect()
}
