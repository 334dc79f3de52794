//! Bending, in two forms.
//!
//! *Quadratic* (Bergou, Wardetzky, Harmon, Zorin and Grinspun, *A quadratic bending model for
//! inextensible surfaces*, 2006): the energy of cloth that hardly stretches is quadratic in the
//! positions, so its Hessian `Q` is constant and is assembled once.
//!
//! *Springs* across each edge, between the tips of its two triangles (Le Thanh and Gagalowicz 2007,
//! equation 5): no quadratic stiffness about the flat state. Kept for comparison.

use crate::garment::{Hinge, Level};
use crate::geometry::{Vector2, Vector3};
use crate::pattern::Fabric;

/// Which bending energy is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Bending {
    /// The quadratic isometric energy.
    #[default]
    Quadratic,
    /// The paper's springs across edges.
    Springs,
}

/// Radius of curvature at which the springs across edges cost what the quadratic energy costs, m:
/// a fold of everyday size. No constant matches both everywhere, one being of fourth order.
const MATCHING_RADIUS: f64 = 0.02;

/// Mean of cos⁸ over all angles: a spring at an angle to the curvature shortens by the fourth power of
/// the cosine only, and its energy is the square of that.
const TURNED_SHARE: f64 = 35.0 / 128.0;

/// The quadratic form of one hinge, `½ |Σ cᵢ xᵢ|²` over ends and tips.
pub struct HingeForm {
    /// End, end, tip, tip.
    pub particles: [u32; 4],
    /// Square roots of N/m.
    pub coefficients: [f64; 4],
}

/// The four particles and rest geometry of a hinge.
struct Rest {
    particles: [u32; 4],
    /// Per triangle: cotangents at the two ends and the triangle's area, m².
    sides: [([f64; 2], f64); 2],
    /// m, the mean of both sides.
    edge_length: f64,
    /// Cosine between warp and the direction across the edge; curvature runs that way.
    cos_to_warp: f64,
}

fn cotangent(at: Vector2, p: Vector2, q: Vector2) -> f64 {
    let (u, v) = (p - at, q - at);
    u.dot(&v) / crate::geometry::cross(u, v).abs()
}

impl Rest {
    fn of(level: &Level, hinge: &Hinge) -> Self {
        let first = level.particles(hinge.triangles[0] as usize);
        let tip = hinge.tips[0] as usize;
        let ends = [first[(tip + 1) % 3], first[(tip + 2) % 3]];
        let mut tips = [0; 2];
        let mut lengths = [0.0; 2];
        let mut cosines = [0.0; 2];
        let sides = std::array::from_fn(|k| {
            let triangle = hinge.triangles[k] as usize;
            let (particles, rest) = (level.particles(triangle), level.rest_corners(triangle));
            let tip = hinge.tips[k] as usize;
            let at = |end: u32| particles.iter().position(|&p| p == end).expect("both triangles have both ends");
            let (a, b, t) = (rest[at(ends[0])], rest[at(ends[1])], rest[tip]);
            tips[k] = particles[tip];
            lengths[k] = (b - a).norm();
            // The edge's own x is what lies across it, measured against the warp along y.
            cosines[k] = ((b - a).x / lengths[k]).abs();
            ([cotangent(a, b, t), cotangent(b, a, t)], 0.5 * crate::geometry::cross(b - a, t - a).abs())
        });
        Self {
            particles: [ends[0], ends[1], tips[0], tips[1]],
            sides,
            edge_length: 0.5 * (lengths[0] + lengths[1]),
            cos_to_warp: 0.5 * (cosines[0] + cosines[1]),
        }
    }
}

/// The quadratic form of a hinge: `E = ½ · B / (A₀ + A₁) · |Σ kᵢ xᵢ|²`, with the cotangents that
/// Bergou et al. give in equation 4. Each side takes its cotangents from its own panel, which is
/// what makes seams bend like cloth.
///
/// Bergou et al. have `3B`, which makes the mean of the curvatures at the edges right but counts the
/// scatter of those at differently turned edges as bending: a cylinder of equilateral triangles
/// then costs three times the `½ B A / R²` of a plate.
pub fn hinge_form(level: &Level, hinge: &Hinge, fabric: &Fabric) -> HingeForm {
    let rest = Rest::of(level, hinge);
    let [([a0, b0], area0), ([a1, b1], area1)] = rest.sides;
    let weight = (fabric.bending_along(rest.cos_to_warp) / (area0 + area1)).sqrt();
    let k = [b0 + b1, a0 + a1, -(a0 + b0), -(a1 + b1)];
    HingeForm { particles: rest.particles, coefficients: k.map(|k| k * weight) }
}

/// A spring between the tips of a hinge.
#[derive(Clone, Copy, Debug)]
pub struct CrossSpring {
    pub particles: [u32; 2],
    /// 1/m.
    pub(super) inverse_rest: f64,
    /// J.
    pub(super) stiffness: f64,
}

impl CrossSpring {
    pub fn of(level: &Level, hinge: &Hinge, fabric: &Fabric) -> Self {
        let rest = Rest::of(level, hinge);
        let [(_, area0), (_, area1)] = rest.sides;
        let height = 2.0 * (area0 + area1) / rest.edge_length;
        // Distance between the tips of the flat hinge: two heights and the shift along the edge.
        let along =
            |([a, b], area): ([f64; 2], f64)| 0.5 * (a - b) / (a + b) * rest.edge_length * f64::from(area > 0.0);
        let rest_length = height.hypot(along(rest.sides[0]) - along(rest.sides[1])).max(0.5 * height);
        // On a cylinder of radius R the flat length s becomes the chord: e ≈ -(s/R)²/24.
        let rigidity = fabric.bending_along(rest.cos_to_warp) / TURNED_SHARE;
        let energy = 0.5 * rigidity / MATCHING_RADIUS.powi(2) * (area0 + area1) / 3.0;
        let strain = (rest_length / MATCHING_RADIUS).powi(2) / 24.0;
        Self {
            particles: [rest.particles[2], rest.particles[3]],
            inverse_rest: 1.0 / rest_length,
            stiffness: 2.0 * energy / (strain * strain),
        }
    }

    /// Energy, J, and its gradient at the second particle, N; the first feels the opposite.
    #[inline]
    pub fn evaluate(&self, [a, b]: [Vector3; 2]) -> (f64, Vector3) {
        let span = b - a;
        let length = span.norm();
        let strain = length * self.inverse_rest - 1.0;
        let unit = span / length.max(1e-3 / self.inverse_rest);
        (0.5 * self.stiffness * strain * strain, unit * (self.stiffness * strain * self.inverse_rest))
    }

    /// `dᵀ H d` without what compression makes negative.
    #[inline]
    pub fn curvature(&self, [a, b]: [Vector3; 2], [da, db]: [Vector3; 2]) -> f64 {
        let span = b - a;
        let length = span.norm().max(1e-3 / self.inverse_rest);
        let tension = self.stiffness * (length * self.inverse_rest - 1.0) * self.inverse_rest;
        let along = (db - da).dot(&span) / length;
        let across = ((db - da).norm_squared() - along * along).max(0.0);
        self.stiffness * self.inverse_rest.powi(2) * along * along + tension.max(0.0) / length * across
    }

    /// N/m.
    pub fn diagonal(&self) -> f64 {
        self.stiffness * self.inverse_rest.powi(2)
    }
}
