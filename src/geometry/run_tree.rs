//! A hierarchy over boxes that come in spatial order, built in one pass.
//!
//! Particles lie along a Morton curve (`garment::order`), triangles follow their first particle: a
//! run of neighbours in memory is a patch of cloth. So the tree needs no search for good splits.
//! Eight consecutive boxes have one above them, eight of those one above again, and where a box's
//! children are follows from its index.
//!
//! Boxes are kept in `f32`, rounded outwards: half the memory, twice as many to an instruction. Boxes
//! that meet are therefore always found; such as miss each other by less than rounding may be found too.
//!
//! Not promised: speed for boxes in any other order; what is found is the same.

use super::Vector3;
use rayon::prelude::*;

/// Boxes to a run.
const RUN: usize = 8;
/// Binary digits of an index within a run.
const RUN_BITS: usize = RUN.trailing_zeros() as usize;
/// Levels below a piece of parallel work: two runs of 512 boxes each.
const LEVELS_TO_A_PIECE: usize = 2;

/// Consecutive boxes, by axis, so that all are tested against another at once.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    low: [[f32; RUN]; 3],
    high: [[f32; RUN]; 3],
}

/// A box in `f32`: its lowest corner, its highest.
type Bounds = ([f32; 3], [f32; 3]);

/// Axis-aligned boxes with their indices `0..n`, in spatial order, for finding those that meet.
pub struct RunTree {
    /// The boxes themselves, then the boxes around each of their runs, and so on to a single run.
    levels: Vec<Vec<Run>>,
}

impl Run {
    const EMPTY: Run = Run { low: [[f32::INFINITY; RUN]; 3], high: [[f32::NEG_INFINITY; RUN]; 3] };

    /// Bit `k` tells whether box `k` meets the box `low..high`; touching counts.
    #[inline]
    fn meeting(&self, (low, high): Bounds) -> u32 {
        // The widest gap along any axis: compilers make vectors of this, and not of comparisons.
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let mut gaps = [f32::NEG_INFINITY; RUN];
        for axis in 0..3 {
            for (k, gap) in gaps.iter_mut().enumerate() {
                *gap = larger(*gap, larger(self.low[axis][k] - high[axis], low[axis] - self.high[axis][k]));
            }
        }
        gaps.iter().enumerate().fold(0, |bits, (k, &gap)| bits | (u32::from(gap <= 0.0) << k))
    }

    fn around(&self) -> Bounds {
        let low = self.low.map(|axis| axis.into_iter().fold(f32::INFINITY, f32::min));
        let high = self.high.map(|axis| axis.into_iter().fold(f32::NEG_INFINITY, f32::max));
        (low, high)
    }

    #[inline]
    fn get(&self, k: usize) -> Bounds {
        (self.low.map(|axis| axis[k]), self.high.map(|axis| axis[k]))
    }

    fn set(&mut self, k: usize, (low, high): Bounds) {
        for axis in 0..3 {
            self.low[axis][k] = low[axis];
            self.high[axis][k] = high[axis];
        }
    }
}

/// A number not above `x`: at least one unit in the last place below the nearest.
#[inline]
fn below(x: f64) -> f32 {
    let nearest = x as f32;
    nearest - (nearest.abs() * f32::EPSILON + f32::MIN_POSITIVE)
}

fn rounded_outwards((low, high): (Vector3, Vector3)) -> Bounds {
    (std::array::from_fn(|axis| below(low[axis])), std::array::from_fn(|axis| -below(-high[axis])))
}

/// Eight boxes to a run; the last run is filled up with empty ones.
fn runs(boxes: impl Iterator<Item = Bounds>) -> Vec<Run> {
    let mut runs = Vec::with_capacity(boxes.size_hint().0.div_ceil(RUN));
    for (index, bounds) in boxes.enumerate() {
        if index % RUN == 0 {
            runs.push(Run::EMPTY);
        }
        runs.last_mut().expect("a run was just begun").set(index % RUN, bounds);
    }
    runs
}

impl RunTree {
    /// A tree over the boxes `(low, high)`.
    pub fn new(boxes: impl Iterator<Item = (Vector3, Vector3)>) -> Self {
        let mut levels = vec![runs(boxes.map(rounded_outwards))];
        while levels[levels.len() - 1].len() > 1 {
            levels.push(runs(levels[levels.len() - 1].iter().map(Run::around)));
        }
        Self { levels }
    }

    /// Replaces some boxes, whose indices ascend.
    pub fn update(&mut self, boxes: impl Iterator<Item = (u32, (Vector3, Vector3))>) {
        let mut changed: Vec<usize> = Vec::new();
        for (index, bounds) in boxes {
            self.levels[0][index as usize / RUN].set(index as usize % RUN, rounded_outwards(bounds));
            changed.push(index as usize / RUN);
        }
        for level in 1..self.levels.len() {
            changed.dedup();
            let (finer, coarser) = self.levels.split_at_mut(level);
            for run in &mut changed {
                coarser[0][*run / RUN].set(*run % RUN, finer[level - 1][*run].around());
                *run /= RUN;
            }
        }
    }

    /// Calls `visit` with the index of every box that meets box `index`, itself included, ascending.
    pub fn for_each_meeting(&self, index: u32, mut visit: impl FnMut(u32)) {
        let bounds = self.levels[0][index as usize / RUN].get(index as usize % RUN);
        self.descend(self.levels.len() - 1, 0, bounds, &mut visit);
    }

