//! Parts of the body between which cloth has to go, and has no room.

use super::{Finding, Given, Sewn};
use crate::Code;
use crate::body::{Body, Landmarks, Part};
use crate::geometry::{BoxTree, Vector3, closest_on_triangle};

/// Limbs come together at armpit and crotch; this far from there they should be apart, m.
const FROM_THE_FORK: f64 = 0.07;

/// Arms that are too near to torso and legs where the garment has sides or sleeves, and thighs within trousers.
pub fn near(given: &Given, sewn: &Sewn, body: &Body, marks: &Landmarks) -> Vec<Finding> {
    // A layer of cloth for each of the two parts.
    let needed = 2.0 * given.clearance + given.fabric.thickness;
    let low = sewn.positions.iter().fold(Vector3::repeat(f64::INFINITY), |a, p| a.inf(p));
    let high = sewn.positions.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
    let dressed = |p: Vector3| p.y > low.y && p.y < high.y && p.x > low.x && p.x < high.x;
    let is_arm = |part: Part| matches!(part, Part::Arm(_));
    let trunk = Surface::new(body, |t| t.iter().all(|&v| !is_arm(marks.parts[v as usize])));
    let mut findings = Vec::new();
    for side in [0, 1u8] {
        let fork = marks.armpits[side as usize];
        let among = (0..marks.parts.len()).filter(|&v| marks.parts[v] == Part::Arm(side)).map(|v| body.positions()[v]);
        let among = among.filter(|&p| dressed(p) && (p - fork).norm() > FROM_THE_FORK);
        if let Some((gap, place)) = trunk.nearest_of(among, needed) {
            let name = ["left arm", "right arm"][side as usize];
            let other = if place.y > marks.crotch.y { "torso" } else { "legs" };
            findings.push(told(name, other, gap, needed, place.y - marks.floor));
        }
    }
    findings
}

fn told(name: &str, other: &str, gap: f64, needed: f64, height: f64) -> Finding {
    Finding::new(
        Code::ArmNearTorso,
        format!(
            "It is {:.1} mm from the {other}, {height:.2} m above the floor; cloth around both needs {:.1} mm.",
            1e3 * gap,
            1e3 * needed
        ),
        "Take the body in a pose whose arms are farther from the torso, such as an A-pose, or ask for a smaller clearance.",
    )
    .within(name)
    .measured("gap_m", gap)
    .measured("needed_m", needed)
}

/// A part of the body's surface.
struct Surface {
    corners: Vec<[Vector3; 3]>,
    tree: BoxTree,
}

impl Surface {
    fn new(body: &Body, belongs: impl Fn(&[u32; 3]) -> bool) -> Self {
        let of = |t: &[u32; 3]| t.map(|v| body.positions()[v as usize]);
        let corners: Vec<[Vector3; 3]> = body.triangles().iter().filter(|t| belongs(t)).map(of).collect();
        let tree = BoxTree::of_triangles(corners.iter().copied(), 0.0);
        Self { corners, tree }
    }

    /// The least distance of any of the points that is below `reach`, m, and where.
    fn nearest_of(&self, points: impl Iterator<Item = Vector3>, reach: f64) -> Option<(f64, Vector3)> {
        let squared = |point: Vector3, t: u32| {
            let corners = self.corners[t as usize];
            let [a, b, c] = closest_on_triangle(point, corners);
            (corners[0] * a + corners[1] * b + corners[2] * c - point).norm_squared()
        };
        let near = |p: Vector3| self.tree.nearest(p, reach, |t| squared(p, t)).map(|(_, squared)| (squared.sqrt(), p));
        points.filter_map(near).min_by(|a, b| a.0.total_cmp(&b.0))
    }
}
