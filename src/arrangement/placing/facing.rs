//! From openings to a map of the garment around the body, and from the map which way each panel faces.

use super::figure::Figure;
use super::map::{Pin, harmonic};
use super::names::Hints;
use super::rims::Opening;
use super::surface::{Rim, Surface};
use crate::geometry::Vector3;
use std::f64::consts::{PI, TAU};

/// Where the openings of a piece pull its particles, m, and what is left of and right of them.
pub struct Draft {
    /// Per particle of the surface, those of the piece; m, world.
    pub places: Vec<Vector3>,
    pub openings: Vec<(usize, Opening)>,
    /// Around its body, and not only in front of and behind it.
    pub is_tube: bool,
}

/// How far a hem at full length is thought below the neck at least, m.
const SHORTEST_WAY: f64 = 0.05;
/// Trial phases of a tube: five degrees.
const PHASES: usize = 72;

/// Maps a piece around the body.
pub fn draft(
    surface: &Surface,
    hints: &[Hints],
    figure: &Figure,
    piece: usize,
    openings: Vec<(usize, Opening)>,
) -> Draft {
    let find = |opening: Opening| openings.iter().find(|(_, o)| *o == opening).map(|(rim, _)| *rim);
    let mut draft = match (find(Opening::Top), find(Opening::Hem)) {
        (Some(top), Some(hem)) => {
            let places = tube(surface, hints, figure, [top, hem]);
            Draft { places, openings, is_tube: true }
        }
        _ => Draft { places: branches(surface, figure, &openings), openings, is_tube: false },
    };
    if !draft.is_tube && is_mirrored(surface, hints, figure.middle, piece, &draft) {
        draft.places.iter_mut().for_each(|p| p.x = 2.0 * figure.middle - p.x);
        for (_, opening) in &mut draft.openings {
            *opening = match *opening {
                Opening::Arm(side) => Opening::Arm(1 - side),
                Opening::Leg(side) => Opening::Leg(1 - side),
                other => other,
            };
        }
        // Arms that do not hang alike: once more, on their own sides.
        draft.places = branches(surface, figure, &draft.openings);
    }
    draft
}

/// Arms, legs, neck and hem have their middles where the body comes out; seen from the front.
fn branches(surface: &Surface, figure: &Figure, openings: &[(usize, Opening)]) -> Vec<Vector3> {
    let marks = figure.marks;
    let start = openings.iter().find(|(_, o)| matches!(o, Opening::Neck | Opening::Top | Opening::Open));
    let base = match start {
        Some((_, Opening::Top)) => marks.waist,
        _ => 0.5 * (marks.neck_sides[0].y + marks.neck_sides[1].y),
    };
    let from_start = start.map(|(rim, _)| surface.distances(surface.rims[*rim].indices()));
    let way = |rim: usize| {
        let distances = from_start.as_ref()?;
        let least = surface.rims[rim].indices().map(|p| distances[p as usize]).fold(f64::INFINITY, f64::min);
        Some(least.max(SHORTEST_WAY)).filter(|way| way.is_finite())
    };
    let mut pins = Vec::new();
    for &(rim, opening) in openings {
        let all = || surface.rims[rim].indices().collect::<Vec<u32>>();
        let place = match opening {
            Opening::Neck | Opening::Top => Vector3::new(figure.middle, base, 0.0),
            Opening::Hem => Vector3::new(figure.middle, base - way(rim).unwrap_or(0.5), 0.0),
            Opening::Arm(side) => figure.along_arm(side, way(rim).unwrap_or(0.5)).0,
            Opening::Leg(side) => figure.leg_at(side, base - way(rim).unwrap_or(0.9)),
            Opening::Open => {
                pins.extend(open_front(surface, figure, openings, rim));
                continue;
            }
        };
        pins.push(Pin { particles: all(), place, axes: Vector3::new(1.0, 1.0, 0.0) });
    }
    harmonic(surface, &pins)
}

