//! `motion.toile`: how the particles of a garment move, frame by frame.
//!
//! A file that grows: each frame is a record of fixed size with a checksum of its own, so that a run that is killed
//! leaves all its whole frames readable, and goes on after the last of them. All numbers little-endian:
//!
//! ```text
//! 8 bytes   "TOILEM\r\n"      the line break shows transfers that mend line ends
//! u32       version           1
//! u32       number size       8 for f64, 4 for f32
//! u64       particles         of the finest level of the state
//! f64       frame rate        frames a second
//! 32 bytes  SHA-256           of the file `state.toile` whose particles move
//! u32       CRC-32            of everything before it (IEEE 802.3)
//!
//! then frame after frame:
//! u64       number            0, 1, 2 ...
//! numbers   x y z             of each particle, m, world
//! u32       CRC-32            of the record before it
//! ```
//!
//! What follows the last whole frame is the rest of a frame that was being written; readers leave it alone.

use super::export::Frames;
use crate::Error;
use crate::garment::MOST_PARTICLES;
use crate::geometry::Vector3;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 8] = b"TOILEM\r\n";
const VERSION: u32 = 1;
const HEADER_BYTES: usize = 8 + 4 + 4 + 8 + 8 + 32 + 4;
const CHECKSUM_BYTES: usize = 4;
/// Frames of a second beyond which a rate is a slip; simulators step faster, films do not.
const HIGHEST_RATE: f64 = 100_000.0;

/// How positions are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// f32: a tenth of a micrometre at the height of a man. Half the size.
    Single,
    /// f64, as computed.
    Double,
}

impl Precision {
    fn number_bytes(self) -> usize {
        match self {
            Precision::Single => 4,
            Precision::Double => 8,
        }
    }
}

/// What a motion is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionHeader {
    pub precision: Precision,
    pub particle_count: usize,
    /// Frames a second.
    pub frame_rate: f64,
    /// Of the file `state.toile` whose particles move.
    pub state_sha256: [u8; 32],
}

impl MotionHeader {
    fn bytes(&self) -> [u8; HEADER_BYTES] {
        let mut bytes = Vec::with_capacity(HEADER_BYTES);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((self.precision.number_bytes() as u32).to_le_bytes());
        bytes.extend((self.particle_count as u64).to_le_bytes());
        bytes.extend(self.frame_rate.to_le_bytes());
        bytes.extend(self.state_sha256);
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes.try_into().expect("the header has its length")
    }

    fn parse(bytes: &[u8]) -> Result<Self, Error> {
        if !bytes.starts_with(MAGIC) {
            return Err(Error::new(
                "It is not a motion of toile.",
                "Give the file `motion.toile` that a simulation wrote.",
            ));
        }
        if bytes.len() < HEADER_BYTES {
            return Err(damaged(format!("The file ends after {} bytes, within its header.", bytes.len())));
        }
        let (content, checksum) = bytes[..HEADER_BYTES].split_at(HEADER_BYTES - CHECKSUM_BYTES);
        let word = |at: usize| u32::from_le_bytes(content[at..at + 4].try_into().expect("four bytes"));
        let long = |at: usize| u64::from_le_bytes(content[at..at + 8].try_into().expect("eight bytes"));
        if word(8) != VERSION {
            return Err(Error::new(
                format!("The motion has version {}; this toile reads version {VERSION}.", word(8)),
                "Simulate again with this version, or use a newer toile.",
            ));
        }
        if crc32fast::hash(content).to_le_bytes() != checksum {
            return Err(damaged("The checksum of its header is wrong."));
        }
        let precision = match word(12) {
            4 => Precision::Single,
            8 => Precision::Double,
            other => return Err(damaged(format!("Its numbers have {other} bytes instead of 4 or 8."))),
        };
        let (particles, frame_rate) = (long(16), f64::from_bits(long(24)));
        if particles == 0 || particles as f64 > MOST_PARTICLES {
            return Err(damaged(format!("It tells of {particles} particles.")));
        }
        let mut state_sha256 = [0; 32];
        state_sha256.copy_from_slice(&content[32..64]);
        let header = Self { precision, particle_count: particles as usize, frame_rate, state_sha256 };
        header.check().map(|()| header)
    }

    /// Is it the header of a possible motion?
    fn check(&self) -> Result<(), Error> {
        if self.frame_rate > 0.0 && self.frame_rate <= HIGHEST_RATE {
            return Ok(());
        }
        Err(Error::new(
            format!("{} frames a second are impossible.", self.frame_rate),
            format!("Give a rate above 0 and up to {HIGHEST_RATE}."),
        ))
    }

