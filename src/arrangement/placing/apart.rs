//! Panels moved out of each other and out of the body, once their seams have had their say.

use super::Limb;
use super::stance::Stance;
use super::surface::Surface;
use crate::body::Body;
use crate::geometry::Vector3;
use crate::pattern::Pattern;

/// Panels that would lie in each other are moved apart by this, m, along the way that they face.
const STAGGER: f64 = 0.02;

/// Steps in which trouser legs are moved apart where they would lie in each other, m, and how many there are.
const LEG_STEP: f64 = 0.005;
const MOST_LEG_STEPS: usize = 30;

/// Moves the panels of the two legs apart, as one, until none lies in one of the other leg.
pub fn part_legs(pattern: &Pattern, stances: &[Stance], moves: &mut [Vector3]) {
    let flat = |side: usize| -> Vec<usize> {
        (0..stances.len()).filter(|&k| stances[k].limb == Limb::Leg(side) && stances[k].bend.is_none()).collect()
    };
    let legs = [flat(0), flat(1)];
    for _ in 0..MOST_LEG_STEPS {
        let meet = legs[0].iter().any(|&a| {
            legs[1].iter().any(|&b| {
                let alike = stances[a].face.dot(&stances[b].face) > 0.99;
                alike
                    && overlap(
                        &outline(pattern, stances, moves, a),
                        &outline(pattern, stances, moves, b),
                        &stances[a].free,
                    )
            })
        });
        if !meet {
            break;
        }
        for (panels, way) in legs.iter().zip([1.0, -1.0]) {
            panels.iter().for_each(|&k| moves[k].x += way * LEG_STEP);
        }
    }
}

/// Steps in which panels leave the body, m, and how many there are.
const CLEARING_STEP: f64 = 0.02;
const MOST_CLEARING_STEPS: usize = 12;

/// Moves panels that begin inside the body out of it, the way that they face; feet reach farther than legs.
pub fn clear_body(surface: &Surface, stances: &[Stance], moves: &mut [Vector3], body: &Body) {
    // Hoods are wide enough, and reach down to shoulders that the search of first positions lifts them from.
    for k in (0..stances.len()).filter(|&k| stances[k].limb != Limb::Head) {
        let way = stances[k].face;
        let points: Vec<Vector3> =
            surface.level.panels[k].points.clone().map(|p| stances[k].turned(surface.level.rest[p])).collect();
        for _ in 0..MOST_CLEARING_STEPS {
            if !points.iter().any(|p| body.contains(p + moves[k])) {
                break;
            }
            moves[k] += way * CLEARING_STEP;
        }
    }
}

/// The outline of a panel where it is, m, world.
fn outline(pattern: &Pattern, stances: &[Stance], moves: &[Vector3], k: usize) -> Vec<Vector3> {
    pattern.panels[k].polygon(OUTLINE_POINTS).iter().map(|&p| stances[k].turned(p) + moves[k]).collect()
}

/// Moves panels that would lie in each other apart, the smaller one outwards.
pub fn stagger(pattern: &Pattern, stances: &[Stance], moves: &mut [Vector3]) {
    let mut order: Vec<usize> = (0..stances.len()).filter(|&k| stances[k].bend.is_none()).collect();
    let area = |k: usize| pattern.panels[k].signed_area().abs();
    order.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));
    for (n, &k) in order.iter().enumerate() {
        let mut tries = 0;
        while tries < MOST_STAGGERS
            && order[..n].iter().any(|&other| {
                let alike = stances[k].face.dot(&stances[other].face) > 0.99;
                let deep = (moves[k] - moves[other]).dot(&stances[k].face)
                    + stances[k].turned(stances[k].middle).dot(&stances[k].face)
                    - stances[other].turned(stances[other].middle).dot(&stances[k].face);
                alike
                    && deep.abs() < 0.7 * STAGGER
                    && overlap(
                        &outline(pattern, stances, moves, k),
                        &outline(pattern, stances, moves, other),
                        &stances[k].free,
                    )
            })
        {
            moves[k] += stances[k].face * STAGGER;
            tries += 1;
        }
    }
}

const OUTLINE_POINTS: usize = 6;
const MOST_STAGGERS: usize = 6;

/// Do two outlines in parallel planes overlap, seen along their normals?
fn overlap(a: &[Vector3], b: &[Vector3], plane: &[Vector3; 2]) -> bool {
    let flat = |p: &Vector3| [p.dot(&plane[0]), p.dot(&plane[1])];
    let (a, b): (Vec<_>, Vec<_>) = (a.iter().map(flat).collect(), b.iter().map(flat).collect());
    let inside = |p: [f64; 2], polygon: &[[f64; 2]]| {
        let mut odd = false;
        for (k, q) in polygon.iter().enumerate() {
            let r = polygon[(k + 1) % polygon.len()];
            if (q[1] > p[1]) != (r[1] > p[1]) && p[0] < q[0] + (p[1] - q[1]) / (r[1] - q[1]) * (r[0] - q[0]) {
                odd = !odd;
            }
        }
        odd
    };
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let cross = |p: [f64; 2], q: [f64; 2], r: [f64; 2], s: [f64; 2]| {
        side(p, q, r) * side(p, q, s) < 0.0 && side(r, s, p) * side(r, s, q) < 0.0
    };
    let ends = |polygon: &[[f64; 2]], k: usize| (polygon[k], polygon[(k + 1) % polygon.len()]);
    inside(a[0], &b)
        || inside(b[0], &a)
        || (0..a.len()).any(|i| {
            let (p, q) = ends(&a, i);
            (0..b.len()).any(|j| {
                let (r, s) = ends(&b, j);
                cross(p, q, r, s)
            })
        })
}