/// An open front: what of its line is nearest to the arms is the nape, what is farthest the hem.
fn open_front(surface: &Surface, figure: &Figure, openings: &[(usize, Opening)], rim: usize) -> [Pin; 2] {
    let arms = openings.iter().filter(|(_, o)| matches!(o, Opening::Arm(_)));
    let ways: Vec<Vec<f64>> = arms.map(|(arm, _)| surface.distances(surface.rims[*arm].indices())).collect();
    let mut line: Vec<(f64, u32)> =
        surface.rims[rim].indices().map(|p| (ways.iter().map(|way| way[p as usize]).sum(), p)).collect();
    line.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (nape, hem) = (line.len() / 5, line.len() / 3);
    let top = 0.5 * (figure.marks.neck_sides[0].y + figure.marks.neck_sides[1].y);
    let far = line.last().map_or(0.5, |last| 0.5 * (last.0 - line[0].0)).max(SHORTEST_WAY);
    let pin = |part: &[(f64, u32)], y: f64| Pin {
        particles: part.iter().map(|(_, p)| *p).collect(),
        place: Vector3::new(figure.middle, y, 0.0),
        axes: Vector3::new(1.0, 1.0, 0.0),
    };
    [pin(&line[..nape.max(1)], top), pin(&line[line.len() - hem.max(1)..], top - far)]
}

/// Both rims as level circles, the one below turned as the cloth between them has it least.
fn tube(surface: &Surface, hints: &[Hints], figure: &Figure, [top, hem]: [usize; 2]) -> Vec<Vector3> {
    let (upper, lower) = (&surface.rims[top], &surface.rims[hem]);
    let distances = surface.distances(upper.indices());
    let way = lower.indices().map(|p| distances[p as usize]).fold(f64::INFINITY, f64::min).max(SHORTEST_WAY);
    let base = figure.waist_for(upper.length);
    let around_top: Vec<f64> = upper.particles.iter().map(|(_, along)| along / upper.length).collect();
    let around_hem = around(lower, &distances);
    let circle = |rim: &Rim, around: &[f64], height: f64, sense: f64, phase: f64| {
        let radius = rim.length / TAU;
        let pin = |(&(p, _), share): (&(u32, f64), &f64)| {
            let (sin, cos) = (phase + sense * TAU * share).sin_cos();
            // One of many in one place pulls as all do together.
            let place = Vector3::new(figure.middle + radius * cos, height, radius * sin);
            Pin { particles: vec![p], place, axes: Vector3::repeat(1.0) }
        };
        rim.particles.iter().zip(around).map(pin).collect::<Vec<_>>()
    };
    // Seen from outside the cloth is at the left hand: at the front one walks an upper rim towards the body's right, a lower one
    // towards its left. Angles go from the left, +x, over the front, +z.
    let near: Vec<bool> = distances.iter().map(|&d| d < way).collect();
    let unturned = harmonic(surface, &circle(upper, &around_top, base, 1.0, 0.0));
    let phase = phase(surface, hints, figure, upper, &unturned, &near);
    let mut pins = circle(upper, &around_top, base, 1.0, phase);
    let free = harmonic(surface, &pins);
    let (mut sin, mut cos) = (0.0, 0.0);
    for (&(p, _), share) in lower.particles.iter().zip(&around_hem) {
        let at = free[p as usize];
        let off = at.z.atan2(at.x - figure.middle) + TAU * share;
        let weight = (at.x - figure.middle).hypot(at.z);
        (sin, cos) = (sin + weight * off.sin(), cos + weight * off.cos());
    }
    pins.extend(circle(lower, &around_hem, base - way, -1.0, sin.atan2(cos)));
    harmonic(surface, &pins)
}

/// How far around a tube each particle of its lower rim is, as a share of once around, from the first: what of the rim's length
/// leads towards the upper rim or away from it, along the edges of vents and slits, does not lead around. `distances` are those
/// from the upper rim, m.
fn around(rim: &Rim, distances: &[f64]) -> Vec<f64> {
    let count = rim.particles.len();
    let mut at = 0.0;
    let starts = (0..count).map(|k| {
        let start = at;
        let (p, from) = rim.particles[k];
        let (q, to) = if k + 1 < count { rim.particles[k + 1] } else { (rim.particles[0].0, rim.length) };
        let (length, away) = (to - from, distances[q as usize] - distances[p as usize]);
        at += (length * length - away * away).max(0.0).sqrt();
        start
    });
    let starts: Vec<f64> = starts.collect();
    // A rim that leads nowhere around is no rim of a tube.
    let whole = if at > 0.0 { at } else { f64::INFINITY };
    starts.into_iter().map(|start| start / whole).collect()
}

