//! Which part of the body comes out of which opening.
//!
//! The sewn garment tells it nearly without words: its openings are as many as the body has parts to let out, arms and legs
//! come in pairs of equal openings, and the hem is farthest from the sleeves. A skirt has two openings, trousers three, a shirt
//! four, a suit of both five. Names decide where this is not enough.

use super::names::{Hints, Zone};
use super::surface::Surface;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    Neck,
    /// A cuff, or the armhole where there is no sleeve; 0 at the body's left.
    Arm(usize),
    Leg(usize),
    /// The upper edge of what has no sleeves: a waist, a strapless top.
    Top,
    Hem,
    /// Neck and hem in one line, of what is open at the front.
    Open,
}

/// Rims shorter than this let no part of the body out, m.
const SHORTEST: f64 = 0.12;
/// Left and right differ by no more than this share.
const ALIKE: f64 = 0.06;
/// Rims that are looked at, the longest of a piece.
const MOST_RIMS: usize = 8;
/// An open front makes its line longer than the cuffs by more than this factor; a waist is shorter.
const OPEN_FRONT: f64 = 4.5;
/// How far from the sleeves, m, a metre of length more makes a rim look, if it is to be told neck from hem.
const HEM_IS_LONGER: f64 = 0.5;

/// The openings of a piece, by rim; none where the seams leave it open and the names do too.
pub fn openings(surface: &Surface, hints: &[Hints], piece: usize) -> Vec<(usize, Opening)> {
    let mut rims: Vec<usize> = (0..surface.rims.len())
        .filter(|&r| surface.rims[r].piece == piece && surface.rims[r].length > SHORTEST)
        .collect();
    rims.sort_by(|&a, &b| surface.rims[b].length.total_cmp(&surface.rims[a].length));
    rims.truncate(MOST_RIMS);
    let known = Known { surface, hints };
    match rims.len() {
        0 | 1 => Vec::new(),
        2 => known.of_tube([rims[0], rims[1]]),
        _ => known.of_branches(&rims),
    }
}

struct Known<'a> {
    surface: &'a Surface,
    hints: &'a [Hints],
}

