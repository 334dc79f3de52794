//! Stretch and compression of the cloth.

use crate::garment::Level;
use crate::geometry::{Vector2, Vector3};
use crate::pattern::Pattern;
use rayon::prelude::*;

/// Strains as shares of one, weighted by rest area. A triangle has two principal stretches σ; its
/// strain is the larger `|σ - 1|`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strain {
    /// Of both principal stretches' `|σ - 1|`.
    pub mean: f64,
    pub p99: f64,
    pub max: f64,
    /// Of the larger stretch alone, `σ - 1`, where it is positive.
    pub stretch_p99: f64,
    pub stretch_max: f64,
    /// Of the smaller stretch alone, `1 - σ`, where it is positive.
    pub compression_p99: f64,
    pub compression_max: f64,
}

/// The principal stretches of a triangle, the larger first: the singular values of the map from its
/// rest corners, m, to its corners, m. `None` for a triangle without rest area.
pub fn principal_stretches(rest: [Vector2; 3], corners: [Vector3; 3]) -> Option<[f64; 2]> {
    let inverse = nalgebra::Matrix2::from_columns(&[rest[1] - rest[0], rest[2] - rest[0]]).try_inverse()?;
    let map = nalgebra::Matrix3x2::from_columns(&[corners[1] - corners[0], corners[2] - corners[0]]) * inverse;
    // Eigenvalues of the 2 × 2 metric in closed form.
    let metric = map.transpose() * map;
    let (mean, half) = (0.5 * metric.trace(), 0.5 * (metric[(0, 0)] - metric[(1, 1)]));
    let spread = half.hypot(metric[(0, 1)]);
    Some([(mean + spread).sqrt(), (mean - spread).max(0.0).sqrt()])
}

/// What unequal seams impose on the triangles that touch them: longer side over shorter, less one.
pub fn gather_allowance(pattern: &Pattern, level: &Level) -> Vec<f64> {
    // Differences of a hundredth are eased in without gathers.
    const EASED: f64 = 0.01;
    let mut of_particle = vec![0.0f64; level.particle_count];
    for (seam, sides) in pattern.seams.iter().zip(&level.seams) {
        let [a, b] = pattern.seam_lengths(seam);
        let excess = a.max(b) / a.min(b) - 1.0;
        if excess > EASED {
            for &point in sides.iter().flatten() {
                let allowed = &mut of_particle[level.particle_of[point as usize] as usize];
                *allowed = allowed.max(excess);
            }
        }
    }
    let most = |t| level.particles(t).iter().map(|&p| of_particle[p as usize]).fold(0.0, f64::max);
    (0..level.triangles.len()).map(most).collect()
}

impl Strain {
    /// Strain of all triangles, each less its `allowance`.
    pub fn of(level: &Level, positions: &[Vector3], allowance: &[f64]) -> Self {
        let areas = level.rest_areas();
        let stretches: Vec<Option<[f64; 2]>> = (0..areas.len())
            .into_par_iter()
            .with_min_len(FEWEST_TRIANGLES)
            .map(|t| principal_stretches(level.rest_corners(t), level.particles(t).map(|p| positions[p as usize])))
            .collect();
        // Not `max`, which would make zero of what is not a number.
        let less = |strain: f64, t: usize| if strain < allowance[t] { 0.0 } else { strain - allowance[t] };
        // `measure` of both stretches of all triangles, with their areas.
        let measured = |measure: fn(f64, f64) -> f64| -> Vec<(f64, f64)> {
            let each = stretches.iter().enumerate();
            each.filter_map(|(t, of)| of.map(|[larger, smaller]| (less(measure(larger, smaller), t), areas[t])))
                .collect()
        };
        let top = |mut values: Vec<(f64, f64)>| {
            let max = values.iter().map(|v| v.0).fold(0.0, f64::max);
            (percentile_99(&mut values), max)
        };
        let both = measured(|larger, smaller| 0.5 * ((larger - 1.0).abs() + (smaller - 1.0).abs()));
        let total: f64 = both.iter().map(|v| v.1).sum();
        let mean = both.iter().map(|(strain, area)| strain * area).sum::<f64>();
        drop(both);
        let (p99, max) = top(measured(|larger, smaller| (larger - 1.0).abs().max((smaller - 1.0).abs())));
        let (stretch_p99, stretch_max) = top(measured(|larger, _| (larger - 1.0).max(0.0)));
        let (compression_p99, compression_max) = top(measured(|_, smaller| (1.0 - smaller).max(0.0)));
        Self {
            mean: if total > 0.0 { mean / total } else { 0.0 },
            p99,
            max,
            stretch_p99,
            stretch_max,
            compression_p99,
            compression_max,
        }
    }
}

/// Triangles that one thread measures at least.
const FEWEST_TRIANGLES: usize = 2048;

/// The least value that 99 % of the weight do not exceed, of `(value, weight)`, which are put in another order; zero
/// of none.
fn percentile_99(values: &mut [(f64, f64)]) -> f64 {
    let weight = |values: &[(f64, f64)]| values.iter().map(|v| v.1).sum::<f64>();
    let target = 0.99 * weight(values);
    // Halved around the value that is sought.
    let (mut values, mut below) = (values, 0.0);
    while values.len() > 1 {
        let middle = values.len() / 2;
        values.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0));
        let (smaller, larger) = values.split_at_mut(middle);
        let of_smaller = weight(smaller);
        values = if below + of_smaller >= target {
            smaller
        } else {
            below += of_smaller;
            larger
        };
    }
    values.first().map_or(0.0, |v| v.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::PanelRange;

    #[test]
    fn stretches_of_a_known_map() {
        let rest = [[0.0, 0.0], [1.0, 0.2], [0.3, 1.0]].map(Vector2::from);
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.0, 2.0);
        let corners = rest.map(|p| turn * Vector3::new(1.2 * p.x, 0.9 * p.y, 0.0) + Vector3::new(5.0, 0.0, 1.0));
        let [larger, smaller] = principal_stretches(rest, corners).unwrap();
        assert!((larger - 1.2).abs() < 1e-12 && (smaller - 0.9).abs() < 1e-12);
    }

    #[test]
    fn positions_that_are_not_numbers_have_no_strain_to_be_proud_of() {
        let level = Level {
            resolution: 1.0,
            particle_count: 3,
            panels: vec![PanelRange { points: 0..3, triangles: 0..1 }],
            rest: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector2::from).to_vec(),
            particle_of: vec![0, 1, 2],
            triangles: vec![[0, 1, 2]],
            stitches: vec![],
            hinges: vec![],
            seams: vec![],
            segments: vec![],
            eased: vec![],
        };
        let positions = [Vector3::repeat(f64::NAN), Vector3::x(), Vector3::y()];
        assert!(Strain::of(&level, &positions, &[0.0]).mean.is_nan());
    }

    #[test]
    fn the_percentile_counts_area_not_triangles() {
        let mut values = vec![(0.01, 1.0); 100];
        values.push((0.5, 0.5));
        assert_eq!(percentile_99(&mut values.clone()), 0.01);
        values.push((0.5, 1.0));
        assert_eq!(percentile_99(&mut values), 0.5);
    }
}
