//! Where the panels start.

use super::{Finding, Given, listed};
use crate::Code;
use crate::arrangement::{Care, arrange, check_placement, placed};
use crate::geometry::Vector3;

/// Panels that have to be moved farther than this to clear the body are mentioned, m: those of patterns on the body that they
/// were drawn for are moved by up to 6 cm.
const FAR_MOVE: f64 = 0.08;

pub fn findings(given: &Given) -> Vec<Finding> {
    let pattern = given.pattern;
    let lying: Vec<&str> =
        pattern.panels.iter().filter(|panel| panel.placement.is_none()).map(|p| p.name.as_str()).collect();
    if let Some(&first) = lying.first() {
        let finding = Finding::new(
            Code::Unplaced,
            format!(
                "{} of {} panels have no place around the body: {}.",
                lying.len(),
                pattern.panels.len(),
                listed(lying.iter().copied())
            ),
            "Give a body, and have the panels placed by themselves: `--place auto`.",
        );
        return vec![finding.within(format!("panel \"{first}\""))];
    }
    let Some(body) = given.body else { return Vec::new() };
    if let Err(error) = check_placement(pattern, body) {
        return Finding::of_error(error, Code::PlacedElsewhere);
    }
    let (Some(garment), Some(field)) = (given.garment, given.field) else { return Vec::new() };
    let positions = placed(pattern, &garment.open);
    let mut findings = Vec::new();
    for (panel, range) in pattern.panels.iter().zip(&garment.open.panels) {
        let points = &positions[range.points.clone()];
        let inside = points.iter().filter(|p| body.contains(**p)).count();
        if inside > 0 {
            let share = inside as f64 / points.len() as f64;
            let finding = Finding::new(
                Code::StartsInside,
                format!("{:.0} % of it start inside the body.", (100.0 * share).ceil()),
                "It is moved out before it is sewn; if it comes out on the wrong side, place it farther from the body.",
            );
            findings.push(finding.within(format!("panel \"{}\"", panel.name)).measured("share_inside", share));
        }
    }
    let shifts = arrange(pattern, &garment.open, body, field, Care::Seams).shifts;
    for (panel, shift) in pattern.panels.iter().zip(shifts).filter(|(_, shift)| shift.norm() > FAR_MOVE) {
        findings.push(moved(shift).within(format!("panel \"{}\"", panel.name)).measured("shift_m", shift.norm()));
    }
    findings
}

fn moved(shift: Vector3) -> Finding {
    let way = |by: f64, words: [&str; 2]| {
        let word = words[usize::from(by < 0.0)];
        (by.abs() >= 5e-3).then(|| format!("{:.0} mm {word}", 1e3 * by.abs()))
    };
    let ways = [
        way(shift.x, ["to its left", "to its right"]),
        way(shift.y, ["up", "down"]),
        way(shift.z, ["forward", "backward"]),
    ];
    let ways: Vec<String> = ways.into_iter().flatten().collect();
    Finding::new(
        Code::MovedFar,
        format!("It is moved {} before it is sewn, so that its seams clear the body.", ways.join(", ")),
        "If its file places it for a body of another size or pose, place it with --place auto. If it was placed so, see its start with `toile place --picture`, and correct it in an arrangement file.",
    )
}
