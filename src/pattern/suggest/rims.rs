//! Runs of edges: where the pieces that are sewn so far end in closed lines, a line of one piece may belong to a line of
//! another. A sleeve's cap goes into an armhole of front and back, a waistband onto the waists of four panels.

use super::score::Edges;
use crate::geometry::UnionFind;
use crate::pattern::NotchKind;

/// A closed line of open edges.
struct Rim {
    /// In the order in which one walks with the cloth at the left hand, right side up.
    edges: Vec<usize>,
    /// m.
    length: f64,
    piece: u32,
    /// The rim of its mirror images; itself if it is that.
    image: Option<usize>,
    /// It is not the outline of a panel that is sewn to nothing: facings and pockets are as large as each other.
    is_sewn: bool,
    /// Means, weighted by lengths: how far it bulges outwards, and how much its outside points up in the drawing.
    bulge: f64,
    up: f64,
    /// By the share of the rim from its first edge.
    notches: Vec<(f64, NotchKind)>,
}

/// Two rims that are to be sewn, both from the same corner; the second is walked backwards.
pub struct Run {
    pub sides: [Vec<usize>; 2],
    pub score: f64,
    pub reasons: Vec<String>,
}

/// Below this score nothing is proposed.
const LEAST: f64 = 2.0;
/// Points of a rim whose heights in the drawing are compared.
const PROBES: usize = 48;
/// Notches this near to each other, as a share of the rim, meet.
const NEAR: f64 = 0.08;
/// More rims than this are not compared with one another.
const MOST_RIMS: usize = 400;

/// Runs for what is still open. `sewn_to` has for each edge its partner, if it has one.
pub fn runs(edges: &Edges, sewn_to: &[Option<usize>]) -> Vec<Run> {
    let rims = rims(edges, sewn_to);
    if rims.len() > MOST_RIMS {
        return Vec::new();
    }
    let mut pairs = Vec::new();
    for a in 0..rims.len() {
        for b in 0..rims.len() {
            // The longer chain of edges first: the armhole before the cap.
            let is_garment = |rim: usize| rims[rim].is_sewn && rims[rim].image != Some(a + b - rim);
            if rims[a].piece != rims[b].piece
                && is_garment(a)
                && is_garment(b)
                && (rims[a].edges.len(), b) > (rims[b].edges.len(), a)
            {
                let run = joined(edges, &rims, a, b);
                if run.score >= LEAST {
                    pairs.push((run, [a, b]));
                }
            }
        }
    }
    pairs.sort_by(|(p, i), (q, j)| q.score.total_cmp(&p.score).then(i.cmp(j)));
    let mut used = vec![false; rims.len()];
    // Pieces meet in one line: with a second they would close to a tyre, as a cuff sewn to both ends of its sleeve.
    let mut joined_pieces = UnionFind::new(edges.ids.iter().map(|id| id.panel + 1).max().unwrap_or(0));
    let mut runs = Vec::new();
    for (run, [a, b]) in pairs {
        if used[a] || used[b] || joined_pieces.find(rims[a].piece) == joined_pieces.find(rims[b].piece) {
            continue;
        }
        // Both sides of the garment at once.
        let image = match (rims[a].image, rims[b].image) {
            (Some(p), Some(q)) if p != a && q != b && !used[p] && !used[q] => Some([p, q]),
            _ => None,
        };
        let score = run.score;
        runs.push(run);
        (used[a], used[b]) = (true, true);
        joined_pieces.union(rims[a].piece, rims[b].piece);
        if let Some([p, q]) =
            image.filter(|&[p, q]| joined_pieces.find(rims[p].piece) != joined_pieces.find(rims[q].piece))
        {
            joined_pieces.union(rims[p].piece, rims[q].piece);
            runs.push(Run { score, ..joined(edges, &rims, p, q) });
            (used[p], used[q]) = (true, true);
        }
    }
    runs
}

