//! Small patterns for tests.

use super::*;

/// A panel with straight sides through `corners`, m.
pub fn polygon(name: &str, corners: &[[f64; 2]]) -> Panel {
    let corner = |k: usize| Vector2::from(corners[k % corners.len()]);
    let side = |k| Segment { curve: Curve::line(corner(k), corner(k + 1)), label: None };
    let placement = Placement::flat(Rotation3::identity(), Vector3::zeros());
    Panel::new(name, (0..corners.len()).map(side).collect()).at(placement)
}

/// A rectangle from the origin; its segments are bottom, right, top and left.
pub fn rectangle(name: &str, width: f64, height: f64) -> Panel {
    polygon(name, &[[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
}

/// One panel and no seams.
pub fn cloth(panel: Panel) -> Pattern {
    Pattern { name: "cloth".to_owned(), panels: vec![panel], seams: vec![] }
}

fn seam(a: [usize; 2], b: [usize; 2]) -> Seam {
    let side = |[panel, segment]: [usize; 2]| SegmentId { panel, segment };
    Seam { sides: [side(a), side(b)], sense: Sense::Opposed }
}

/// Two rectangles side by side, the right side of the first sewn to the left side of the second.
pub fn two_rectangles(width: f64, height: f64) -> Pattern {
    let panels = vec![rectangle("left", width, height), rectangle("right", width, height)];
    Pattern { name: "pair".to_owned(), panels, seams: vec![seam([0, 1], [1, 3])] }
}

/// A rectangle whose left side is sewn to its right side.
pub fn tube(girth: f64, height: f64) -> Pattern {
    Pattern { seams: vec![seam([0, 1], [0, 3])], ..cloth(rectangle("tube", girth, height)) }
}
