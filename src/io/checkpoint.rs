//! `checkpoint.toile`: where a simulation stands between two frames, to be gone on from.
//!
//! ```text
//! 8 bytes   "TOILEP\r\n"
//! u32       version            3
//! u32       length             of the description, bytes
//! bytes     description        JSON: what is simulated and how, and what the frames so far were like
//! numbers   x y z              f64, of each particle: its position, m; then of each its velocity, m/s
//! numbers   extra              f64, of each particle: what it keeps beyond the clearance, m
//! triangles                    u32, of each particle: the triangle of the body that it was last near to
//! u32       CRC-32             of everything before it
//! ```
//!
//! All numbers little-endian. A simulation goes on only from a checkpoint of its own: the same garments, the same body
//! and motion, the same settings.

use super::simulation_report::{FrameRecord, Settled};
use crate::Error;
use crate::dynamics::{Movement, Remembered};
use crate::geometry::Vector3;
use serde::{Deserialize, Serialize};

const MAGIC: &[u8; 8] = b"TOILEP\r\n";
const VERSION: u32 = 3;
const HEADER_BYTES: usize = 8 + 4 + 4;
const CHECKSUM_BYTES: usize = 4;

/// What a checkpoint is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// A digest of all that decides the result.
    pub of: String,
    pub settled: Settled,
    /// One per frame that was simulated.
    pub frames: Vec<FrameRecord>,
}

/// A simulation between two frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    pub description: Description,
    pub movement: Movement,
    pub remembered: Remembered,
}

/// The bytes of the file.
pub fn write(checkpoint: &Checkpoint) -> Vec<u8> {
    let description = serde_json::to_vec(&checkpoint.description).expect("a description is plain data");
    let Movement { positions, velocities } = &checkpoint.movement;
    let mut bytes = Vec::with_capacity(HEADER_BYTES + description.len() + 60 * positions.len() + CHECKSUM_BYTES);
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((description.len() as u32).to_le_bytes());
    bytes.extend(description);
    for vector in positions.iter().chain(velocities) {
        vector.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    }
    let Remembered { extra, triangles } = &checkpoint.remembered;
    extra.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    triangles.iter().for_each(|t| bytes.extend(t.to_le_bytes()));
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// Reads a checkpoint of so many particles, whatever the bytes are.
pub fn read(bytes: &[u8], particles: usize) -> Result<Checkpoint, Error> {
    let damaged = |problem: String| Error::new(problem, "Simulate from the beginning: leave out --resume.");
    if !bytes.starts_with(MAGIC) {
        return Err(damaged("It is not a checkpoint of toile.".to_owned()));
    }
    if bytes.len() < HEADER_BYTES + CHECKSUM_BYTES {
        return Err(damaged(format!("The file ends after {} bytes, within its header.", bytes.len())));
    }
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    if word(8) != VERSION {
        return Err(damaged(format!("The checkpoint has version {}; this toile reads version {VERSION}.", word(8))));
    }
    let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM_BYTES);
    if crc32fast::hash(content).to_le_bytes() != checksum {
        return Err(damaged("The checksum of the checkpoint is wrong.".to_owned()));
    }
    let (length, rest) = (word(12) as usize, &content[HEADER_BYTES..]);
    if rest.len() != length.saturating_add(60 * particles) {
        return Err(damaged(format!("The checkpoint is not one of {particles} particles.")));
    }
    let (rest, triangles) = rest.split_at(rest.len() - 4 * particles);
    let (description, numbers) = rest.split_at(length);
    let description = serde_json::from_slice(description)
        .map_err(|e| damaged(format!("The description of the checkpoint cannot be read ({e}).")))?;
    let numbers: Vec<f64> =
        numbers.chunks_exact(8).map(|n| f64::from_le_bytes(n.try_into().expect("eight bytes"))).collect();
    if !numbers.iter().all(|x| x.is_finite()) {
        return Err(damaged("The checkpoint has a number that is not finite.".to_owned()));
    }
    let (vectors, extra) = numbers.split_at(6 * particles);
    let vectors: Vec<Vector3> = vectors.chunks_exact(3).map(|v| Vector3::new(v[0], v[1], v[2])).collect();
    let (positions, velocities) = (vectors[..particles].to_vec(), vectors[particles..].to_vec());
    let triangles = triangles.chunks_exact(4).map(|t| u32::from_le_bytes(t.try_into().expect("four bytes")));
    let remembered = Remembered { extra: extra.to_vec(), triangles: triangles.collect() };
    Ok(Checkpoint { description, movement: Movement { positions, velocities }, remembered })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Checkpoint {
        let vector = |k: usize| Vector3::new(k as f64 / 3.0, -1e-300, 1.0);
        Checkpoint {
            description: Description {
                of: "abc".to_owned(),
                settled: Settled::default(),
                frames: vec![FrameRecord::default(); 2],
            },
            movement: Movement { positions: (0..5).map(vector).collect(), velocities: (5..10).map(vector).collect() },
            remembered: Remembered { extra: vec![0.0, 1e-3, 0.0, 2e-4, 0.0], triangles: vec![0, 7, u32::MAX, 3, 9] },
        }
    }

    #[test]
    fn what_is_written_is_read_back_to_the_last_bit() {
        assert_eq!(read(&write(&sample()), 5).unwrap(), sample());
    }

    #[test]
    fn damaged_checkpoints_are_refused() {
        let bytes = write(&sample());
        assert!(read(&bytes, 6).is_err());
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length], 5).is_err(), "{length} bytes were taken for a checkpoint");
        }
        for k in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[k] ^= 0x20;
            assert!(read(&damaged, 5).is_err(), "a flipped bit in byte {k} was not found");
        }
    }
}