fn rims(edges: &Edges, sewn_to: &[Option<usize>]) -> Vec<Rim> {
    let count = edges.ids.len();
    let next = |edge: usize| edges.beside(edge)[usize::from(!edges.is_clockwise(edge))];
    let mut pieces = UnionFind::new(edges.ids.iter().map(|id| id.panel + 1).max().unwrap_or(0));
    for (edge, partner) in sewn_to.iter().enumerate() {
        if let Some(partner) = partner {
            pieces.union(edges.ids[edge].panel as u32, edges.ids[*partner].panel as u32);
        }
    }
    let mut rim_of = vec![usize::MAX; count];
    let mut rims: Vec<Rim> = Vec::new();
    for first in 0..count {
        if sewn_to[first].is_some() || rim_of[first] != usize::MAX {
            continue;
        }
        let mut line = Vec::new();
        let mut edge = first;
        while rim_of[edge] == usize::MAX {
            rim_of[edge] = rims.len();
            line.push(edge);
            edge = next(edge);
            let mut steps = 0;
            while let Some(partner) = sewn_to[edge] {
                edge = next(partner);
                steps += 1;
                if steps > count {
                    return Vec::new();
                }
            }
        }
        let panel = edges.ids[first].panel;
        let mut rim = Rim::new(edges, line, pieces.find(panel as u32));
        rim.is_sewn = (0..count).any(|edge| edges.ids[edge].panel == panel && sewn_to[edge].is_some());
        rims.push(rim);
    }
    for k in 0..rims.len() {
        let images: Option<Vec<usize>> = rims[k].edges.iter().map(|&e| edges.mirror(e).map(|m| rim_of[m])).collect();
        rims[k].image = images.and_then(|images| {
            let there = images[0];
            let whole = there != usize::MAX && images.iter().all(|&rim| rim == there);
            (whole && rims[there].edges.len() == images.len()).then_some(there)
        });
    }
    rims
}

impl Rim {
    fn new(edges: &Edges, line: Vec<usize>, piece: u32) -> Self {
        let length: f64 = line.iter().map(|&e| edges.length(e)).sum();
        let mean = |of: &dyn Fn(usize) -> f64| line.iter().map(|&e| of(e) * edges.length(e)).sum::<f64>() / length;
        let (bulge, up) = (mean(&|e| edges.bulge(e)), mean(&|e| edges.outwards(e).y));
        let (mut at, mut notches) = (0.0, Vec::new());
        for &e in &line {
            let walked = |fraction: f64| if edges.is_clockwise(e) { 1.0 - fraction } else { fraction };
            notches.extend(
                edges.notches_of(e).iter().map(|&(f, kind)| ((at + walked(f) * edges.length(e)) / length, kind)),
            );
            at += edges.length(e);
        }
        Self { edges: line, length, piece, image: None, is_sewn: true, bulge, up, notches }
    }

    /// Where each edge starts, as a share.
    fn starts(&self, edges: &Edges) -> Vec<f64> {
        let mut at = 0.0;
        let start = |&edge: &usize| {
            let start = at / self.length;
            at += edges.length(edge);
            start
        };
        self.edges.iter().map(start).collect()
    }

    /// The heights of its points in the drawing, from the mean of each panel's, m.
    fn heights(&self, edges: &Edges) -> Vec<f64> {
        let starts = self.starts(edges);
        let mut heights = Vec::with_capacity(PROBES);
        let mut panels = Vec::with_capacity(PROBES);
        for k in 0..PROBES {
            let at = (k as f64 + 0.5) / PROBES as f64;
            let n = starts.partition_point(|&start| start <= at).max(1) - 1;
            let edge = self.edges[n];
            let share = (at - starts[n]) * self.length / edges.length(edge).max(f64::MIN_POSITIVE);
            let share = if edges.is_clockwise(edge) { 1.0 - share } else { share };
            heights.push(edges.height(edge, share.clamp(0.0, 1.0)));
            panels.push(edges.ids[edge].panel);
        }
        let mut means = std::collections::BTreeMap::new();
        for (panel, height) in panels.iter().zip(&heights) {
            let (sum, count) = means.entry(*panel).or_insert((0.0, 0.0));
            (*sum, *count) = (*sum + height, *count + 1.0);
        }
        panels.iter().zip(&heights).map(|(panel, height)| height - means[panel].0 / means[panel].1).collect()
    }

    /// Is the corner where an edge starts in the middle of the garment?
    fn is_middle(&self, edges: &Edges, start: usize) -> bool {
        let before = self.edges[(start + self.edges.len() - 1) % self.edges.len()];
        edges.mirror(before) == Some(self.edges[start])
    }
}

