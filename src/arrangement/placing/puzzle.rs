//! Where panels that stand as they shall have to be for their seams to be short: linear least squares (theory, equation 23).

use super::Limb;
use super::map::solve;
use super::stance::Stance;
use crate::geometry::{Vector2, Vector3};
use crate::pattern::{Pattern, Placement};

/// Two panels and the middles of the two sides of their seam.
pub struct Tie {
    pub panels: [usize; 2],
    /// Middles of the sides, turned and bent as their panels are but not moved, m.
    pub ends: [Vector3; 2],
    /// Where the second end should be, seen from the first, m.
    pub apart: Vector3,
    /// Length of the seam, m.
    pub weight: f64,
}

/// A panel's point that belongs on a plane: `normal · point = value`.
pub struct Row {
    pub panel: usize,
    /// Turned and bent but not moved, m.
    pub point: Vector3,
    pub normal: Vector3,
    /// m.
    pub value: f64,
    pub weight: f64,
}

/// What holds a panel to its place in the draft, against a metre of seam.
const DRAFT: f64 = 2e-3;
const TOLERANCE: f64 = 1e-12;
/// Panels that face the same way lie this far apart along their seam, m.
const GAP: f64 = 0.015;
/// How much more such a seam counts than one to the other side of the body, which is open in any case; and between halves of a
/// torso, which sleeves would else pull over each other.
const BESIDE: f64 = 5.0;
const HALVES: f64 = 50.0;
/// Panels face the same way if their normals have at least this product.
const ALIKE: f64 = 0.7;

/// The seams between different panels.
pub fn ties(pattern: &Pattern, stances: &[Stance]) -> Vec<Tie> {
    let tie = |seam: &crate::pattern::Seam| {
        let [a, b] = seam.sides;
        if a.panel == b.panel {
            return None;
        }
        let end = |side: crate::pattern::SegmentId| {
            let (stance, curve) = (&stances[side.panel], &pattern.segment(side).curve);
            let points = (0..=STEPS).map(|k| stance.turned(curve.at_fraction(k as f64 / STEPS as f64)));
            points.sum::<Vector3>() / (STEPS + 1) as f64
        };
        let off = |side: crate::pattern::SegmentId| {
            let curve = &pattern.segment(side).curve;
            let chord = curve.at_fraction(1.0) - curve.start;
            let wound = pattern.panels[side.panel].signed_area().signum();
            let out = Vector2::new(chord.y, -chord.x) * wound;
            stances[side.panel].rotation * Vector3::new(out.x, out.y, 0.0)
        };
        let [p, q] = [&stances[a.panel], &stances[b.panel]];
        let beside = p.bend.is_none() && q.bend.is_none() && p.face.dot(&q.face) > ALIKE;
        let way = (off(a).try_normalize(1e-9).unwrap_or_default() - off(b).try_normalize(1e-9).unwrap_or_default())
            .try_normalize(1e-3)
            .unwrap_or_default();
        let apart = if beside { way * GAP } else { Vector3::zeros() };
        let counts = match (beside, p.limb, q.limb) {
            (true, Limb::Torso, Limb::Torso) => HALVES,
            (true, ..) => BESIDE,
            (false, ..) => 1.0,
        };
        let [l, m] = pattern.seam_lengths(seam);
        Some(Tie { panels: [a.panel, b.panel], ends: [end(a), end(b)], apart, weight: 0.5 * (l + m) * counts })
    };
    pattern.seams.iter().filter_map(tie).collect()
}

/// Points along a side of a seam.
const STEPS: usize = 8;

/// The translation of each panel, m: `Σ ties weight |b − a − apart|² + Σ rows weight (n · p − value)²`, each panel moving along
/// its free directions only.
pub fn translations(stances: &[Stance], ties: &[Tie], rows: &[Row]) -> Vec<Vector3> {
    let base: Vec<Vector3> = stances.iter().map(Stance::base).collect();
    let to_draft = |stance: &Stance| stance.drafted - stance.turned(stance.middle);
    // Unknowns: two lengths along the free directions of each panel.
    let moves =
        |x: &[f64], panel: usize| stances[panel].free[0] * x[2 * panel] + stances[panel].free[1] * x[2 * panel + 1];
    let add = |y: &mut [f64], panel: usize, force: Vector3| {
        for k in 0..2 {
            y[2 * panel + k] += stances[panel].free[k].dot(&force);
        }
    };
    let apply = |x: &[f64]| {
        let mut y: Vec<f64> = x.iter().map(|x| DRAFT * x).collect();
        for tie in ties {
            let [a, b] = tie.panels;
            let stretch = (moves(x, b) - moves(x, a)) * tie.weight;
            add(&mut y, b, stretch);
            add(&mut y, a, -stretch);
        }
        for row in rows {
            add(&mut y, row.panel, row.normal * (row.weight * row.normal.dot(&moves(x, row.panel))));
        }
        y
    };
    let mut right = vec![0.0; 2 * stances.len()];
    for (panel, stance) in stances.iter().enumerate() {
        add(&mut right, panel, (to_draft(stance) - base[panel]) * DRAFT);
    }
    for tie in ties {
        let [a, b] = tie.panels;
        let gap = tie.ends[1] + base[b] - tie.ends[0] - base[a] - tie.apart;
        add(&mut right, b, -gap * tie.weight);
        add(&mut right, a, gap * tie.weight);
    }
    for row in rows {
        let off = row.value - row.normal.dot(&(row.point + base[row.panel]));
        add(&mut right, row.panel, row.normal * (row.weight * off));
    }
    let x = solve(apply, &right, TOLERANCE, 40 * right.len() + 100);
    (0..stances.len()).map(|panel| base[panel] + moves(&x, panel)).collect()
}

impl Stance {
    /// A point of the panel, turned and bent, not moved, m.
    pub fn turned(&self, point: Vector2) -> Vector3 {
        self.placement(Vector3::zeros()).place(point)
    }

    /// The translation with which the panel's middle is at the point that it goes through.
    fn base(&self) -> Vector3 {
        self.through - self.turned(self.middle)
    }

    pub fn placement(&self, translation: Vector3) -> Placement {
        Placement { rotation: self.rotation, translation, bend: self.bend, raised: 0.0 }
    }
}
