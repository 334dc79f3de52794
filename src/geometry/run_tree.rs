//! A hierarchy over boxes that come in spatial order, built in one pass.
//!
//! Particles lie along a Morton curve (`garment::order`), edges and triangles follow their first
//! particle: a run of neighbours in memory is a patch of cloth. So the tree needs no search for good
//! splits. Eight consecutive boxes have one above them, eight of those one above again, and where a
//! box's children are follows from its index.
//!
//! Not promised: speed for boxes in any other order; what is found is the same.

use super::Vector3;

/// Boxes to a run.
const RUN: usize = 8;
/// Binary digits of an index within a run.
const RUN_BITS: usize = RUN.trailing_zeros() as usize;

/// Consecutive boxes, by axis, so that all are tested against another at once.
#[derive(Clone, Copy, Debug)]
struct Run {
    low: [[f64; RUN]; 3],
    high: [[f64; RUN]; 3],
}

/// Axis-aligned boxes with their indices `0..n`, in spatial order, for finding those that meet a box.
pub struct RunTree {
    /// The boxes themselves, then the boxes around each of their runs, and so on to a single run.
    levels: Vec<Vec<Run>>,
}

impl Run {
    const EMPTY: Run = Run { low: [[f64::INFINITY; RUN]; 3], high: [[f64::NEG_INFINITY; RUN]; 3] };

    /// Bit `k` tells whether box `k` meets the box `low..high`; touching counts.
    #[inline]
    fn meeting(&self, low: Vector3, high: Vector3) -> u32 {
        // The widest gap along any axis: compilers make vectors of this, and not of comparisons.
        let larger = |a: f64, b: f64| if a > b { a } else { b };
        let mut gaps = [f64::NEG_INFINITY; RUN];
        for axis in 0..3 {
            for (k, gap) in gaps.iter_mut().enumerate() {
                *gap = larger(*gap, larger(self.low[axis][k] - high[axis], low[axis] - self.high[axis][k]));
            }
        }
        gaps.iter().enumerate().fold(0, |bits, (k, &gap)| bits | (u32::from(gap <= 0.0) << k))
    }

    fn bounds(&self) -> (Vector3, Vector3) {
        let low = self.low.map(|axis| axis.into_iter().fold(f64::INFINITY, f64::min));
        let high = self.high.map(|axis| axis.into_iter().fold(f64::NEG_INFINITY, f64::max));
        (low.into(), high.into())
    }
}

/// Eight boxes to a run; the last run is filled up with empty ones.
fn runs(boxes: impl Iterator<Item = (Vector3, Vector3)>) -> Vec<Run> {
    let mut runs = Vec::with_capacity(boxes.size_hint().0.div_ceil(RUN));
    for (index, (low, high)) in boxes.enumerate() {
        let within = index % RUN;
        if within == 0 {
            runs.push(Run::EMPTY);
        }
        let run = runs.last_mut().expect("a run was just begun");
        for axis in 0..3 {
            run.low[axis][within] = low[axis];
            run.high[axis][within] = high[axis];
        }
    }
    runs
}

impl RunTree {
    /// A tree over the boxes `(low, high)`.
    pub fn new(boxes: impl Iterator<Item = (Vector3, Vector3)>) -> Self {
        let mut levels = vec![runs(boxes)];
        while levels[levels.len() - 1].len() > 1 {
            levels.push(runs(levels[levels.len() - 1].iter().map(Run::bounds)));
        }
        Self { levels }
    }

    /// Calls `visit` with the index of every box from `first` on that meets the box `low..high`, ascending.
    pub fn for_each_meeting(&self, low: Vector3, high: Vector3, first: u32, mut visit: impl FnMut(u32)) {
        if !self.levels[0].is_empty() {
            self.descend(self.levels.len() - 1, 0, (low, high), first as usize, &mut visit);
        }
    }

    fn descend(&self, level: usize, run: usize, of: (Vector3, Vector3), first: usize, visit: &mut impl FnMut(u32)) {
        let mut meeting = self.levels[level][run].meeting(of.0, of.1);
        // Children that end before the first index.
        let before = (first >> (RUN_BITS * level)).saturating_sub(run * RUN);
        meeting &= u32::MAX.checked_shl(before as u32).unwrap_or(0);
        while meeting != 0 {
            let child = run * RUN + meeting.trailing_zeros() as usize;
            if level == 0 {
                visit(child as u32);
            } else {
                self.descend(level - 1, child, of, first, visit);
            }
            meeting &= meeting - 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxes() -> impl Strategy<Value = Vec<(Vector3, Vector3)>> {
        let corner = || [-1.0..1.0, -1.0..1.0, -1.0..1.0f64].prop_map(Vector3::from);
        let sized =
            (corner(), corner()).prop_map(|(middle, size)| (middle - size.abs() * 0.2, middle + size.abs() * 0.2));
        prop::collection::vec(sized, 0..700)
    }

    proptest! {
        #[test]
        fn finds_what_testing_every_box_finds(boxes in boxes(), first in 0..700u32, share in 0.0..1.0f64) {
            let tree = RunTree::new(boxes.iter().copied());
            let (low, high) = (Vector3::repeat(-share), Vector3::repeat(0.5 * share));
            let mut found = Vec::new();
            tree.for_each_meeting(low, high, first, |index| found.push(index));
            let meets = |&index: &u32| {
                let (l, h) = boxes[index as usize];
                (0..3).all(|axis| l[axis] <= high[axis] && h[axis] >= low[axis])
            };
            let expected: Vec<u32> = (first..boxes.len() as u32).filter(meets).collect();
            prop_assert_eq!(found, expected);
        }
    }
}
