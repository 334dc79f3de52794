//! Moves that lead through nothing.
//!
//! > from a state without intersections, if the moves of no pair's particles, less their common mean,
//! > add up to the pair's distance, nothing can have passed through anything    (theory, equation 15)
//!
//! It needs no continuous collision detection. Offset Geometric Contact (Chen et al. 2025, section 3)
//! bounds the moves themselves, which locks layers that move together.

use super::pairs::Pair;
use super::{CHUNK, LEAST_CHUNKS, MOST_PAIRS_ALONE, SelfContact, larger};
use crate::geometry::Vector3;
use rayon::prelude::*;

/// Share of a pair's distance that its sides may move towards each other in one step: below one, so
/// that touching stays excluded.
const APPROACH_SHARE: f64 = 0.8;
/// When some particle would stray farther, all get new origins that are away by this share of the
/// most. On fine levels these are few: one in a thousand where half of this would be one in a hundred;
/// with more the searches cost the same and come twice as often.
const RENEWED_DRIFT: f64 = 0.5;
/// How often the moves of pairs in their own way are drawn together before they are cut.
const DRAWING_ROUNDS: usize = 4;
/// How often in all, before all moves are shortened.
const MOST_ROUNDS: usize = 16;
/// Drawn a little closer than needed, as the neighbours move as well.
const DRAWING: f64 = 0.9;
/// Four moves add up to no more closing than this many times the longest of them: each differs from
/// the mean of all by one and a half at most, and one on each side counts.
const MOST_CLOSING: f64 = 3.0;

/// A pair in its own way.
struct Blocked {
    particles: [u32; 4],
    /// Mean of the particles' moves.
    mean: Vector3,
    /// What its particles may keep of their moves against the mean.
    share: f64,
    /// m.
    distance: f64,
}

/// No particle of a blocked pair moves farther than its part of the pair's distance.
fn stop(blocked: &[Blocked], moves: &mut [Vector3]) {
    for pair in blocked {
        let most = 0.5 * APPROACH_SHARE * pair.distance;
        for p in pair.particles {
            let m = &mut moves[p as usize];
            let length = m.norm();
            if length > most {
                *m *= most / length;
            }
        }
    }
}

/// Each particle follows the pair that leaves it the least.
fn draw_together(blocked: &[Blocked], moves: &mut [Vector3]) {
    let mut strictest: std::collections::BTreeMap<u32, (f64, Vector3)> = std::collections::BTreeMap::new();
    for pair in blocked {
        for p in pair.particles {
            let entry = strictest.entry(p).or_insert((f64::INFINITY, Vector3::zeros()));
            if pair.share < entry.0 {
                *entry = (pair.share, pair.mean);
            }
        }
    }
    for (p, (share, mean)) in strictest {
        let m = &mut moves[p as usize];
        *m = mean + (*m - mean) * (DRAWING * share);
    }
}

impl SelfContact {
    /// Shortens moves until no pair can pass through each other; tells how many pairs were in the way.
    ///
    /// The sides of a pair at distance `d` cannot meet while the moves of their particles, less their
    /// common mean, add up to less than `d`. Where they do not, the particles' moves are first drawn
    /// towards the mean; where a few rounds of that do not suffice they are cut to a share of `d`
    /// each, which may block neighbours in turn; in the end all moves are shortened alike.
    pub fn limit(&mut self, positions: &[Vector3], moves: &mut [Vector3]) -> usize {
        self.limit_for(MOST_ROUNDS, positions, moves)
    }

    /// Only draws the moves of pairs in their own way together; nobody is stopped. For cloth that a moving body carries
    /// along: what is stopped there is torn from what is not. Pairs that are squeezed may then pass through each other.
    pub fn draw(&mut self, positions: &[Vector3], moves: &mut [Vector3]) -> usize {
        self.limit_for(DRAWING_ROUNDS, positions, moves)
    }

