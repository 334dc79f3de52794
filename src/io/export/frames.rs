//! Positions of the particles over time, one frame in memory at a time.

use crate::Error;
use crate::geometry::Vector3;

/// A garment in motion, or at rest: at least one frame of as many particles as its level has.
pub trait Frames {
    /// Frames a second.
    fn frame_rate(&self) -> f64;

    fn frame_count(&self) -> usize;

    /// Puts the positions of a frame into `positions`: one per particle, m, world. `frame` counts from zero.
    fn read(&mut self, frame: usize, positions: &mut Vec<Vector3>) -> Result<(), Error>;
}

/// Frames in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// Frames a second.
    pub frame_rate: f64,
    /// Per frame, one position per particle, m, world.
    pub frames: Vec<Vec<Vector3>>,
}

/// The rate that is told of what does not move, frames a second: that of films.
const STILL_RATE: f64 = 24.0;

impl Sequence {
    /// A garment at rest.
    pub fn still(positions: Vec<Vector3>) -> Self {
        Self { frame_rate: STILL_RATE, frames: vec![positions] }
    }
}

impl Frames for Sequence {
    fn frame_rate(&self) -> f64 {
        self.frame_rate
    }

    fn frame_count(&self) -> usize {
        self.frames.len()
    }

    fn read(&mut self, frame: usize, positions: &mut Vec<Vector3>) -> Result<(), Error> {
        positions.clone_from(&self.frames[frame]);
        Ok(())
    }
}

/// Some frames of a motion: `first`, then every `step`-th, `count` of them.
pub struct Chosen<'a> {
    pub all: &'a mut dyn Frames,
    pub first: usize,
    pub step: usize,
    pub count: usize,
}

impl Frames for Chosen<'_> {
    fn frame_rate(&self) -> f64 {
        self.all.frame_rate() / self.step as f64
    }

    fn frame_count(&self) -> usize {
        self.count
    }

    fn read(&mut self, frame: usize, positions: &mut Vec<Vector3>) -> Result<(), Error> {
        assert!(frame < self.count, "the frame is not among those chosen");
        self.all.read(self.first + frame * self.step, positions)
    }
}

/// Calls `each` with the number and the positions of every frame, in their order.
pub fn for_each<E: From<Error>>(
    frames: &mut dyn Frames,
    mut each: impl FnMut(usize, &[Vector3]) -> Result<(), E>,
) -> Result<(), E> {
    let mut positions = Vec::new();
    for frame in 0..frames.frame_count() {
        frames.read(frame, &mut positions)?;
        each(frame, &positions)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_second_frame_has_half_the_rate() {
        let frames = (0..7).map(|k| vec![Vector3::new(f64::from(k), 0.0, 0.0)]).collect();
        let mut all = Sequence { frame_rate: 24.0, frames };
        let mut chosen = Chosen { all: &mut all, first: 1, step: 2, count: 3 };
        assert_eq!((chosen.frame_rate(), chosen.frame_count()), (12.0, 3));
        let mut seen = Vec::new();
        for_each::<Error>(&mut chosen, |k, positions| {
            seen.push((k, positions[0].x));
            Ok(())
        })
        .unwrap();
        assert_eq!(seen, [(0, 1.0), (1, 3.0), (2, 5.0)]);
    }
}
