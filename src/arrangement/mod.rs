//! Where the panels start: as the pattern places them, moved where the body is in the way.
//!
//! A seam closes along the straight lines between its stitches. Where such a line passes through
//! the body the seam cannot close, or closes on the wrong side of a limb: shoulders whose panels
//! start too low, sleeves that start beside their arm or at another angle. Each panel is therefore
//! moved, rigidly and as little as possible, until the lines of its stitches are as clear of the
//! body as they can be and no part of it starts inside (a pattern search; the automatic placement of
//! Le Thanh and Gagalowicz 2005 has the same aim). A search with more care also makes hems and cuffs face
//! what comes out of them.

mod motion;
mod openings;
pub mod placing;

use crate::body::{Body, DistanceField};
use crate::garment::{Level, PanelRange};
use crate::geometry::{BoxTree, EdgeTable, UnionFind, Vector3, triangle_distance};
use crate::pattern::Pattern;
use crate::{Code, Error};
use motion::Motion;
use nalgebra::Rotation3;
use openings::{Arc, Core, arcs};
use rayon::prelude::*;

/// What the search for first positions looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Care {
    /// The lines of the stitches: enough where a pattern was placed around its body.
    Seams,
    /// Besides, what hems and cuffs will be around; panels that lean are set upright. For those that start in the wrong
    /// places, at half as much time again.
    SeamsAndOpenings,
}

/// First positions, and how they differ from the pattern's own placement.
pub struct Arrangement {
    /// One per particle of the open level, m, world.
    pub positions: Vec<Vector3>,
    /// How far the middle of each panel was moved, m.
    pub shifts: Vec<Vector3>,
    /// How far above the places where they are worn the panels start, m.
    pub raised: f64,
}

/// Steps of the search, m, long to short.
const STEPS: [f64; 4] = [0.04, 0.02, 0.01, 0.005];
/// A turn by this, rad, goes with a step of one metre: 7 degrees with the longest.
const TURN: f64 = 3.0;
/// The farthest that a panel is moved, m: beyond it the garment was made for another body.
const FARTHEST: f64 = 0.16;
/// The farthest that it is turned, rad: arms of another pose than the pattern's.
const FARTHEST_TURN: f64 = 0.35;
/// Distance between samples along a stitch's line, m: finds a wrist.
const SIGHT_SPACING: f64 = 0.01;
/// Lines and panels should pass the body at least this far outside, m: the thickness of a seam.
const SIGHT_CLEARANCE: f64 = 0.005;
/// And if they can, this far, m: a tube that closes around a limb turns some way around it.
pub const SIGHT_MARGIN: f64 = 0.04;
/// What a line costs that passes the body at no distance, over one that passes inside it.
const MARGIN_PRICE: f64 = 0.3;
/// What a metre of shift costs, for each stitch, in metres of blocked line: panels move when that
/// clears at least this share of their stitches by as much as they move.
const SHIFT_PRICE: f64 = 0.03;
/// The same for a shift against the partner of a stitch.
const RELATIVE_PRICE: f64 = 0.06;
/// Panels whose outward normals have at least this product can lie over each other.
const FACING_ALIKE: f64 = 0.7;
/// What a stitch costs whose partner comes to lie behind its rim, per metre.
const OVERLAP_PRICE: f64 = 0.5;
/// What it costs, for each particle of a panel's part of an opening, and per metre, that the body is not ahead of it.
const OPENING_PRICE: f64 = 1.0;
/// The middle of the part and that of the limb may be this far apart, m.
const OPENING_SLACK: f64 = 0.015;
/// Panels are not moved nearer to each other than this, m.
const PANEL_CLEARANCE: f64 = 0.004;
/// How often all panels are visited at one step length.
const MOST_ROUNDS: usize = 8;
/// Where panels may move, besides along their own outward normal: up, down, sideways and aslant, as
/// arms hang.
const DIRECTIONS: [[f64; 3]; 8] = {
    const ASLANT: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [ASLANT, ASLANT, 0.0],
        [-ASLANT, ASLANT, 0.0],
        [ASLANT, -ASLANT, 0.0],
        [-ASLANT, -ASLANT, 0.0],
    ]
};

