//! Where the outlines of the panels carry particles, on every level.
//!
//! A seam is sampled once for both its sides, at equal fractions of their arc lengths, so that every
//! particle of one side has its partner on the other. The finest level is sampled evenly and each
//! coarser one keeps some of its samples: corners are kept always, and whatever is a particle on a
//! level is one on all finer levels.

use crate::geometry::{Vector2, polygon_crossing};
use crate::pattern::{Pattern, SegmentId, Sense};
use crate::{Code, Error};

/// The samples of one segment or of the two sides of one seam.
struct Line {
    /// Sewn segments have two sides.
    sides: Vec<(SegmentId, Sense)>,
    /// Evenly spaced steps on the finest level.
    finest_steps: u32,
    /// Per level, coarsest first: which of the finest samples it keeps, ascending, with both ends.
    kept: Vec<Vec<u32>>,
}

/// The outlines of a pattern, sampled on every level.
pub struct Outlines {
    lines: Vec<Line>,
    /// Per panel and segment: its line and its side in it.
    line_of: Vec<Vec<(usize, usize)>>,
}

/// The outline of one panel on one level.
pub struct Outline {
    /// A closed polygon in the order of the panel's segments, m.
    pub points: Vec<Vector2>,
    /// Per segment: index of its first point in `points`, and its number of steps.
    pub segments: Vec<(usize, usize)>,
}

impl Outline {
    /// Index of the point after `step` steps along a segment.
    pub fn point_of(&self, segment: usize, step: usize) -> usize {
        (self.segments[segment].0 + step) % self.points.len()
    }
}

impl Outlines {
    /// Samples `pattern` for `resolutions`, coarsest first, m.
    pub fn new(pattern: &Pattern, resolutions: &[f64]) -> Result<Self, Error> {
        let mut lines = Vec::new();
        let mut line_of: Vec<Vec<Option<(usize, usize)>>> =
            pattern.panels.iter().map(|p| vec![None; p.segments.len()]).collect();
        let sewn = pattern.seams.iter().map(|s| vec![(s.sides[0], Sense::Aligned), (s.sides[1], s.sense)]);
        let all = pattern.panels.iter().enumerate().flat_map(|(panel, p)| {
            (0..p.segments.len()).map(move |segment| vec![(SegmentId { panel, segment }, Sense::Aligned)])
        });
        for sides in sewn.chain(all) {
            if line_of[sides[0].0.panel][sides[0].0.segment].is_some() {
                continue;
            }
            for (k, (id, _)) in sides.iter().enumerate() {
                line_of[id.panel][id.segment] = Some((lines.len(), k));
            }
            let longest = sides.iter().map(|(id, _)| pattern.segment(*id).curve.length()).fold(0.0, f64::max);
            lines.push(Line::new(sides, longest, resolutions));
        }
        let line_of = line_of.into_iter().map(|p| p.into_iter().flatten().collect()).collect();
        let mut outlines = Self { lines, line_of };
        for level in (0..resolutions.len()).rev() {
            outlines.uncross(pattern, level, resolutions[level])?;
        }
        Ok(outlines)
    }

    /// Chords of a long step may cross where the curves do not: such panels get more samples.
    fn uncross(&mut self, pattern: &Pattern, level: usize, resolution: f64) -> Result<(), Error> {
        // Sixteen-fold refinement resolves whatever a pattern maker can draw; more is a damaged file.
        const MOST_REFINEMENTS: usize = 4;
        for (panel, drawn) in pattern.panels.iter().enumerate() {
            let mut refinements = 0;
            while polygon_crossing(&self.outline(pattern, panel, level).points).is_some() {
                if refinements == MOST_REFINEMENTS {
                    return Err(Error::new(
                        format!(
                            "Its outline crosses itself at a resolution of {} mm.",
                            (resolution * 1e4).round() / 10.0
                        ),
                        "Straighten the narrow part of the outline, or ask for a finer resolution.",
                    )
                    .coded(Code::PanelTooNarrow)
                    .within(format!("panel \"{}\"", drawn.name)));
                }
                refinements += 1;
                for segment in 0..drawn.segments.len() {
                    if !drawn.segments[segment].curve.is_straight() {
                        let line = self.line_of[panel][segment].0;
                        self.lines[line].refine(level);
                    }
                }
            }
        }
        Ok(())
    }

