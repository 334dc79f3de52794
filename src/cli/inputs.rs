//! What a command is given, read and checked.

use super::arguments::{Align, Solving};
use super::stopwatch::Moment;
use super::{Failure, complaint};
use crate::arrangement::check_placed;
use crate::body::{Alignment, Body};
use crate::geometry::Vector3;
use crate::io::report::Stage;
use crate::io::{body_obj, dxf, fabric_toml, pattern_file, read, seams_toml, state};
use crate::pattern::{Fabric, Pattern};
use crate::{Code, Error, Warning};
use std::path::Path;

/// A pattern, and what to call it.
pub struct PatternInput {
    pub pattern: Pattern,
    /// The file, for messages.
    pub place: String,
    /// Of the file.
    pub sha256: String,
    pub warnings: Vec<Warning>,
    /// Per seam: is its ease stated? Empty where none is.
    pub eased: Vec<bool>,
}

impl PatternInput {
    /// Reads a pattern file and sews it by a file of seams, if one is given.
    pub fn open_sewn(path: &Path, seams: Option<&Path>, options: &dxf::Options) -> Result<Self, Error> {
        let mut input = Self::open(path, options)?;
        if let Some(seams) = seams {
            input.sew(seams)?;
        }
        Ok(input)
    }

    /// Sews it by a file of seams instead of its own.
    pub fn sew(&mut self, seams: &Path) -> Result<(), Error> {
        let input = self;
        let text = read::text(seams).map_err(|e| e.coded(Code::SeamUnusable))?;
        let within = |e: Error| e.coded(Code::SeamUnusable).within(seams.display());
        let sewn = seams_toml::sew(&input.pattern, &text).map_err(within)?;
        let note = |problem: String, remedy: &str| Error::new(problem, remedy).coded(Code::SeamNote);
        if !input.pattern.seams.is_empty() {
            let count = input.pattern.seams.len();
            let error = note(
                format!("The {count} seams of the pattern itself are left aside for those of this file."),
                "Leave --seams out to sew the pattern's own.",
            );
            input.warnings.push(Warning(error.within(seams.display())));
        }
        for (panel, _) in sewn.pattern.panels.iter().zip(&sewn.turned).filter(|(_, turned)| **turned) {
            let error = note(
                "The panel is turned over, so that the right sides of all panels lie outside.".to_owned(),
                "If it is drawn right side up, look at the seams around it with `toile seams show`.",
            );
            input.warnings.push(Warning(error.within(format!("panel \"{}\"", panel.name)).within(seams.display())));
        }
        let noted = |w: Warning| Warning(w.0.coded(Code::SeamNote).within(seams.display()));
        input.warnings.extend(sewn.warnings.into_iter().map(noted));
        (input.pattern, input.eased) = (sewn.pattern, sewn.eased);
        Ok(())
    }

    /// Reads a pattern file of any kind.
    pub fn open(path: &Path, options: &dxf::Options) -> Result<Self, Error> {
        let place = path.display().to_string();
        let bytes = read::bytes(path).map_err(|e| e.coded(Code::PatternUnreadable))?;
        Self::parse(&bytes, &name_of(path), &place, options).map_err(|e| e.within(place))
    }

    pub fn parse(bytes: &[u8], name: &str, place: &str, options: &dxf::Options) -> Result<Self, Error> {
        let (pattern, warnings) = pattern_file::open(bytes, name, options)?;
        let eased = pattern_file::stated_ease(bytes);
        Ok(Self { pattern, place: place.to_owned(), sha256: read::sha256_hex(bytes), warnings, eased })
    }

    /// Is there anything that holds its panels together?
    pub fn check_sewn(&self) -> Result<(), Error> {
        if self.pattern.panels.len() < 2 || !self.pattern.seams.is_empty() {
            return Ok(());
        }
        Err(Error::new(
            format!(
                "Its {} panels have no seams: drawings such as DXF and FreeSewing hold none.",
                self.pattern.panels.len()
            ),
            "Have seams proposed with `toile seams suggest`, look them over, and give the file with --seams.",
        )
        .coded(Code::NoSeams)
        .within(&self.place))
    }

