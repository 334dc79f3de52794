//! Rings of a sewn garment: closed lines along which a height, or a length along a limb, has one value, and how long they are
//! on the flat panels.

use super::Sewn;
use crate::body::section::plane_axes;
use crate::geometry::{UnionFind, Vector3};
use std::collections::BTreeMap;

/// A closed line around the sewn garment.
pub struct Ring {
    /// On the flat panels, m.
    pub length: f64,
    /// Of those that it runs over, ascending.
    pub panels: Vec<u32>,
    /// In no order, but all the same way around, m, world.
    steps: Vec<[Vector3; 2]>,
}

impl Ring {
    /// Does it go around a line through `center`?
    pub fn encloses(&self, center: Vector3, axis: Vector3) -> bool {
        let (across, up) = plane_axes(axis);
        let flat = |p: Vector3| [(p - center).dot(&across), (p - center).dot(&up)];
        let angle = |&[from, to]: &[Vector3; 2]| {
            let ([a, b], [c, d]) = (flat(from), flat(to));
            (a * d - b * c).atan2(a * c + b * d)
        };
        self.steps.iter().map(angle).sum::<f64>().abs() > std::f64::consts::PI
    }
}

/// The point of an edge at which the value is taken on, seen from one of its triangles.
struct Crossing {
    /// Particles, the smaller first.
    edge: [u32; 2],
    /// Of the list of steps.
    step: u32,
}

/// A line through one triangle.
struct Step {
    ends: [Vector3; 2],
    /// m, on the panel.
    length: f64,
    panel: u32,
}

/// The closed lines on which `values`, one per particle, are `at`.
pub fn rings(sewn: &Sewn, values: &[f64], at: f64) -> Vec<Ring> {
    let level = &sewn.garment.levels[0];
    let mut crossings: Vec<Crossing> = Vec::new();
    let mut steps: Vec<Step> = Vec::new();
    for t in 0..level.triangles.len() {
        let corners = level.particles(t);
        let above = corners.map(|p| values[p as usize] >= at);
        // The sides that lead up and down, if the triangle is crossed.
        let side = |up: bool| (0..3).find(|&k| above[k] != up && above[(k + 1) % 3] == up);
        let (Some(up), Some(down)) = (side(true), side(false)) else { continue };
        let rest = level.rest_corners(t);
        let crossed = |k: usize| {
            let [p, q] = [k, (k + 1) % 3];
            let [a, b] = [corners[p], corners[q]];
            let (from, to) = (values[a as usize], values[b as usize]);
            let share = (at - from) / (to - from);
            let point = sewn.positions[a as usize].lerp(&sewn.positions[b as usize], share);
            ([a.min(b), a.max(b)], point, rest[p].lerp(&rest[q], share))
        };
        let ((edge, point, flat), (other_edge, other_point, other_flat)) = (crossed(up), crossed(down));
        let step = steps.len() as u32;
        crossings.push(Crossing { edge, step });
        crossings.push(Crossing { edge: other_edge, step });
        steps.push(Step { ends: [point, other_point], length: (other_flat - flat).norm(), panel: sewn.panel_of[t] });
    }
    crossings.sort_unstable_by_key(|c| (c.edge, c.step));
    closed(&crossings, steps)
}

/// The sets of steps that hang together and have no end, in the order of their first steps.
fn closed(crossings: &[Crossing], steps: Vec<Step>) -> Vec<Ring> {
    let mut sets = UnionFind::new(steps.len());
    let mut open = Vec::new();
    for shared in crossings.chunk_by(|a, b| a.edge == b.edge) {
        // An end has one step at its edge; where there are more than two, the line branches.
        match shared {
            [a, b] => sets.union(a.step, b.step),
            others => open.extend(others.iter().map(|crossing| crossing.step)),
        }
    }
    let open: std::collections::BTreeSet<u32> = open.into_iter().map(|step| sets.find(step)).collect();
    let mut rings: BTreeMap<u32, Ring> = BTreeMap::new();
    for (index, step) in (0..).zip(steps) {
        let set = sets.find(index);
        if open.contains(&set) {
            continue;
        }
        let ring = rings.entry(set).or_insert_with(|| Ring { length: 0.0, panels: Vec::new(), steps: Vec::new() });
        ring.length += step.length;
        ring.panels.push(step.panel);
        ring.steps.push(step.ends);
    }
    let mut rings: Vec<Ring> = rings.into_values().collect();
    for ring in &mut rings {
        ring.panels.sort_unstable();
        ring.panels.dedup();
    }
    rings
}