/// Particles of the open level where the pattern places its panels, m, world.
pub fn placed(pattern: &Pattern, open: &Level) -> Vec<Vector3> {
    let mut positions = Vec::with_capacity(open.rest.len());
    for (panel, range) in pattern.panels.iter().zip(&open.panels) {
        positions.extend(open.rest[range.points.clone()].iter().map(|&p| panel.place(p)));
    }
    positions
}

/// Has every panel a place around the body to start from?
pub fn check_placed(pattern: &Pattern) -> Result<(), Error> {
    let Some(lying) = pattern.panels.iter().find(|panel| panel.placement.is_none()) else { return Ok(()) };
    Err(Error::new(
        "It has no place around the body: drawings such as DXF and FreeSewing hold none.",
        "Have the panels placed by themselves: `--place auto`.",
    )
    .coded(Code::Unplaced)
    .within(format!("panel \"{}\"", lying.name)))
}

/// Was the pattern placed around this body? Panels may start a metre in front of it; their middle,
/// however, is where the body is.
pub fn check_placement(pattern: &Pattern, body: &Body) -> Result<(), Error> {
    check_placed(pattern)?;
    let (low, high) = body.bounds();
    let (mut middle, mut area) = (Vector3::zeros(), 0.0);
    let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
    for panel in &pattern.panels {
        let outline = panel.polygon(OUTLINE_POINTS);
        let points: Vec<Vector3> = outline.iter().map(|&p| panel.place(p)).collect();
        let weight = panel.signed_area().abs();
        middle += points.iter().sum::<Vector3>() * (weight / points.len() as f64);
        area += weight;
        lowest = points.iter().map(|p| p.y).fold(lowest, f64::min);
        highest = points.iter().map(|p| p.y).fold(highest, f64::max);
    }
    let aside = middle / area - (low + high) * 0.5;
    let aside = aside.x.hypot(aside.z);
    let apart = (lowest - high.y).max(low.y - highest);
    let (far, way) = if apart > 0.0 { (apart, "above or below") } else { (aside, "beside") };
    if apart > 0.0 || aside > FARTHEST_ASIDE {
        return Err(Error::new(
            format!("The pattern is placed {far:.2} m {way} the body."),
            "Use the body that it was placed for, or place the panels around this one: metres, y up, the body's middle at x = 0, z = 0.",
        )
        .coded(Code::PlacedElsewhere));
    }
    Ok(())
}

/// Points of each segment by which a panel is placed.
const OUTLINE_POINTS: usize = 4;
/// The farthest that the middle of all panels may be beside that of the body, m: more than a coat's
/// back is behind it.
const FARTHEST_ASIDE: f64 = 0.5;

/// Places the panels and moves them where the body is in the way of their seams.
///
/// The field should know distances up to [`SIGHT_MARGIN`] outside the body.
pub fn arrange(pattern: &Pattern, open: &Level, body: &Body, field: &DistanceField, care: Care) -> Arrangement {
    let search = Search::new(pattern, open, body, field, care);
    let motions = search.run(pattern);
    let shifts = motions.iter().zip(&search.middles).map(|(motion, &middle)| motion.of(middle) - middle).collect();
    let mut positions = search.positions;
    for (range, motion) in open.panels.iter().zip(&motions) {
        positions[range.points.clone()].iter_mut().for_each(|p| *p = motion.of(*p));
    }
    let placements = pattern.panels.iter().filter_map(|panel| panel.placement.as_ref());
    Arrangement { positions, shifts, raised: placements.map(|p| p.raised).fold(0.0, f64::max) }
}

impl Arrangement {
    /// Counts the shifts of the panels of a level from where those of another arrangement are counted from.
    pub fn since(&mut self, other: &Arrangement, open: &Level) {
        for (k, range) in open.panels.iter().enumerate() {
            let middle = |of: &Arrangement| {
                let points = &of.positions[range.points.clone()];
                points.iter().sum::<Vector3>() / points.len() as f64
            };
            self.shifts[k] = middle(self) - (middle(other) - other.shifts[k]);
        }
    }
}

