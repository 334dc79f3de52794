//! `toile export`: a fitted garment, at rest or in motion, as files that other programs take.

use super::arguments::Export;
use super::{Failure, Status, complaint, results};
use crate::io::export::{Chosen, Frames, MotionPart, NamedFile, Origin, Sequence, SkinPart, Source, Target, write_set};
use crate::io::motion_cache::MotionReader;
use crate::io::moving_body::gltf::Skin;
use crate::io::moving_body::{self, Options};
use crate::io::state::{self, State};
use crate::io::{length, read};
use crate::{Error, Warning};
use std::path::{Path, PathBuf};

pub fn run(asked: &Export) -> Result<Status, Failure> {
    let targets = targets(&asked.to)?;
    let range =
        asked.frames.as_deref().map(Range::parse).transpose().map_err(|e| Failure::Usage(e.within("--frames")))?;
    let file = state_file(&asked.fit)?;
    keep_the_fit(&file, &asked.out)?;
    let bytes = read::bytes(&file)?;
    let within = |e: Error| e.within(file.display());
    let mut state = state::read(&bytes).map_err(within)?;
    let (pattern, garment) = state.rebuild().map_err(within)?;
    let state_sha256 = read::sha256(&bytes);
    let mut motion = motion_file(asked, &file).map(|path| open_motion(path, &state, &state_sha256)).transpose()?;
    let level = garment.levels.last().expect("a garment has at least one level");
    let (skin, skin_part) = skin(asked, &targets)?.unzip();
    let source = Source {
        pattern: &pattern,
        level,
        fabric: &state.fabric,
        clearance: state.settings.clearance,
        skin: skin.as_ref(),
    };
    let mut origin = Origin {
        state_sha256: read::hexadecimal(&state_sha256),
        pattern: NamedFile { name: state.pattern_name.clone(), sha256: state.pattern_sha256.clone() },
        body: NamedFile { name: state.body_name.clone(), sha256: state.body_sha256.clone() },
        motion: None,
        skin: skin_part,
    };
    let mut still = Sequence::still(std::mem::take(&mut state.positions));
    let mut chosen;
    let frames: &mut dyn Frames = match &mut motion {
        Some((path, reader)) => {
            let place = path.display().to_string();
            chosen = range.unwrap_or_default().of(reader).map_err(|e| e.within(place))?;
            let (sha256, _) = read::sha256_of_file(path)?;
            origin.motion = Some(MotionPart { sha256, first_frame: chosen.first, step: chosen.step });
            &mut chosen
        }
        None if range.is_some() => {
            let remedy = "Give the motion with --motion, or leave --frames out for the garment at rest.";
            return Err(Failure::Usage(
                Error::new("There is no motion to choose frames of.", remedy).within("--frames"),
            ));
        }
        None => &mut still,
    };
    let count = frames.frame_count();
    results::prepare(&asked.out)?;
    let names = write_set(&source, &origin, &targets, frames, &asked.out)?;
    eprintln!(
        "{}: {} particles at {}, {}; {} in {}",
        state.pattern_name,
        level.particle_count,
        length::describe(level.resolution),
        if count == 1 { "at rest".to_owned() } else { format!("{count} frames") },
        if names.len() > 12 { format!("{} files", names.len()) } else { names.join(", ") },
        asked.out.display()
    );
    Ok(Status::Fine)
}

/// The body that a skinned garment follows, if one is asked for, and what the manifest tells of it.
fn skin(asked: &Export, targets: &[Target]) -> Result<Option<(Skin, SkinPart)>, Failure> {
    let Some(body) = &asked.skin else { return Ok(None) };
    if !targets.contains(&Target::GlbSkinned) {
        let remedy = "Add glb-skinned to the targets, or leave --skin out.";
        return Err(Failure::Usage(Error::new("No target follows a skin.", remedy).within("--skin")));
    }
    let options = Options { clip: asked.clip.clone(), frame_rate: asked.fps, ..Options::default() };
    let (skin, warnings) = moving_body::skin(body, &options, asked.skin_frame)?;
    warnings.iter().for_each(complaint::print_warning);
    let name = body.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let file = NamedFile { name, sha256: read::sha256_hex(&read::bytes(body)?) };
    Ok(Some((skin, SkinPart { file, clip: asked.clip.clone(), frame: asked.skin_frame })))
}

fn targets(asked: &[String]) -> Result<Vec<Target>, Failure> {
    let named = asked.iter().map(|name| Target::named(name.trim()).map_err(|e| Failure::Usage(e.within("--to"))));
    named.collect()
}

