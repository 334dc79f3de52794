//! Which ends of the seams meet: found for all seams together.
//!
//! Every panel has its right side up or is turned over (one bit for each), and where all seams join right side to right
//! side along one outside, these bits say for every seam which ends meet: opposite ways along two outlines that run
//! around their panels in the same sense. A side of several stretches adds a bit, the way along it. Of all choices
//! the one is taken that costs least: what speaks against each way of sewing each seam (`evidence`), and every corner
//! that is sewn to a corner it would not be sewn to otherwise. The latter is Euler's characteristic: with seams that cross,
//! the same panels and seams make a surface with fewer corners, that is with more handles. Few panels are tried in all ways; many start
//! from a spanning tree of the clearest seams and are improved one and two at a time.

use super::evidence::{SidePath, Travelled, cost};
use super::{Measured, SeamPlan, Stretch};
use crate::geometry::UnionFind;
use crate::pattern::inside::shown_from_inside;
use crate::pattern::{Pattern, Sense};
use crate::{Code, Warning};
use std::collections::BTreeMap;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Directions {
    /// Per panel: is its right side the side that was taken for the wrong one?
    pub turned: Vec<bool>,
    /// Per plan: is the first side travelled against the outlines of its panels, right side up?
    pub backward: Vec<bool>,
    /// Per plan: does it fold one panel over the other, stated so or forced to?
    pub folded: Vec<bool>,
    /// Stated directions that contradict one another, and seams that look twisted.
    pub warnings: Vec<Warning>,
}

impl Directions {
    /// The ways along the stretches of both sides of a plan.
    pub(super) fn travelled<'a>(&self, index: usize, plan: &'a SeamPlan) -> [Vec<Travelled<'a>>; 2] {
        travelled(plan, self.backward[index], self.folded[index], &|panel| self.turned[panel])
    }

    /// How the outlines, as they are drawn, run along a plan that sews one stretch to one.
    pub fn sense(&self, index: usize, plan: &SeamPlan) -> Sense {
        let [a, b] = self.travelled(index, plan).map(|side| side[0].forward);
        if a == b { Sense::Aligned } else { Sense::Opposed }
    }
}

/// What every needless loss of a corner costs: a handle costs two, more than notches that do not match.
const LOST_CORNER: f64 = 1.0;
/// What contradicting a stated direction costs: more than everything else.
const STATED: f64 = 1000.0;
/// What turning a panel over costs: panels are drawn right side up, unless names or much else speak against it.
const TURNED: f64 = 0.3;
/// Of as many bits all choices are tried.
const MOST_BITS_TRIED: usize = 11;
/// A seam looks twisted if the other way would cost so much less.
const TWISTED: f64 = 1.5;

/// Finds directions for plans whose parts do not overlap.
pub fn find_directions(pattern: &Pattern, plans: &[SeamPlan]) -> Directions {
    let measured = Measured::new(pattern);
    let mut problem = Problem::new(pattern, plans, &measured);
    let mut bits = vec![false; pattern.panels.len() + plans.len()];
    for component in problem.components() {
        problem.solve(&component, &mut bits);
        problem.choose_outside(&component, &mut bits);
    }
    let (turned, backward) = bits.split_at(pattern.panels.len());
    let mut found = Directions {
        turned: turned.to_vec(),
        backward: backward.to_vec(),
        folded: plans.iter().map(|plan| plan.right_wrong).collect(),
        warnings: Vec::new(),
    };
    for (index, plan) in plans.iter().enumerate() {
        problem.judge(index, plan, &bits, &mut found);
    }
    found
}

fn travelled<'a>(
    plan: &'a SeamPlan,
    backward: bool,
    folded: bool,
    turned: &dyn Fn(usize) -> bool,
) -> [Vec<Travelled<'a>>; 2] {
    let side = |k: usize| {
        // Along one outside, the two sides of a seam run opposite ways around their panels.
        let way = backward ^ (k == 1 && !folded);
        let travelled = |stretch: &'a Stretch| Travelled { stretch, forward: !(turned(stretch.panel) ^ way) };
        plan.sides[k].iter().map(travelled).collect()
    };
    [side(0), side(1)]
}

