//! A first map of the sewn garment into space: as smooth as it can be with its openings where the body comes out.

use super::surface::Surface;
use crate::geometry::Vector3;

/// Some particles whose mean belongs somewhere, in the axes that are asked for.
pub struct Pin {
    pub particles: Vec<u32>,
    pub place: Vector3,
    /// 1 where the axis counts, else 0.
    pub axes: Vector3,
}

/// How strongly a pin holds, as multiples of what an edge pulls with.
const HOLD: f64 = 100.0;
/// What keeps pieces that nothing pins in the middle.
const REST: f64 = 1e-9;
/// The map is good when its residual has fallen to this share.
const TOLERANCE: f64 = 1e-11;
const MOST_ITERATIONS: usize = 4000;

/// The places of all particles, m, that minimize `Σ edges |xᵢ − xⱼ|² + Σ pins HOLD n |mean − place|²` (theory, equation 22).
pub fn harmonic(surface: &Surface, pins: &[Pin]) -> Vec<Vector3> {
    let count = surface.neighbors.len();
    let of_axis = |axis: usize| {
        let pins: Vec<&Pin> = pins.iter().filter(|pin| pin.axes[axis] > 0.0 && !pin.particles.is_empty()).collect();
        let mean = |x: &[f64], pin: &Pin| {
            pin.particles.iter().map(|&p| x[p as usize]).sum::<f64>() / pin.particles.len() as f64
        };
        let apply = |x: &[f64]| {
            let row = |(at, neighbors): (&f64, &Vec<(u32, f64)>)| {
                REST * at + neighbors.iter().map(|&(q, _)| at - x[q as usize]).sum::<f64>()
            };
            let mut y: Vec<f64> = x.iter().zip(&surface.neighbors).map(row).collect();
            for pin in &pins {
                let pull = HOLD * mean(x, pin);
                pin.particles.iter().for_each(|&p| y[p as usize] += pull);
            }
            y
        };
        let mut right = vec![0.0; count];
        for pin in &pins {
            pin.particles.iter().for_each(|&p| right[p as usize] += HOLD * pin.place[axis]);
        }
        solve(apply, &right, TOLERANCE, MOST_ITERATIONS)
    };
    let [x, y, z] = [0, 1, 2].map(of_axis);
    (0..count).map(|p| Vector3::new(x[p], y[p], z[p])).collect()
}

/// Conjugate gradients for a symmetric positive definite matrix (Hestenes and Stiefel 1952).
pub fn solve(apply: impl Fn(&[f64]) -> Vec<f64>, right: &[f64], tolerance: f64, most: usize) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut x = vec![0.0; right.len()];
    let mut residual = right.to_vec();
    let mut direction = residual.clone();
    let mut squared = dot(&residual, &residual);
    let enough = squared * tolerance * tolerance;
    for _ in 0..most {
        if squared <= enough {
            break;
        }
        let image = apply(&direction);
        let curvature = dot(&direction, &image);
        if curvature <= 0.0 {
            break;
        }
        let step = squared / curvature;
        for k in 0..x.len() {
            x[k] += step * direction[k];
            residual[k] -= step * image[k];
        }
        let before = std::mem::replace(&mut squared, dot(&residual, &residual));
        let keep = squared / before;
        direction.iter_mut().zip(&residual).for_each(|(d, r)| *d = r + keep * *d);
    }
    x
}
