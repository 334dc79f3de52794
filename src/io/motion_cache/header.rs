//! What a motion is of, and the bytes of its header and of a frame.

use crate::Error;
use crate::garment::MOST_PARTICLES;
use crate::geometry::Vector3;

const MAGIC: &[u8; 8] = b"TOILEM\r\n";
const VERSION: u32 = 1;
pub const HEADER_BYTES: usize = 8 + 4 + 4 + 8 + 8 + 32 + 4;
pub const CHECKSUM_BYTES: usize = 4;
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
    pub fn number_bytes(self) -> usize {
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
    pub fn bytes(&self) -> [u8; HEADER_BYTES] {
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

    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
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
    pub fn check(&self) -> Result<(), Error> {
        if self.frame_rate > 0.0 && self.frame_rate <= HIGHEST_RATE {
            return Ok(());
        }
        Err(Error::new(
            format!("{} frames a second are impossible.", self.frame_rate),
            format!("Give a rate above 0 and up to {HIGHEST_RATE}."),
        ))
    }

    pub fn record_bytes(&self) -> usize {
        8 + self.particle_count * 3 * self.precision.number_bytes() + CHECKSUM_BYTES
    }

    pub fn record_start(&self, frame: usize) -> u64 {
        HEADER_BYTES as u64 + frame as u64 * self.record_bytes() as u64
    }

    pub fn record(&self, frame: usize, positions: &[Vector3]) -> Vec<u8> {
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
    pub fn is_whole(&self, frame: usize, record: &[u8]) -> bool {
        let (content, checksum) = record.split_at(record.len() - CHECKSUM_BYTES);
        content[..8] == (frame as u64).to_le_bytes() && crc32fast::hash(content).to_le_bytes() == checksum
    }
}

pub fn damaged(problem: impl Into<String>) -> Error {
    Error::new(problem, "The file is damaged; copy it again, or simulate again.")
}
