//! A fitted garment, at rest or in motion, as files that other programs take: `toile export`.
//!
//! Each format is a file of small functions. [`write_set`] writes those that are asked for, scripts that load them, and a
//! manifest that tells what the numbers mean. Vertices are the particles of the finest level in their order, in every
//! format but GLB and the flat panels, whose vertices are the points of panels, in theirs. Units are SI, y is up: nothing
//! is converted, so that numbers can be compared; scripts turn axes where a program has others.

mod arrays;
mod frames;
mod manifest;
mod newton;
mod npz;
mod ply;
mod point_cache;
mod target;
mod usd;

pub use frames::{Chosen, Frames, Sequence};
pub use manifest::{MANIFEST, MotionPart, NamedFile, Origin, SkinPart};
pub use target::Target;

use super::atomic::{self, Unfinished};
use super::moving_body::gltf::Skin;
use super::{garment_obj, glb, read};
use crate::Error;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::pattern::{Fabric, Pattern};
use manifest::FilePart;
use std::path::Path;

/// What does not move of a garment.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    pub pattern: &'a Pattern,
    /// The finest.
    pub level: &'a Level,
    pub fabric: &'a Fabric,
    /// Kept from the body, m.
    pub clearance: f64,
    /// The body that a skinned garment follows, in the pose of the first frame.
    pub skin: Option<&'a Skin>,
}

/// The nearest isotropic cloth, for programs that know no other.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Isotropic {
    /// Young's modulus times thickness, N/m.
    stretch: f64,
    /// N·m.
    bending: f64,
}

impl Isotropic {
    /// Geometric means of warp and weft: equally far from both by ratio.
    fn of(fabric: &Fabric) -> Self {
        Self {
            stretch: (fabric.stretch.warp * fabric.stretch.weft).sqrt(),
            bending: (fabric.bending.warp * fabric.bending.weft).sqrt(),
        }
    }

    /// Lamé's constants in the plane, μ and λ, N/m.
    fn lame(&self, poisson_ratio: f64) -> [f64; 2] {
        let nu = poisson_ratio;
        [self.stretch / (2.0 * (1.0 + nu)), self.stretch * nu / (1.0 - nu * nu)]
    }
}

/// More frames than this are not written as files of their own: a quarter of an hour of film, and folders grow slow.
const MOST_FILES: usize = 20_000;

/// The folder of files that each hold one frame.
const FRAMES_FOLDER: &str = "frames";

/// Writes the files for all `targets` into the folder `out`, which is there, and the manifest last of all: where it is,
/// all is. Tells the names of what was written. An earlier manifest is removed first.
pub fn write_set(
    source: &Source,
    origin: &Origin,
    targets: &[Target],
    frames: &mut dyn Frames,
    out: &Path,
) -> Result<Vec<String>, Error> {
    assert!(frames.frame_count() > 0, "there is a frame to be exported");
    let mut set = Set { source, frames, out, files: Vec::new() };
    set.check(targets)?;
    remove(&out.join(MANIFEST))?;
    let mut first = Vec::new();
    set.frames.read(0, &mut first)?;
    set.common(&first)?;
    for kind in Target::ALL.into_iter().filter(|kind| targets.contains(kind)) {
        set.target(kind, &first)?;
    }
    let Set { mut files, .. } = set;
    let text = manifest::text(source, origin, targets, frames, &files);
    atomic::write(&out.join(MANIFEST), text.as_bytes())?;
    let mut names: Vec<String> = files.drain(..).map(|file| file.name).collect();
    names.push(MANIFEST.to_owned());
    Ok(names)
}

/// A set of files while it grows.
struct Set<'a> {
    source: &'a Source<'a>,
    frames: &'a mut dyn Frames,
    out: &'a Path,
    files: Vec<FilePart>,
}

