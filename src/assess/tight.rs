//! Where a garment is too tight: stretched by more than its fabric bears.

use super::principal_stretches;
use crate::garment::Level;
use crate::geometry::Vector3;

/// A panel that is stretched beyond the limit of its fabric.
#[derive(Clone, Debug, PartialEq)]
pub struct Tight {
    pub panel: usize,
    /// Part of the panel's area that is.
    pub share: f64,
    /// The largest stretch, as a share of one.
    pub largest: f64,
    /// The middle of what is, m, world.
    pub place: Vector3,
}

/// Less than this of a panel is the work of single triangles, not of a body that is too large.
const LEAST_SHARE: f64 = 0.005;

/// The panels of which some part is stretched beyond `limit`, as a share of one; less what gathers impose on each triangle.
pub fn tight_places(level: &Level, positions: &[Vector3], allowance: &[f64], limit: f64) -> Vec<Tight> {
    let areas = level.rest_areas();
    let of_panel = |(panel, range): (usize, &crate::garment::PanelRange)| {
        let (mut whole, mut area, mut moment, mut largest) = (0.0, 0.0, Vector3::zeros(), 0.0f64);
        for t in range.triangles.clone() {
            let corners = level.particles(t).map(|p| positions[p as usize]);
            let stretch = principal_stretches(level.rest_corners(t), corners).map_or(0.0, |[most, _]| most - 1.0);
            whole += areas[t];
            if stretch - allowance[t] > limit {
                area += areas[t];
                moment += corners.iter().sum::<Vector3>() * (areas[t] / 3.0);
                largest = largest.max(stretch - allowance[t]);
            }
        }
        (area > LEAST_SHARE * whole).then(|| Tight { panel, share: area / whole, largest, place: moment / area })
    };
    level.panels.iter().enumerate().filter_map(of_panel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::shapes;

    #[test]
    fn the_panel_that_is_stretched_is_named_with_its_place() {
        let level = Garment::build(&shapes::two_rectangles(0.2, 0.3), &[0.03]).unwrap().levels.remove(0);
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        for (k, &p) in level.particle_of.iter().enumerate() {
            let right = level.panels[1].points.contains(&k);
            // The right panel is a tenth wider than it was cut.
            let x = if right { 0.2 + 1.1 * level.rest[k].x } else { level.rest[k].x };
            positions[p as usize] = Vector3::new(x, level.rest[k].y, 0.0);
        }
        let none = vec![0.0; level.triangles.len()];
        let found = tight_places(&level, &positions, &none, 0.05);
        assert_eq!(found.len(), 1);
        assert!(found[0].panel == 1 && (found[0].largest - 0.1).abs() < 1e-9 && (found[0].share - 1.0).abs() < 1e-9);
        assert!((found[0].place - Vector3::new(0.31, 0.15, 0.0)).norm() < 1e-9, "{}", found[0].place);
        assert!(tight_places(&level, &positions, &none, 0.11).is_empty());
        assert!(tight_places(&level, &positions, &vec![0.06; none.len()], 0.05).is_empty());
    }
}