impl Known<'_> {
    /// How much of a rim runs along panels of these zones.
    fn share(&self, rim: usize, zones: &[Zone]) -> f64 {
        let rim = &self.surface.rims[rim];
        let is = |panel: usize| self.hints[panel].zone.is_some_and(|zone| zones.contains(&zone));
        rim.panels.iter().filter(|(panel, _)| is(*panel)).map(|(_, length)| length).sum::<f64>() / rim.length
    }

    /// At which side the names have a rim: from -1, right, to 1, left.
    fn side(&self, rim: usize) -> f64 {
        let rim = &self.surface.rims[rim];
        rim.panels.iter().map(|&(panel, length)| self.hints[panel].left.unwrap_or(0.0) * length).sum::<f64>()
            / rim.length
    }

    fn length(&self, rim: usize) -> f64 {
        self.surface.rims[rim].length
    }

    /// How far two rims are apart along the cloth, m.
    pub fn apart(&self, a: usize, b: usize) -> f64 {
        let distances = self.surface.distances(self.surface.rims[a].indices());
        self.surface.rims[b].indices().map(|p| distances[p as usize]).fold(f64::INFINITY, f64::min)
    }

    /// Skirts and strapless tops.
    fn of_tube(&self, [longer, shorter]: [usize; 2]) -> Vec<(usize, Opening)> {
        // A top is held by its upper edge, a skirt by its waist, and both are the shorter one unless names know better.
        let upper = [Zone::Waistband, Zone::Neck, Zone::Head];
        let below = [Zone::Skirt, Zone::Leg];
        let votes = |rim: usize| self.share(rim, &upper) - self.share(rim, &below);
        let torso = [Zone::Torso];
        // A waistband under a bodice is its lower edge.
        let bodice = self.share(longer, &torso) + self.share(shorter, &torso) > 0.5;
        let (mut first, mut second) = (votes(longer), votes(shorter));
        if bodice {
            (first, second) = (self.share(longer, &torso), self.share(shorter, &torso));
        }
        match first > second + 0.1 {
            true => vec![(longer, Opening::Top), (shorter, Opening::Hem)],
            false => vec![(shorter, Opening::Top), (longer, Opening::Hem)],
        }
    }

    fn of_branches(&self, rims: &[usize]) -> Vec<(usize, Opening)> {
        let mut pairs = Vec::new();
        for (k, &a) in rims.iter().enumerate() {
            for &b in &rims[k + 1..] {
                let opposite = self.side(a) * self.side(b) < 0.5;
                if self.length(b) > self.length(a) * (1.0 - ALIKE) && opposite {
                    pairs.push([a, b]);
                }
            }
        }
        let mut best: Option<(f64, Vec<(usize, Opening)>)> = None;
        let none = [None];
        let choices = || pairs.iter().copied().map(Some).chain(none);
        for arms in choices() {
            for legs in choices() {
                let taken: Vec<usize> = arms.iter().chain(&legs).flatten().copied().collect();
                let rest: Vec<usize> = rims.iter().copied().filter(|rim| !taken.contains(rim)).collect();
                if taken.is_empty() || rest.is_empty() || rims.len() - rest.len() != taken.len() {
                    continue;
                }
                let score = self.score(arms, legs, &rest);
                if best.as_ref().is_none_or(|(other, _)| score > *other) {
                    best = Some((score, self.labels(arms, legs, &rest)));
                }
            }
        }
        best.map_or_else(Vec::new, |(_, labels)| labels)
    }

    /// How well these pairs are arms and legs.
    fn score(&self, arms: Option<[usize; 2]>, legs: Option<[usize; 2]>, rest: &[usize]) -> f64 {
        let mut score = 0.0;
        for &rim in arms.iter().flatten() {
            score += self.share(rim, &[Zone::Arm]);
            score -= 2.0 * self.share(rim, &[Zone::Leg, Zone::Skirt, Zone::Waistband, Zone::Head]);
        }
        for &rim in legs.iter().flatten() {
            score += self.share(rim, &[Zone::Leg]);
            score -= 2.0 * self.share(rim, &[Zone::Arm, Zone::Torso, Zone::Neck, Zone::Head, Zone::Waistband]);
        }
        for pair in [arms, legs].into_iter().flatten() {
            // The more alike, the more a pair: other openings may be of nearly the same length.
            score -= (1.0 - self.length(pair[1]) / self.length(pair[0])) / ALIKE * 0.3;
        }
        let longest = rest.iter().map(|&rim| self.length(rim)).fold(0.0, f64::max);
        let expected = match (arms, legs) {
            (Some(arms), Some(legs)) => {
                score += 1.0;
                let far = |pair: [usize; 2]| pair.iter().map(|&rim| self.apart(rest[0], rim)).sum::<f64>();
                score += if far(legs) > far(arms) { 0.2 } else { -0.2 };
                1
            }
            (Some(pair), None) => {
                let open = rest.len() == 1;
                score += if !open || longest > OPEN_FRONT * self.length(pair[0]) { 0.5 } else { -0.5 };
                if open { 1 } else { 2 }
            }
            (None, Some(pair)) => {
                score += if rest.len() == 1 && longest < OPEN_FRONT * self.length(pair[0]) { 0.5 } else { -0.5 };
                1
            }
            (None, None) => 0,
        };
        score - 0.3 * rest.len().abs_diff(expected) as f64
    }

    fn labels(&self, arms: Option<[usize; 2]>, legs: Option<[usize; 2]>, rest: &[usize]) -> Vec<(usize, Opening)> {
        let mut labels = Vec::new();
        if let Some([a, b]) = arms {
            labels.extend([(a, Opening::Arm(0)), (b, Opening::Arm(1))]);
        }
        if let Some([a, b]) = legs {
            let crossed = arms.is_some_and(|[left, right]| {
                let names = self.side(left) * self.side(a) + self.side(right) * self.side(b);
                let ways = self.apart(left, a) + self.apart(right, b) - self.apart(left, b) - self.apart(right, a);
                if names.abs() > 0.1 { names < 0.0 } else { ways > 0.0 }
            });
            let sides = if crossed { [1, 0] } else { [0, 1] };
            labels.extend([(a, Opening::Leg(sides[0])), (b, Opening::Leg(sides[1]))]);
        }
        // Of what is left the neck is nearest to the arms and short, the hem farthest and long: cuffs of long sleeves are as far
        // from either.
        let away = |rim: usize| {
            let far = arms.iter().flatten().map(|&arm| self.apart(arm, rim)).sum::<f64>();
            far + HEM_IS_LONGER * self.length(rim) - self.share(rim, &[Zone::Neck, Zone::Head])
                + self.share(rim, &[Zone::Skirt, Zone::Waistband, Zone::Leg])
        };
        let mut rest: Vec<(f64, usize)> = rest.iter().map(|&rim| (away(rim), rim)).collect();
        rest.sort_by(|a, b| a.0.total_cmp(&b.0));
        match (arms, legs, rest.as_slice()) {
            (Some(_), Some(_), [(_, neck), ..]) => labels.push((*neck, Opening::Neck)),
            (Some(_), None, [(_, open)]) => labels.push((*open, Opening::Open)),
            (Some(_), None, [(_, neck), .., (_, hem)]) => labels.extend([(*neck, Opening::Neck), (*hem, Opening::Hem)]),
            (None, _, rest) => {
                let longest = rest.iter().max_by(|a, b| self.length(a.1).total_cmp(&self.length(b.1)));
                labels.extend(longest.map(|(_, rim)| (*rim, Opening::Top)));
            }
            _ => {}
        }
        labels
    }
}