impl Set<'_> {
    fn check(&self, targets: &[Target]) -> Result<(), Error> {
        if targets.contains(&Target::GlbSkinned) && self.source.skin.is_none() {
            let remedy = "Give the animated body, a .glb or .gltf file, with --skin.";
            return Err(Error::new("There is no body whose joints a skinned garment could follow.", remedy));
        }
        let count = self.frames.frame_count();
        let by_frame = targets.iter().find(|target| [Target::Obj, Target::Ply].contains(target));
        match by_frame {
            Some(target) if count > MOST_FILES => Err(Error::new(
                format!("{count} frames would be as many files for {}; up to {MOST_FILES} are written.", target.name()),
                "Choose fewer frames with --frames, or export a point cache (pc2, mdd) or usd.",
            )),
            _ => Ok(()),
        }
    }

    fn common(&mut self, first: &[Vector3]) -> Result<(), Error> {
        let source = self.source;
        let text = garment_obj::write_as_one(source.pattern, source.level, first);
        self.bytes("garment.obj", "the sewn garment in the first frame, rest coordinates as vt", text.as_bytes())?;
        let about = "rest coordinates, triangles, masses, and how flat panels and sewn garment belong together";
        self.pieces("rest.npz", about, |source, _, out| arrays::write_rest(source, out))
    }

    fn target(&mut self, target: Target, first: &[Vector3]) -> Result<(), Error> {
        let Source { pattern, level, .. } = *self.source;
        match target {
            Target::Blender => {
                self.pc2()?;
                self.script("import_into_blender.py", include_str!("scripts/import_into_blender.py"))
            }
            Target::Pc2 => self.pc2(),
            Target::Mdd => self.pieces("garment.mdd", "positions of all frames, MDD", |source, frames, out| {
                point_cache::write_mdd(source.level.particle_count, frames, out)
            }),
            Target::Obj => {
                self.each_frame("obj", |positions| garment_obj::write_as_one(pattern, level, positions).into_bytes())
            }
            Target::Ply => {
                self.each_frame("ply", |positions| ply::write_garment(level, positions))?;
                self.bytes("rest.ply", "the panels flat, each vertex with its particle", &ply::write_rest(level))
            }
            Target::Glb => {
                let file = glb::write_frames(pattern, level, self.frames)?;
                self.bytes("garment.glb", "glTF 2.0, a mesh for each panel, frames as morph targets", &file)
            }
            Target::GlbSkinned => {
                let skin = self.source.skin.expect("it was looked for before anything was written");
                let file = glb::write_skinned(pattern, level, first, skin)?;
                self.bytes("garment_skinned.glb", "glTF 2.0, the first frame on the body's skeleton and clips", &file)
            }
            Target::Usd => self.pieces("garment.usda", "USD, frames as time samples", |source, frames, out| {
                usd::write(source, frames, out)
            }),
            Target::Npz => {
                let about = "all of rest.npz and the positions of all frames";
                self.pieces("garment.npz", about, |source, frames, out| arrays::write_garment(source, frames, out))
            }
            Target::Newton => {
                self.pieces("newton.npz", "what Newton's cloth builders take", |source, _, out| {
                    Ok(newton::write(source, first, out)?)
                })?;
                self.script("load_into_newton.py", include_str!("scripts/load_into_newton.py"))
            }
            Target::Contourcraft => {
                self.pieces("contourcraft.npz", "what a garment template of ContourCraft holds", |source, _, out| {
                    Ok(arrays::write_contourcraft(source, first, out)?)
                })?;
                self.script("make_contourcraft_template.py", include_str!("scripts/make_contourcraft_template.py"))
            }
        }
    }

    fn pc2(&mut self) -> Result<(), Error> {
        self.pieces("garment.pc2", "positions of all frames, PC2", |source, frames, out| {
            point_cache::write_pc2(source.level.particle_count, frames, out)
        })
    }

    /// A file for each frame; a garment at rest has one alone, without a number.
    fn each_frame(&mut self, ending: &str, bytes: impl Fn(&[Vector3]) -> Vec<u8>) -> Result<(), Error> {
        let mut positions = Vec::new();
        let count = self.frames.frame_count();
        if count == 1 {
            self.frames.read(0, &mut positions)?;
            return self.bytes(&format!("garment.{ending}"), "the sewn garment", &bytes(&positions));
        }
        make_folder(&self.out.join(FRAMES_FOLDER))?;
        for frame in 0..count {
            self.frames.read(frame, &mut positions)?;
            self.bytes(&format!("{FRAMES_FOLDER}/garment.{frame:05}.{ending}"), "one frame", &bytes(&positions))?;
        }
        Ok(())
    }

    fn script(&mut self, name: &str, text: &str) -> Result<(), Error> {
        self.bytes(name, "loads the files", text.as_bytes())
    }

    fn bytes(&mut self, name: &str, about: &'static str, bytes: &[u8]) -> Result<(), Error> {
        self.pieces(name, about, |_, _, out| Ok(std::io::Write::write_all(out, bytes)?))
    }

    /// Writes a file that another target may have asked for before.
    fn pieces(
        &mut self,
        name: &str,
        about: &'static str,
        fill: impl FnOnce(&Source, &mut dyn Frames, &mut std::io::BufWriter<&mut std::fs::File>) -> Result<(), Unfinished>,
    ) -> Result<(), Error> {
        if self.files.iter().any(|file| file.name == name) {
            return Ok(());
        }
        let path = self.out.join(name);
        let (source, frames) = (self.source, &mut *self.frames);
        atomic::write_pieces(&path, |out| fill(source, frames, out))?;
        let (sha256, bytes) = read::sha256_of_file(&path)?;
        self.files.push(FilePart { name: name.to_owned(), about, bytes, sha256 });
        Ok(())
    }
}

/// Removes a file of an earlier run, if there is one.
fn remove(path: &Path) -> Result<(), Error> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(atomic::refused(path, &e)),
        _ => Ok(()),
    }
}

fn make_folder(path: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(path).map_err(|e| atomic::refused(path, &e))
}
