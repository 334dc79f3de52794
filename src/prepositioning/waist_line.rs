//! The waist line that a skirt or trousers hang from: held while they are fitted, and told to whoever goes on with them.

use super::Scene;
use super::sewing::hold;
use crate::arrangement::Arrangement;
use crate::energy::Hold;
use crate::garment::{Garment, Level};
use crate::geometry::Vector3;
use crate::pattern::{Pattern, SegmentLabel};
use std::ops::Range;

/// A garment whose top is at most this far above its waist line hangs from the waist, m: a waistband.
const HANGS_FROM_WAIST: f64 = 0.2;
/// How far below its place in the pattern a waist line may sink while a garment settles, m.
const WAIST_SLACK: f64 = 0.01;

/// The waist line of a garment that hangs from it. What reaches higher hangs from the shoulders.
pub struct Waist {
    /// Of the garment.
    panels: Range<usize>,
    /// Where it is worn, m: where the pattern places it, less what it was raised by.
    height: f64,
}

impl Waist {
    /// Of a garment that hangs from its waist line.
    pub fn of(pattern: &Pattern, garment: &Garment, arrangement: &Arrangement) -> Option<Self> {
        let line = hanging(pattern, &garment.open, &arrangement.positions)?;
        Some(Self { panels: 0..pattern.panels.len(), height: line.height - arrangement.raised })
    }

    /// Keeps it from sinking below where the pattern places it, as buttons would.
    pub fn hold(&self, scene: &Scene, level: usize, positions: &[Vector3]) -> Option<Hold> {
        let (cloth, line) = (&scene.garment.levels[level], SegmentLabel::LowerInterface);
        let hold = hold(scene.pattern, cloth, self.panels.clone(), line, positions)?;
        Some(Hold { height: self.height - WAIST_SLACK, ..hold })
    }

    /// The same waist where the panels of the garment begin at `first`.
    pub fn among(&self, first: usize) -> Self {
        Self { panels: self.panels.start + first..self.panels.end + first, height: self.height }
    }
}

/// Particles of the waist line of a garment that hangs from it, as skirts and trousers do; none if there is no such line or
/// the garment reaches higher. Of a level of the sewn garment at `positions`, m, world.
pub fn waist_line(pattern: &Pattern, level: &Level, positions: &[Vector3]) -> Vec<u32> {
    hanging(pattern, level, positions).map(|line| line.particles).unwrap_or_default()
}

/// The waist line, if the garment hangs from it.
fn hanging(pattern: &Pattern, level: &Level, positions: &[Vector3]) -> Option<Hold> {
    let line = hold(pattern, level, 0..pattern.panels.len(), SegmentLabel::LowerInterface, positions)?;
    let top = positions.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    (top <= line.height + HANGS_FROM_WAIST).then_some(line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::shapes;

    #[test]
    fn a_skirt_hangs_from_its_waist_and_a_dress_does_not() {
        let mut pattern = shapes::tube(0.6, 0.5);
        let garment = Garment::build(&pattern, &[0.05]).unwrap();
        let level = &garment.levels[0];
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        for (rest, &p) in level.rest.iter().zip(&level.particle_of) {
            positions[p as usize] = Vector3::new(rest.x, rest.y, 0.0);
        }
        assert!(waist_line(&pattern, level, &positions).is_empty());
        let label = |pattern: &mut Pattern, height: f64| {
            let panel = &mut pattern.panels[0];
            for k in 0..panel.segments.len() {
                let corners = level.segments[0][k].iter();
                let at = |p: &u32| (level.rest[*p as usize].y - height).abs() < 1e-6;
                panel.segments[k].label = corners.clone().all(at).then_some(SegmentLabel::LowerInterface);
            }
        };
        label(&mut pattern, 0.5);
        let waist = waist_line(&pattern, level, &positions);
        assert!(waist.len() > 5 && waist.iter().all(|&p| positions[p as usize].y > 0.49), "{waist:?}");
        label(&mut pattern, 0.0);
        assert!(waist_line(&pattern, level, &positions).is_empty());
    }
}
