//! All that would make it impossible to build a garment from a pattern.

use super::{Panel, Pattern, Placement, SegmentId};
use crate::geometry::Vector2;
use crate::{Code, Error};
use std::collections::{HashMap, HashSet};

/// A segment shorter than this is a slip of the drawing, m: a hundredth of a millimetre.
const SHORTEST_SEGMENT: f64 = 1e-5;
/// A panel smaller than this cannot be cut, m²: four square millimetres.
const SMALLEST_PANEL: f64 = 4e-6;
/// A panel larger than this, or farther from the origin, was drawn in another unit, m.
const LARGEST_EXTENT: f64 = 20.0;
/// How far a segment may start from where the one before ended, m.
const CLOSING_TOLERANCE: f64 = 1e-6;

impl Pattern {
    /// All that keeps the pattern from being sewn: the first fault, which carries the others.
    pub fn check(&self) -> Result<(), Error> {
        if self.panels.is_empty() {
            return Err(
                Error::new("The pattern has no panels.", "Export it again with its panels.").coded(Code::NoPanels)
            );
        }
        let mut faults = Vec::new();
        let mut names: HashSet<&str> = HashSet::new();
        for panel in &self.panels {
            faults.extend(check_name(&panel.name).err());
            if !names.insert(&panel.name) {
                faults.push(
                    Error::new(
                        format!("Two panels are named \"{}\".", panel.name),
                        "Give every panel a name of its own.",
                    )
                    .coded(Code::NameTwice),
                );
            }
            faults.extend(panel.check().map_err(|e| e.within(format!("panel \"{}\"", panel.name))).err());
        }
        self.check_seams(&mut faults);
        Error::all(faults).map_or(Ok(()), Err)
    }

    fn check_seams(&self, faults: &mut Vec<Error>) {
        let mut sewn: HashMap<SegmentId, usize> = HashMap::new();
        for (index, seam) in self.seams.iter().enumerate() {
            let mut fault = |e: Error| faults.push(e.within(format!("stitch {index}")));
            for side in seam.sides {
                let Some(panel) = self.panels.get(side.panel) else {
                    fault(
                        Error::new(
                            format!("It names panel number {}, which does not exist.", side.panel),
                            format!("The pattern has {} panels, counted from 0.", self.panels.len()),
                        )
                        .coded(Code::SeamUnknownEdge),
                    );
                    continue;
                };
                if side.segment >= panel.segments.len() {
                    fault(
                        Error::new(
                            format!(
                                "It names edge {} of panel \"{}\", which does not exist.",
                                side.segment, panel.name
                            ),
                            format!("The panel has {} edges, counted from 0.", panel.segments.len()),
                        )
                        .coded(Code::SeamUnknownEdge),
                    );
                } else if let Some(other) = sewn.insert(side, index) {
                    fault(
                        Error::new(
                            format!(
                                "Edge {} of panel \"{}\" is already sewn by stitch {other}.",
                                side.segment, panel.name
                            ),
                            "Sew every edge once; split the edge where different parts of it meet different edges.",
                        )
                        .coded(Code::EdgeSewnTwice),
                    );
                }
            }
        }
    }
}

/// A name is one line of text: it stands for its panel in messages and in files.
fn check_name(name: &str) -> Result<(), Error> {
    let breaks = |c: char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}');
    if name.trim().is_empty() || name.contains(breaks) {
        return Err(Error::new(
            format!("A panel is named \"{}\".", name.escape_debug()),
            "Give every panel a name of its own, one line of text without control characters.",
        )
        .coded(Code::NameUnusable));
    }
    Ok(())
}

