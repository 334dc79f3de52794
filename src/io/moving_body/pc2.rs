//! PC2 point caches: positions of every vertex at every sample, little-endian f32.
//!
//! 12 bytes `POINTCACHE2\0`, i32 version 1, i32 points, f32 first frame, f32 frames from sample to sample, i32 samples; then
//! three f32 for each point of each sample.

use super::USUAL_FRAME_RATE;
use super::obj_sequence::Mesh;
use crate::Error;
use crate::body::Motion;
use crate::body::motion::check_baked_size;
use crate::geometry::Vector3;

pub const TAG: &[u8] = b"POINTCACHE2\0";
const HEADER: usize = 32;
const EXPORT_AGAIN: &str = "Export the cache again, of the body that is given with it.";

/// A cache that moves the vertices of `mesh`; `frame_rate` is that of the program that wrote it, frames a second.
pub fn read(bytes: &[u8], (positions, triangles): Mesh, frame_rate: Option<f64>) -> Result<Motion, Error> {
    let wrong = |at: usize, problem: String| Error::new(problem, EXPORT_AGAIN).within(format!("byte {at}"));
    if !bytes.starts_with(TAG) || bytes.len() < HEADER {
        return Err(wrong(0, "It does not begin as a PC2 cache does.".into()));
    }
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let (version, points, samples) =
        (i32::from_le_bytes(word(12)), i32::from_le_bytes(word(16)), i32::from_le_bytes(word(28)));
    let frames_per_sample = f64::from(f32::from_le_bytes(word(24)));
    if version != 1 {
        return Err(wrong(12, format!("It has the version {version}, not 1.")));
    }
    if usize::try_from(points) != Ok(positions.len()) {
        return Err(wrong(16, format!("The cache moves {points} vertices, the body has {}.", positions.len())));
    }
    if !(frames_per_sample.is_finite() && frames_per_sample > 0.0) {
        return Err(wrong(24, format!("Its samples are {frames_per_sample} frames apart.")));
    }
    let samples = usize::try_from(samples).ok().filter(|&s| s > 0);
    let samples = samples.ok_or_else(|| wrong(28, "It has no samples.".into()))?;
    check_baked_size(positions.len(), samples)?;
    let frames = frames(&bytes[HEADER..], HEADER, positions.len(), samples, f32::from_le_bytes)?;
    Motion::baked(triangles, frame_rate.unwrap_or(USUAL_FRAME_RATE) / frames_per_sample, frames)
}

/// `samples` times the positions of `points` vertices, which begin at byte `offset` of the file.
pub fn frames(
    bytes: &[u8],
    offset: usize,
    points: usize,
    samples: usize,
    number: fn([u8; 4]) -> f32,
) -> Result<Vec<Vec<Vector3>>, Error> {
    let needed = points * samples * 12;
    if bytes.len() < needed {
        let problem =
            format!("The cache is cut: {samples} samples of {points} vertices end at byte {}.", offset + needed);
        return Err(Error::new(problem, EXPORT_AGAIN).within(format!("byte {}", offset + bytes.len())));
    }
    let numbers = bytes[..needed].as_chunks::<4>().0;
    if let Some(k) = numbers.iter().position(|&n| !number(n).is_finite()) {
        let error =
            Error::new("A coordinate is no finite number.", EXPORT_AGAIN).within(format!("byte {}", offset + 4 * k));
        return Err(error.within(format!("sample {}, vertex {}", k / 3 / points, k / 3 % points + 1)));
    }
    let point = |p: &[[u8; 4]; 3]| Vector3::from(p.map(|n| f64::from(number(n))));
    Ok(numbers.as_chunks::<3>().0.chunks(points).map(|sample| sample.iter().map(point).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    pub fn mesh() -> Mesh {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from);
        (positions.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    fn cache(points: i32, samples: i32) -> Vec<u8> {
        let mut bytes = TAG.to_vec();
        bytes.extend([1, points].iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend([1.0f32, 0.5].iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(samples.to_le_bytes());
        bytes.extend((0..24).flat_map(|k| (0.125 * k as f32).to_le_bytes()));
        bytes
    }

    #[test]
    fn samples_are_read_as_they_were_written() {
        let motion = read(&cache(4, 2), mesh(), None).unwrap();
        // Two samples a frame, 24 frames a second.
        assert_eq!((motion.frame_count(), motion.frame_rate()), (2, 48.0));
        assert_eq!(motion.positions(0)[1], Vector3::new(0.375, 0.5, 0.625));
        assert_eq!(motion.positions(1)[3], Vector3::new(2.625, 2.75, 2.875));
        assert_eq!(read(&cache(4, 2), mesh(), Some(30.0)).unwrap().frame_rate(), 60.0);
    }

    #[test]
    fn damaged_caches_are_told_so() {
        let problem = |bytes: &[u8]| read(bytes, mesh(), None).unwrap_err().to_string();
        assert!(problem(&cache(5, 2)).contains("byte 16: The cache moves 5 vertices, the body has 4"));
        assert!(problem(&cache(-1, 2)).contains("moves -1"));
        assert!(problem(&cache(4, 0)).contains("byte 28"));
        assert!(problem(&cache(4, i32::MAX)).contains("MiB"));
        assert!(problem(&cache(4, 3)).contains("byte 128: The cache is cut"));
        assert!(problem(&cache(4, 2)[..31]).contains("byte 0"));
        let mut bytes = cache(4, 2);
        bytes[HEADER + 4 * 13..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(problem(&bytes).contains("sample 1, vertex 1, byte 84"), "{}", problem(&bytes));
        let mut bytes = cache(4, 2);
        bytes[24..28].copy_from_slice(&0f32.to_le_bytes());
        assert!(problem(&bytes).contains("frames apart"));
    }
}
