//! Writing a motion.

use super::header::MotionHeader;
use super::reader::MotionReader;
use crate::Error;
use crate::geometry::Vector3;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Appends frames.
#[derive(Debug)]
pub struct MotionWriter {
    path: PathBuf,
    file: File,
    header: MotionHeader,
    frame_count: usize,
}

impl MotionWriter {
    /// Starts a motion; a file of that name is replaced.
    pub fn create(path: &Path, header: MotionHeader) -> Result<Self, Error> {
        assert!(header.particle_count > 0, "a motion is of some particles");
        header.check().map_err(|e| e.within(path.display()))?;
        // The header alone is a whole file, with no frames: the new name never stands for less.
        crate::io::atomic::write(path, &header.bytes())?;
        Self::at(path, header, 0)
    }

    /// Goes on after the last whole frame of a motion, which has to be of the same garment, rate and precision.
    /// What was left of an unfinished frame is cut off.
    pub fn resume(path: &Path, header: &MotionHeader) -> Result<Self, Error> {
        let mut reader = MotionReader::open(path)?;
        if reader.header() != header {
            return Err(Error::new(
                "The motion is of another state, rate or precision.",
                "Give another file, or start the simulation anew.",
            )
            .within(path.display()));
        }
        let whole = reader.whole_frames()?;
        Self::at(path, *header, whole)
    }

    fn at(path: &Path, header: MotionHeader, frame_count: usize) -> Result<Self, Error> {
        let opened = OpenOptions::new().write(true).open(path).and_then(|mut file| {
            file.set_len(header.record_start(frame_count))?;
            file.seek(SeekFrom::End(0))?;
            Ok(file)
        });
        let file = opened.map_err(|e| crate::io::atomic::refused(path, &e))?;
        Ok(Self { path: path.to_owned(), file, header, frame_count })
    }

    /// Frames so far.
    pub fn frame_count(&self) -> usize {
        self.frame_count
    }

    /// Adds a frame: one position per particle, m, world.
    pub fn append(&mut self, positions: &[Vector3]) -> Result<(), Error> {
        assert_eq!(positions.len(), self.header.particle_count, "a frame has a position for each particle");
        let record = self.header.record(self.frame_count, positions);
        let written = self.file.write_all(&record);
        written.map_err(|e| crate::io::atomic::refused(&self.path, &e))?;
        self.frame_count += 1;
        Ok(())
    }

    /// Asks for all frames to be on the disk.
    pub fn finish(self) -> Result<(), Error> {
        self.file.sync_all().map_err(|e| crate::io::atomic::refused(&self.path, &e))
    }
}
