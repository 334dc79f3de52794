//! Seams that join the right edges the wrong way around, or edges that belong to others, as the placement shows.
//!
//! Panels are placed so that what is sewn together lies near each other. Of the two ways to sew a seam, and of the two ways
//! to pair the sides of two seams, the nearer one is meant.

use super::Finding;
use crate::Code;
use crate::geometry::Vector3;
use crate::pattern::sewing::Measured;
use crate::pattern::{Pattern, Seam, Sense};

/// Points of each side that are compared.
const SAMPLES: usize = 9;
/// A seam of two straight parallel sides of length `l` gains `l²/3` when it is sewn the other way around; half of that is clear.
const TWISTED: f64 = 1.0 / 6.0;
/// Sides of seams that could be exchanged differ in length by no more than this share.
const ALIKE: f64 = 0.06;
/// Shorter sides than this may lie at any angle, m: the corners of an armhole.
const LEAST_LENGTH: f64 = 0.05;
/// What two seams must gain on average when they exchange partners, m: a hand's breadth.
const EXCHANGED: f64 = 0.1;

/// Points along a side from its start to its end, m, world.
type Line = [Vector3; SAMPLES];

fn lines(pattern: &Pattern, measured: &Measured, seam: &Seam) -> [Line; 2] {
    seam.sides.map(|side| {
        let at = |k: usize| measured.point(side, k as f64 / (SAMPLES - 1) as f64);
        std::array::from_fn(|k| pattern.panels[side.panel].place(at(k)))
    })
}

/// Mean squared distance of partners, m².
fn spread(a: &Line, b: &Line, sense: Sense) -> f64 {
    let partner = |k: usize| if sense == Sense::Opposed { SAMPLES - 1 - k } else { k };
    (0..SAMPLES).map(|k| (a[k] - b[partner(k)]).norm_squared()).sum::<f64>() / SAMPLES as f64
}

/// Seams whose ends would lie nearer to each other the other way around.
pub fn twisted(pattern: &Pattern, measured: &Measured) -> Vec<Finding> {
    let of_seam = |seam: &Seam| {
        let [a, b] = lines(pattern, measured, seam);
        let other = if seam.sense == Sense::Opposed { Sense::Aligned } else { Sense::Opposed };
        let gain = spread(&a, &b, seam.sense) - spread(&a, &b, other);
        let [first, second] = seam.sides.map(|side| measured.length_of(side));
        let is_long = first.min(second) > LEAST_LENGTH && seam.sides[0].panel != seam.sides[1].panel;
        (is_long && gain > TWISTED * first * second).then(|| {
            Finding::new(
                Code::SeamTwisted,
                "It looks twisted: as the panels are placed, its ends lie nearer to each other the other way around.",
                "Turn one panel over or change the direction of the seam; if the panels are merely placed askew, place them with --place auto, or by an arrangement file where that placed them so.",
            )
            .within(format!("seam \"{}\"", pattern.seam_name(seam)))
        })
    };
    pattern.seams.iter().filter_map(of_seam).collect()
}

/// Pairs of seams whose sides would lie much nearer to each other if they exchanged partners.
pub fn exchanged(pattern: &Pattern, measured: &Measured) -> Vec<Finding> {
    let lines: Vec<[Line; 2]> = pattern.seams.iter().map(|seam| lines(pattern, measured, seam)).collect();
    let length = |seam: usize, side: usize| measured.length_of(pattern.seams[seam].sides[side]);
    let alike = |a: f64, b: f64| (a - b).abs() < ALIKE * a.min(b);
    let distance = |a: &Line, b: &Line, sense: Sense| spread(a, b, sense).sqrt();
    // Darts lie beside each other, and are sewn one by one.
    let between = |seam: &Seam| seam.sides[0].panel != seam.sides[1].panel;
    let seams = || pattern.seams.iter().enumerate().filter(|(_, seam)| between(seam));
    let mut findings = Vec::new();
    for (i, first) in seams() {
        for (j, second) in seams().filter(|(j, _)| *j > i) {
            if first.sense != second.sense || !alike(length(i, 1), length(j, 1)) || !alike(length(i, 0), length(j, 0)) {
                continue;
            }
            let as_sewn = [i, j].map(|k| distance(&lines[k][0], &lines[k][1], first.sense));
            let straight = [(i, j), (j, i)].map(|(k, l)| distance(&lines[k][0], &lines[l][1], first.sense));
            let gain = 0.5 * (as_sewn[0] + as_sewn[1] - straight[0] - straight[1]);
            if gain > EXCHANGED && straight[0].max(straight[1]) < as_sewn[0].min(as_sewn[1]) {
                let finding = Finding::new(
                    Code::SeamsCross,
                    format!(
                        "It crosses the seam \"{}\": as the panels are placed, the two would be {:.0} cm shorter on average with their partners exchanged.",
                        pattern.seam_name(second),
                        100.0 * gain
                    ),
                    "Look whether left is sewn to left and front to back (`toile seams show`), and exchange the partners.",
                );
                findings
                    .push(finding.within(format!("seam \"{}\"", pattern.seam_name(first))).measured("gain_m", gain));
            }
        }
    }
    findings
}
