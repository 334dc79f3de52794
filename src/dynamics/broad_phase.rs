//! Volumes around the parts of a body: axis-aligned boxes, oriented boxes, spheres.
//!
//! A part is a patch of skin of some two hundred triangles that lie together. A point's distance from a part's volume
//! is a lower bound of its distance from the part; parts are searched in the order of that bound until the next bound
//! is farther than what was found (Kaynar Kabul 2004 compares such volumes for limbs).

use super::settings::BroadPhase;
use crate::geometry::Vector3;
use nalgebra::Matrix3;

/// Triangles to a part.
const PART: usize = 200;

/// The lowest and highest coordinates of some points.
pub fn enclosing(points: impl Iterator<Item = Vector3>) -> (Vector3, Vector3) {
    let nothing = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    points.fold(nothing, |(low, high), p| (low.inf(&p), high.sup(&p)))
}

/// One volume.
#[derive(Clone, Copy, Debug)]
enum Volume {
    Sphere {
        center: Vector3,
        radius: f64,
    },
    /// A box whose axes are the rows of `axes`.
    Box {
        axes: Matrix3<f64>,
        low: Vector3,
        high: Vector3,
    },
}

impl Volume {
    fn around(kind: BroadPhase, points: &[Vector3]) -> Self {
        let (low, high) = enclosing(points.iter().copied());
        let middle = (low + high) * 0.5;
        match kind {
            BroadPhase::Spheres => {
                let squared = points.iter().map(|p| (p - middle).norm_squared()).fold(0.0, f64::max);
                Volume::Sphere { center: middle, radius: squared.sqrt() }
            }
            BroadPhase::OrientedBoxes => {
                // Along the principal axes of the points.
                let mean = points.iter().sum::<Vector3>() / points.len() as f64;
                let spread: Matrix3<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
                let axes = nalgebra::SymmetricEigen::new(spread).eigenvectors.transpose();
                let (low, high) = enclosing(points.iter().map(|p| axes * p));
                Volume::Box { axes, low, high }
            }
            BroadPhase::AlignedBoxes | BroadPhase::Tree | BroadPhase::Maps => {
                Volume::Box { axes: Matrix3::identity(), low, high }
            }
        }
    }

    /// Square of a bound that a point is at least from what the volume encloses, m².
    fn squared_bound(&self, point: Vector3) -> f64 {
        match self {
            Volume::Sphere { center, radius } => ((point - center).norm() - radius).max(0.0).powi(2),
            Volume::Box { axes, low, high } => {
                let p = axes * point;
                (low - p).sup(&(p - high)).sup(&Vector3::zeros()).norm_squared()
            }
        }
    }
}

/// The parts of a body with their volumes.
pub struct Volumes {
    parts: Vec<(Volume, Vec<u32>)>,
}

impl Volumes {
    /// Around the paths of triangles whose vertices move from `start` to `end`.
    pub fn new(kind: BroadPhase, triangles: &[[u32; 3]], start: &[Vector3], end: &[Vector3]) -> Self {
        let mut all: Vec<u32> = (0..triangles.len() as u32).collect();
        let middle = |t: u32| triangles[t as usize].iter().map(|&v| start[v as usize]).sum::<Vector3>() / 3.0;
        let mut parts = Vec::new();
        let mut left = Vec::from_iter(std::iter::once(0..all.len()));
        while let Some(range) = left.pop() {
            let some = &mut all[range.clone()];
            if some.len() <= PART {
                let vertices = some.iter().flat_map(|&t| triangles[t as usize]).map(|v| v as usize);
                let points: Vec<Vector3> = vertices.flat_map(|v| [start[v], end[v]]).collect();
                if !points.is_empty() {
                    parts.push((Volume::around(kind, &points), some.to_vec()));
                }
                continue;
            }
            // Halved across the longest extent.
            let (low, high) = enclosing(some.iter().map(|&t| middle(t)));
            let axis = (high - low).imax();
            some.sort_by(|&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b)));
            let half = range.start + range.len() / 2;
            left.extend([half..range.end, range.start..half]);
        }
        Self { parts }
    }

    /// The triangle within `reach` of `point`, m, that is nearest, as `squared_distance` tells.
    pub fn nearest(&self, point: Vector3, reach: f64, squared_distance: impl Fn(u32) -> f64) -> Option<(u32, f64)> {
        let mut bounds: Vec<(f64, usize)> =
            self.parts.iter().enumerate().map(|(k, (volume, _))| (volume.squared_bound(point), k)).collect();
        bounds.retain(|(bound, _)| *bound < reach * reach);
        bounds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best = (reach * reach, None);
        for (bound, part) in bounds {
            if bound >= best.0 {
                break;
            }
            for &t in &self.parts[part].1 {
                let squared = squared_distance(t);
                if squared < best.0 {
                    best = (squared, Some(t));
                }
            }
        }
        best.1.map(|t| (t, best.0))
    }
}
