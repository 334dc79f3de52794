//! Reading a motion.

use super::header::{CHECKSUM_BYTES, HEADER_BYTES, MotionHeader, Precision, damaged};
use crate::Error;
use crate::geometry::Vector3;
use crate::io::export::Frames;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Reads one frame at a time, any in any order.
#[derive(Debug)]
pub struct MotionReader {
    path: PathBuf,
    file: File,
    header: MotionHeader,
    frame_count: usize,
    unfinished_bytes: u64,
    record: Vec<u8>,
}

impl MotionReader {
    pub fn open(path: &Path) -> Result<Self, Error> {
        let within = |e: Error| e.within(path.display());
        let mut file = File::open(path).map_err(|e| within(crate::io::read::unreadable(path, &e)))?;
        let unreadable = |e: io::Error| within(crate::io::read::unreadable(path, &e));
        let mut head = Vec::with_capacity(HEADER_BYTES);
        (&mut file).take(HEADER_BYTES as u64).read_to_end(&mut head).map_err(unreadable)?;
        let header = MotionHeader::parse(&head).map_err(within)?;
        let after = file.metadata().map_err(unreadable)?.len().saturating_sub(HEADER_BYTES as u64);
        let record_bytes = header.record_bytes() as u64;
        let (frame_count, unfinished_bytes) = ((after / record_bytes) as usize, after % record_bytes);
        Ok(Self { path: path.to_owned(), file, header, frame_count, unfinished_bytes, record: Vec::new() })
    }

    pub fn header(&self) -> &MotionHeader {
        &self.header
    }

    /// Bytes of a frame that was being written when the run ended; 0 after a run that came to its end.
    pub fn unfinished_bytes(&self) -> u64 {
        self.unfinished_bytes
    }

    /// Fills `self.record`; `false` where the record is not what was written.
    fn fetch(&mut self, frame: usize) -> io::Result<bool> {
        self.record.resize(self.header.record_bytes(), 0);
        self.file.seek(SeekFrom::Start(self.header.record_start(frame)))?;
        self.file.read_exact(&mut self.record)?;
        Ok(self.header.is_whole(frame, &self.record))
    }

    /// How many frames from the first on are as they were written: where a run that was cut off goes on.
    pub fn whole_frames(&mut self) -> Result<usize, Error> {
        for frame in 0..self.frame_count {
            let whole = self
                .fetch(frame)
                .map_err(|e| crate::io::read::unreadable(&self.path, &e).within(self.path.display()))?;
            if !whole {
                return Ok(frame);
            }
        }
        Ok(self.frame_count)
    }
}

impl Frames for MotionReader {
    fn frame_rate(&self) -> f64 {
        self.header.frame_rate
    }

    fn frame_count(&self) -> usize {
        self.frame_count
    }

    fn read(&mut self, frame: usize, positions: &mut Vec<Vector3>) -> Result<(), Error> {
        let within = |e: Error, path: &Path| e.within(format!("frame {frame}")).within(path.display());
        match self.fetch(frame) {
            Err(e) => return Err(within(crate::io::read::unreadable(&self.path, &e), &self.path)),
            Ok(false) => return Err(within(damaged("The checksum of the frame is wrong."), &self.path)),
            Ok(true) => {}
        }
        let numbers = &self.record[8..self.record.len() - CHECKSUM_BYTES];
        positions.clear();
        match self.header.precision {
            Precision::Single => positions.extend(numbers.as_chunks::<12>().0.iter().map(|p| {
                let x = |k: usize| f64::from(f32::from_le_bytes(p[4 * k..4 * k + 4].try_into().expect("four bytes")));
                Vector3::new(x(0), x(1), x(2))
            })),
            Precision::Double => positions.extend(numbers.as_chunks::<24>().0.iter().map(|p| {
                let x = |k: usize| f64::from_le_bytes(p[8 * k..8 * k + 8].try_into().expect("eight bytes"));
                Vector3::new(x(0), x(1), x(2))
            })),
        }
        if positions.iter().flatten().any(|x| !x.is_finite()) {
            return Err(within(damaged("The frame has a number that is not finite."), &self.path));
        }
        Ok(())
    }
}