    fn record_bytes(&self) -> usize {
        8 + self.particle_count * 3 * self.precision.number_bytes() + CHECKSUM_BYTES
    }

    fn record_start(&self, frame: usize) -> u64 {
        HEADER_BYTES as u64 + frame as u64 * self.record_bytes() as u64
    }

    fn record(&self, frame: usize, positions: &[Vector3]) -> Vec<u8> {
        let mut record = Vec::with_capacity(self.record_bytes());
        record.extend((frame as u64).to_le_bytes());
        for x in positions.iter().flatten() {
            match self.precision {
                Precision::Single => record.extend((*x as f32).to_le_bytes()),
                Precision::Double => record.extend(x.to_le_bytes()),
            }
        }
        record.extend(crc32fast::hash(&record).to_le_bytes());
        record
    }

    /// Is this the whole record of a frame?
    fn is_whole(&self, frame: usize, record: &[u8]) -> bool {
        let (content, checksum) = record.split_at(record.len() - CHECKSUM_BYTES);
        content[..8] == (frame as u64).to_le_bytes() && crc32fast::hash(content).to_le_bytes() == checksum
    }
}

fn damaged(problem: impl Into<String>) -> Error {
    Error::new(problem, "The file is damaged; copy it again, or simulate again.")
}

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
        let mut file = File::open(path).map_err(|e| within(super::read::unreadable(path, &e)))?;
        let unreadable = |e: io::Error| within(super::read::unreadable(path, &e));
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
            let whole =
                self.fetch(frame).map_err(|e| super::read::unreadable(&self.path, &e).within(self.path.display()))?;
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
            Err(e) => return Err(within(super::read::unreadable(&self.path, &e), &self.path)),
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
        super::atomic::write(path, &header.bytes())?;
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
        let file = opened.map_err(|e| super::atomic::refused(path, &e))?;
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
        written.map_err(|e| super::atomic::refused(&self.path, &e))?;
        self.frame_count += 1;
        Ok(())
    }

    /// Asks for all frames to be on the disk.
    pub fn finish(self) -> Result<(), Error> {
        self.file.sync_all().map_err(|e| super::atomic::refused(&self.path, &e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PARTICLES: usize = 3;

    fn header(precision: Precision) -> MotionHeader {
        MotionHeader { precision, particle_count: PARTICLES, frame_rate: 23.976, state_sha256: [7; 32] }
    }

    fn frame(k: usize) -> Vec<Vector3> {
        (0..PARTICLES).map(|i| Vector3::new(0.1 * k as f64, i as f64 / 3.0, -1e-9)).collect()
    }

    /// A file of some frames, and where it is.
    fn written(precision: Precision, frames: usize) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("motion.toile");
        let mut writer = MotionWriter::create(&path, header(precision)).unwrap();
        (0..frames).for_each(|k| writer.append(&frame(k)).unwrap());
        writer.finish().unwrap();
        (folder, path)
    }

    fn read_all(path: &Path) -> Vec<Vec<Vector3>> {
        let mut reader = MotionReader::open(path).unwrap();
        let mut read = |k| {
            let mut positions = Vec::new();
            reader.read(k, &mut positions).map(|()| positions).unwrap()
        };
        (0..MotionReader::open(path).unwrap().frame_count()).map(&mut read).collect()
    }

    #[test]
    fn frames_read_back_the_same_in_any_order() {
        let (_folder, path) = written(Precision::Double, 5);
        assert_eq!(read_all(&path), (0..5).map(frame).collect::<Vec<_>>());
        let mut reader = MotionReader::open(&path).unwrap();
        let mut positions = Vec::new();
        for k in [4, 0, 2] {
            reader.read(k, &mut positions).unwrap();
            assert_eq!(positions, frame(k));
        }
        assert_eq!((reader.frame_rate(), reader.header()), (23.976, &header(Precision::Double)));
        let (_folder, path) = written(Precision::Single, 2);
        assert!(read_all(&path)[1].iter().zip(frame(1)).all(|(a, b)| (a - b).norm() < 1e-7));
    }

    #[test]
    fn a_killed_run_leaves_its_whole_frames_and_goes_on_after_them_to_the_same_bytes() {
        let (_folder, whole) = written(Precision::Double, 6);
        let expected = std::fs::read(&whole).unwrap();
        let record = header(Precision::Double).record_bytes();
        for kept in [HEADER_BYTES, HEADER_BYTES + 1, HEADER_BYTES + 3 * record, HEADER_BYTES + 4 * record - 1] {
            let (_folder, path) = written(Precision::Double, 0);
            std::fs::write(&path, &expected[..kept]).unwrap();
            let reader = MotionReader::open(&path).unwrap();
            let frames = (kept - HEADER_BYTES) / record;
            assert_eq!(reader.frame_count(), frames);
            assert_eq!(reader.unfinished_bytes() as usize, kept - HEADER_BYTES - frames * record);
            let mut writer = MotionWriter::resume(&path, &header(Precision::Double)).unwrap();
            (writer.frame_count()..6).for_each(|k| writer.append(&frame(k)).unwrap());
            assert!(std::fs::read(&path).unwrap() == expected, "after {kept} bytes");
        }
    }

    #[test]
    fn a_run_goes_on_before_a_frame_that_never_reached_the_disk() {
        let (_folder, path) = written(Precision::Double, 4);
        let mut bytes = std::fs::read(&path).unwrap();
        let record = header(Precision::Double).record_bytes();
        bytes[HEADER_BYTES + 2 * record..HEADER_BYTES + 3 * record].fill(0);
        std::fs::write(&path, &bytes).unwrap();
        let error = MotionReader::open(&path).unwrap().read(2, &mut Vec::new()).unwrap_err();
        assert!(error.place().contains("frame 2") && error.problem().contains("checksum"), "{error}");
        assert_eq!(MotionWriter::resume(&path, &header(Precision::Double)).unwrap().frame_count(), 2);
    }

    #[test]
    fn another_garment_is_not_gone_on_with() {
        let (_folder, path) = written(Precision::Double, 1);
        let other = MotionHeader { state_sha256: [8; 32], ..header(Precision::Double) };
        assert!(MotionWriter::resume(&path, &other).unwrap_err().problem().contains("another state"));
        assert!(MotionWriter::resume(&path, &header(Precision::Single)).is_err());
        assert_eq!(read_all(&path).len(), 1);
    }

    #[test]
    fn errors_tell_what_is_wrong_with_the_file() {
        let (folder, path) = written(Precision::Double, 1);
        let bytes = std::fs::read(&path).unwrap();
        let problem = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            MotionReader::open(&path).unwrap_err().problem().to_owned()
        };
        assert!(problem(b"").contains("not a motion"));
        assert!(problem(b"TOILE\0\r\n").contains("not a motion"));
        assert!(problem(&bytes[..20]).contains("header"));
        let changed = |at: usize, value: u8| {
            let mut changed = bytes.clone();
            changed[at] = value;
            changed
        };
        assert!(problem(&changed(8, 2)).contains("version 2"));
        assert!(problem(&changed(40, 2)).contains("checksum"));
        // Forged, with checksums that fit: sizes that no memory holds, rates that are no numbers.
        let forged = |header: MotionHeader| header.bytes();
        let sound = header(Precision::Double);
        assert!(problem(&forged(MotionHeader { particle_count: usize::MAX, ..sound })).contains("particles"));
        assert!(problem(&forged(MotionHeader { frame_rate: f64::NAN, ..sound })).contains("frames a second"));
        let mut nan = frame(0);
        nan[1].z = f64::NAN;
        std::fs::write(&path, [&sound.bytes()[..], &sound.record(0, &nan)].concat()).unwrap();
        let error = MotionReader::open(&path).unwrap().read(0, &mut Vec::new()).unwrap_err();
        assert!(error.problem().contains("not finite"));
        assert!(MotionReader::open(folder.path()).is_err());
        assert!(MotionReader::open(&folder.path().join("none")).unwrap_err().problem().contains("no such file"));
    }

    proptest! {
        #[test]
        fn any_damage_is_told_or_leaves_the_frames_as_they_were(at in any::<prop::sample::Index>(), change in 1u8..) {
            let (_folder, path) = written(Precision::Single, 3);
            let frames = read_all(&path);
            let mut bytes = std::fs::read(&path).unwrap();
            let at = at.index(bytes.len());
            bytes[at] ^= change;
            std::fs::write(&path, &bytes).unwrap();
            let Ok(mut reader) = MotionReader::open(&path) else { return Ok(()) };
            let mut wrong = 0;
            for (k, frame) in frames.iter().enumerate() {
                let mut positions = Vec::new();
                match reader.read(k, &mut positions) {
                    Ok(()) => prop_assert_eq!(&positions, frame),
                    Err(_) => wrong += 1,
                }
            }
            prop_assert_eq!(wrong, 1);
        }
    }
}
