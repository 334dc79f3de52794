//! Rings of surface points, and the quads between them.

use super::cage::Cage;
use crate::geometry::Vector3;

/// Extents of a section from its center in four directions, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Radii {
    pub outward: f64,
    pub inward: f64,
    pub front: f64,
    pub back: f64,
}

/// (outward, forward) coordinates of a superellipse |x/a|^s + |y/b|^s = 1, m, at an angle from outward to front. The
/// squareness s is 2 for an ellipse; about 2.4 gives the flatter front and back of a torso.
pub(super) fn superellipse(radii: Radii, squareness: f64, degrees: f64) -> (f64, f64) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let bent = |v: f64| v.abs().powf(2.0 / squareness);
    let outward = if cos >= 0.0 { radii.outward } else { -radii.inward };
    let forward = if sin >= 0.0 { radii.front } else { -radii.back };
    (outward * bent(cos), forward * bent(sin))
}

/// Quads between two rings, `to` being farther along the tube. Rings run upward on the side that faces a viewer who
/// sees the tube run to the right:
///
/// ```text
///     from[i+1] --- to[i+1]
///        |             |
///     from[i]   --- to[i]
/// ```
pub(super) fn join(cage: &mut Cage, from: &[u32], to: &[u32]) {
    let count = from.len();
    for i in 0..count {
        let next = (i + 1) % count;
        cage.quads.push([from[i], to[i], to[next], from[next]]);
    }
}

/// Leads an opening of eight edges into a ring of six, using up the four edges around `opening[0]`.
///
/// ```text
///     6 --- 7 --- 0 --- 1 --- 2     opening
///     |     |     |     |     |
///     |     m0 -- m1 -- m2    |
///     |    /      |      \    |
///     5 --------- 0 --------- 1     ring
/// ```
pub(super) fn narrow(cage: &mut Cage, opening: &[u32; 8], ring: &[u32; 6], middle: &[u32; 3]) {
    let (p, q, m) = (opening, ring, middle);
    for i in 2..6 {
        cage.quads.push([p[i], q[i - 1], q[i], p[i + 1]]);
    }
    cage.quads.extend([
        [p[6], q[5], m[0], p[7]],
        [p[7], m[0], m[1], p[0]],
        [p[0], m[1], m[2], p[1]],
        [p[1], m[2], q[1], p[2]],
        [m[0], q[5], q[0], m[1]],
        [m[1], q[0], q[1], m[2]],
    ]);
}

/// Closes a tube of six edges. The two points at its tip lie toward `ring[first]` and the point opposite.
///
/// ```text
///          1 --- 2
///        /  \     \
///       0    a --- b --- 3     (first = 0, seen from inside)
///        \  /     /
///          5 --- 4
/// ```
pub(super) fn cap(cage: &mut Cage, ring: &[u32; 6], first: usize, tip: [Vector3; 2]) {
    let r = |i: usize| ring[(first + i) % 6];
    let [a, b] = tip.map(|point| cage.add(point));
    cage.quads.extend([[a, r(1), r(0), r(5)], [b, r(2), r(1), a], [r(4), r(3), r(2), b], [r(5), r(4), b, a]]);
}

/// Adds a ring of points.
pub(super) fn add_ring<const N: usize>(cage: &mut Cage, at: impl Fn(usize) -> Vector3) -> [u32; N] {
    std::array::from_fn(|i| cage.add(at(i)))
}
