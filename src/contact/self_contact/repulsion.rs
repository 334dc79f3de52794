//! What a pair costs at a distance below its clearance.

/// Energy of a pair, J, its slope, N, and its curvature, N/m, at a distance below its clearance, m:
/// quadratic down to half the clearance, logarithmic below, with continuous slope (Chen et al. 2025,
/// equation 18; theory, equation 11).
#[inline]
pub fn repulsion(distance: f64, clearance: f64, stiffness: f64) -> (f64, f64, f64) {
    let depth = clearance - distance;
    let half = 0.5 * clearance;
    if distance >= half {
        return (0.5 * stiffness * depth * depth, -stiffness * depth, stiffness);
    }
    let barrier = stiffness * half * half;
    let energy = 0.5 * stiffness * half * half - barrier * (distance / half).ln();
    (energy, -barrier / distance, (barrier / (distance * distance)).min(STIFFEST * stiffness))
}

/// The barrier's curvature is not taken for more than this many times the pair's stiffness: one
/// nearly closed pair must not hold up the step of the whole garment.
const STIFFEST: f64 = 20.0;