/// How well two rims go together, and from which corners.
fn joined(edges: &Edges, rims: &[Rim], a: usize, b: usize) -> Run {
    let (p, q) = (&rims[a], &rims[b]);
    let mut reasons = Vec::new();
    let ratio = p.length.min(q.length) / p.length.max(q.length);
    let mut score = match ratio {
        r if r > 0.985 => 2.0,
        r if r > 0.95 => 1.3,
        r if r > 0.88 => 0.4,
        r if r > 0.75 => -0.8,
        _ => -9.0,
    };
    reasons.push(match ratio {
        r if r > 0.985 => "lines of equal lengths".to_owned(),
        r => format!("lines, {:.0} % longer on one side", 100.0 * (1.0 / r - 1.0)),
    });
    // Names of what is sewn, by lengths.
    let mut named = 0.0;
    for &e in &p.edges {
        for &f in &q.edges {
            let share = edges.length(e) * edges.length(f) / (p.length * q.length);
            named += share * crate::pattern::names::together(&edges.role(e), &edges.role(f));
        }
    }
    score += 0.8 * named;
    let is_band =
        |image: usize, rim: usize| image != rim && rims[image].piece == rims[rim].piece && rims[rim].edges.len() == 1;
    match (p.image, q.image) {
        // A band is its own image in two ways.
        (Some(i), Some(j)) if (i == a) != (j == b) && !(is_band(i, a) || is_band(j, b)) => score -= 4.0,
        (Some(i), Some(j)) if (i == a) == (j == b) => {
            score += 0.7;
            reasons.push("symmetry".to_owned());
        }
        _ => {}
    }
    if p.bulge < -0.05 && q.bulge < -0.05 || p.up * q.up > 0.4 {
        score -= 4.0;
    }
    if p.bulge * q.bulge < -0.01 {
        score += 0.7;
        reasons.push("one bulges in, the other out".to_owned());
    }
    let mut best = (f64::NEG_INFINITY, 0, 0);
    let heights = [p, q].map(|rim| rim.heights(edges));
    for (i, from) in p.starts(edges).into_iter().enumerate() {
        for (j, to) in q.starts(edges).into_iter().enumerate() {
            let notches = notches(p, q, from, to);
            let middle = f64::from(u8::from(p.is_middle(edges, i) && q.is_middle(edges, j)));
            let fit = likeness(&heights, from, to) + notches + 0.5 * middle;
            if fit > best.0 + 1e-9 {
                best = (fit, i, j);
            }
        }
    }
    let (fit, i, j) = best;
    score += fit;
    if fit > 1.2 {
        reasons.push("notches or forms".to_owned());
    }
    let forward: Vec<usize> = (0..p.edges.len()).map(|k| p.edges[(i + k) % p.edges.len()]).collect();
    let backward: Vec<usize> = (1..=q.edges.len()).map(|k| q.edges[(j + q.edges.len() - k) % q.edges.len()]).collect();
    Run { sides: [forward, backward], score, reasons }
}

/// How alike the heights of two rims are, from -1 to 1, the first walked from a share, the second back from one; 0 where flat.
fn likeness([p, q]: &[Vec<f64>; 2], from: f64, to: f64) -> f64 {
    /// Rims flatter than this have no top and bottom, m.
    const FLAT: f64 = 0.02;
    let at = |heights: &[f64], share: f64| heights[((share.rem_euclid(1.0)) * PROBES as f64) as usize % PROBES];
    let (mut product, mut squares) = (0.0, [0.0; 2]);
    for k in 0..PROBES {
        let t = (k as f64 + 0.5) / PROBES as f64;
        let (x, y) = (at(p, from + t), at(q, to - t));
        product += x * y;
        squares = [squares[0] + x * x, squares[1] + y * y];
    }
    let flat = squares.iter().any(|square| square / (PROBES as f64) < FLAT * FLAT);
    if flat { 0.0 } else { product / (squares[0] * squares[1]).sqrt() }
}

/// What notches say: 1.5 where all meet one of their kind, less than nothing where none does.
fn notches(p: &Rim, q: &Rim, from: f64, to: f64) -> f64 {
    if p.notches.is_empty() || q.notches.is_empty() {
        return 0.0;
    }
    let meets = |(f, kind): &&(f64, NotchKind)| {
        q.notches.iter().any(|(g, other)| {
            let off = ((f - from) - (to - g)).rem_euclid(1.0);
            kind == other && off.min(1.0 - off) < NEAR
        })
    };
    let share = p.notches.iter().filter(meets).count() as f64 / p.notches.len().max(q.notches.len()) as f64;
    2.0 * share - 0.5
}
