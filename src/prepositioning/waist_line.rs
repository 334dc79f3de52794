//! The waist line that a fitted garment hangs from, for whoever goes on with it.

use super::relaxing::HANGS_FROM_WAIST;
use super::sewing::hold;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::pattern::{Pattern, SegmentLabel};

/// Particles of the waist line of a garment that hangs from it, as skirts and trousers do; none if there is no such line or
/// the garment reaches higher, and hangs from the shoulders. By the rule of the fit, asked of a level of the sewn
/// garment at `positions`, m, world.
pub fn waist_line(pattern: &Pattern, level: &Level, positions: &[Vector3]) -> Vec<u32> {
    let line = hold(pattern, level, 0..pattern.panels.len(), SegmentLabel::LowerInterface, positions);
    let top = positions.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    line.filter(|line| top <= line.height + HANGS_FROM_WAIST).map(|line| line.particles).unwrap_or_default()
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
