//! Seams proposed: every pair of segments is scored, the most certain are taken first, and each taken seam speaks for
//! those that go on where it ends.
//!
//! A score is a sum of evidence, in the manner of logarithmic odds: lengths, names, forms, darts, and, where the panels
//! are placed, whether the one segment is where the other's cloth would go on (`placed`) or, where nothing is
//! placed, how the corners fit. The weights come from how garments are made, not from a fit to examples. Segments for which nothing
//! speaks stay open: hems, necklines, cuffs.

mod names;
mod score;

use crate::geometry::UnionFind;
use crate::pattern::sewing::SeamPlan;
use crate::pattern::{Pattern, SegmentId};
use score::{Edges, Scored};

/// A seam that is proposed.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    pub plan: SeamPlan,
    /// From 0 to 1.
    pub confidence: f64,
    /// Why, in a few words.
    pub reason: String,
}

/// Below this score nothing is proposed: even odds are not worth a hand's work.
const LEAST: f64 = 0.5;
/// What it speaks for a seam that an end of it is sewn already, by the seams taken before.
const GOES_ON: f64 = 1.5;
/// More segments than this are not all compared with each other: no pattern has so many.
const MOST_SEGMENTS: usize = 3000;

/// Seams for the pattern's panels, whatever seams it has; the most certain first.
pub fn suggest(pattern: &Pattern) -> Vec<Suggestion> {
    let edges = Edges::new(pattern);
    if edges.ids.len() > MOST_SEGMENTS {
        return Vec::new();
    }
    let mut candidates: Vec<Scored> = Vec::new();
    for a in 0..edges.ids.len() {
        for b in a + 1..edges.ids.len() {
            let scored = edges.score(a, b);
            if scored.score > LEAST - 2.0 * GOES_ON {
                candidates.push(scored);
            }
        }
    }
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score).then((a.a, a.b).cmp(&(b.a, b.b))));
    let mut corners = UnionFind::new(edges.ids.len());
    let mut sewn = vec![false; edges.ids.len()];
    let mut taken: Vec<(Scored, f64)> = Vec::new();
    loop {
        // What was taken changes the scores of its neighbours alone, but a look at all is cheap.
        let mut best: Option<(f64, usize)> = None;
        for (k, candidate) in candidates.iter().enumerate() {
            if sewn[candidate.a] || sewn[candidate.b] || best.is_some_and(|(s, _)| candidate.score + 2.0 * GOES_ON <= s)
            {
                continue;
            }
            let mut score = candidate.score;
            for [u, v] in edges.ends(candidate) {
                if corners.find(u) == corners.find(v) && u != v {
                    score += GOES_ON;
                }
            }
            if best.is_none_or(|(s, _)| score > s + 1e-9) {
                best = Some((score, k));
            }
        }
        let Some((score, k)) = best.filter(|(score, _)| *score >= LEAST) else { break };
        let candidate = candidates[k].clone();
        sewn[candidate.a] = true;
        sewn[candidate.b] = true;
        for [u, v] in edges.ends(&candidate) {
            corners.union(u, v);
        }
        taken.push((candidate, score));
    }
    let suggestion = |(candidate, score): (Scored, f64)| {
        let sides: [SegmentId; 2] = [edges.ids[candidate.a], edges.ids[candidate.b]];
        let names = sides.map(|id| format!("{}:{}", pattern.panels[id.panel].name, id.segment));
        Suggestion {
            plan: SeamPlan::whole(format!("{} + {}", names[0], names[1]), sides),
            confidence: 1.0 / (1.0 + (LEAST - score).exp()),
            reason: candidate.reasons.join(", "),
        }
    };
    let mut made: Vec<Suggestion> = taken.into_iter().map(suggestion).collect();
    made.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
    made
}