/// What one way of sewing one seam costs, and the corners that it joins.
type Way = (f64, Vec<[u32; 2]>);

struct Problem<'a> {
    pattern: &'a Pattern,
    plans: &'a [SeamPlan],
    measured: &'a Measured,
    /// Per panel: do names say that its wrong side is drawn?
    from_inside: Vec<bool>,
    /// Per plan: its ways by the turns of its stretches' panels and its own bit.
    ways: Vec<BTreeMap<u64, Way>>,
    /// Per panel: number of its first corner.
    first_corner: Vec<u32>,
    corners: usize,
}

/// Panels that hang together and the plans between them.
struct Component {
    panels: Vec<usize>,
    plans: Vec<usize>,
}

impl<'a> Problem<'a> {
    fn new(pattern: &'a Pattern, plans: &'a [SeamPlan], measured: &'a Measured) -> Self {
        let mut corners = 0;
        let first_corner = pattern.panels.iter().map(|panel| {
            corners += panel.segments.len();
            (corners - panel.segments.len()) as u32
        });
        let first_corner = first_corner.collect();
        let from_inside = shown_from_inside(pattern);
        Self { pattern, plans, measured, from_inside, ways: vec![BTreeMap::new(); plans.len()], first_corner, corners }
    }

    fn components(&self) -> Vec<Component> {
        let mut sets = UnionFind::new(self.pattern.panels.len());
        let first = |plan: &SeamPlan| plan.sides[0][0].panel as u32;
        for plan in self.plans {
            plan.sides.iter().flatten().for_each(|stretch| sets.union(first(plan), stretch.panel as u32));
        }
        let mut components: BTreeMap<u32, Component> = BTreeMap::new();
        for panel in 0..self.pattern.panels.len() {
            let entry = components.entry(sets.find(panel as u32));
            entry.or_insert_with(|| Component { panels: Vec::new(), plans: Vec::new() }).panels.push(panel);
        }
        for (index, plan) in self.plans.iter().enumerate() {
            let of = sets.find(first(plan));
            components.get_mut(&of).expect("every panel is in a component").plans.push(index);
        }
        components.into_values().collect()
    }

    /// The bits on which a plan depends.
    fn key(&self, index: usize, bits: &[bool]) -> u64 {
        let plan = &self.plans[index];
        let own = bits[self.pattern.panels.len() + index];
        let panels = plan.sides.iter().flatten().map(|stretch| bits[stretch.panel]);
        std::iter::once(own).chain(panels).take(64).enumerate().fold(0, |key, (k, bit)| key | u64::from(bit) << k)
    }

    fn way(&mut self, index: usize, bits: &[bool]) -> &Way {
        let key = self.key(index, bits);
        if !self.ways[index].contains_key(&key) {
            let way = self.compute(index, bits, self.plans[index].right_wrong);
            self.ways[index].insert(key, way);
        }
        &self.ways[index][&key]
    }

    fn compute(&self, index: usize, bits: &[bool], folded: bool) -> Way {
        let plan = &self.plans[index];
        let own = bits[self.pattern.panels.len() + index];
        let sides = travelled(plan, own, folded, &|panel| bits[panel]);
        let mut joined = Vec::new();
        let paths = sides.each_ref().map(|side| SidePath::new(side, self.measured));
        let mut against = cost(self.pattern, self.measured, plan, [&paths[0], &paths[1]]);
        if let Some(stated) = plan.direction {
            let [a, b] = [sides[0][0].forward, sides[1][0].forward];
            let found = if a == b { Sense::Aligned } else { Sense::Opposed };
            against += if found == stated { 0.0 } else { STATED };
        }
        let corners = paths.each_ref().map(|path| self.corners_along(path));
        // Ends meet, and so do corners on the way that lie beside each other.
        const BESIDE: f64 = 0.02;
        for &(f, a) in &corners[0] {
            for &(g, b) in &corners[1] {
                if (f - g).abs() < BESIDE && a != b {
                    joined.push([a, b]);
                }
            }
        }
        // Where one stretch ends on a side, the next begins.
        for side in &corners {
            for pair in side.windows(2) {
                if pair[1].0 - pair[0].0 < 1e-9 && pair[0].1 != pair[1].1 {
                    joined.push([pair[0].1, pair[1].1]);
                }
            }
        }
        (against, joined)
    }

