//! Openings: a body passes through what it wears, so that no part of a garment may be sewn up to a bag.
//!
//! Which seam closes a bag cannot be told while seams are taken: the caps of a sleeve's halves are as alike as the edges above and
//! under the arm, and whichever pair is taken, the others look the more certain for it. When all are taken, each part of the
//! garment is looked at as the surface that its own seams make ([`Surface::is_bag`]): a sleeve without what it is sewn into, a skirt
//! without its waistband. Of a bag the fewest seams that open it are given up, and of these the least certain: those of edges
//! that could be sewn to another part as well. They are not proposed again, and their edges are free for something else.

use super::score::Scored;
use super::{LEAST, Sewing};
use crate::pattern::names::Part;
use crate::pattern::sewing::{Directions, SeamPlan, find_directions};
use crate::pattern::surface::{Surface, pieces_of};
use crate::pattern::{Pattern, Seam};

impl Sewing<'_> {
    /// Of the seams that are taken, with their directions, those that are to be given up, by their places; none if nothing is a bag.
    pub(super) fn closing(&self, directions: &Directions) -> Vec<usize> {
        let pattern = self.edges.pattern;
        let sewn = self.sewn(directions);
        let mut given_up = Vec::new();
        for panels in self.groups() {
            for piece in pieces_of(&panels, &sewn) {
                given_up.extend(self.opening(pattern, &piece, &sewn));
            }
        }
        self.with_images(given_up)
    }

    /// Panels that a part of the body passes through: all of them, those of each part of the garment, and sleeves with their cuffs.
    fn groups(&self) -> Vec<Vec<usize>> {
        let panels = &self.edges.pattern.panels;
        let mut first = 0;
        let parts = panels.iter().map(|panel| {
            first += panel.segments.len();
            self.edges.part(first - 1)
        });
        let parts: Vec<Option<Part>> = parts.collect();
        let of = |group: &[Option<Part>]| (0..parts.len()).filter(|&panel| group.contains(&parts[panel])).collect();
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (panel, &part) in parts.iter().enumerate() {
            // A head stays in its hood, and collars lie open.
            if !parts[..panel].contains(&part) && !matches!(part, Some(Part::Hood | Part::Collar)) {
                groups.push(of(&[part]));
            }
        }
        groups.push(of(&[Some(Part::Sleeve), Some(Part::Cuff)]));
        groups.push((0..parts.len()).collect());
        groups
    }

    /// Which ends of what is taken meet.
    pub(super) fn directions(&self) -> Directions {
        find_directions(self.edges.pattern, &self.plans())
    }

    fn plans(&self) -> Vec<SeamPlan> {
        let sides = |seam: &Scored| [seam.a, seam.b].map(|edge| self.edges.ids[edge]);
        self.taken.iter().map(|(seam, _)| SeamPlan::whole("", sides(seam))).collect()
    }

    /// What is taken as seams of the pattern, in the same order.
    fn sewn(&self, found: &Directions) -> Vec<Seam> {
        let plans = self.plans();
        let seam = |(k, plan): (usize, &SeamPlan)| Seam {
            sides: plan.sides.each_ref().map(|side| side[0].parts()[0].id),
            sense: found.sense(k, plan),
        };
        plans.iter().enumerate().map(seam).collect()
    }

    /// Seams of a piece to be given up, if it is a bag: one that opens it, or two, or the one that is easiest to spare.
    fn opening(&self, pattern: &Pattern, piece: &[usize], sewn: &[Seam]) -> Vec<usize> {
        if !Surface::new(pattern, piece, sewn).is_bag(pattern) {
            return Vec::new();
        }
        let within = |seam: &Seam| seam.sides.iter().all(|side| piece.binary_search(&side.panel).is_ok());
        let mut own: Vec<(f64, usize)> =
            (0..sewn.len()).filter(|&k| within(&sewn[k])).map(|k| (self.loss(k), k)).collect();
        own.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let opens = |without: &[usize]| {
            let left: Vec<Seam> = (0..sewn.len()).filter(|k| !without.contains(k)).map(|k| sewn[k]).collect();
            pieces_of(piece, &left).iter().all(|piece| !Surface::new(pattern, piece, &left).is_bag(pattern))
        };
        if let Some((_, one)) = own.iter().find(|(_, k)| opens(&[*k])) {
            return vec![*one];
        }
        let pairs =
            own.iter().enumerate().flat_map(|(n, &(p, a))| own[n + 1..].iter().map(move |&(q, b)| (p + q, [a, b])));
        let mut pairs: Vec<(f64, [usize; 2])> = pairs.collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        match pairs.iter().find(|(_, pair)| opens(pair)) {
            Some((_, pair)) => pair.to_vec(),
            None => own.first().map(|(_, k)| *k).into_iter().collect(),
        }
    }

    /// What is lost with a taken seam, by what its edges say alone: less where one of them has another partner in another part.
    fn loss(&self, taken: usize) -> f64 {
        let seam = &self.taken[taken].0;
        let is_free = |edge: usize| self.sewn_to[edge].is_none();
        let other = self.candidates.iter().filter(|other| {
            let [a, b] = [other.a, other.b];
            let shared = [a, b].into_iter().find(|edge| [seam.a, seam.b].contains(edge));
            shared.is_some_and(|shared| is_free(a + b - shared) && !self.edges.same_part(a, b))
        });
        seam.score - other.map(|other| other.score).fold(LEAST, f64::max)
    }

    /// In drawings, seams come and go in mirror images.
    fn with_images(&self, mut seams: Vec<usize>) -> Vec<usize> {
        let image = |k: &usize| {
            let ends = [self.taken[*k].0.a, self.taken[*k].0.b].map(|edge| self.edges.mirror(edge));
            let [Some(a), Some(b)] = ends else { return None };
            self.taken.iter().position(|(seam, _)| [seam.a, seam.b] == [a.min(b), a.max(b)])
        };
        if self.edges.are_drawn() {
            let images: Vec<usize> = seams.iter().filter_map(image).collect();
            seams.extend(images);
        }
        seams.sort_unstable();
        seams.dedup();
        seams
    }
}