    /// Calls `visit` with the index of every box that meets the box `low..high`, ascending.
    pub fn for_each_meeting_box(&self, low: Vector3, high: Vector3, mut visit: impl FnMut(u32)) {
        if !self.levels[0].is_empty() {
            self.descend(self.levels.len() - 1, 0, rounded_outwards((low, high)), &mut visit);
        }
    }

    fn descend(&self, level: usize, run: usize, bounds: Bounds, visit: &mut impl FnMut(u32)) {
        let mut meeting = self.levels[level][run].meeting(bounds);
        while meeting != 0 {
            let child = run * RUN + meeting.trailing_zeros() as usize;
            if level == 0 {
                visit(child as u32);
            } else {
                self.descend(level - 1, child, bounds, visit);
            }
            meeting &= meeting - 1;
        }
    }

    /// Calls `find(i, j, &mut found)` for all pairs of boxes `i < j` that meet, and gives back what was
    /// found. The order of the pairs follows from the boxes alone, whatever the number of threads.
    pub fn collect_pairs<T: Send>(&self, find: impl Fn(u32, u32, &mut Vec<T>) + Sync) -> Vec<T> {
        let mut level = self.levels.len() - 1;
        let mut pieces = if self.levels[0].is_empty() { vec![] } else { vec![(0, 0)] };
        while level > LEVELS_TO_A_PIECE {
            let mut finer = Vec::new();
            pieces.iter().for_each(|&(a, b)| self.meeting_children(level, a, b, |i, j| finer.push((i, j))));
            pieces = finer;
            level -= 1;
        }
        let within = |&(a, b): &(usize, usize)| {
            let mut found = Vec::new();
            self.descend_both(level, a, b, &mut |i, j| find(i as u32, j as u32, &mut found));
            found
        };
        pieces.par_iter().flat_map_iter(within).collect()
    }

    fn descend_both(&self, level: usize, a: usize, b: usize, visit: &mut impl FnMut(usize, usize)) {
        if level == 0 {
            self.meeting_children(0, a, b, visit);
        } else {
            self.meeting_children(level, a, b, |i, j| self.descend_both(level - 1, i, j, visit));
        }
    }

    /// The pairs of a box of run `a` and one of run `b` that meet. Within one run each pair comes once,
    /// and boxes that stand for others come with themselves.
    #[inline]
    fn meeting_children(&self, level: usize, a: usize, b: usize, mut visit: impl FnMut(usize, usize)) {
        let (one, other) = (&self.levels[level][a], &self.levels[level][b]);
        for k in 0..RUN {
            let mut meeting = other.meeting(one.get(k));
            if a == b {
                meeting &= u32::MAX << (k + usize::from(level == 0));
            }
            while meeting != 0 {
                visit(a << RUN_BITS | k, b << RUN_BITS | meeting.trailing_zeros() as usize);
                meeting &= meeting - 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Box = (Vector3, Vector3);

    /// Corners on a binary grid, so that boxes touch or miss each other by far more than rounding.
    fn boxes(most: usize) -> impl Strategy<Value = Vec<Box>> {
        let corner = |most: i32| [0..most, 0..most, 0..most].prop_map(|c| Vector3::from(c.map(f64::from)) / 8.0);
        prop::collection::vec((corner(100), corner(20)).prop_map(|(low, size)| (low, low + size)), 0..most)
    }

    fn meet(a: &Box, b: &Box) -> bool {
        (0..3).all(|axis| a.0[axis] <= b.1[axis] && a.1[axis] >= b.0[axis])
    }

    proptest! {
        #[test]
        fn finds_what_testing_every_pair_finds(boxes in boxes(700)) {
            let tree = RunTree::new(boxes.iter().copied());
            let mut pairs = tree.collect_pairs(|i, j, found| found.push((i, j)));
            pairs.sort_unstable();
            let meets = |i: usize, j: usize| meet(&boxes[i], &boxes[j]);
            let every = (0..boxes.len()).flat_map(|i| (i + 1..boxes.len()).map(move |j| (i, j)));
            let expected: Vec<_> = every.filter(|&(i, j)| meets(i, j)).map(|(i, j)| (i as u32, j as u32)).collect();
            prop_assert_eq!(pairs, expected);
            for i in (0..boxes.len()).step_by(17) {
                let mut found = Vec::new();
                tree.for_each_meeting(i as u32, |j| found.push(j as usize));
                prop_assert_eq!(found, (0..boxes.len()).filter(|&j| meets(i, j)).collect::<Vec<_>>());
            }
        }

        #[test]
        fn an_updated_tree_is_that_of_the_new_boxes(old in boxes(300), new in boxes(300), every in 1..40usize) {
            let count = old.len().min(new.len());
            let changed = (0..count).step_by(every);
            let mut boxes = old[..count].to_vec();
            let mut tree = RunTree::new(boxes.iter().copied());
            changed.clone().for_each(|k| boxes[k] = new[k]);
            tree.update(changed.map(|k| (k as u32, new[k])));
            prop_assert_eq!(tree.levels, RunTree::new(boxes.into_iter()).levels);
        }
    }

    #[test]
    fn boxes_that_touch_are_found_however_their_corners_round() {
        for k in 0..1000 {
            let edge = 0.1 + f64::from(k) / 977.0;
            let low = (Vector3::zeros(), Vector3::repeat(edge));
            let high = (Vector3::repeat(edge), Vector3::repeat(2.0));
            let pairs = RunTree::new([low, high].into_iter()).collect_pairs(|i, j, found| found.push([i, j]));
            assert_eq!(pairs, [[0, 1]], "{edge}");
        }
    }
}