    /// The outline of a panel on a level.
    pub fn outline(&self, pattern: &Pattern, panel: usize, level: usize) -> Outline {
        let mut points = Vec::new();
        let mut segments = Vec::new();
        for (k, segment) in pattern.panels[panel].segments.iter().enumerate() {
            let fractions = self.fractions(SegmentId { panel, segment: k }, level);
            let steps = fractions.len() - 1;
            segments.push((points.len(), steps));
            points.extend(fractions[..steps].iter().map(|&f| segment.curve.at_fraction(f)));
        }
        Outline { points, segments }
    }

    /// Fractions of the arc length at which a segment has its particles on a level, ascending.
    fn fractions(&self, id: SegmentId, level: usize) -> Vec<f64> {
        let (line, side) = self.line_of[id.panel][id.segment];
        let line = &self.lines[line];
        let steps = f64::from(line.finest_steps);
        let kept = line.kept[level].iter();
        match line.sides[side].1 {
            Sense::Aligned => kept.map(|&k| f64::from(k) / steps).collect(),
            Sense::Opposed => kept.rev().map(|&k| f64::from(line.finest_steps - k) / steps).collect(),
        }
    }
}

impl Line {
    fn new(sides: Vec<(SegmentId, Sense)>, length: f64, resolutions: &[f64]) -> Self {
        let steps = |resolution: f64| (length / resolution - 1e-9).ceil().max(1.0) as u32;
        let finest_steps = steps(resolutions[resolutions.len() - 1]);
        let mut kept = vec![(0..=finest_steps).collect::<Vec<u32>>()];
        for &resolution in resolutions.iter().rev().skip(1) {
            let finer = &kept[0];
            kept.insert(0, thinned(finer, steps(resolution)));
        }
        Self { sides, finest_steps, kept }
    }

    /// More samples on a level: those of the next finer one, on the finest twice as many.
    fn refine(&mut self, level: usize) {
        if level + 1 < self.kept.len() {
            self.kept[level] = self.kept[level + 1].clone();
        } else {
            self.finest_steps *= 2;
            for kept in &mut self.kept {
                kept.iter_mut().for_each(|k| *k *= 2);
            }
            self.kept[level] = (0..=self.finest_steps).collect();
        }
    }
}

/// About evenly spaced `steps` of the given samples, with both ends.
fn thinned(samples: &[u32], steps: u32) -> Vec<u32> {
    let last = samples.len() - 1;
    let steps = (steps as usize).min(last);
    (0..=steps).map(|i| samples[(2 * i * last + steps) / (2 * steps)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn thinning_keeps_the_ends_and_repeats_nothing(count in 1u32..200, steps in 1u32..250) {
            let samples: Vec<u32> = (0..=count).map(|k| 3 * k).collect();
            let kept = thinned(&samples, steps);
            prop_assert_eq!((kept[0], kept[kept.len() - 1]), (0, 3 * count));
            prop_assert!(kept.windows(2).all(|w| w[0] < w[1]));
            prop_assert_eq!(kept.len() as u32, steps.min(count) + 1);
        }
    }

    #[test]
    fn every_coarse_sample_is_a_fine_one() {
        let line = Line::new(vec![], 0.731, &[0.05, 0.0232, 0.0108, 0.005]);
        for levels in line.kept.windows(2) {
            assert!(levels[0].iter().all(|k| levels[1].contains(k)));
        }
        assert_eq!(line.finest_steps, 147);
    }
}