    /// The same, if it can be fitted: its panels have places around the body.
    pub fn for_fitting(self) -> Result<Self, Error> {
        check_placed(&self.pattern).map_err(|e| e.within(&self.place))?;
        Ok(self)
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
    /// How it was brought into our frame, if that was asked for, and the mesh there as an OBJ file.
    pub alignment: Option<Alignment>,
    pub aligned_obj: Option<String>,
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
    pub fn open(path: &Path, align: Align) -> Result<Self, Error> {
        let read = || {
            let bytes = read::bytes(path)?;
            match align {
                Align::Auto => Self::aligned(&bytes, &name_of(path)),
                Align::None => {
                    let mut input = Self::parse(&bytes, &name_of(path)).map_err(|e| with_alignment(e, &bytes))?;
                    if !stands_plainly(&input.body) {
                        input.warnings.extend(misplaced(&input.body));
                    }
                    Ok(input)
                }
            }
        };
        read().map_err(|e: Error| e.coded(Code::BodyUnreadable).within(path.display()))
    }

    pub fn parse(bytes: &[u8], name: &str) -> Result<Self, Error> {
        let (positions, triangles) = body_obj::mesh(bytes)?;
        Self::of_mesh(bytes, name, positions, triangles)
    }

    /// The same, brought into our frame first.
    fn aligned(bytes: &[u8], name: &str) -> Result<Self, Error> {
        let (mut positions, triangles) = body_obj::mesh(bytes)?;
        let alignment = Alignment::recognize(&positions, &triangles)?;
        positions.iter_mut().for_each(|p| *p = alignment.apply(*p));
        let obj = body_obj::write(&positions, &triangles);
        let mut input = Self::of_mesh(bytes, name, positions, triangles)?;
        (input.alignment, input.aligned_obj) = (Some(alignment), Some(obj));
        Ok(input)
    }

    fn of_mesh(bytes: &[u8], name: &str, positions: Vec<Vector3>, triangles: Vec<[u32; 3]>) -> Result<Self, Error> {
        let start = Moment::now();
        let (body, warnings) = Body::new(positions, triangles)?;
        let stage = start.stage("body");
        let sha256 = read::sha256_hex(bytes);
        let (alignment, aligned_obj) = (None, None);
        Ok(Self { body, name: name.to_owned(), sha256, warnings, stage, alignment, aligned_obj, worn: Vec::new() })
    }

    /// The same, looked at more closely than a fit has time for.
    pub fn looked_over(mut self) -> Self {
        if self.alignment.is_none() && stands_plainly(&self.body) {
            self.warnings.extend(misplaced(&self.body));
        }
        self
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
                .coded(Code::WornElsewhere)
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

/// The same error; with the way out, if it is only that the body lies otherwise.
fn with_alignment(error: Error, bytes: &[u8]) -> Error {
    let recognized =
        body_obj::mesh(bytes).and_then(|(positions, triangles)| Alignment::recognize(&positions, &triangles));
    match recognized {
        Ok(alignment) if !alignment.is_identity() => {
            let remedy = format!(
                "{} Or give --align auto, which takes it as {}, {} up, facing {}.",
                error.remedy(),
                alignment.unit,
                alignment.up,
                alignment.facing
            );
            Error::new(error.problem(), remedy).coded(error.code().unwrap_or(Code::BodyUnreadable))
        }
        _ => error,
    }
}

/// Does the body stand over the origin, broader than deep? Then it is not looked at more closely before every fit, which
/// takes as long as the coarsest levels; `check` does so.
fn stands_plainly(body: &Body) -> bool {
    let (low, high) = body.bounds();
    let (middle, extent) = ((low + high) * 0.5, high - low);
    low.y.abs() < NEARLY && middle.x.abs() < NEARLY && extent.x > extent.z
}

/// m.
const NEARLY: f64 = 0.1;

/// A warning about a body that can be dressed, but stands where no pattern will be.
fn misplaced(body: &Body) -> Option<Warning> {
    let alignment = Alignment::recognize(body.positions(), body.triangles()).ok().filter(Alignment::is_far)?;
    let [x, y, z] = alignment.away();
    Some(Warning(Error::new(
        format!(
            "The body seems to be in {}, {} up, facing {}, and to stand at ({x:.2}, {y:.2}, {z:.2}) m.",
            alignment.unit, alignment.up, alignment.facing
        ),
        "Patterns are placed for a body in metres, y up, facing +z, that stands over the origin: give --align auto, or move it.",
    )
    .coded(Code::BodyMisplaced)))
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
        let text = read::text(path).map_err(|e| e.coded(Code::FabricUnusable))?;
        let within = |e: Error| e.coded(Code::FabricUnusable).within(path.display());
        return Ok(fabric_toml::parse(&text, &name_of(path)).map_err(within)?);
    }
    Fabric::named(asked).map_err(|e| Failure::Usage(e.coded(Code::FabricUnusable).within("--fabric")))
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