    /// The corners of the panels along a side, by the fraction of its length.
    fn corners_along(&self, path: &SidePath) -> Vec<(f64, u32)> {
        let corner = |panel: usize, k: usize| {
            let count = self.pattern.panels[panel].segments.len();
            self.first_corner[panel] + (k % count) as u32
        };
        let mut along = Vec::new();
        for (k, (part, forward)) in path.parts.iter().enumerate() {
            let start = if k == 0 { 0.0 } else { path.ends[k - 1] } / path.length();
            let end = path.ends[k] / path.length();
            let (low, high) = if *forward { (start, end) } else { (end, start) };
            let mut both = Vec::new();
            if part.from == 0.0 {
                both.push((low, corner(part.id.panel, part.id.segment)));
            }
            if part.to == 1.0 {
                both.push((high, corner(part.id.panel, part.id.segment + 1)));
            }
            both.sort_by(|a, b| a.0.total_cmp(&b.0));
            along.extend(both);
        }
        along
    }

    fn total(&mut self, component: &Component, bits: &[bool]) -> f64 {
        let mut sets = UnionFind::new(self.corners);
        let mut sum = 0.0;
        let mut lost = 0;
        for &index in &component.plans {
            let (against, joined) = self.way(index, bits);
            sum += against;
            for &[a, b] in joined {
                if sets.find(a) != sets.find(b) {
                    sets.union(a, b);
                    lost += 1;
                }
            }
        }
        let turned = component.panels.iter().filter(|&&panel| bits[panel] != self.from_inside[panel]).count();
        // All turned is none turned.
        let turned = turned.min(component.panels.len() - turned);
        sum + LOST_CORNER * f64::from(lost) + TURNED * turned as f64
    }

    /// Sets the bits of a component, the first panel as drawn.
    fn solve(&mut self, component: &Component, bits: &mut [bool]) {
        let panels = self.pattern.panels.len();
        let several = |plan: &SeamPlan| plan.sides.iter().any(|side| side.len() > 1);
        let free: Vec<usize> = component.panels[1..]
            .iter()
            .copied()
            .chain(component.plans.iter().filter(|&&p| several(&self.plans[p])).map(|&p| panels + p))
            .collect();
        if free.len() <= MOST_BITS_TRIED {
            let mut best = (f64::INFINITY, 0u32);
            for choice in 0..1u32 << free.len() {
                free.iter().enumerate().for_each(|(k, &bit)| bits[bit] = choice >> k & 1 == 1);
                let total = self.total(component, bits);
                if total < best.0 - 1e-9 {
                    best = (total, choice);
                }
            }
            free.iter().enumerate().for_each(|(k, &bit)| bits[bit] = best.1 >> k & 1 == 1);
        } else {
            self.grow(component, bits);
            self.improve(component, &free, bits);
        }
    }

    /// Turns panels along the clearest seams first: a spanning tree of the panels.
    fn grow(&mut self, component: &Component, bits: &mut [bool]) {
        // Per pair of panels, how much more it costs that one of them is turned.
        let mut between: BTreeMap<[usize; 2], f64> = BTreeMap::new();
        for &index in &component.plans {
            let [a, b] = self.plans[index].sides.each_ref().map(|side| side[0].panel);
            if a != b {
                bits[a] = false;
                bits[b] = false;
                let same = self.way(index, bits).0;
                bits[b] = true;
                let other = self.way(index, bits).0;
                bits[b] = false;
                *between.entry([a.min(b), a.max(b)]).or_default() += other - same;
            }
        }
        let mut pairs: Vec<([usize; 2], f64)> = between.into_iter().collect();
        pairs.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
        let mut group: BTreeMap<usize, usize> = component.panels.iter().map(|&p| (p, p)).collect();
        for ([a, b], more) in pairs {
            let (of_a, of_b) = (group[&a], group[&b]);
            if of_a == of_b {
                continue;
            }
            let turn = (bits[a] ^ bits[b]) != (more < 0.0);
            for (&panel, of) in group.iter_mut().filter(|(_, of)| **of == of_b) {
                *of = of_a;
                bits[panel] ^= turn;
            }
        }
        if bits[component.panels[0]] {
            component.panels.iter().for_each(|&panel| bits[panel] ^= true);
        }
    }

