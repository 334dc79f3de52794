//! What drawings say that have no place around a body: they stand upright, right side up, and are alike on both sides.

use super::score::{Edges, Scored};
use crate::pattern::names::{Part, together};

/// A seam in the middle of front or back leans by less: the outside of its edges points aside by at least this share.
const UPRIGHT: f64 = 0.7;

impl Edges<'_> {
    /// Drawings stand upright, and garments are alike on both sides.
    pub fn drawn(&self, made: &mut Scored) {
        /// Never.
        const NOT: f64 = -9.0;
        /// What an edge whose outside points up, down or aside at least has there.
        const MOSTLY: f64 = 0.8;
        /// Concave by more than a waist or an inner leg: armholes, necklines.
        const SCOOPED: f64 = -0.12;
        /// Lengths that differ by more are no evidence, unless names go together so well.
        const ALIKE: f64 = 0.9;
        const KNOWN: f64 = 0.9;
        /// Equal lengths of mirror images are no evidence.
        const IMAGES: f64 = -1.2;
        let (a, b) = (made.a, made.b);
        let (panel_a, panel_b) = (self.ids[a].panel, self.ids[b].panel);
        let [out_a, out_b] = [a, b].map(|edge| self.outwards(edge));
        if self.mirror(a).is_some_and(|image| self.ids[image].panel == panel_b) {
            let limb = matches!(self.part(a), Some(Part::Sleeve | Part::Cuff));
            let center = self.mirror(a) == Some(b) && out_a.x.abs() > UPRIGHT && !limb;
            // The seam is long; below it there may be a vent.
            let share = 2.0 * self.length(a) / self.pattern.panels[panel_a].perimeter();
            made.score = if center && !self.is_band(panel_a) { made.score + IMAGES + share } else { NOT };
            made.reasons = vec!["the middle between a panel and its mirror image".to_owned()];
            return;
        }
        // What is gathered is told by its name, or runs along several edges.
        let lengths = [a, b].map(|edge| self.length(edge));
        let together = together(&self.role(a), &self.role(b));
        if lengths[0].min(lengths[1]) < ALIKE * lengths[0].max(lengths[1]) && together < KNOWN {
            made.score -= 4.0;
        }
        let part = self.part(a);
        // Sleeves and hoods are drawn in any way.
        if !self.same_part(a, b) || matches!(part, Some(Part::Sleeve | Part::Cuff | Part::Hood | Part::Collar)) {
            return;
        }
        let is_middle = |edge: usize| self.mirror(edge) == Some(edge);
        let hems = out_a.y < -MOSTLY && out_b.y < -MOSTLY;
        let scooped = self.bulge(a) < SCOOPED && self.bulge(b) < SCOOPED;
        if is_middle(a) && is_middle(b) || hems || scooped || out_a.y * out_b.y < -0.5 {
            made.score = NOT;
            return;
        }
        made.is_upper = out_a.y > MOSTLY && out_b.y > MOSTLY;
        if self.faces_differ(made) {
            // Seen from outside, a front's left is sewn to a back's right.
            made.score += if out_a.x * out_b.x < 0.0 { 0.5 } else { -3.0 };
        }
    }

    /// A strip: four edges, two of them several times as long as the others.
    pub fn is_band(&self, panel: usize) -> bool {
        const LONG: f64 = 2.4;
        let lengths: Vec<f64> =
            (0..self.ids.len()).filter(|&e| self.ids[e].panel == panel).map(|e| self.length(e)).collect();
        let (low, high) = lengths.iter().fold((f64::INFINITY, 0.0f64), |(l, h), &x| (l.min(x), h.max(x)));
        lengths.len() == 4 && high > LONG * low
    }
}
