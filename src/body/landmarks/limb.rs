//! Limbs as centerlines with sections: what a sleeve or a trouser leg is wrapped around.

use crate::body::section::{Loop, hull, loops, tape};
use crate::geometry::Vector3;
use std::f64::consts::TAU;

/// A limb, the neck or the torso, as sections square to its centerline (level ones of the torso and the neck).
#[derive(Clone, Debug, Default)]
pub struct Limb {
    /// Middles of the sections, m, world, from the root to the end: from the shoulder joint to the wrist, from the hip joint to
    /// the ankle, from the crotch to the base of the neck, from the base of the neck to its top.
    pub axis: Vec<Vector3>,
    /// For each section the radius of a circle of the same girth, m.
    pub radii: Vec<f64>,
    /// For each section its convex hull, in order around it, m, world.
    pub outlines: Vec<Vec<Vector3>>,
}

impl Limb {
    pub(super) fn push(&mut self, center: Vector3, outline: Vec<Vector3>) {
        let girth: f64 = outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| (b - a).norm()).sum();
        self.axis.push(center);
        self.radii.push(girth / TAU);
        self.outlines.push(outline);
    }

    /// Lengths along the axis from its root, m; one per section.
    pub fn lengths(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let steps = self.axis.windows(2).map(|w| (w[1] - w[0]).norm());
        let later = steps.map(|step| {
            sum += step;
            sum
        });
        [0.0].into_iter().take(self.axis.len()).chain(later).collect()
    }

    /// The length of the axis, m.
    pub fn length(&self) -> f64 {
        self.lengths().last().copied().unwrap_or(0.0)
    }

    /// Point, unit direction towards the end, and radius at a length from the root, m; beyond the ends, those of the ends.
    pub fn at(&self, length: f64) -> (Vector3, Vector3, f64) {
        let lengths = self.lengths();
        let last = self.axis.len().saturating_sub(2);
        let k = lengths.partition_point(|&l| l <= length).saturating_sub(1).min(last);
        let next = (k + 1).min(self.axis.len() - 1);
        let step = lengths[next] - lengths[k];
        let t = if step > 0.0 { ((length - lengths[k]) / step).clamp(0.0, 1.0) } else { 0.0 };
        let direction = (self.axis[next] - self.axis[k]).try_normalize(0.0).unwrap_or(-Vector3::y());
        let point = self.axis[k].lerp(&self.axis[next], t);
        (point, direction, self.radii[k] + (self.radii[next] - self.radii[k]) * t)
    }

    /// The length from the root, m, at which the axis passes a point.
    pub fn length_of(&self, point: Vector3) -> f64 {
        let (mut best, mut at, mut before) = (f64::INFINITY, 0.0, 0.0);
        for w in self.axis.windows(2) {
            let along = w[1] - w[0];
            let t = ((point - w[0]).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let distance = (w[0] + along * t - point).norm_squared();
            if distance < best {
                (best, at) = (distance, before + t * along.norm());
            }
            before += along.norm();
        }
        at
    }
}

/// A section of a limb.
pub struct Station {
    pub center: Vector3,
    /// Towards the end, unit length.
    pub direction: Vector3,
    pub outline: Vec<Vector3>,
    /// m.
    pub tape: f64,
}

/// How often a centerline is brought into the middle of its sections.
const CENTERINGS: usize = 4;
/// Over how many stations to each side the direction of a centerline is taken.
const SMOOTHING: usize = 3;
/// A section that is so many times as long as the next one farther out is no longer one of the limb alone.
const MERGED: f64 = 1.45;

/// Sections square to the centerline of a limb, from the root to the end, near a first guess of it: a path of some
/// points, before which the root lies if it is known. `among` are the triangles that may be cut. Sections that are not of the
/// limb alone, at its root, are left out.
pub fn stations(
    positions: &[Vector3],
    triangles: &[[u32; 3]],
    among: &[u32],
    root: Option<Vector3>,
    guess: &[Vector3],
    spacing: f64,
) -> Vec<Station> {
    let start: Vec<Vector3> = root.into_iter().chain(guess.iter().copied()).collect();
    let mut path = resampled(&start, spacing);
    let mut stations = Vec::new();
    for _ in 0..CENTERINGS {
        stations = Vec::with_capacity(path.len());
        // From the end, where there is nothing but the limb, towards the root.
        for k in (0..path.len()).rev() {
            let (before, after) = (k.saturating_sub(SMOOTHING), (k + SMOOTHING).min(path.len() - 1));
            let Some(direction) = (path[after] - path[before]).try_normalize(0.0) else { continue };
            let found = loops(positions, triangles, among.iter().copied(), path[k], direction);
            let nearest = found
                .into_iter()
                .map(|l| (l.center(), l))
                .min_by(|(a, _), (b, _)| (a - path[k]).norm_squared().total_cmp(&(b - path[k]).norm_squared()));
            let Some((center, curve)) = nearest else { continue };
            let station = station(center, direction, &curve);
            let reach = station.tape / TAU * 2.0;
            let merged = stations.last().is_some_and(|last: &Station| station.tape > MERGED * last.tape);
            if merged && stations.len() > path.len() / 2 {
                break;
            }
            if (center - path[k]).norm() < reach.max(2.0 * spacing) {
                stations.push(station);
            }
        }
        stations.reverse();
        if stations.len() < 2 {
            break;
        }
        let middles: Vec<Vector3> = root.into_iter().chain(stations.iter().map(|s| s.center)).collect();
        path = resampled(&middles, spacing);
    }
    stations
}

fn station(center: Vector3, direction: Vector3, curve: &Loop) -> Station {
    let outline = hull(&curve.points, direction);
    Station { center, direction, tape: tape(&outline, direction), outline }
}

/// Points on a path at even distances of about `spacing`, its ends among them.
pub fn resampled(path: &[Vector3], spacing: f64) -> Vec<Vector3> {
    let length: f64 = path.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let count = ((length / spacing).round() as usize).clamp(1, 1000);
    let mut points = Vec::with_capacity(count + 1);
    let (mut segment, mut before) = (0, 0.0);
    for k in 0..=count {
        let wanted = length * k as f64 / count as f64;
        while segment + 2 < path.len() && before + (path[segment + 1] - path[segment]).norm() < wanted {
            before += (path[segment + 1] - path[segment]).norm();
            segment += 1;
        }
        let along = path[segment + 1] - path[segment];
        let t = ((wanted - before) / along.norm().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        points.push(path[segment] + along * t);
    }
    points
}
