//! Moves that lead through nothing.
//!
//! > from a state without intersections, if the moves of no pair's particles, less their common mean,
//! > add up to the pair's distance, nothing can have passed through anything    (theory, equation 15)
//!
//! > nor if they do not along a line across which a plane is between its sides    (theory, equation 15a)
//!
//! It needs no continuous collision detection. Offset Geometric Contact (Chen et al. 2025, section 3)
//! bounds the moves themselves, which locks layers that move together.

use super::pairs::{Pair, Span};
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

/// A gap that is narrower than this, m, may be one of rounding: positions are exact to a thousandth of it.
const LEAST_GAP: f64 = 1e-12;

/// A pair in its own way.
struct Blocked {
    particles: [u32; 4],
    /// Mean of the particles' moves.
    mean: Vector3,
    /// What its particles may keep of their moves against the mean.
    share: f64,
    /// The line along which alone they lose the rest; none where they lose it altogether.
    normal: Option<Vector3>,
    /// m.
    distance: f64,
}

impl Blocked {
    /// What a particle of the pair is left with.
    fn drawn(&self, m: Vector3) -> Vector3 {
        let against = self.mean - m;
        let lost = self.normal.map_or(against, |normal| normal * normal.dot(&against));
        m + lost * (1.0 - DRAWING * self.share)
    }
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

/// Each particle follows the pair that leaves it the least. Returns those that do.
fn draw_together(blocked: &[Blocked], moves: &mut [Vector3]) -> Vec<u32> {
    let mut strictest: std::collections::BTreeMap<u32, &Blocked> = std::collections::BTreeMap::new();
    for pair in blocked {
        for p in pair.particles {
            let entry = strictest.entry(p).or_insert(pair);
            if pair.share < entry.share {
                *entry = pair;
            }
        }
    }
    for (&p, pair) in &strictest {
        let m = &mut moves[p as usize];
        *m = pair.drawn(*m);
    }
    strictest.into_keys().collect()
}

impl SelfContact {
    /// Shortens moves until no pair can pass through each other; tells how many pairs were in the way.
    ///
    /// The sides of a pair at distance `d` cannot meet while the moves of their particles, less their
    /// common mean, add up to less than `d`, nor while they add up to less than the gap along a line
    /// that has one: that of the nearest points, or across both sides. Where they add up to more, the
    /// particles' moves are first drawn towards the mean, along the line that leaves them the most;
    /// where a few rounds of that do not suffice they are cut to a share of `d` each, which may block
    /// neighbours in turn; in the end all moves are shortened alike.
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
        // No move gets longer than this in what follows: pairs that the longest cannot close are out of the question.
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
                let drawn = draw_together(&blocked, moves);
                self.keep_followed(&drawn, longest, positions, moves);
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

    /// Shortens the moves of particles that were drawn along, which may be longer than they were: to the longest, m, of all,
    /// and so that none leaves its origin farther behind than it may.
    fn keep_followed(&self, drawn: &[u32], longest: f64, positions: &[Vector3], moves: &mut [Vector3]) {
        for &p in drawn {
            let p = p as usize;
            let m = &mut moves[p];
            let length = m.norm();
            if length > longest {
                *m *= longest / length;
            }
            let drift = positions[p] - self.origin[p];
            let room = self.most_drift.powi(2) - drift.norm_squared();
            if (drift + *m).norm_squared() > self.most_drift.powi(2) {
                // |drift + s m| = most, for s between 0 and 1; none where rounding has left no room.
                let (along, squared) = (drift.dot(m), m.norm_squared());
                let share = ((along * along + squared * room).max(0.0).sqrt() - along) / squared;
                *m *= share.clamp(0.0, 1.0);
            }
        }
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
            let Span { vector, .. } = pair.span(positions);
            let distance = vector.norm();
            let altogether = APPROACH_SHARE * distance / closing;
            if altogether >= 1.0 {
                return None;
            }
            let (mut share, mut normal) = (altogether, None);
            for direction in [vector / distance, pair.normal(positions)] {
                let along = share_along(direction, &pair, positions, m);
                if along > share {
                    (share, normal) = (along, Some(direction));
                }
            }
            // Rounding must not block what was just cut to fit.
            (share < 1.0 - 1e-9).then_some(Blocked { particles: pair.particles, mean, share, normal, distance })
        };
        near.par_iter().with_min_len(MOST_PAIRS_ALONE).filter_map(blocked).collect()
    }
}

/// What the particles of a pair may keep of their moves along a direction, of length one, so that a plane across it stays
/// between the sides; more than 1 where they need lose nothing. Zero where no such plane is between them now: any direction
/// may be asked for.
fn share_along(direction: Vector3, pair: &Pair, positions: &[Vector3], moves: [Vector3; 4]) -> f64 {
    let base = positions[pair.particles[0] as usize];
    let gap = pair.gap(pair.particles.map(|p| direction.dot(&(positions[p as usize] - base))));
    // Of the gap, if each side did the worst that one of its particles does.
    let widening = pair.gap(moves.map(|m| direction.dot(&m)));
    match gap > LEAST_GAP {
        true if widening < 0.0 => APPROACH_SHARE * gap / -widening,
        true => f64::INFINITY,
        // NaN as well, of sides that touch, or lie along one line.
        false => 0.0,
    }
}