impl Panel {
    fn check(&self) -> Result<(), Error> {
        if self.segments.len() < 2 {
            return Err(Error::new(
                format!("The outline has {} edges.", self.segments.len()),
                "An outline needs at least two edges that close a loop.",
            )
            .coded(Code::OutlineOpen));
        }
        let edges = || (0..).zip(&self.segments);
        let at = |k: usize, e: Error| e.within(format!("edge {k}"));
        let unusable = |k: usize| {
            let error = Error::new("It has a coordinate that is not a number.", "Export the panel again.");
            at(k, error.coded(Code::NumberUnusable))
        };
        // What comes of one fault is no further fault: the outline is looked at as a whole where its edges are sound.
        let mut faults: Vec<Error> =
            edges().filter(|(_, segment)| !segment.curve.is_finite()).map(|(k, _)| unusable(k)).collect();
        if let Some(fault) = Error::all(std::mem::take(&mut faults)) {
            return Err(fault);
        }
        // Before any length: measuring a curve of a light-year to a nanometre takes for ever.
        self.check_extent()?;
        for (k, segment) in edges() {
            let next = &self.segments[(k + 1) % self.segments.len()];
            if (segment.curve.end - next.curve.start).norm() > CLOSING_TOLERANCE {
                let error = Error::new(
                    "The outline is open: the next edge does not start where this one ends.",
                    "List the edges in the order of the loop, each from its start to its end.",
                );
                faults.push(at(k, error.coded(Code::OutlineOpen)));
            }
            let chord = (segment.curve.end - segment.curve.start).norm();
            // Long curves are not measured: it takes time.
            if chord < SHORTEST_SEGMENT && segment.curve.length() < SHORTEST_SEGMENT {
                let error =
                    Error::new("The edge has no length.", "Remove it and let its neighbours meet in one corner.");
                faults.push(at(k, error.coded(Code::EdgeWithoutLength)));
            }
        }
        if let Some(fault) = Error::all(faults) {
            return Err(fault);
        }
        if let Some((i, j)) = self.crossing_segments() {
            let place = if i == j {
                format!("Edge {i} crosses itself.")
            } else {
                format!("Edges {i} and {j} cross each other.")
            };
            let remedy = "Redraw the outline so that it encloses one area without crossing itself.";
            return Err(Error::new(place, remedy).coded(Code::OutlineCrosses));
        }
        if self.signed_area().abs() < SMALLEST_PANEL {
            return Err(Error::new(
                format!("The outline encloses {:.2} mm².", self.signed_area().abs() * 1e6),
                "Check the outline and the unit of the pattern.",
            )
            .coded(Code::PanelWithoutArea));
        }
        Ok(())
    }

    fn check_extent(&self) -> Result<(), Error> {
        let shift = self.placement.as_ref().map_or(0.0, |placement| placement.translation.norm());
        let turned = |placement: &Placement| placement.rotation.matrix().iter().all(|r| r.is_finite());
        let bent = |placement: &Placement| {
            placement.bend.is_none_or(|bend| {
                bend.radius.is_finite()
                    && bend.radius != 0.0
                    && (bend.along.norm() - 1.0).abs() < 1e-6
                    && bend.origin.norm().is_finite()
            })
        };
        let raised = self.placement.as_ref().map_or(0.0, |placement| placement.raised);
        if !(shift.is_finite() && raised.is_finite() && self.placement.as_ref().is_none_or(|p| turned(p) && bent(p))) {
            return Err(Error::new(
                "The placement is not finite.",
                "Give the translation and rotation as plain numbers.",
            )
            .coded(Code::NumberUnusable));
        }
        let near = |farthest: f64| {
            if farthest <= LARGEST_EXTENT {
                return Ok(());
            }
            Err(Error::new(
                format!("The panel reaches {farthest:.1} m from the origin."),
                "Check the unit of the pattern: lengths are divided by `units_in_meter`, 100 for centimetres.",
            )
            .coded(Code::TooFar))
        };
        let farthest = |points: &mut dyn Iterator<Item = Vector2>| points.map(|p| p.norm()).fold(shift, f64::max);
        near(farthest(&mut self.segments.iter().flat_map(|s| s.curve.control_points())))?;
        // Arcs may bulge out.
        near(farthest(&mut self.segments.iter().flat_map(|s| s.curve.sketch(8))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_one_line_of_text() {
        for name in ["", " ", "left\nsleeve", "left\u{2028}sleeve", "left\0sleeve"] {
            assert!(check_name(name).is_err(), "{name:?}");
        }
        for name in ["left_sleeve", "left sleeve", "linke Ärmel", "o # f"] {
            assert!(check_name(name).is_ok(), "{name:?}");
        }
    }
}