struct Search<'a> {
    open: &'a Level,
    field: &'a DistanceField,
    care: Care,
    /// With the arcs of all openings, where these matter.
    core: Option<Core>,
    arcs: Vec<Arc>,
    /// As placed, m, world.
    positions: Vec<Vector3>,
    panel_of: Vec<usize>,
    /// Per panel: outward normal, as placed.
    normals: Vec<Vector3>,
    /// Per particle on a rim: out of its panel, in the panel's plane; as placed, world.
    off_panel: Vec<Vector3>,
    /// Per panel: its stitches.
    stitches: Vec<Vec<[u32; 2]>>,
    /// Per panel: the middle of its particles, and how far they reach from it, as placed.
    middles: Vec<Vector3>,
    reaches: Vec<f64>,
    /// Per panel: its triangles, as placed.
    trees: Vec<BoxTree>,
}

impl<'a> Search<'a> {
    fn new(pattern: &Pattern, open: &'a Level, body: &Body, field: &'a DistanceField, care: Care) -> Self {
        let mut panel_of = vec![0; open.particle_count];
        for (panel, range) in open.panels.iter().enumerate() {
            panel_of[range.points.clone()].fill(panel);
        }
        let mut stitches = vec![Vec::new(); pattern.panels.len()];
        for &[a, b] in &open.stitches {
            let (p, q) = (panel_of[a as usize], panel_of[b as usize]);
            stitches[p].push([a, b]);
            if p != q {
                stitches[q].push([a, b]);
            }
        }
        let positions = placed(pattern, open);
        let middle = |range: &PanelRange| {
            let points = &positions[range.points.clone()];
            points.iter().sum::<Vector3>() / points.len() as f64
        };
        let middles: Vec<Vector3> = open.panels.iter().map(middle).collect();
        let reach = |(range, middle): (&PanelRange, &Vector3)| {
            positions[range.points.clone()].iter().map(|p| (p - middle).norm()).fold(0.0, f64::max)
        };
        let reaches = open.panels.iter().zip(&middles).map(reach).collect();
        let corners = |t: usize| open.particles(t).map(|p| positions[p as usize]);
        let tree = |range: &PanelRange| BoxTree::of_triangles(range.triangles.clone().map(corners), 0.0);
        let trees = open.panels.iter().map(tree).collect();
        let off_panel = off_panel(open, &positions);
        let normals = pattern.panels.iter().map(|panel| panel.outward_normal()).collect();
        let (core, arcs) = match care {
            Care::Seams => (None, Vec::new()),
            Care::SeamsAndOpenings => (Some(Core::new(body, field)), arcs(open, &panel_of, &positions)),
        };
        Self {
            open,
            field,
            care,
            core,
            arcs,
            positions,
            panel_of,
            normals,
            off_panel,
            stitches,
            middles,
            reaches,
            trees,
        }
    }

    /// Moves all panels together, then pairs of units that are sewn to each other, then single units.
    fn run(&self, pattern: &Pattern) -> Vec<Motion> {
        let count = pattern.panels.len();
        let mut motions = vec![Motion::none(); count];
        let units = self.units();
        let mut groups: Vec<Vec<usize>> = vec![(0..count).collect()];
        groups.extend(self.pairs(&units));
        let (first_unit, leans) = (groups.len(), self.care == Care::SeamsAndOpenings);
        groups.extend(units);
        for step in STEPS {
            for _ in 0..MOST_ROUNDS {
                let mut moved = false;
                for (k, group) in groups.iter().enumerate() {
                    let outward = pattern.panels[group[0]].outward_normal();
                    moved |= self.improve(group, leans && k >= first_unit, outward, step, &mut motions);
                }
                if !moved {
                    break;
                }
            }
        }
        motions
    }

