//! What a command is given, read and checked.

use super::arguments::Solving;
use super::stopwatch::Moment;
use super::{Failure, complaint};
use crate::body::Body;
use crate::io::report::Stage;
use crate::io::{body_obj, fabric_toml, garmentcode, read, seams_toml, state};
use crate::pattern::{Fabric, Pattern};
use crate::{Error, Warning};
use std::path::Path;

/// A pattern, the text it came from, and what to call it.
pub struct PatternInput {
    pub pattern: Pattern,
    /// The file, for messages.
    pub place: String,
    pub text: String,
    /// The file of seams that it is sewn with, if one was given.
    pub seams_text: Option<String>,
    pub sha256: String,
    pub warnings: Vec<Warning>,
}

impl PatternInput {
    /// Reads a pattern file and sews it by a file of seams, if one is given.
    pub fn open_sewn(path: &Path, seams: Option<&Path>) -> Result<Self, Error> {
        let mut input = Self::open(path)?;
        let Some(seams) = seams else { return Ok(input) };
        let text = read::text(seams)?;
        let within = |e: Error| e.within(seams.display());
        let sewn = seams_toml::sew(&input.pattern, &text).map_err(within)?;
        if !input.pattern.seams.is_empty() {
            input.warnings.push(Warning(
                Error::new(
                    format!(
                        "The {} seams of the pattern itself are left aside for those of this file.",
                        input.pattern.seams.len()
                    ),
                    "Leave --seams out to sew the pattern's own.",
                )
                .within(seams.display()),
            ));
        }
        for (panel, _) in input.pattern.panels.iter().zip(&sewn.turned).filter(|(_, turned)| **turned) {
            input.warnings.push(Warning(
                Error::new(
                    "The panel is turned over, so that the right sides of all panels lie outside.",
                    "If it is drawn right side up, look at the seams around it with `toile seams show`.",
                )
                .within(format!("panel \"{}\"", panel.name))
                .within(seams.display()),
            ));
        }
        input.warnings.extend(sewn.warnings.into_iter().map(|w| Warning(within(w.0))));
        input.pattern = sewn.pattern;
        input.seams_text = Some(text);
        Ok(input)
    }

    /// Reads a pattern file.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let place = path.display().to_string();
        Self::parse(read::text(path)?, &name_of(path), &place).map_err(|e| e.within(place))
    }

    pub fn parse(text: String, name: &str, place: &str) -> Result<Self, Error> {
        let (pattern, warnings) = garmentcode::parse(&text, name)?;
        let sha256 = read::sha256_hex(text.as_bytes());
        Ok(Self { pattern, place: place.to_owned(), sha256, text, seams_text: None, warnings })
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
    /// What it wears, innermost first.
    pub worn: Vec<WornInput>,
}

/// A garment that the body wears already.
pub struct WornInput {
    pub name: String,
    pub sha256: String,
    /// Of its fabric, m.
    pub thickness: f64,
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
        let sha256 = read::sha256_hex(bytes);
        Ok(Self { body, name: name.to_owned(), sha256, warnings, stage, worn: Vec::new() })
    }

    /// Puts on a garment that was fitted before: the folder of its results, or its state.
    pub fn put_on(&mut self, path: &Path) -> Result<(), Error> {
        let file = if path.is_dir() { path.join("state.toile") } else { path.to_owned() };
        let bytes = read::bytes(&file)?;
        let within = |e: Error| e.within(file.display());
        let state = state::read(&bytes).map_err(within)?;
        let (_, garment) = state.rebuild().map_err(within)?;
        if state.body_sha256 != self.sha256 {
            self.warnings.push(Warning(
                Error::new(
                    format!("It was fitted on another body, \"{}\".", state.body_name),
                    "Fit it on this body first, unless the two are the same in place and shape.",
                )
                .within(file.display()),
            ));
        }
        let finest = garment.levels.last().expect("a garment has at least one level");
        self.body = self.body.dressed(&state.positions, &finest.particle_triangles());
        let sha256 = read::sha256_hex(&bytes);
        self.worn.push(WornInput { name: state.pattern_name, sha256, thickness: state.fabric.thickness });
        Ok(())
    }
}

/// The name of a file without its folder and its ending.
fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

/// The fabrics asked for, one for each garment: either one for all of them or a list with commas between.
pub fn fabrics(asked: Option<&str>, garments: usize) -> Result<Vec<Fabric>, Failure> {
    let Some(list) = asked.filter(|list| garments > 1 && list.contains(',')) else {
        return Ok(vec![fabric(asked)?; garments]);
    };
    let named: Vec<&str> = list.split(',').map(str::trim).collect();
    if named.len() != garments {
        return Err(Failure::Usage(
            Error::new(
                format!("{} fabrics are listed for {garments} garments.", named.len()),
                "Give one for all, or one for each in the order of the patterns.",
            )
            .within("--fabric"),
        ));
    }
    named.into_iter().map(|one| fabric(Some(one))).collect()
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
