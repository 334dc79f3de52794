//! Seams proposed: every pair of segments is scored, the most certain are taken first, and each taken seam speaks for
//! those that go on where it ends.
//!
//! A score is a sum of evidence, in the manner of logarithmic odds: lengths, names, forms, darts, and, where the panels
//! are placed, whether the one segment is where the other's cloth would go on (`placed`) or, where nothing is
//! placed, how the corners fit. The weights come from how garments are made, not from a fit to examples. Segments for which nothing
//! speaks stay open: hems, necklines, cuffs.
//!
//! In drawings, of which no panel has a place, seams come in mirror images (`symmetry`), and what is left open closes in lines of
//! several edges (`rims`). What would make a bag of a part of the garment is given up again (`openings`).

mod drawn;
mod openings;
mod rims;
mod score;
mod symmetry;

use crate::geometry::UnionFind;
use crate::pattern::Pattern;
use crate::pattern::inside::shown_from_inside;
use crate::pattern::sewing::{SeamPlan, Stretch};
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
    let from_inside = shown_from_inside(pattern);
    let seen = pattern.turned_over(&from_inside);
    let mut edges = Edges::new(&seen);
    if edges.ids.len() > MOST_SEGMENTS {
        return Vec::new();
    }
    let mut sewing = Sewing::new(&edges);
    sewing.take_all();
    // What closes a bag is none of its seams, and yet tells which panels are drawn with their wrong sides up: those edges are alike.
    let mut turned = None;
    // Ends: of the candidates, which are finitely many, some are given up in every round.
    loop {
        let found = sewing.directions();
        let closing = sewing.closing(&found);
        turned.get_or_insert(found.turned);
        if closing.is_empty() {
            break;
        }
        sewing.give_up(&closing);
        sewing.take_all();
    }
    let Sewing { taken, sewn_to, .. } = sewing;
    turned.into_iter().for_each(|turned| edges.turn_over(turned));
    let suggestion = |sides: [Vec<usize>; 2], score: f64, reasons: &[String]| {
        let id = |&e: &usize| seen.turned_segment(&from_inside, edges.ids[e]);
        let stretches = |side: &Vec<usize>| side.iter().map(|e| Stretch::whole(id(e))).collect::<Vec<_>>();
        let name = |e: &usize| format!("{}:{}", pattern.panels[id(e).panel].name, id(e).segment);
        let names = sides.each_ref().map(|side| side.iter().map(name).collect::<Vec<_>>().join(" and "));
        Suggestion {
            plan: SeamPlan {
                name: names.join(" + "),
                sides: sides.each_ref().map(stretches),
                direction: None,
                right_wrong: false,
                ease: None,
                place: String::new(),
            },
            confidence: 1.0 / (1.0 + (LEAST - score).exp()),
            reason: reasons.join(", "),
        }
    };
    let mut made: Vec<Suggestion> = taken
        .iter()
        .map(|(candidate, score)| suggestion([vec![candidate.a], vec![candidate.b]], *score, &candidate.reasons))
        .collect();
    if edges.are_drawn() {
        for run in rims::runs(&edges, &sewn_to) {
            made.push(suggestion(run.sides, run.score - 1.0, &run.reasons));
        }
    }
    made.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
    made
}

/// What is taken so far.
struct Sewing<'e> {
    edges: &'e Edges<'e>,
    candidates: Vec<Scored>,
    corners: UnionFind,
    /// Per edge.
    sewn_to: Vec<Option<usize>>,
    taken: Vec<(Scored, f64)>,
}

impl<'e> Sewing<'e> {
    fn new(edges: &'e Edges<'e>) -> Self {
        let count = edges.ids.len();
        let mut candidates: Vec<Scored> = Vec::new();
        for a in 0..count {
            for b in a + 1..count {
                let scored = edges.score(a, b);
                if scored.score > LEAST - 2.0 * GOES_ON {
                    candidates.push(scored);
                }
            }
        }
        candidates.sort_by(|a, b| b.score.total_cmp(&a.score).then((a.a, a.b).cmp(&(b.a, b.b))));
        Self { edges, candidates, corners: UnionFind::new(count), sewn_to: vec![None; count], taken: Vec::new() }
    }

