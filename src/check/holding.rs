//! What holds the garment up: cloth that passes over the shoulders, or a ring around the torso that is smaller than what is
//! below it.

use super::rings::rings;
use super::tight::level_of;
use super::{Finding, Sewn};
use crate::Code;
use crate::body::Landmarks;
use crate::geometry::Vector3;
use crate::pattern::{Pattern, SegmentLabel};

/// Distance of the rings that are looked at, m.
const SPACING: f64 = 0.01;
/// How far beyond the ends of the shoulders a seam may pass over them, m.
const BESIDE: f64 = 0.03;

/// A finding if nothing holds the garment. Only what reaches the middle of the torso is judged: sleeves and stockings are held
/// by friction.
pub fn nothing(pattern: &Pattern, sewn: &Sewn, marks: &Landmarks) -> Option<Finding> {
    let held_by_itself = |label: Option<SegmentLabel>| label == Some(SegmentLabel::LowerInterface);
    let said = pattern.panels.iter().flat_map(|panel| &panel.segments).any(|segment| held_by_itself(segment.label));
    if said || pattern.seams.is_empty() || !reaches_torso(sewn, marks) || passes_over_shoulders(sewn, marks) {
        return None;
    }
    let heights: Vec<f64> = sewn.positions.iter().map(|p| p.y).collect();
    let top = level_of(&marks.torso, marks.neck_back.y).map_or(marks.shoulders[0].y, |(p, _)| p.y);
    let count = ((top - marks.crotch.y) / SPACING).max(0.0) as usize;
    let mut widest = 0.0;
    let mut least = f64::INFINITY;
    for k in 0..=count {
        let height = marks.crotch.y + SPACING * k as f64;
        let Some((center, girth)) = level_of(&marks.torso, height) else { continue };
        widest = f64::max(widest, girth);
        let around = rings(sewn, &heights, height).into_iter().filter(|ring| ring.encloses(center, Vector3::y()));
        let smallest = around.map(|ring| ring.length).fold(f64::INFINITY, f64::min);
        if smallest < widest {
            return None;
        }
        least = least.min(smallest);
    }
    let problem = if least.is_finite() {
        format!(
            "Nothing passes over the shoulders, and its smallest ring around the torso, {:.1} cm, is no smaller than the hips, {:.1} cm: it would slide down.",
            100.0 * least,
            100.0 * widest
        )
    } else {
        "Nothing passes over the shoulders, and no closed ring goes around the torso: it would fall off.".to_owned()
    };
    let remedy = "Sew the shoulders, close the waist, or make it narrower; of a GarmentCode pattern label the edges that are held at the waist `lower_interface`.";
    let finding = Finding::new(Code::NothingHolds, problem, remedy);
    Some(if least.is_finite() {
        finding.measured("smallest_ring_m", least).measured("hips_m", widest)
    } else {
        finding
    })
}

/// Is some of the garment above the crotch, and on both sides of the middle?
fn reaches_torso(sewn: &Sewn, marks: &Landmarks) -> bool {
    let above = || sewn.positions.iter().filter(|p| p.y > marks.crotch.y);
    above().any(|p| p.x > marks.crotch.x) && above().any(|p| p.x < marks.crotch.x)
}

/// Does cloth lead from front to back between the ends of the shoulders, above the armpits?
fn passes_over_shoulders(sewn: &Sewn, marks: &Landmarks) -> bool {
    let middle = 0.5 * (marks.shoulders[0].z + marks.shoulders[1].z);
    let above = marks.armpits[0].y.max(marks.armpits[1].y);
    let (left, right) = (marks.shoulders[0].x + BESIDE, marks.shoulders[1].x - BESIDE);
    let over = |p: Vector3| p.y > above && p.x < left && p.x > right;
    let level = &sewn.garment.levels[0];
    (0..level.triangles.len()).any(|t| {
        let corners = level.particles(t).map(|p| sewn.positions[p as usize]);
        let behind = corners.iter().filter(|p| p.z < middle).count();
        (1..3).contains(&behind) && corners.iter().all(|&p| over(p))
    })
}