/// The angle of the first particle of the upper rim: as the names have it, or so that panels lie in front and behind.
/// `free` is the map with the upper rim alone in its place, its first particle at no angle.
fn phase(surface: &Surface, hints: &[Hints], figure: &Figure, upper: &Rim, free: &[Vector3], near: &[bool]) -> f64 {
    let mut area = vec![0.0; hints.len()];
    for (t, a) in surface.level.rest_areas().into_iter().enumerate() {
        let counts = surface.level.particles(t).iter().any(|&p| near[p as usize]);
        area[surface.panel_of[t] as usize] += if counts { a } else { 0.0 };
    }
    let named = |panel: usize| hints[panel].front.is_some() || hints[panel].left.is_some();
    // Middles of the panels along the rim; of all panels, each with its area, where those at the rim have no side in their
    // names: a waistband in one piece.
    let sides: Vec<(f64, f64, usize)> = if upper.panels.iter().any(|&(panel, _)| named(panel)) {
        along_rim(surface, upper)
    } else {
        let all = surface.level.panels.iter().enumerate().filter(|(panel, _)| area[*panel] > 0.0);
        let whole: f64 = area.iter().sum();
        let side = |(panel, range): (usize, &crate::garment::PanelRange)| {
            let places = range.points.clone().map(|p| free[surface.level.particle_of[p] as usize]);
            let (x, z) = places.fold((0.0, 0.0), |(x, z), p| (x + p.x - figure.middle, z + p.z));
            (z.atan2(x), upper.length * area[panel] / whole, panel)
        };
        all.map(side).collect()
    };
    let score = |phase: f64| {
        let of = |&(angle, length, panel): &(f64, f64, usize)| {
            let (sin, cos) = (angle + phase).sin_cos();
            let hint = hints[panel];
            let named = hint.front.map_or(0.0, |front| front * sin) + hint.left.map_or(0.0, |left| left * cos);
            // Without names: seams at the sides, and the larger part behind.
            length * (named + 0.1 * (1.0 - 2.0 * cos * cos)) - 0.01 * area[panel] * sin
        };
        sides.iter().map(of).sum::<f64>()
    };
    let phases = (0..PHASES).map(|k| TAU * k as f64 / PHASES as f64 - PI);
    phases.max_by(|a, b| score(*a).total_cmp(&score(*b))).unwrap_or(0.0)
}

/// The panels at a rim: the angle of the middle of each if the first particle is at none, rad, and its length, m.
fn along_rim(surface: &Surface, rim: &Rim) -> Vec<(f64, f64, usize)> {
    let mut panel_of = vec![usize::MAX; surface.neighbors.len()];
    for (t, &panel) in surface.panel_of.iter().enumerate() {
        surface.level.particles(t).iter().for_each(|&p| panel_of[p as usize] = panel as usize);
    }
    let side = |&(panel, length): &(usize, f64)| {
        let (mut sin, mut cos) = (0.0, 0.0);
        for (_, along) in rim.particles.iter().filter(|(p, _)| panel_of[*p as usize] == panel) {
            let (s, c) = (TAU * along / rim.length).sin_cos();
            (sin, cos) = (sin + s, cos + c);
        }
        (sin.atan2(cos), length, panel)
    };
    rim.panels.iter().map(side).collect()
}

/// Does the map have left and right, and with them front and back, the wrong way round?
fn is_mirrored(surface: &Surface, hints: &[Hints], middle: f64, piece: usize, draft: &Draft) -> bool {
    let (mut named, mut silent) = (0.0, 0.0);
    for (panel, hint) in hints.iter().enumerate() {
        let range = &surface.level.panels[panel];
        if surface.piece_of[surface.level.particle_of[range.points.start] as usize] != piece {
            continue;
        }
        let look = look(surface, panel, &draft.places);
        let facing = look.normal.z / look.area.max(1e-12);
        named += hint.front.unwrap_or(0.0) * facing.signum() * look.rest_area;
        named += hint.left.unwrap_or(0.0) * (look.middle.x - middle).signum() * look.rest_area;
        // Back parts are larger, where anybody sits in them, and reach higher, at the neck.
        silent -= facing.signum() * look.rest_area;
    }
    if named != 0.0 {
        return named < 0.0;
    }
    for (rim, opening) in &draft.openings {
        if *opening == Opening::Neck {
            silent = neck_depth(surface, *rim, draft);
        }
    }
    silent < 0.0
}

