//! Hems that would start around the feet are drawn up above the ankles until the garment is sewn, as trousers are put on.
//!
//! A leg that is too long closes around the foot otherwise, or under its toes, and nothing leads it out again. Thought shorter
//! until its seams are closed it closes around the ankle, and slides down over the instep when it gets its length back.

use crate::body::{Body, Landmarks};
use crate::garment::Level;
use crate::geometry::{Vector2, Vector3};
use nalgebra::Matrix2;

/// What starts higher than this share of the body's height is not at its feet.
const FEET: f64 = 0.08;
/// How far above the ankle a hem is drawn, m: past the bend of the instep.
const ABOVE_ANKLE: f64 = 0.01;

/// The open level as it is sewn: where its panels reach below the ankles, what is below the knees is thought shorter, evenly.
/// `positions` of its particles, m, world, follow. None if nothing is to be drawn up.
pub fn draw_up(body: &Body, open: &Level, positions: &mut [Vector3]) -> Option<Level> {
    let lowest = positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let (low, high) = body.bounds();
    if lowest > low.y + FEET * (high.y - low.y) {
        return None;
    }
    let marks = Landmarks::find(body).ok()?;
    let ankle = marks.ankles[0].y.max(marks.ankles[1].y) + ABOVE_ANKLE;
    let knee = marks.knees[0].y.min(marks.knees[1].y);
    if lowest >= ankle || ankle >= knee {
        return None;
    }
    let share = (knee - ankle) / (knee - lowest);
    let rise = |y: f64| (1.0 - share) * (knee - y).max(0.0);
    let mut shorter = open.clone();
    for panel in &open.panels {
        let points = panel.points.clone();
        let (rest, at) = (&mut shorter.rest[points.clone()], &mut positions[points]);
        // Where up is on the panel, if it stands at all.
        let up = slope(rest, at);
        let along = if up.norm() > LEAST_SLOPE { up / up.norm_squared() } else { Vector2::zeros() };
        for (rest, at) in rest.iter_mut().zip(at) {
            *rest += along * rise(at.y);
            at.y += rise(at.y);
        }
    }
    Some(shorter)
}

/// The open level on its way back to its length: a share of what it was shortened by is left.
pub fn lengthened(open: &Level, shorter: &Level, left: f64) -> Level {
    let rest = open.rest.iter().zip(&shorter.rest).map(|(long, short)| long.lerp(short, left)).collect();
    Level { rest, ..open.clone() }
}

/// A panel that rises less than this, m a metre, lies.
const LEAST_SLOPE: f64 = 0.3;

/// By how much the height of a panel's points grows with their places on it, m a metre: the nearest linear function.
fn slope(rest: &[Vector2], at: &[Vector3]) -> Vector2 {
    let count = rest.len() as f64;
    let middle = rest.iter().sum::<Vector2>() / count;
    let height = at.iter().map(|p| p.y).sum::<f64>() / count;
    let (mut spread, mut rise) = (Matrix2::zeros(), Vector2::zeros());
    for (p, at) in rest.iter().zip(at) {
        spread += (p - middle) * (p - middle).transpose();
        rise += (p - middle) * (at.y - height);
    }
    spread.try_inverse().map_or(Vector2::zeros(), |inverse| inverse * rise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrangement::placed;
    use crate::garment::Garment;
    use crate::io::{body_obj, embedded};
    use crate::pattern::{Curve, Panel, Pattern, Placement, Segment};
    use nalgebra::Rotation3;

    /// The open level of a panel beside the leg, 20 cm wide, from a height down to another, m, turned in its plane.
    fn leg(top: f64, bottom: f64, turned: f64) -> (Pattern, Level) {
        let turn = nalgebra::Rotation2::new(turned);
        let corners = [[-0.1, bottom], [0.1, bottom], [0.1, top], [-0.1, top]].map(|c| turn * Vector2::from(c));
        let sides = (0..4).map(|k| Segment { curve: Curve::line(corners[k], corners[(k + 1) % 4]), label: None });
        let upright = Rotation3::from_axis_angle(&Vector3::z_axis(), -turned);
        let placement = Placement::flat(upright, Vector3::new(0.1, 0.0, 0.2));
        let panel = Panel::new("leg", sides.collect()).at(placement);
        let pattern = Pattern { name: "leg".into(), panels: vec![panel], seams: vec![] };
        let open = Garment::build(&pattern, &[0.03]).unwrap().open;
        (pattern, open)
    }

    #[test]
    fn what_reaches_below_the_ankles_is_drawn_up_without_strain_and_gets_its_length_back() {
        let body = body_obj::parse(embedded::MANNEQUIN_OBJ).unwrap().0;
        let ankle = Landmarks::find(&body).unwrap().ankles[0].y;
        for turned in [0.0, 0.8] {
            let (pattern, open) = leg(0.7, -0.03, turned);
            let start = placed(&pattern, &open);
            let mut positions = start.clone();
            let shorter = draw_up(&body, &open, &mut positions).unwrap();
            let lowest = positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
            assert!((lowest - ankle - ABOVE_ANKLE).abs() < 2e-3, "{lowest} at the ankle, {ankle}");
            assert!(start.iter().zip(&positions).all(|(a, b)| (a.x, a.z) == (b.x, b.z) && (a.y < 0.6 || a == b)));
            for t in 0..open.triangles.len() {
                let (rest, at) = (shorter.rest_corners(t), open.particles(t).map(|p| positions[p as usize]));
                for k in 0..3 {
                    let strain = (at[k] - at[(k + 1) % 3]).norm() / (rest[k] - rest[(k + 1) % 3]).norm() - 1.0;
                    assert!(strain.abs() < 0.01, "an edge is strained by {strain}");
                }
            }
            assert_eq!(lengthened(&open, &shorter, 0.0).rest, open.rest);
        }
    }

    #[test]
    fn what_ends_above_the_ankles_stays_as_it_is() {
        let body = body_obj::parse(embedded::MANNEQUIN_OBJ).unwrap().0;
        let (pattern, open) = leg(0.7, 0.16, 0.0);
        let mut positions = placed(&pattern, &open);
        let before = positions.clone();
        assert!(draw_up(&body, &open, &mut positions).is_none() && positions == before);
    }
}
