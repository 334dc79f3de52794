//! Panels drawn as one sees them through the body: their wrong side.
//!
//! A draft shows every panel right side up. Some programs draw backs as one sees them through the front instead, so that what is left
//! on the front is left on the back as well. One panel alone does not show it; the names of fronts and backs of one side do.

use super::names::{Face, role};
use super::sewing::Measured;
use super::{Panel, Pattern, SegmentId};
use crate::geometry::Vector2;

/// Per panel: does its drawing show the wrong side of the fabric? Known of drawings whose names tell left and right, front and
/// back; nobody's where panels have places, which tell more.
pub fn shown_from_inside(pattern: &Pattern) -> Vec<bool> {
    /// Lengths of which the smaller is more than this share of the larger are equal.
    const EQUAL: f64 = 0.995;
    let roles: Vec<_> = pattern.panels.iter().map(|panel| role(&panel.name)).collect();
    let mut shown = vec![false; pattern.panels.len()];
    if pattern.panels.iter().any(|panel| panel.placement.is_some()) {
        return shown;
    }
    let measured = Measured::new(pattern);
    let asides: Vec<Vec<(f64, f64)>> = (0..pattern.panels.len()).map(|k| asides(pattern, &measured, k)).collect();
    // What is sewn at the side points aside on both panels: different ways where both show the right side.
    let mut votes = 0;
    for (a, one) in roles.iter().enumerate() {
        for (b, other) in roles.iter().enumerate().skip(a + 1) {
            let faced = matches!((one.face, other.face), (Some(f), Some(g)) if f != g);
            if faced && one.side.is_some() && one.side == other.side && one.part == other.part {
                for (p, x) in &asides[a] {
                    for (_, y) in asides[b].iter().filter(|(q, _)| p.min(*q) > EQUAL * p.max(*q)) {
                        votes += if x * y > 0.0 { 1 } else { -1 };
                    }
                }
            }
        }
    }
    if votes > 0 {
        shown = roles.iter().map(|role| role.face == Some(Face::Back)).collect();
    }
    shown
}

/// Length and way, left or right, of the segments of a panel that face aside in the drawing.
fn asides(pattern: &Pattern, measured: &Measured, panel: usize) -> Vec<(f64, f64)> {
    /// By at least this share.
    const ASIDE: f64 = 0.7;
    let turn = pattern.panels[panel].signed_area().signum();
    let outwards = |segment: usize| {
        let id = SegmentId { panel, segment };
        let chord = measured.point(id, 1.0) - measured.point(id, 0.0);
        let out = Vector2::new(chord.y, -chord.x) * turn;
        // Seen with the side up that the outline says is the right one.
        (measured.length_of(id), turn * out.x / chord.norm().max(1e-6))
    };
    (0..pattern.panels[panel].segments.len()).map(outwards).filter(|(_, x)| x.abs() > ASIDE).collect()
}

impl Pattern {
    /// The panels with some of them turned over: their outlines run the other way round, from the same corner.
    pub fn turned_over(&self, which: &[bool]) -> Self {
        let panel = |(panel, turned): (&Panel, &bool)| if *turned { panel.turned_over() } else { panel.clone() };
        Self { panels: self.panels.iter().zip(which).map(panel).collect(), seams: Vec::new(), name: self.name.clone() }
    }

    /// Where a segment of the panels turned over is on the panels as they were, and the other way round.
    pub fn turned_segment(&self, which: &[bool], id: SegmentId) -> SegmentId {
        let last = self.panels[id.panel].segments.len() - 1;
        SegmentId { segment: if which[id.panel] { last - id.segment } else { id.segment }, ..id }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::shapes::polygon;

    /// A quarter of a top: its middle, at the left of the drawing or at the right, is longer than its side.
    fn quarter(name: &str, middle_is_left: bool) -> Panel {
        let corners = [[0.0, 0.0], [0.25, 0.0], [0.25, 0.4], [0.0, 0.5]];
        let mut mirrored = corners.map(|[x, y]| [0.25 - x, y]);
        mirrored.reverse();
        Panel { placement: None, ..polygon(name, if middle_is_left { &corners } else { &mirrored }) }
    }

    #[test]
    fn names_tell_backs_that_are_drawn_as_seen_through_the_front() {
        let top = |backs_are_left: bool| Pattern {
            name: "top".to_owned(),
            panels: vec![
                quarter("left_front", true),
                quarter("right_front", false),
                quarter("left_back", !backs_are_left),
                quarter("right_back", backs_are_left),
            ],
            seams: Vec::new(),
        };
        // Seen from behind, the left half has its middle at the right.
        assert_eq!(shown_from_inside(&top(true)), [false; 4]);
        let inside = top(false);
        let shown = shown_from_inside(&inside);
        assert_eq!(shown, [false, false, true, true]);
        let seen = inside.turned_over(&shown);
        assert_eq!(shown_from_inside(&seen), [false; 4]);
        let there = seen.turned_segment(&shown, SegmentId { panel: 3, segment: 1 });
        assert_eq!(there, SegmentId { panel: 3, segment: 2 });
        let length = |pattern: &Pattern, id| pattern.segment(id).curve.length();
        assert_eq!(length(&seen, SegmentId { panel: 3, segment: 1 }), length(&inside, there));
        // Panels in places need no names.
        let mut placed = inside;
        placed.panels[0] = polygon("left_front", &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(shown_from_inside(&placed), [false; 4]);
    }
}