    fn take_all(&mut self) {
        self.take(|sewing, candidate| !candidate.is_upper && !sewing.has_middle(candidate));
        // Shoulders are open beside: at armhole and neckline. Waists are not.
        self.take(|sewing, candidate| {
            candidate.is_upper && [candidate.a, candidate.b].iter().all(|&edge| sewing.is_free_beside(edge))
        });
    }

    /// Takes the best of some candidates as long as there are good ones.
    fn take(&mut self, among: impl Fn(&Self, &Scored) -> bool) {
        loop {
            // What was taken changes the scores of its neighbours alone, but a look at all is cheap.
            let mut best: Option<(f64, usize)> = None;
            for k in 0..self.candidates.len() {
                let candidate = &self.candidates[k];
                if self.sewn_to[candidate.a].is_some()
                    || self.sewn_to[candidate.b].is_some()
                    || best.is_some_and(|(s, _)| candidate.score + 2.0 * GOES_ON <= s)
                    || !among(self, candidate)
                {
                    continue;
                }
                let mut score = candidate.score;
                for [u, v] in self.edges.ends(candidate) {
                    if self.corners.find(u) == self.corners.find(v) && u != v {
                        score += GOES_ON;
                    }
                }
                if best.is_none_or(|(s, _)| score > s + 1e-9) {
                    best = Some((score, k));
                }
            }
            let Some((score, k)) = best.filter(|(score, _)| *score >= LEAST) else { break };
            let candidate = self.candidates[k].clone();
            let image = self.image(&candidate);
            self.sew(candidate, score);
            if let Some(image) = image {
                self.sew(image, score);
            }
        }
    }

    /// The same seam on the other side of the garment, in drawings.
    fn image(&self, candidate: &Scored) -> Option<Scored> {
        if !self.edges.are_drawn() {
            return None;
        }
        let (a, b) = (self.edges.mirror(candidate.a)?, self.edges.mirror(candidate.b)?);
        let free = |edge: usize| self.sewn_to[edge].is_none() && edge != candidate.a && edge != candidate.b;
        (free(a) && free(b) && a != b).then(|| Scored { a: a.min(b), b: a.max(b), ..candidate.clone() })
    }

    fn sew(&mut self, candidate: Scored, score: f64) {
        self.sewn_to[candidate.a] = Some(candidate.b);
        self.sewn_to[candidate.b] = Some(candidate.a);
        for [u, v] in self.edges.ends(&candidate) {
            self.corners.union(u, v);
        }
        self.taken.push((candidate, score));
    }

    /// Gives up taken seams, by their places, for good. In drawings their edges, where no other is of their length, are left to the
    /// lines of several edges: the caps of both halves of a sleeve are as long as the armhole, and none of them need be as its half.
    fn give_up(&mut self, closing: &[usize]) {
        let (mut kept, mut barred) = (Vec::new(), Vec::new());
        for (k, taken) in std::mem::take(&mut self.taken).into_iter().enumerate() {
            if closing.contains(&k) { barred.push([taken.0.a, taken.0.b]) } else { kept.push(taken) }
        }
        let drawn = self.edges.are_drawn();
        self.candidates.retain(|candidate| {
            let pair = [candidate.a, candidate.b];
            let is_left = drawn && !self.edges.are_as_long(candidate.a, candidate.b);
            let touches = || barred.iter().flatten().any(|edge| pair.contains(edge));
            let is_barred = barred.contains(&pair) || is_left && touches();
            !is_barred
        });
        self.corners = UnionFind::new(self.sewn_to.len());
        self.sewn_to.fill(None);
        kept.into_iter().for_each(|(candidate, score)| self.sew(candidate, score));
    }

    /// Would it be the second seam between a panel and its mirror image? A panel has one in the middle of the garment.
    fn has_middle(&self, candidate: &Scored) -> bool {
        let is_middle = |edge: usize| {
            self.edges.mirror(edge).is_some_and(|image| image != edge && self.sewn_to[edge] == Some(image))
        };
        let panel = self.edges.ids[candidate.a].panel;
        self.edges.mirror(candidate.a) == Some(candidate.b)
            && (0..self.sewn_to.len()).any(|edge| self.edges.ids[edge].panel == panel && is_middle(edge))
    }

    /// Is nothing of the same part of the garment sewn to the edges beside one?
    fn is_free_beside(&self, edge: usize) -> bool {
        let is_free = |beside: usize| self.sewn_to[beside].is_none_or(|to| !self.edges.same_part(beside, to));
        self.edges.beside(edge).into_iter().all(is_free)
    }
}
