//! Bodies that move: glTF, sequences of OBJ files, vertex caches on an OBJ body, motion capture on a glTF body.
//!
//! [`open`] is the door to all of them. It tells the format by what the file begins with, and a sequence by its name.
//! Nothing is turned or scaled: frames are in metres with y up, as the file has them, whichever way the body faces.

mod bvh;
pub mod gltf;
mod mdd;
mod obj_sequence;
mod pc2;
mod retarget;

pub use retarget::Retargeting;

use super::read;
use crate::body::Motion;
use crate::body::motion::{FRAME_RATES, MOST_FRAMES};
use crate::{Error, Warning};
use std::path::{Path, PathBuf};

/// What the name of a moving body leaves open.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The body that a vertex cache (OBJ) or a motion capture (glTF) moves.
    pub body: Option<PathBuf>,
    /// The clip of a glTF file, by its name or its number counted from 0. Else the first.
    pub clip: Option<String>,
    /// Nodes or meshes of a glTF file, by name. Else all of the scene.
    pub meshes: Vec<String>,
    /// Frames a second. Clips and motion captures are sampled so; of sequences and PC2 caches, which do not know, it is the
    /// rate of their frames, else 24.
    pub frame_rate: Option<f64>,
    /// Which joint of a BVH file moves which node of the body, where their names differ.
    pub joints: Vec<(String, String)>,
}

/// Frames a second of what does not tell.
pub const USUAL_FRAME_RATE: f64 = 24.0;

/// Reads a moving body: a `.glb` or `.gltf` file; a folder of OBJ files or a pattern such as `walk_%04d.obj` or `walk_####.obj`;
/// one OBJ file, which stands still; a `.pc2` or `.mdd` file with an OBJ body; a `.bvh` file with a glTF body.
pub fn open(path: &Path, options: &Options) -> Result<(Motion, Vec<Warning>), Error> {
    if let Some(rate) = options.frame_rate.filter(|rate| !FRAME_RATES.contains(rate)) {
        let remedy = format!("Between {} and {} are possible; films have 24.", FRAME_RATES.start(), FRAME_RATES.end());
        return Err(Error::new(format!("{rate} frames a second were asked for."), remedy));
    }
    if path.is_dir() || obj_sequence::is_pattern(path) {
        return obj_sequence::open(path, options.frame_rate.unwrap_or(USUAL_FRAME_RATE))
            .map(|motion| (motion, Vec::new()));
    }
    let bytes = read::bytes(path)?;
    let here = |e: Error| e.within(path.display());
    let format = Format::of(&bytes, path).ok_or_else(|| {
        here(Error::new(
            "It is no moving body that can be read.",
            "Give a .glb or .gltf file, a folder or pattern of OBJ files, or a .pc2, .mdd or .bvh file with its body.",
        ))
    })?;
    match format {
        Format::Gltf => rig(&bytes, path, options).and_then(|rig| rig.play(options)).map_err(here),
        Format::Obj => obj_sequence::still(&bytes, options.frame_rate.unwrap_or(USUAL_FRAME_RATE))
            .map(|motion| (motion, Vec::new()))
            .map_err(here),
        Format::Pc2 | Format::Mdd => {
            let body = body_of(options, path, "OBJ file", "the mesh whose vertices the cache moves")?;
            let mesh = obj_sequence::mesh(&read::bytes(body)?).map_err(|e| e.within(body.display()))?;
            let read = if matches!(format, Format::Pc2) { pc2::read } else { mdd::read };
            read(&bytes, mesh, options.frame_rate).map(|motion| (motion, Vec::new())).map_err(here)
        }
        Format::Bvh => {
            let text = read::utf8(bytes).map_err(here)?;
            let capture = bvh::read(&text).map_err(here)?;
            let body = body_of(options, path, "glTF file", "the skinned body that the capture moves")?;
            let rig = rig(&read::bytes(body)?, body, options).map_err(|e| e.within(body.display()))?;
            let plan = Retargeting::new(&capture, &rig, &options.joints).map_err(here)?;
            plan.play(&capture, rig, options.frame_rate).map_err(here)
        }
    }
}

/// What carries the skin of a glTF body, in the pose of a frame of the clip that the options name.
pub fn skin(path: &Path, options: &Options, frame: usize) -> Result<(gltf::Skin, Vec<Warning>), Error> {
    let bytes = read::bytes(path)?;
    let here = |e: Error| e.within(path.display());
    if Format::of(&bytes, path) != Some(Format::Gltf) {
        let problem = "It is no glTF file: it has no joints that a garment could follow.";
        return Err(here(Error::new(problem, "Give the .glb or .gltf file of a body with a skin.")));
    }
    rig(&bytes, path, options).and_then(|rig| rig.skin(options, frame)).map_err(here)
}

/// The body of a glTF file, whose buffers may lie beside it.
fn rig(bytes: &[u8], path: &Path, options: &Options) -> Result<gltf::Rig, Error> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    gltf::Rig::read(bytes, &options.meshes, &mut |name| read::bytes(&folder.join(name)))
}

fn body_of<'a>(options: &'a Options, path: &Path, kind: &str, what: &str) -> Result<&'a Path, Error> {
    options.body.as_deref().ok_or_else(|| {
        let error = Error::new("It has motion, but no body.", format!("Name the body, an {kind}: {what}."));
        error.within(path.display())
    })
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Gltf,
    Obj,
    Pc2,
    Mdd,
    Bvh,
}

impl Format {
    /// By what the file begins with; where that says nothing, by its name.
    fn of(bytes: &[u8], path: &Path) -> Option<Self> {
        let text = bytes.trim_ascii_start();
        let start = |tag: &[u8]| text.get(..tag.len()).is_some_and(|start| start.eq_ignore_ascii_case(tag));
        if bytes.starts_with(b"glTF") || start(b"{") {
            return Some(Self::Gltf);
        }
        if bytes.starts_with(pc2::TAG) {
            return Some(Self::Pc2);
        }
        if start(b"HIERARCHY") {
            return Some(Self::Bvh);
        }
        let suffix = path.extension()?.to_string_lossy().to_ascii_lowercase();
        let formats = [
            ("glb", Self::Gltf),
            ("gltf", Self::Gltf),
            ("obj", Self::Obj),
            ("pc2", Self::Pc2),
            ("mdd", Self::Mdd),
            ("bvh", Self::Bvh),
        ];
        formats.into_iter().find(|(name, _)| *name == suffix).map(|(_, format)| format)
    }
}

/// How many frames, `rate` a second, lie in `duration`, s; the one at the start is the first.
fn frames_within(duration: f64, rate: f64) -> Result<usize, Error> {
    // The last one counts even where rounding puts it a little later.
    let frames = (duration * rate + 1e-3).floor() + 1.0;
    if frames >= 1.0 && frames <= MOST_FRAMES as f64 {
        return Ok(frames as usize);
    }
    Err(Error::new(
        format!("The animation lasts {duration} s: with {rate} frames a second these are more than {MOST_FRAMES}."),
        "Ask for fewer frames a second, or export a shorter shot; times are in seconds.",
    ))
}
