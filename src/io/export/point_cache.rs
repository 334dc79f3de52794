//! Point caches: a header and positions, frame after frame, without a mesh. Two programs' formats, both read by Blender's
//! modifier Mesh Cache and many others.
//!
//! *PC2*, of 3ds Max, little-endian: `POINTCACHE2\0`, i32 version 1, i32 points, f32 start frame, f32 frames between
//! samples, i32 samples; then f32 x y z of each point, sample after sample.
//!
//! *MDD*, of LightWave, big-endian: i32 frames, i32 points, f32 time of each frame in seconds; then f32 x y z of each
//! point, frame after frame.

use super::frames::{Frames, for_each};
use crate::geometry::Vector3;
use crate::io::atomic::Unfinished;
use std::io::Write;

/// Writes a PC2 file: particles as points, in their order, m, y up.
pub fn write_pc2(particle_count: usize, frames: &mut dyn Frames, out: &mut impl Write) -> Result<(), Unfinished> {
    out.write_all(b"POINTCACHE2\0")?;
    out.write_all(&1i32.to_le_bytes())?;
    out.write_all(&count(particle_count)?.to_le_bytes())?;
    out.write_all(&0f32.to_le_bytes())?;
    out.write_all(&1f32.to_le_bytes())?;
    out.write_all(&count(frames.frame_count())?.to_le_bytes())?;
    for_each(frames, |_, positions| Ok(out.write_all(&numbers(positions, f32::to_le_bytes))?))
}

/// Writes an MDD file: particles as points, in their order, m, y up.
pub fn write_mdd(particle_count: usize, frames: &mut dyn Frames, out: &mut impl Write) -> Result<(), Unfinished> {
    let frame_count = frames.frame_count();
    out.write_all(&count(frame_count)?.to_be_bytes())?;
    out.write_all(&count(particle_count)?.to_be_bytes())?;
    for frame in 0..frame_count {
        out.write_all(&((frame as f64 / frames.frame_rate()) as f32).to_be_bytes())?;
    }
    for_each(frames, |_, positions| Ok(out.write_all(&numbers(positions, f32::to_be_bytes))?))
}

fn numbers(positions: &[Vector3], bytes: fn(f32) -> [u8; 4]) -> Vec<u8> {
    positions.iter().flatten().flat_map(|&x| bytes(x as f32)).collect()
}

fn count(count: usize) -> Result<i32, Unfinished> {
    let too_many = || {
        crate::Error::new(
            format!("A point cache cannot count to {count}."),
            "Choose fewer frames with --frames, or another format.",
        )
    };
    i32::try_from(count).map_err(|_| too_many().into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::export::Sequence;

    fn sequence() -> Sequence {
        let frame = |k: f64| vec![Vector3::new(k, 0.25, -2.0), Vector3::new(1.0 / 3.0, k, 0.0)];
        Sequence { frame_rate: 25.0, frames: vec![frame(0.0), frame(1.0), frame(1.5)] }
    }

    fn floats(bytes: &[u8], number: fn([u8; 4]) -> f32) -> Vec<f32> {
        bytes.as_chunks::<4>().0.iter().map(|&four| number(four)).collect()
    }

    const NUMBERS: [f32; 18] = [
        0.0,
        0.25,
        -2.0,
        1.0 / 3.0,
        0.0,
        0.0,
        1.0,
        0.25,
        -2.0,
        1.0 / 3.0,
        1.0,
        0.0,
        1.5,
        0.25,
        -2.0,
        1.0 / 3.0,
        1.5,
        0.0,
    ];

    #[test]
    fn a_pc2_file_is_as_its_description_says() {
        let mut file = Vec::new();
        write_pc2(2, &mut sequence(), &mut file).unwrap();
        let head = b"POINTCACHE2\0\x01\0\0\0\x02\0\0\0\0\0\0\0\0\0\x80\x3f\x03\0\0\0";
        assert_eq!(&file[..32], head);
        assert_eq!(floats(&file[32..], f32::from_le_bytes), NUMBERS);
    }

    #[test]
    fn an_mdd_file_is_as_its_description_says() {
        let mut file = Vec::new();
        write_mdd(2, &mut sequence(), &mut file).unwrap();
        assert_eq!(&file[..8], [0, 0, 0, 3, 0, 0, 0, 2]);
        assert_eq!(floats(&file[8..20], f32::from_be_bytes), [0.0, 0.04, 0.08]);
        assert_eq!(floats(&file[20..], f32::from_be_bytes), NUMBERS);
    }
}
