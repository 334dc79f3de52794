//! MDD vertex caches: positions of every vertex at times of their own, big-endian.
//!
//! i32 samples, i32 points, one f32 time, s, for each sample; then three f32 for each point of each sample.

use super::obj_sequence::Mesh;
use super::{USUAL_FRAME_RATE, frames_within, pc2};
use crate::Error;
use crate::body::Motion;
use crate::body::motion::{MOST_FRAMES, check_baked_size};
use crate::geometry::Vector3;

const HEADER: usize = 8;
/// Times this evenly spaced are taken for frames, in parts of a frame.
const EVEN: f64 = 0.02;
const EXPORT_AGAIN: &str = "Export the cache again, of the body that is given with it.";

/// A cache that moves the vertices of `mesh`, sampled `frame_rate` times a second; else as often as it was written, if
/// evenly, and 24 times if not.
pub fn read(bytes: &[u8], (positions, triangles): Mesh, frame_rate: Option<f64>) -> Result<Motion, Error> {
    let wrong = |at: usize, problem: String| Error::new(problem, EXPORT_AGAIN).within(format!("byte {at}"));
    if bytes.len() < HEADER {
        return Err(wrong(0, "It does not begin as an MDD cache does.".into()));
    }
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let (samples, points) = (i32::from_be_bytes(word(0)), i32::from_be_bytes(word(4)));
    if usize::try_from(points) != Ok(positions.len()) {
        return Err(wrong(4, format!("The cache moves {points} vertices, the body has {}.", positions.len())));
    }
    let samples = usize::try_from(samples).ok().filter(|s| (1..=MOST_FRAMES).contains(s));
    let samples = samples.ok_or_else(|| wrong(0, format!("It should have from 1 to {MOST_FRAMES} samples.")))?;
    check_baked_size(positions.len(), samples)?;
    let start = HEADER + 4 * samples;
    if bytes.len() < start {
        return Err(wrong(
            bytes.len(),
            format!("The cache is cut: the times of its {samples} samples end at byte {start}."),
        ));
    }
    let times: Vec<f64> = (0..samples).map(|k| f64::from(f32::from_be_bytes(word(HEADER + 4 * k)))).collect();
    if let Some(k) = times.iter().position(|t| !t.is_finite()) {
        return Err(wrong(HEADER + 4 * k, format!("Sample {k} is at {} s.", times[k])));
    }
    if let Some(k) = times.windows(2).position(|w| w[0] >= w[1]) {
        let problem =
            format!("The times of its samples do not ascend: {} s comes before {} s.", times[k], times[k + 1]);
        return Err(wrong(HEADER + 4 * (k + 1), problem));
    }
    let frames = pc2::frames(&bytes[start..], start, positions.len(), samples, f32::from_be_bytes)?;
    let even = even_rate(&times);
    match (even, frame_rate) {
        (Some(rate), None) => Motion::baked(triangles, rate, frames),
        (Some(rate), Some(asked)) if (rate / asked - 1.0).abs() < 1e-6 => Motion::baked(triangles, rate, frames),
        (_, asked) => {
            let rate = asked.unwrap_or(USUAL_FRAME_RATE);
            let count = frames_within(times[samples - 1] - times[0], rate)?;
            check_baked_size(positions.len(), count)?;
            let sampled = (0..count).map(|k| at(times[0] + k as f64 / rate, &times, &frames)).collect();
            Motion::baked(triangles, rate, sampled)
        }
    }
}

/// Samples a second, if they are evenly spaced.
fn even_rate(times: &[f64]) -> Option<f64> {
    let (first, last) = (times[0], times[times.len() - 1]);
    let rate = if times.len() > 1 { (times.len() - 1) as f64 / (last - first) } else { USUAL_FRAME_RATE };
    let even = times.iter().zip(0u32..).all(|(t, k)| ((t - first) * rate - f64::from(k)).abs() <= EVEN);
    let whole = rate.round();
    even.then(|| if (rate / whole - 1.0).abs() < 1e-3 { whole } else { rate })
}

/// Positions at a time, in a straight line between samples.
fn at(time: f64, times: &[f64], frames: &[Vec<Vector3>]) -> Vec<Vector3> {
    let after = times.partition_point(|&t| t <= time).clamp(1, times.len().max(2) - 1);
    let Some(end) = frames.get(after) else { return frames[0].clone() };
    let t = ((time - times[after - 1]) / (times[after] - times[after - 1])).clamp(0.0, 1.0);
    frames[after - 1].iter().zip(end).map(|(a, b)| a.lerp(b, t)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Mesh {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from);
        (positions.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    fn cache(points: i32, times: &[f32]) -> Vec<u8> {
        let mut bytes: Vec<u8> = [times.len() as i32, points].iter().flat_map(|n| n.to_be_bytes()).collect();
        bytes.extend(times.iter().flat_map(|t| t.to_be_bytes()));
        bytes.extend((0..12 * times.len()).flat_map(|k| (0.25 * k as f32).to_be_bytes()));
        bytes
    }

    #[test]
    fn samples_are_read_as_they_were_written() {
        let motion = read(&cache(4, &[1.0, 1.04, 1.08]), mesh(), None).unwrap();
        assert_eq!((motion.frame_count(), motion.frame_rate()), (3, 25.0));
        assert_eq!(motion.positions(2)[1], Vector3::new(6.75, 7.0, 7.25));
        assert_eq!(read(&cache(4, &[0.0]), mesh(), None).unwrap().frame_count(), 1);
    }

    #[test]
    fn other_rates_lie_on_straight_lines_between_samples() {
        for (times, asked) in [(vec![0.0, 0.5, 1.0], Some(4.0)), (vec![0.0, 0.25, 1.0], Some(4.0))] {
            let motion = read(&cache(4, &times), mesh(), asked).unwrap();
            assert_eq!((motion.frame_count(), motion.frame_rate()), (5, 4.0));
            let expected = 0.25 * if times[1] == 0.5 { 6.0 } else { 12.0 };
            assert!((motion.positions(1)[0].x - expected).abs() < 1e-9);
            assert!((motion.positions(4)[0].x - 6.0).abs() < 1e-9);
        }
        assert_eq!(read(&cache(4, &[0.0, 0.25, 1.0]), mesh(), None).unwrap().frame_count(), 25);
    }

    #[test]
    fn damaged_caches_are_told_so() {
        let problem = |bytes: &[u8]| read(bytes, mesh(), None).unwrap_err().to_string();
        assert!(problem(&cache(3, &[0.0])).contains("byte 4: The cache moves 3 vertices, the body has 4"));
        assert!(problem(&cache(4, &[])).contains("samples"));
        assert!(problem(&cache(4, &[0.0, f32::NAN])).contains("byte 12"));
        assert!(problem(&cache(4, &[0.0, 0.5, 0.5])).contains("byte 16: The times"));
        assert!(problem(&cache(4, &[0.0, 1e9])[..]).contains("more than") || even_rate(&[0.0, 1e9]).is_some());
        let whole = cache(4, &[0.0, 0.5]);
        assert!(problem(&whole[..whole.len() - 1]).contains("is cut"));
        assert!(problem(&whole[..12]).contains("is cut") && problem(&whole[..7]).contains("byte 0"));
    }
}
