//! Panels around the body, and the seams between their segments.

use super::outline::Outline;

/// A panel and where it hangs before sewing.
pub struct Panel {
    pub name: &'static str,
    /// Part of the body that it dresses: `body`, `arm` or `leg`.
    pub part: &'static str,
    pub outline: Outline,
    /// Place of the drawing's origin, cm.
    pub translation: [f64; 3],
    /// Turn about the z axis, counter-clockwise seen from the front, degrees.
    pub turn: f64,
}

/// One side of a seam: a segment of a panel, by their names.
#[derive(Clone, Copy)]
pub struct Side {
    pub panel: &'static str,
    pub segment: &'static str,
}

pub const fn side(panel: &'static str, segment: &'static str) -> Side {
    Side { panel, segment }
}

pub struct Pattern {
    pub panels: Vec<Panel>,
    pub seams: Vec<[Side; 2]>,
}

impl Pattern {
    /// The place of a segment in its panel's outline.
    pub fn index_of(&self, Side { panel, segment }: Side) -> usize {
        let found = self.panels.iter().find(|p| p.name == panel);
        let found = found.unwrap_or_else(|| panic!("there is no panel {panel}"));
        let index = found.outline.segments.iter().position(|s| s.name == segment);
        index.unwrap_or_else(|| panic!("panel {panel} has no segment {segment}"))
    }
}