/// The state of a fit, given as its folder or by itself.
fn state_file(fit: &Path) -> Result<PathBuf, Error> {
    if !fit.is_dir() {
        return Ok(fit.to_owned());
    }
    let file = fit.join("state.toile");
    if !file.exists() && fit.join("outfit.json").exists() {
        let remedy = "Export each garment by itself: give the folder of one of them.";
        return Err(Error::new("It is the folder of several garments.", remedy).within(fit.display()));
    }
    Ok(file)
}

/// The files of the fit have the names of some that are exported, and are not to be replaced by them.
fn keep_the_fit(state: &Path, out: &Path) -> Result<(), Failure> {
    let folder = state.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (folder.canonicalize(), out.canonicalize()) {
        (Ok(fit), Ok(out)) if fit == out => {
            let problem = "The files would replace those of the fit.";
            Err(Failure::Usage(Error::new(problem, "Give another folder, such as one in it.").within("--out")))
        }
        _ => Ok(()),
    }
}

/// The motion that was asked for, or the one beside the state.
fn motion_file(asked: &Export, state: &Path) -> Option<PathBuf> {
    let beside = || Some(state.with_file_name("motion.toile")).filter(|file| file.exists());
    if asked.still { None } else { asked.motion.clone().or_else(beside) }
}

fn open_motion(path: PathBuf, state: &State, sha256: &[u8; 32]) -> Result<(PathBuf, MotionReader), Error> {
    let reader = MotionReader::open(&path)?;
    let problem = if reader.header().state_sha256 != *sha256 {
        "It is the motion of another fit."
    } else if reader.header().particle_count != state.positions.len() {
        "It has another number of particles than the state."
    } else if reader.frame_count() == 0 {
        "It has no whole frame yet."
    } else {
        if reader.unfinished_bytes() > 0 {
            let remedy = "What is whole is exported; let the simulation go on for the rest.";
            let error = Error::new("Its last frame is not whole: the run that wrote it did not end.", remedy);
            complaint::print_warning(&Warning(error.within(path.display())));
        }
        return Ok((path, reader));
    };
    let remedy = "Give the motion that was simulated from this state, or --still for the garment as it was fitted.";
    Err(Error::new(problem, remedy).within(path.display()))
}

/// Frames as they are asked for: from `first` to `last`, both included, every `step`-th.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Range {
    first: usize,
    /// None for the end of the motion.
    last: Option<usize>,
    step: usize,
}

impl Default for Range {
    fn default() -> Self {
        Self { first: 0, last: None, step: 1 }
    }
}

impl Range {
    fn parse(text: &str) -> Result<Self, Error> {
        let wrong = || {
            Error::new(
                format!("\"{}\" is no range of frames.", text.chars().take(60).collect::<String>()),
                "Write it like \"0..71\", \"24..\", \"12\" or, for every second frame, \"0..71/2\".",
            )
        };
        let number = |text: &str| text.trim().parse::<usize>().map_err(|_| wrong());
        let (ends, step) = match text.split_once('/') {
            Some((ends, step)) => (ends, number(step)?),
            None => (text, 1),
        };
        let (first, last) = match ends.split_once("..") {
            Some((first, last)) if last.trim().is_empty() => (number(first)?, None),
            Some((first, last)) => (number(first)?, Some(number(last)?)),
            None => (number(ends)?, Some(number(ends)?)),
        };
        if step == 0 || last.is_some_and(|last| last < first) {
            return Err(wrong());
        }
        Ok(Self { first, last, step })
    }

    fn of(self, motion: &mut MotionReader) -> Result<Chosen<'_>, Error> {
        let there = motion.frame_count() - 1;
        let last = self.last.unwrap_or(there);
        if self.first > there || last > there {
            return Err(Error::new(
                format!("It has no frame {}; its last is {there}.", self.first.max(last)),
                "Choose frames that are there with --frames.",
            ));
        }
        Ok(Chosen { all: motion, first: self.first, step: self.step, count: (last - self.first) / self.step + 1 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_frames_are_understood_or_refused() {
        let range = |first, last, step| Ok(Range { first, last, step });
        assert_eq!(Range::parse("0..71"), range(0, Some(71), 1));
        assert_eq!(Range::parse("24.."), range(24, None, 1));
        assert_eq!(Range::parse("12"), range(12, Some(12), 1));
        assert_eq!(Range::parse(" 0 .. 71 / 2 "), range(0, Some(71), 2));
        for wrong in ["", "..", "a..b", "5..2", "0..9/0", "-1..4", "1...3", "1/", "99999999999999999999"] {
            assert!(Range::parse(wrong).is_err(), "{wrong}");
        }
    }
}
