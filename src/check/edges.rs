//! Edges and lengths: short ones, unequal ones, and those that look like another unit.

use super::{Finding, Given};
use crate::Code;
use crate::geometry::Vector2;
use crate::pattern::sewing::Measured;
use crate::pattern::{Panel, Pattern};
use std::collections::BTreeMap;

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

/// Edges that the finest level gives one short step: the shortest is named first.
pub fn short(given: &Given, measured: &Measured) -> Option<Finding> {
    const MOST_LISTED: usize = 6;
    let &resolution = given.resolutions.last()?;
    let panels = given.pattern.panels.iter().zip(&measured.length);
    let edges =
        panels.flat_map(|(panel, lengths)| lengths.iter().enumerate().map(move |(k, &length)| (panel, k, length)));
    let mut short: Vec<(&Panel, usize, f64)> = edges.filter(|(_, _, length)| *length < resolution).collect();
    short.sort_by(|a, b| a.2.total_cmp(&b.2));
    let &(panel, edge, shortest) = short.first()?;
    let named = |(panel, k, length): &(&Panel, usize, f64)| format!("{}:{k} ({:.1} mm)", panel.name, 1e3 * length);
    let others: Vec<String> = short.iter().skip(1).take(MOST_LISTED).map(named).collect();
    let more = short.len().saturating_sub(1 + MOST_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let others = if others.is_empty() { String::new() } else { format!(" So are {}{more}.", others.join(", ")) };
    let finding = Finding::new(
        Code::EdgeShort,
        format!(
            "With {:.1} mm it is shorter than the finest resolution, {:.1} mm.{others}",
            1e3 * shortest,
            1e3 * resolution
        ),
        "Fit at a finer resolution if the detail matters, or draw the edge and its neighbour as one if it is a slip.",
    );
    let finding = finding.within(format!("edge {edge}")).within(format!("panel \"{}\"", panel.name));
    Some(finding.measured("shortest_edge_m", shortest).measured("resolution_m", resolution))
}

/// Seams between the same two panels that are all unequal, and nobody said that it is meant.
#[derive(Default)]
struct Unequal {
    seams: Vec<usize>,
    longer: f64,
    shorter: f64,
}

/// Seams whose sides differ in length by more than can be eased.
pub fn unequal(given: &Given, measured: &Measured) -> Vec<Finding> {
    let mut between: BTreeMap<[usize; 2], Unequal> = BTreeMap::new();
    for (index, seam) in given.pattern.seams.iter().enumerate() {
        let [a, b] = seam.sides.map(|side| measured.length_of(side));
        if a.max(b) / a.min(b) - 1.0 <= MOST_EASE || given.eased.get(index).copied().unwrap_or(false) {
            continue;
        }
        // The panel with the longer side first.
        let [p, q] = seam.sides.map(|side| side.panel);
        let found = between.entry(if a > b { [p, q] } else { [q, p] }).or_default();
        found.seams.push(index);
        found.longer += a.max(b);
        found.shorter += a.min(b);
    }
    let mut found: Vec<Unequal> = between.into_values().collect();
    found.sort_by_key(|unequal| unequal.seams[0]);
    found.iter().map(|unequal| told_unequal(given.pattern, unequal)).collect()
}

fn told_unequal(pattern: &Pattern, Unequal { seams, longer, shorter }: &Unequal) -> Finding {
    let share = longer / shorter - 1.0;
    let remedy = if share > GATHERED {
        "If it is to be gathered, all is well: state `ease` with the seam and nothing is said. If not, it sews the wrong edges."
    } else {
        "Look whether it sews the right edges; correct the longer one, or state `ease` with the seam if it is meant."
    };
    let too_much = 1e3 * (longer - shorter);
    let sizes = format!(
        "{:.1} cm are sewn to {:.1} cm: {too_much:.1} mm too much, {:.0} % of the shorter side",
        100.0 * longer,
        100.0 * shorter,
        100.0 * share
    );
    let problem = match seams.len() {
        1 => format!("{sizes}."),
        count => format!("{sizes}, here and in {} between the same panels together.", others(count - 1)),
    };
    Finding::new(Code::SeamUnequal, problem, remedy)
        .within(format!("seam \"{}\"", pattern.seam_name(&pattern.seams[seams[0]])))
        .measured("ease_m", longer - shorter)
        .measured("ease_share", share)
}

fn others(count: usize) -> String {
    if count == 1 { "the other seam".to_owned() } else { format!("{count} other seams") }
}