    /// Changes one or two bits at a time as long as it helps.
    fn improve(&mut self, component: &Component, free: &[usize], bits: &mut [bool]) {
        /// Rounds, so that large patterns end too.
        const MOST_ROUNDS: usize = 20;
        /// With more bits than this, pairs would take long.
        const MOST_FOR_PAIRS: usize = 40;
        let mut best = self.total(component, bits);
        for _ in 0..MOST_ROUNDS {
            let before = best;
            for (k, &a) in free.iter().enumerate() {
                let partners = if free.len() <= MOST_FOR_PAIRS { &free[k + 1..] } else { &[] };
                for b in std::iter::once(None).chain(partners.iter().map(Some)) {
                    bits[a] ^= true;
                    if let Some(&b) = b {
                        bits[b] ^= true;
                    }
                    let total = self.total(component, bits);
                    if total < best - 1e-9 {
                        best = total;
                    } else {
                        bits[a] ^= true;
                        if let Some(&b) = b {
                            bits[b] ^= true;
                        }
                    }
                }
            }
            if best >= before - 1e-9 {
                break;
            }
        }
    }

    /// All panels of a component may be turned together: the right sides face away from the middle where they have
    /// places, or else as many as possible are as drawn.
    fn choose_outside(&mut self, component: &Component, bits: &mut [bool]) {
        let panels = || component.panels.iter().map(|&p| (p, &self.pattern.panels[p]));
        let sign = |panel: usize| if bits[panel] != self.from_inside[panel] { -1.0 } else { 1.0 };
        let facing: f64 = if panels().all(|(_, panel)| panel.placement.is_some()) {
            let center = |panel: &crate::pattern::Panel| {
                let corners: Vec<_> = panel.corners().collect();
                let mean = corners.iter().fold(crate::geometry::Vector2::zeros(), |s, c| s + c) / corners.len() as f64;
                panel.place(mean)
            };
            let area: f64 = panels().map(|(_, p)| p.signed_area().abs()).sum();
            let middle = panels()
                .fold(crate::geometry::Vector3::zeros(), |s, (_, p)| s + center(p) * (p.signed_area().abs() / area));
            panels().map(|(k, p)| sign(k) * p.signed_area().abs() * p.outward_normal().dot(&(center(p) - middle))).sum()
        } else {
            panels().map(|(k, p)| sign(k) * p.signed_area().abs()).sum()
        };
        if facing < 0.0 {
            let panel_count = self.pattern.panels.len();
            component.panels.iter().for_each(|&panel| bits[panel] ^= true);
            component.plans.iter().for_each(|&plan| bits[panel_count + plan] ^= true);
        }
    }

    /// Is a seam contradicted or twisted?
    fn judge(&mut self, index: usize, plan: &SeamPlan, bits: &[bool], found: &mut Directions) {
        let own = self.way(index, bits).0;
        let other = self.compute(index, bits, !plan.right_wrong).0;
        if own >= STATED {
            let way = if plan.direction == Some(Sense::Opposed) { "opposed" } else { "aligned" };
            found.folded[index] = !plan.right_wrong;
            found.warnings.push(Warning(plan.complain(
                format!("Its direction is stated as \"{way}\", which contradicts the other seams: sewn so, the right side of the fabric meets the wrong side."),
                "Leave `direction` out and it is found; or write `right_wrong = true` if the one panel is to be folded over the other. It is sewn as stated.",
            )
            .coded(Code::DirectionContradicted)));
        } else if plan.direction.is_none() && own - other > TWISTED {
            found.warnings.push(Warning(plan.complain(
                "It looks twisted: its ends would fit better the other way, but then the right side of the fabric would meet the wrong side.",
                "Look whether it sews the right edges (`toile seams show`); if one panel is to be folded over the other, write `right_wrong = true`.",
            )
            .coded(Code::SeamTwisted)));
        }
    }
}