    /// Panels that are placed edge to edge along a seam move as one.
    fn units(&self) -> Vec<Vec<usize>> {
        let mut sets = UnionFind::new(self.stitches.len());
        for (panel, stitches) in self.stitches.iter().enumerate() {
            let mut joined = vec![0; self.stitches.len()];
            for &[a, b] in stitches {
                let gap = (self.positions[a as usize] - self.positions[b as usize]).norm();
                let (p, q) = (self.panel_of[a as usize], self.panel_of[b as usize]);
                joined[if p == panel { q } else { p }] += usize::from(gap < PANEL_CLEARANCE);
            }
            // Two stitches make an edge.
            for (other, _) in joined.iter().enumerate().filter(|(q, joined)| *q != panel && **joined >= 2) {
                sets.union(panel as u32, other as u32);
            }
        }
        let of = |unit: usize, sets: &mut UnionFind| {
            (0..self.stitches.len()).filter(|&p| sets.find(p as u32) as usize == unit).collect::<Vec<_>>()
        };
        (0..self.stitches.len()).map(|p| of(p, &mut sets)).filter(|unit| !unit.is_empty()).collect()
    }

    /// Each unit with the one that it shares most stitches with.
    fn pairs(&self, units: &[Vec<usize>]) -> Vec<Vec<usize>> {
        let mut unit_of = vec![0; self.stitches.len()];
        for (unit, panels) in units.iter().enumerate() {
            panels.iter().for_each(|&p| unit_of[p] = unit);
        }
        let mut pairs: Vec<Vec<usize>> = Vec::new();
        for (unit, panels) in units.iter().enumerate() {
            let mut shared = vec![0; units.len()];
            for &[a, b] in panels.iter().flat_map(|&p| &self.stitches[p]) {
                for p in [a, b] {
                    shared[unit_of[self.panel_of[p as usize]]] += 1;
                }
            }
            shared[unit] = 0;
            let partner = (0..shared.len()).max_by_key(|&q| (shared[q], usize::MAX - q)).unwrap_or(unit);
            let mut pair = [panels.as_slice(), units[partner].as_slice()].concat();
            pair.sort_unstable();
            if partner != unit && shared[partner] > 0 && !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        pairs
    }

    /// Moves a group of panels by one step if that pays. What `leans` is turned about all axes.
    fn improve(&self, group: &[usize], leans: bool, outward: Vector3, step: f64, motions: &mut [Motion]) -> bool {
        let start: Vec<Motion> = group.iter().map(|&p| motions[p]).collect();
        let center = group.iter().map(|&p| motions[p].of(self.middles[p])).sum::<Vector3>() / group.len() as f64;
        let still = Rotation3::identity();
        let shifts = DIRECTIONS.map(Vector3::from).into_iter().chain([outward]).map(|d| (still, d * step));
        // Groups of units turn as arms do, about the axis that looks from front to back; what leans lies in single ones.
        let axes = [Vector3::z(), Vector3::x(), Vector3::y()];
        let axes = &axes[..if leans { 3 } else { 1 }];
        let angles = axes.iter().flat_map(|axis| [axis * TURN * step, -axis * TURN * step]);
        let turns = angles.map(|angles| (Rotation3::new(angles), Vector3::zeros()));
        let too_far = |(m, &p): (&Motion, &usize)| {
            (m.of(self.middles[p]) - self.middles[p]).norm() > FARTHEST || m.turn.angle() > FARTHEST_TURN
        };
        let trials = shifts.chain(turns).map(|(turn, by)| start.iter().map(|m| m.then(turn, center, by)).collect());
        let mut trials: Vec<Vec<Motion>> = trials.collect();
        trials.retain(|trial| !trial.iter().zip(group).any(too_far));
        let costs: Vec<f64> = trials
            .par_iter()
            .map(|trial| {
                let mut motions = motions.to_vec();
                group.iter().zip(trial).for_each(|(&p, m)| motions[p] = *m);
                self.cost(group, &motions)
            })
            .collect();
        let mut best = (self.cost(group, motions), start.clone());
        for (trial, cost) in trials.into_iter().zip(costs) {
            if cost < best.0 - 1e-9 {
                group.iter().zip(&trial).for_each(|(&p, m)| motions[p] = *m);
                if !self.touches_others(group, motions) {
                    best = (cost, trial);
                }
            }
        }
        group.iter().zip(&best.1).for_each(|(&p, m)| motions[p] = *m);
        best.1 != start
    }

    /// What of the lines of the panels' stitches, and of the panels themselves, is in the body, and
    /// what the motions cost, m.
    fn cost(&self, group: &[usize], motions: &[Motion]) -> f64 {
        let at = |p: u32| motions[self.panel_of[p as usize]].of(self.positions[p as usize]);
        let mut cost = 0.0;
        for &panel in group {
            for &[a, b] in &self.stitches[panel] {
                let (to_a, to_b) = (at(a), at(b));
                let (by_a, by_b) = (to_a - self.positions[a as usize], to_b - self.positions[b as usize]);
                cost += self.blocked(to_a, to_b);
                cost += OVERLAP_PRICE
                    * (self.overlap(a, b, motions, to_b - to_a) + self.overlap(b, a, motions, to_a - to_b));
                cost += RELATIVE_PRICE * (by_a - by_b).norm();
                cost += SHIFT_PRICE * 0.5 * (by_a.norm() + by_b.norm());
            }
            let range = self.open.panels[panel].points.clone();
            cost += range.map(|p| self.depth(at(p as u32))).sum::<f64>();
        }
        let ahead = self.core.iter().flat_map(|core| self.arcs.iter().map(move |arc| (core, arc)));
        for (core, arc) in ahead.filter(|(_, arc)| group.contains(&arc.panel)) {
            let motion = &motions[arc.panel];
            let aside = core.aside(motion.of(arc.middle), self.inward(arc.panel), arc.reach) - OPENING_SLACK;
            cost += OPENING_PRICE * arc.particles as f64 * aside.max(0.0);
        }
        cost
    }

    /// Where the body lies, seen from a panel, whether or not it leans: along the axis nearest to its normal.
    fn inward(&self, panel: usize) -> Vector3 {
        let outward = self.normals[panel];
        let axis = outward.iamax();
        Vector3::from_fn(|k, _| if k == axis { -outward[axis].signum() } else { 0.0 })
    }

    /// How far the partner of a particle lies behind the rim of the particle's panel, m, beyond what the
    /// placement itself has. Panels that face alike and come to lie over each other would be sewn
    /// through each other.
    fn overlap(&self, particle: u32, partner: u32, motions: &[Motion], span: Vector3) -> f64 {
        let (panel, other) = (self.panel_of[particle as usize], self.panel_of[partner as usize]);
        if self.normals[panel].dot(&self.normals[other]) < FACING_ALIKE {
            return 0.0;
        }
        let off = self.off_panel[particle as usize];
        let placed = self.positions[partner as usize] - self.positions[particle as usize];
        let turn = motions[panel].turn;
        let (placed, now) = ((-placed.dot(&off)).max(0.0), (-span.dot(&(turn * off))).max(0.0));
        (now - placed).max(0.0)
    }

    /// Does a panel of the group come nearer to one outside it than they were placed? Panels placed
    /// edge to edge may part, but not slide over each other.
    fn touches_others(&self, group: &[usize], motions: &[Motion]) -> bool {
        group.iter().any(|&panel| {
            (0..motions.len()).filter(|q| !group.contains(q)).any(|other| {
                let near = self.near(panel, other, &motions[panel], &motions[other]);
                near > 0 && near > self.near(panel, other, &Motion::none(), &Motion::none())
            })
        })
    }

    /// How many pairs of triangles of two moved panels are too near to each other.
    fn near(&self, panel: usize, other: usize, motion: &Motion, other_motion: &Motion) -> usize {
        let (middle, other_middle) = (motion.of(self.middles[panel]), other_motion.of(self.middles[other]));
        if (middle - other_middle).norm() > self.reaches[panel] + self.reaches[other] + PANEL_CLEARANCE {
            return 0;
        }
        let grow = Vector3::repeat(PANEL_CLEARANCE);
        let triangle = |t: usize| self.open.particles(t).map(|p| self.positions[p as usize]);
        let mut near = 0;
        for t in self.open.panels[panel].triangles.clone() {
            // In the other panel's own placement, where its tree is.
            let corners = triangle(t).map(|p| other_motion.before(motion.of(p)));
            let [a, b, c] = corners;
            self.trees[other].for_each_meeting(a.inf(&b).inf(&c) - grow, a.sup(&b).sup(&c) + grow, |k| {
                let facing = triangle(self.open.panels[other].triangles.start + k as usize);
                near += usize::from(triangle_distance(corners, facing) < PANEL_CLEARANCE);
            });
        }
        near
    }

    /// Length of a segment's part in the body, m, and a share of that near the body.
    fn blocked(&self, a: Vector3, b: Vector3) -> f64 {
        let length = (b - a).norm();
        let samples = (length / SIGHT_SPACING).ceil();
        // A sample counts whole once it is as deep as samples are apart: the cost has no steps.
        let share = |k: usize| {
            let distance = self.field.distance(a.lerp(&b, k as f64 / samples));
            let inside = ((SIGHT_CLEARANCE - distance) / SIGHT_SPACING).clamp(0.0, 1.0);
            let near = (1.0 - distance / SIGHT_MARGIN).clamp(0.0, 1.0);
            inside + MARGIN_PRICE * near * near
        };
        length * (1..samples as usize).map(share).sum::<f64>() / samples.max(1.0)
    }

    fn depth(&self, point: Vector3) -> f64 {
        (SIGHT_CLEARANCE - self.field.distance(point)).max(0.0)
    }
}

/// For each particle on a rim, the unit vector out of its panel and in its plane; zero elsewhere.
fn off_panel(open: &Level, positions: &[Vector3]) -> Vec<Vector3> {
    let triangles = open.particle_triangles();
    let mut off = vec![Vector3::zeros(); open.particle_count];
    for edge in EdgeTable::new(&triangles).edges.iter().filter(|edge| edge.triangles.len() == 1) {
        let [a, b] = edge.ends.map(|p| positions[p as usize]);
        let tip = triangles[edge.triangles[0] as usize].into_iter().find(|p| !edge.ends.contains(p));
        let from_tip = a - tip.map_or(a, |p| positions[p as usize]);
        let along = (b - a).normalize();
        let out = (from_tip - along * along.dot(&from_tip)).normalize();
        edge.ends.iter().for_each(|&p| off[p as usize] += out);
    }
    off.into_iter().map(|o| o.try_normalize(1e-9).unwrap_or_default()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::geometry::Vector2;
    use crate::pattern::{Curve, Panel, Placement, Seam, Segment, SegmentId, Sense};

    /// A square panel of 40 cm in front of or behind the body, its lower edge at `y`.
    fn square(name: &str, y: f64, z: f64) -> Panel {
        let corners = [[-0.2, 0.0], [0.2, 0.0], [0.2, 0.4], [-0.2, 0.4]].map(Vector2::from);
        let segments =
            (0..4).map(|k| Segment { curve: Curve::line(corners[k], corners[(k + 1) % 4]), label: None }).collect();
        let placement = Placement::flat(nalgebra::Rotation3::identity(), Vector3::new(0.0, y, z));
        Panel::new(name, segments).at(placement)
    }

    #[test]
    fn panels_rise_until_their_shoulder_seam_passes_over_the_body() {
        // The upper edges meet above a ball of one metre; they start 5 cm below its top.
        let (positions, triangles) = crate::body::shapes::sphere(Vector3::new(0.0, 0.5, 0.0), 0.5, 30);
        let (body, _) = Body::new(positions, triangles).unwrap();
        let top = |panel| SegmentId { panel, segment: 2 };
        let seams = vec![Seam { sides: [top(0), top(1)], sense: Sense::Aligned }];
        let panels = vec![square("front", 0.55, 0.6), square("back", 0.55, -0.6)];
        let pattern = Pattern { name: "test".into(), panels, seams };
        let garment = Garment::build(&pattern, &[0.05]).unwrap();
        let arrangement =
            arrange(&pattern, &garment.open, &body, &DistanceField::new(&body, 0.012, SIGHT_MARGIN), Care::Seams);
        for shift in arrangement.shifts {
            assert!((0.04..0.1).contains(&shift.y) && shift.x.abs() < 0.01, "{shift}");
        }
    }
}
