//! Edges that are stretched to their limit do not lengthen.
//!
//! Springs as soft as cloth is at small strains would sag without end; cloth stiffens. Vassilev and Spanlang (2001,
//! section 3.3) change velocities instead of adding stiff springs, which would shorten the step: where an edge would
//! be longer than its limit at the end of the step, the velocities of its ends along it are changed, each in inverse
//! proportion to its inertia, so that it is not.
//!
//! ```text
//!     |x_ij + Δt v_ij| ≤ max(L_max, l)                                (theory, equation 27)
//! ```
//!
//! Edges are visited one after the other and each sees what was changed before. Those that hang from others need
//! more than one visit, so that rounds are repeated until nothing is longer, or they are used up.

use crate::garment::Level;
use crate::geometry::{EdgeTable, Vector3};
use rayon::prelude::*;

/// How often edges that are too long are looked for in a step, at most, and rounds over those that were found.
const MOST_LOOKS: usize = 60;
const ROUNDS: usize = 2;
/// Each visit takes away this many times what an edge is too long by: chains come to terms sooner.
const OVER_RELAXATION: f64 = 1.5;
/// What an edge may be beyond its limit, as a share of it, without another round.
const TOLERANCE: f64 = 3e-4;
/// How much of what an edge is beyond its limit already it gives back in a step.
const RECOVERY: f64 = 0.1;

/// An edge and how long it may be.
#[derive(Clone, Copy, Debug)]
struct Limited {
    ends: [u32; 2],
    /// m.
    rest: f64,
    /// m.
    most: f64,
}

/// The edges of a level and their limits.
pub struct SuperElasticity {
    edges: Vec<Limited>,
    /// Else they are only measured.
    limited: bool,
    too_long: Vec<u32>,
}

impl SuperElasticity {
    /// Edges may be stretched by `limit`, or as far as they are at `positions` if that is more; without one, as they like.
    pub fn new(level: &Level, limit: Option<f64>, positions: &[Vector3]) -> Self {
        let triangles = level.particle_triangles();
        let mut eased = vec![[1.0; 3]; triangles.len()];
        for e in &level.eased {
            eased[e.triangle as usize][e.tip as usize] = e.ratio;
        }
        let edges = EdgeTable::new(&triangles).edges.into_iter().filter_map(|edge| {
            // A seam joins edges of two lengths: the longer one may be drawn out.
            let rest = edge.triangles.iter().map(|&t| {
                let (t, corners) = (t as usize, level.rest_corners(t as usize));
                let tip = triangles[t].iter().position(|p| !edge.ends.contains(p))?;
                Some((corners[(tip + 2) % 3] - corners[(tip + 1) % 3]).norm() * eased[t][tip])
            });
            let rest = rest.flatten().fold(0.0, f64::max);
            let now = (positions[edge.ends[0] as usize] - positions[edge.ends[1] as usize]).norm();
            (rest > 0.0).then(|| Limited {
                ends: edge.ends,
                rest,
                most: (rest * (1.0 + limit.unwrap_or(0.0))).max(now),
            })
        });
        Self { edges: edges.collect(), limited: limit.is_some(), too_long: Vec::new() }
    }

    /// The largest strain of all edges.
    pub fn largest_strain(&self, positions: &[Vector3]) -> f64 {
        self.edges.par_iter().map(|e| e.strain(positions)).reduce(|| f64::NEG_INFINITY, f64::max)
    }

    /// The edge of the largest strain, by its ends, with the strain, if there is any edge.
    pub fn most_stretched(&self, positions: &[Vector3]) -> Option<([u32; 2], f64)> {
        let strains = self.edges.iter().map(|e| (e.ends, e.strain(positions)));
        strains.reduce(|most, next| if next.1 > most.1 { next } else { most })
    }

    /// Changes velocities, m/s, so that no edge is beyond its limit after `step`, s; inertia in kg. `hold` takes back what
    /// of a particle's velocity leads into the body: the edges around it then share what it cannot give.
    pub fn limit(
        &mut self,
        positions: &[Vector3],
        velocities: &mut [Vector3],
        inertia: &[f64],
        step: f64,
        hold: impl Fn(usize, &mut Vector3),
    ) {
        let Self { edges, limited: true, too_long } = self else { return };
        for _ in 0..MOST_LOOKS {
            // Few are too long; all others are only looked at, by all threads.
            let is_long = |e: &Limited| {
                let allowed = e.allowed(positions) * (1.0 + TOLERANCE);
                e.after(positions, velocities, step).norm_squared() > allowed * allowed
            };
            too_long.clear();
            too_long.par_extend(edges.par_iter().enumerate().filter(|(_, e)| is_long(e)).map(|(k, _)| k as u32));
            if too_long.is_empty() {
                break;
            }
            for round in 0..ROUNDS {
                // There and back again, so that no end of a chain is favoured.
                if round % 2 == 1 {
                    too_long.reverse();
                }
                let mut worst = 0.0f64;
                for &k in too_long.iter() {
                    let edge = edges[k as usize];
                    let [a, b] = edge.ends.map(|p| p as usize);
                    let span = edge.after(positions, velocities, step);
                    let (length, allowed) = (span.norm(), edge.allowed(positions));
                    if length <= allowed {
                        continue;
                    }
                    worst = worst.max(length / allowed - 1.0);
                    let (wa, wb) = (inertia[a].recip(), inertia[b].recip());
                    let change = span * (OVER_RELAXATION * (length - allowed) / (length * step * (wa + wb)));
                    velocities[a] += change * wa;
                    velocities[b] -= change * wb;
                    [a, b].into_iter().for_each(|p| hold(p, &mut velocities[p]));
                }
                if worst < TOLERANCE {
                    break;
                }
            }
        }
    }
}

impl Limited {
    /// From one end to the other after `step`, s, as velocities are now.
    #[inline]
    fn after(&self, positions: &[Vector3], velocities: &[Vector3], step: f64) -> Vector3 {
        let [a, b] = self.ends.map(|p| p as usize);
        positions[b] - positions[a] + (velocities[b] - velocities[a]) * step
    }

    fn strain(&self, positions: &[Vector3]) -> f64 {
        let [a, b] = self.ends.map(|p| positions[p as usize]);
        (b - a).norm() / self.rest - 1.0
    }

    /// How long it may be after this step, m: what is too long already comes back slowly.
    #[inline]
    fn allowed(&self, positions: &[Vector3]) -> f64 {
        let [a, b] = self.ends.map(|p| p as usize);
        let now = (positions[b] - positions[a]).norm();
        self.most + (now - self.most).max(0.0) * (1.0 - RECOVERY)
    }
}
