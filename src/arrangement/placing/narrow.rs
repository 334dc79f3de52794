//! Sleeves and trouser legs that end beyond wrist or ankle though neither hand nor foot fits through: they start short of them.
//!
//! Drafts for longer limbs than the body has are gathered along them when they are worn; from beyond a hand their ends would
//! close through it.

use super::facing::Draft;
use super::figure::Figure;
use super::rims::Opening;
use super::stance::Stance;
use super::surface::Surface;
use super::{Limb, Override};
use crate::body::section::tape;
use crate::body::{Body, Part};
use crate::geometry::Vector3;

/// Openings that are wider than a hand or a foot by this factor go around it.
const EASE: f64 = 1.1;
/// The farthest that a piece is moved for it, m: what is longer is meant to be.
const FARTHEST: f64 = 0.3;

/// Moves sleeves up their arms, and what hangs from a waist up, until narrow openings end at wrists and ankles; by how much the
/// latter, m. Panels whose place was asked for stay.
pub fn free_hands_and_feet(
    surface: &Surface,
    figure: &Figure,
    body: &Body,
    stances: &[Stance],
    overrides: &[Option<Override>],
    (panels, draft): (&[usize], &Draft),
    moves: &mut [Vector3],
) -> f64 {
    let marks = figure.marks;
    let hangs = draft.openings.iter().any(|(_, opening)| *opening == Opening::Top);
    let mut lift: f64 = 0.0;
    for &(rim, opening) in &draft.openings {
        let (limb, end, tip) = match opening {
            Opening::Arm(side) => (Limb::Arm(side), marks.wrists[side], marks.fingertips[side]),
            Opening::Leg(side) if hangs => {
                let ankle = marks.ankles[side];
                (Limb::Leg(side), ankle, Vector3::new(ankle.x, marks.floor, ankle.z))
            }
            _ => continue,
        };
        let Some(way) = (tip - end).try_normalize(1e-3) else { continue };
        if surface.rims[rim].length > EASE * girth_beyond(body, figure, limb, end, way) {
            continue;
        }
        let mut on_rim = vec![false; surface.level.particle_count];
        surface.rims[rim].indices().for_each(|p| on_rim[p as usize] = true);
        let beyond = |&panel: &usize| {
            let points = surface.level.panels[panel].points.clone();
            let ends = points.filter(|&p| on_rim[surface.level.particle_of[p] as usize]);
            let places = ends.map(|p| stances[panel].turned(surface.level.rest[p]) + moves[panel]);
            places.map(|p| (p - end).dot(&way)).fold(f64::NEG_INFINITY, f64::max)
        };
        let far = panels.iter().map(beyond).fold(f64::NEG_INFINITY, f64::max).clamp(0.0, FARTHEST);
        match limb {
            Limb::Leg(_) => lift = lift.max(far),
            _ => {
                for &panel in panels.iter().filter(|&&p| stances[p].limb == limb && overrides[p].is_none()) {
                    // Panels on an arm lie along it, not along the hand.
                    let [along, _] = stances[panel].free;
                    moves[panel] += along * (far * along.dot(&-way).max(0.0));
                }
            }
        }
    }
    if panels.iter().any(|&panel| overrides[panel].is_some()) {
        return 0.0;
    }
    panels.iter().for_each(|&panel| moves[panel].y += lift);
    lift
}

/// The girth, m, of what of a limb lies beyond a point, seen along a direction.
fn girth_beyond(body: &Body, figure: &Figure, limb: Limb, from: Vector3, way: Vector3) -> f64 {
    let part = match limb {
        Limb::Arm(side) => Part::Arm(side as u8),
        Limb::Leg(side) => Part::Leg(side as u8),
        Limb::Torso | Limb::Head => Part::Torso,
    };
    let of_limb = body.positions().iter().zip(&figure.marks.parts).filter(|(_, p)| **p == part);
    let beyond: Vec<Vector3> = of_limb.map(|(p, _)| p - from).filter(|p| p.dot(&way) > 0.0).collect();
    let flat: Vec<Vector3> = beyond.iter().map(|p| p - way * p.dot(&way)).collect();
    tape(&flat, way)
}
