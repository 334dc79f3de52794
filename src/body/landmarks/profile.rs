//! Level sections of torso, neck and head: silhouettes and girths by height.

use crate::body::section::{hull, loops, tape};
use crate::geometry::Vector3;

/// What a level plane cuts of torso, neck and head.
#[derive(Clone, Debug)]
pub struct Level {
    /// Height, m.
    pub y: f64,
    /// The convex hull, in order, m, world.
    pub hull: Vec<Vector3>,
    /// Length of the hull, m.
    pub tape: f64,
    /// Foremost and rearmost z on the middle plane, m; none where the plane of symmetry is not met.
    pub depth: Option<[f64; 2]>,
    /// Largest and smallest x, m.
    pub sides: [f64; 2],
    /// Foremost z of the left and the right half, and where it is, m.
    pub foremost: Vector3,
    pub center: Vector3,
}

/// Cuts what is no arm at the given heights; heights at which there is nothing are left out.
pub fn levels(
    positions: &[Vector3],
    triangles: &[[u32; 3]],
    is_arm: &[bool],
    middle: f64,
    heights: impl Iterator<Item = f64>,
) -> Vec<Level> {
    // Triangles by their lowest corner, so that a plane need not look at all of them.
    let low = |t: u32| triangles[t as usize].map(|v| positions[v as usize].y).into_iter().fold(f64::INFINITY, f64::min);
    let high =
        |t: u32| triangles[t as usize].map(|v| positions[v as usize].y).into_iter().fold(f64::NEG_INFINITY, f64::max);
    let mut rising: Vec<(f64, u32)> = (0..triangles.len() as u32).map(|t| (low(t), t)).collect();
    rising.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let tallest = (0..triangles.len() as u32).map(|t| high(t) - low(t)).fold(0.0, f64::max);
    let arm = |t: u32| triangles[t as usize].iter().filter(|&&v| is_arm[v as usize]).count() >= 2;
    let mut levels = Vec::new();
    for y in heights {
        let first = rising.partition_point(|(low, _)| *low < y - tallest);
        let end = rising.partition_point(|(low, _)| *low <= y);
        let near = rising[first..end].iter().map(|(_, t)| *t);
        let mut points = Vec::new();
        let mut crossings: Vec<f64> = Vec::new();
        for curve in loops(positions, triangles, near, Vector3::new(0.0, y, 0.0), Vector3::y()) {
            let count = curve.points.len();
            for k in 0..count {
                if arm(curve.triangles[k]) {
                    continue;
                }
                let (a, b) = (curve.points[k], curve.points[(k + 1) % count]);
                points.push(a);
                if (a.x >= middle) != (b.x >= middle) {
                    crossings.push(a.z + (b.z - a.z) * (middle - a.x) / (b.x - a.x));
                }
            }
        }
        if points.len() < 3 {
            continue;
        }
        let depth = (!crossings.is_empty()).then(|| {
            let most = crossings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            [most, crossings.iter().copied().fold(f64::INFINITY, f64::min)]
        });
        let hull = hull(&points, Vector3::y());
        let sides = [
            hull.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max),
            hull.iter().map(|p| p.x).fold(f64::INFINITY, f64::min),
        ];
        let foremost = hull.iter().copied().max_by(|a, b| a.z.total_cmp(&b.z)).expect("there are points");
        let tape = tape(&hull, Vector3::y());
        let center = middle_of(&hull, y);
        levels.push(Level { y, hull, tape, depth, sides, foremost, center });
    }
    levels
}

/// The middle of the area of a level polygon.
fn middle_of(hull: &[Vector3], y: f64) -> Vector3 {
    let (mut area, mut moment) = (0.0, Vector3::zeros());
    let origin = hull[0];
    for w in hull.windows(2) {
        let (a, b) = (w[0] - origin, w[1] - origin);
        let doubled = a.x * b.z - a.z * b.x;
        area += doubled;
        moment += (a + b) * doubled;
    }
    let middle = if area.abs() > 0.0 { origin + moment / (3.0 * area) } else { origin };
    Vector3::new(middle.x, y, middle.z)
}

/// Of a polyline from one corner to another, the point that is farthest from the straight line between its ends, on the side to
/// which `towards` points: where a concave silhouette has its corner.
pub fn corner(line: &[Vector3], towards: Vector3) -> Option<usize> {
    let (first, last) = (line.first()?, line.last()?);
    let along = (last - first).try_normalize(0.0)?;
    let side = towards - along * towards.dot(&along);
    let depth = |p: &Vector3| (p - first).dot(&side);
    (0..line.len()).max_by(|&i, &j| depth(&line[i]).total_cmp(&depth(&line[j])))
}