    fn limit_for(&mut self, rounds: usize, positions: &[Vector3], moves: &mut [Vector3]) -> usize {
        if self.origin.len() != positions.len() {
            self.rebuild(positions);
        }
        let most_drift = self.most_drift;
        let (longest, strays) = self.cut(positions, moves, most_drift);
        if strays {
            self.renew_strayed(positions, moves, most_drift);
        }
        let drift = self.measure_drift(positions);
        // No move gets longer in what follows: pairs that the longest cannot close are out of the question.
        let closing = MOST_CLOSING * longest;
        let within = closing / APPROACH_SHARE + 2.0 * drift;
        let pairs = self.pairs.par_iter().zip(&self.origin_distance).with_min_len(MOST_PAIRS_ALONE);
        let may_close = |&(pair, &at_origin): &(&Pair, &f64)| {
            at_origin <= within && closing >= APPROACH_SHARE * self.least_distance(pair, at_origin)
        };
        let near: Vec<(Pair, f64)> = pairs.filter(may_close).map(|(pair, at_origin)| (*pair, *at_origin)).collect();
        let mut first = None;
        for round in 0..rounds {
            let blocked = self.blocked(&near, positions, moves);
            first = first.or(Some(blocked.len()));
            if blocked.is_empty() {
                break;
            } else if round < DRAWING_ROUNDS {
                draw_together(&blocked, moves);
            } else if round + 1 < MOST_ROUNDS {
                stop(&blocked, moves);
            } else {
                let least = blocked.iter().map(|b| b.share).fold(1.0, f64::min);
                moves.iter_mut().for_each(|m| *m *= least);
            }
        }
        first.unwrap_or(0)
    }

    /// Cuts moves to `most`, m. Returns the length of the longest, m, and whether a particle would
    /// then be farther than `most` from its origin.
    fn cut(&self, positions: &[Vector3], moves: &mut [Vector3], most: f64) -> (f64, bool) {
        let chunks = moves.par_chunks_mut(CHUNK).zip(positions.par_chunks(CHUNK));
        let chunks = chunks.zip(self.origin.par_chunks(CHUNK)).with_min_len(LEAST_CHUNKS);
        let largest = chunks.map(|((moves, positions), origin)| {
            let (mut longest, mut farthest) = (0.0, 0.0);
            for ((m, p), origin) in moves.iter_mut().zip(positions).zip(origin) {
                let mut squared = m.norm_squared();
                if squared > most * most {
                    *m *= most / squared.sqrt();
                    squared = most * most;
                }
                longest = larger(longest, squared);
                farthest = larger(farthest, (p + *m - origin).norm_squared());
            }
            (longest, farthest)
        });
        let (longest, farthest) = largest.reduce(|| (0.0, 0.0), |a, b| (larger(a.0, b.0), larger(a.1, b.1)));
        (longest.sqrt(), farthest > most * most)
    }

    /// Gives new origins to particles that would otherwise come to be farther from them than `most`, m,
    /// and to those that are so soon.
    fn renew_strayed(&mut self, positions: &[Vector3], moves: &[Vector3], most: f64) {
        let far = RENEWED_DRIFT * most;
        let strays = |&p: &u32| {
            let k = p as usize;
            let away = positions[k] - self.origin[k];
            away.norm_squared() > far * far || (away + moves[k]).norm_squared() > most * most
        };
        let strayed: Vec<u32> = (0..positions.len() as u32).filter(strays).collect();
        self.renew(positions, &strayed);
    }

    /// Pairs whose sides would come too near, among those given with their distances at the origin.
    fn blocked(&self, near: &[(Pair, f64)], positions: &[Vector3], moves: &[Vector3]) -> Vec<Blocked> {
        let blocked = |&(pair, at_origin): &(Pair, f64)| {
            let least_distance = APPROACH_SHARE * self.least_distance(&pair, at_origin);
            let m = pair.particles.map(|p| moves[p as usize]);
            let longest = m.iter().map(|m| m.norm_squared()).fold(0.0, larger);
            if least_distance > 0.0 && MOST_CLOSING * MOST_CLOSING * longest <= least_distance * least_distance {
                return None;
            }
            let mean = (m[0] + m[1] + m[2] + m[3]) * 0.25;
            let (one, other) = pair.largest_on_sides(m.map(|m| (m - mean).norm_squared()));
            let closing = one.sqrt() + other.sqrt();
            // Most pairs are far from meeting; only for the others the distance is worth measuring.
            if closing <= least_distance {
                return None;
            }
            let distance = pair.distance(positions);
            let share = APPROACH_SHARE * distance / closing;
            // Rounding must not block what was just cut to fit.
            (share < 1.0 - 1e-9).then_some(Blocked { particles: pair.particles, mean, share, distance })
        };
        near.par_iter().with_min_len(MOST_PAIRS_ALONE).filter_map(blocked).collect()
    }
}
