//! Edges and lengths: short ones, unequal ones, and those that look like another unit.

use super::{Finding, Given};
use crate::Code;
use crate::geometry::Vector2;
use crate::pattern::sewing::Measured;
use crate::pattern::{Panel, Pattern};

/// The longest panel of a garment, m: from a baby's bib to a train.
const LONGEST_PANEL: std::ops::RangeInclusive<f64> = 0.1..=4.0;

/// Sides of a seam that differ by more than this share of the shorter one are not eased in by pressing alone: tailors ease
/// in 3 to 6 %.
pub const MOST_EASE: f64 = 0.06;

/// From here on cloth is gathered, and drawn so on purpose.
const GATHERED: f64 = 0.25;

/// Is the pattern as large as garments are?
pub fn unit(pattern: &Pattern) -> Option<Finding> {
    let longest = pattern.panels.iter().map(|panel| (extent(panel), panel)).max_by(|a, b| a.0.total_cmp(&b.0));
    let (length, panel) = longest.filter(|(length, _)| !LONGEST_PANEL.contains(length))?;
    let size = if length < 1.0 { format!("{:.1} mm", 1e3 * length) } else { format!("{length:.2} m") };
    let finding = Finding::new(
        Code::UnitDoubtful,
        format!("The longest panel measures {size}, which is a garment for nobody."),
        "Check the unit of the pattern: `units_in_meter` of GarmentCode, --unit of DXF, `unit` of toile's own.",
    );
    Some(finding.within(format!("panel \"{}\"", panel.name)).measured("longest_panel_m", length))
}

/// The longer side of the box around a panel, m.
fn extent(panel: &Panel) -> f64 {
    let points = panel.polygon(8);
    let low = points.iter().fold(Vector2::repeat(f64::INFINITY), |a, p| a.inf(p));
    let high = points.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
    (high - low).max()
}

/// Edges that the finest level gives one short step, panel by panel.
pub fn short(given: &Given, measured: &Measured) -> Vec<Finding> {
    let Some(&resolution) = given.resolutions.last() else { return Vec::new() };
    let of_panel = |(panel, lengths): (&Panel, &Vec<f64>)| {
        let short: Vec<(usize, f64)> = (0..).zip(lengths.iter().copied()).filter(|(_, l)| *l < resolution).collect();
        let shortest = short.iter().map(|(_, length)| *length).reduce(f64::min)?;
        let edges: Vec<String> = short.iter().map(|(k, length)| format!("{k} ({:.1} mm)", 1e3 * length)).collect();
        let (noun, verb) = if short.len() == 1 { ("Edge", "is") } else { ("Edges", "are") };
        let finding = Finding::new(
            Code::EdgeShort,
            format!("{noun} {} {verb} shorter than the finest resolution, {:.1} mm.", edges.join(", "), 1e3 * resolution),
            "Fit at a finer resolution if the detail matters, or draw the edge and its neighbour as one if it is a slip.",
        );
        let place = format!("panel \"{}\"", panel.name);
        Some(finding.within(place).measured("shortest_edge_m", shortest).measured("resolution_m", resolution))
    };
    given.pattern.panels.iter().zip(&measured.length).filter_map(of_panel).collect()
}

/// Seams whose sides differ in length by more than can be eased, and nobody said that it is meant.
pub fn unequal(given: &Given, measured: &Measured) -> Vec<Finding> {
    let pattern = given.pattern;
    let of_seam = |(index, seam): (usize, &crate::pattern::Seam)| {
        let lengths = seam.sides.map(|side| measured.length_of(side));
        let (longer, shorter) = (lengths[0].max(lengths[1]), lengths[0].min(lengths[1]));
        let share = longer / shorter - 1.0;
        if share <= MOST_EASE || given.eased.get(index).copied().unwrap_or(false) {
            return None;
        }
        let remedy = if share > GATHERED {
            "If it is to be gathered, all is well: state `ease` with the seam and nothing is said. If not, it sews the wrong edges."
        } else {
            "Look whether it sews the right edges; correct the longer one, or state `ease` with the seam if it is meant."
        };
        let finding = Finding::new(
            Code::SeamUnequal,
            format!(
                "{:.1} cm are sewn to {:.1} cm: {:.1} mm too much, {:.0} % of the shorter side.",
                100.0 * longer,
                100.0 * shorter,
                1e3 * (longer - shorter),
                100.0 * share
            ),
            remedy,
        );
        let finding = finding.within(format!("seam \"{}\"", pattern.seam_name(seam)));
        Some(finding.measured("ease_m", longer - shorter).measured("ease_share", share))
    };
    pattern.seams.iter().enumerate().filter_map(of_seam).collect()
}