/// How much deeper the neckline is cut in what faces the front, m.
fn neck_depth(surface: &Surface, rim: usize, draft: &Draft) -> f64 {
    let hem = draft.openings.iter().find(|(_, o)| matches!(o, Opening::Hem | Opening::Leg(_)));
    let Some((hem, _)) = hem else { return 0.0 };
    let ways = surface.distances(surface.rims[*hem].indices());
    // Under a hood the neckline is its seam.
    let heads = heads(surface, &draft.openings);
    let mut at_neck = vec![false; surface.level.particle_count];
    surface.rims[rim].indices().for_each(|p| at_neck[p as usize] = true);
    for (t, _) in surface.panel_of.iter().enumerate().filter(|(_, panel)| heads[**panel as usize]) {
        surface.level.particles(t).iter().for_each(|&p| at_neck[p as usize] = true);
    }
    let mut least = [f64::INFINITY; 2];
    for (panel, range) in surface.level.panels.iter().enumerate().filter(|(panel, _)| !heads[*panel]) {
        let side = usize::from(look(surface, panel, &draft.places).normal.z < 0.0);
        for p in range.points.clone().map(|p| surface.level.particle_of[p] as usize).filter(|&p| at_neck[p]) {
            least[side] = least[side].min(ways[p]);
        }
    }
    if least.iter().all(|l| l.is_finite()) { least[1] - least[0] } else { 0.0 }
}

/// A function on the particles that is 1 at one opening and 0 at all others, as smooth as can be.
pub fn flow(surface: &Surface, openings: &[(usize, Opening)], source: usize) -> Vec<f64> {
    let pins = openings.iter().flat_map(|&(rim, _)| {
        let place = Vector3::x() * if rim == source { 1.0 } else { 0.0 };
        surface.rims[rim].indices().map(move |p| Pin { particles: vec![p], place, axes: Vector3::x() })
    });
    harmonic(surface, &pins.collect::<Vec<_>>()).into_iter().map(|f| f.x).collect()
}

/// The flow from the neck that a panel has in the mean, at least, if it is a hood, and its area, m², at least: a collar is smaller.
const HOOD_FLOW: f64 = 0.55;
const HOOD_AREA: f64 = 0.03;

/// Per panel: is it a hood? Its opening is that of the neck, and it is large.
pub fn heads(surface: &Surface, openings: &[(usize, Opening)]) -> Vec<bool> {
    let Some(&(neck, _)) = openings.iter().find(|(_, o)| *o == Opening::Neck) else {
        return vec![false; surface.level.panels.len()];
    };
    let flow = flow(surface, openings, neck);
    let areas = surface.level.rest_areas();
    let is_head = |range: &crate::garment::PanelRange| {
        let sum: f64 = range.points.clone().map(|p| flow[surface.level.particle_of[p] as usize]).sum();
        let area: f64 = areas[range.triangles.clone()].iter().sum();
        area > HOOD_AREA && sum > HOOD_FLOW * range.points.len() as f64
    };
    surface.level.panels.iter().map(is_head).collect()
}

/// How a panel lies in a map.
pub struct Look {
    /// Sum of the normals of its triangles, as long as they are large in the map, m².
    pub normal: Vector3,
    /// Sum of their sizes in the map, m².
    pub area: f64,
    /// On the panel, m².
    pub rest_area: f64,
    pub middle: Vector3,
}

pub fn look(surface: &Surface, panel: usize, places: &[Vector3]) -> Look {
    let (mut normal, mut area, mut rest_area, mut middle) = (Vector3::zeros(), 0.0, 0.0, Vector3::zeros());
    for t in surface.level.panels[panel].triangles.clone() {
        let [a, b, c] = surface.level.particles(t).map(|p| places[p as usize]);
        let n = (b - a).cross(&(c - a)) * 0.5;
        let [p, q, r] = surface.level.rest_corners(t);
        let rest = crate::geometry::signed_area(p, q, r).abs();
        normal += n;
        area += n.norm();
        rest_area += rest;
        middle += (a + b + c) * (rest / 3.0);
    }
    Look { normal, area, rest_area, middle: middle / rest_area.max(1e-12) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vent_leads_nowhere_around_a_hem() {
        // Around for 0.3 m, up and down a slit of 0.2 m, around for 0.1 m; the upper rim is half a metre above the hem.
        let along = [0.0, 0.1, 0.2, 0.3, 0.5, 0.7];
        let particles = along.iter().enumerate().map(|(p, &along)| (p as u32, along)).collect();
        let rim = Rim { particles, length: 0.8, panels: Vec::new(), piece: 0 };
        let shares = around(&rim, &[0.5, 0.5, 0.5, 0.5, 0.3, 0.5]);
        for (share, wanted) in shares.iter().zip([0.0, 0.25, 0.5, 0.75, 0.75, 0.75]) {
            assert!((share - wanted).abs() < 1e-12, "{shares:?}");
        }
    }
}
