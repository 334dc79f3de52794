//! What a body does to cloth that comes near it: changes of velocity and, where cloth is in it, of place.
//!
//! Each particle keeps track of the place of the skin that is nearest to it. By its distance `d` from there it is in
//! one of four classes (Kaynar Kabul 2004, chapter 5):
//!
//! ```text
//!     free           d > δ + b                nothing
//!     proximity      δ < d ≤ δ + b            a penalty along the closest-point direction: approach is slowed down, the
//!                                             more the nearer, so that cloth arrives softly; not where it is to rebound
//!     contact        d ≤ δ after the step     a velocity that keeps δ: reflection and friction in the body's frame
//!     interference   d < 0                    put back on the skin
//! ```
//!
//! `δ` is the clearance. The velocity of the skin is that of the moving triangle at the foot's barycentric weights.
//! Contact is no spring: what rests on the body rests there in exactly the balance of the fit.
//!
//! In a fold of the body a particle meets both skins. Where they leave no room for its clearances it is let be: it goes along
//! with both, to the middle between them and toward the open side (theory, equation 30), the limit of stretch has the last word,
//! and it is not put back.
//!
//! Where the body bulges out between particles they keep farther off: middles of edges and triangles are looked at every
//! so many steps, and what they lack is added to what the particles around keep beyond the clearance.
//!
//! Friction is Coulomb's: a change of the normal velocity by `Δv` takes up to `μ Δv` from the tangential one.

use super::integrator::for_all;
use super::surface::{Place, Surface};
use crate::garment::Level;
use crate::geometry::{EdgeTable, Vector3};
use crate::minimize::CHUNK;
use rayon::prelude::*;

/// Width `b` of the band in which approach is slowed down, m: a step at a metre a second is a tenth of a millimetre.
const BAND: f64 = 5e-4;
/// Cloth inside its clearance regains it at this speed, m/s: fast enough to follow a limb that turns under it, slow
/// enough not to throw it off.
const RECOVERY: f64 = 0.05;
/// Particles within this distance of the skin remember their place, m; for those farther away it is looked for again.
const NEAR: f64 = 0.012;
/// How far away the nearest place is looked for, m.
const REACH: f64 = 0.12;
/// After so many steps a place that is remembered is looked for again: a nearer one may have come from elsewhere.
const REMEMBERED: u32 = 24;
/// For so many steps a place is taken to go along with its triangle, unless the particle has slid farther over the skin
/// than [`SLID`], m: the skin turns by less than its triangles meet at.
const CARRIED: u32 = 6;
const SLID: f64 = 4e-4;
/// Particles that will be nearer to the skin than this after a step are looked at again there, m.
const CLOSE: f64 = 1e-4;
/// The middles of edges and triangles keep this share of the clearance.
const MARGIN: f64 = 0.5;
/// How far the body bulges out between particles, at most, as a share of their distance.
const BULGE: f64 = 0.3;
/// Impacts slower than this are no impacts, m/s: gravity over a step.
const SLOWEST_IMPACT: f64 = 0.05;

/// Skin that faces that which a particle is near to is looked for within this distance, m.
const ACROSS: f64 = 0.012;
/// And within this one by a particle that is inside the body: how far two limbs may pass through each other, m.
const OVERLAP: f64 = 0.05;
/// Cosine of the angle between the normals of two skins below which they hold cloth fast that they leave no room: friction
/// of 0.6 keeps it in a fold of sixty degrees.
const SHARP: f64 = -0.5;
/// Such cloth moves to the middle between them, and out of the fold, at these speeds, m/s.
const TO_MIDDLE: f64 = 0.5;
const SQUEEZE: f64 = 0.5;
/// Particles deeper inside than this, m, as they were between skins that have parted, come out at this speed, m/s; others
/// are put back at once.
const DEEP: f64 = 1e-3;
const RETURN: f64 = 0.5;

/// What is known of a particle and the skin.
#[derive(Clone, Copy, Debug)]
struct Track {
    /// The nearest place, when it was last computed, if the particle is near one.
    place: Option<Place>,
    /// The nearest place of skin that faces the skin there, if that is near as well or passes through it.
    other: Option<Place>,
    /// Do the two leave no room between them?
    pinched: bool,
    /// Steps since it was looked for everywhere, and since it was computed.
    age: u32,
    carried: u32,
    /// How far the particle has slid over the skin since it was computed, m.
    slid: f64,
    /// How far it and the skin may still move against each other before they can touch, m.
    slack: f64,
    /// May it be inside after the step?
    close: bool,
    /// What the particle keeps beyond the clearance, m.
    extra: f64,
    /// The triangle of the last place: the side of a narrow gap that the particle is on.
    side: u32,
    /// The least velocities along the directions away from the skins that the last response left it, m/s.
    least: [Option<(Vector3, f64)>; 2],
    /// Does it pass through the body?
    free: bool,
}

impl Track {
    const UNKNOWN: Track = Track {
        place: None,
        other: None,
        pinched: false,
        age: 0,
        carried: 0,
        slid: 0.0,
        slack: f64::NEG_INFINITY,
        close: false,
        extra: 0.0,
        side: NOWHERE,
        least: [None; 2],
        free: false,
    };
}

/// No triangle.
const NOWHERE: u32 = u32::MAX;

/// What contact remembers from frame to frame, one of each per particle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Remembered {
    /// What the particle keeps beyond the clearance, m.
    pub extra: Vec<f64>,
    /// The triangle of the body that it was last near to; any number that is none if it was near to none.
    pub triangles: Vec<u32>,
}

/// Contact of particles with a moving surface.
pub struct Response {
    tracks: Vec<Track>,
    friction: f64,
    restitution: f64,
    clearance: f64,
}

/// The cloth between particles: edges and triangles of a level, and how near they have to be to the skin to be looked
/// at, m.
pub struct Middles {
    edges: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
    reach: f64,
}

impl Middles {
    pub fn new(level: &Level) -> Self {
        let triangles = level.particle_triangles();
        let edges = EdgeTable::new(&triangles).edges.iter().map(|edge| edge.ends).collect();
        Self { edges, triangles, reach: BULGE * level.resolution }
    }
}

/// How a step met the body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Met {
    pub in_contact: usize,
    /// Particles between two skins that leave them no room.
    pub pinched: usize,
    /// Particles that had to be put back on the skin.
    pub interfering: usize,
    /// The deepest of them, m.
    pub deepest: f64,
}

impl Met {
    fn and(self, other: Met) -> Met {
        Met {
            in_contact: self.in_contact + other.in_contact,
            pinched: self.pinched + other.pinched,
            interfering: self.interfering + other.interfering,
            deepest: self.deepest.max(other.deepest),
        }
    }
}

impl Response {
    pub fn new(particles: usize, clearance: f64, friction: f64, restitution: f64) -> Self {
        Self { tracks: vec![Track::UNKNOWN; particles], friction, restitution, clearance }
    }

    /// The same, but for some particles, true in a list of all of them or of none, that pass through the body.
    pub fn without(mut self, free: Vec<bool>) -> Self {
        self.tracks.iter_mut().zip(free).for_each(|(track, free)| track.free = free);
        self
    }

    /// Forgets all places, but for the sides that particles are on: they are looked for again.
    pub fn look_afresh(&mut self) {
        for track in &mut self.tracks {
            *track = Track { extra: track.extra, side: track.side, free: track.free, ..Track::UNKNOWN };
        }
    }

    pub fn remembered(&self) -> Remembered {
        let of = |track: &Track| (track.extra, track.side);
        let (extra, triangles) = self.tracks.iter().map(of).unzip();
        Remembered { extra, triangles }
    }

    pub fn remember(&mut self, remembered: &Remembered) {
        let each = remembered.extra.iter().zip(&remembered.triangles);
        self.tracks.iter_mut().zip(each).for_each(|(track, (&extra, &side))| (track.extra, track.side) = (extra, side));
    }

    /// Takes over what the fit holds farther out than its clearance, as a sharp part of the body would come through
    /// between the particles otherwise: all that presses on the skin from where it is. `gradient` is that of the
    /// energies at `positions`, N.
    pub fn take_over(&mut self, surface: &Surface, positions: &[Vector3], gradient: &[Vector3]) {
        let clearance = self.clearance;
        let extra = |((track, p), g): ((&Track, &Vector3), &Vector3)| {
            let place = surface.nearest(*p, clearance + MOST_EXTRA).filter(|_| !track.free)?;
            (g.dot(&place.normal) > 0.0).then_some((place.distance - clearance).max(0.0))
        };
        let each = self.tracks.par_iter().zip(positions).zip(gradient);
        let extra: Vec<f64> = each.map(|at| extra(at).unwrap_or(0.0)).collect();
        self.tracks.iter_mut().zip(extra).for_each(|(track, extra)| track.extra = extra);
    }

    /// Changes velocities, m/s, of particles at `positions`, m, so that after `step`, s, they are clear of the surface,
    /// which will have moved as well.
    pub fn respond(&mut self, surface: &Surface, positions: &[Vector3], velocities: &mut [Vector3], step: f64) -> Met {
        let (friction, restitution, clearance) = (self.friction, self.restitution, self.clearance);
        let chunks =
            self.tracks.par_chunks_mut(CHUNK).zip(positions.par_chunks(CHUNK)).zip(velocities.par_chunks_mut(CHUNK));
        let met = chunks.map(|((tracks, positions), velocities)| {
            let mut met = Met::default();
            for ((track, &position), velocity) in tracks.iter_mut().zip(positions).zip(velocities) {
                track.least = [None; 2];
                let Some((place, other)) = track.follow(surface, position, *velocity, step, clearance) else {
                    continue;
                };
                track.pinched = other.is_some_and(|other| no_room(&place, &other, clearance));
                if let (true, Some(other)) = (track.pinched, other) {
                    met.in_contact += 1;
                    met.pinched += 1;
                    let skin = between(surface, [&place, &other], velocity, friction, step);
                    track.slid += (*velocity - skin).norm() * step;
                    track.extra = 0.0;
                    continue;
                }
                let against = Against { friction, restitution, clearance: clearance + track.extra, step };
                let (first, touches) = against.meet(surface, &place, velocity);
                track.least[0] = Some(first);
                let mut arrives = touches;
                if let Some(other) = other {
                    let (second, touches) = against.meet(surface, &other, velocity);
                    track.least[1] = Some(second);
                    arrives |= touches;
                    track.hold(velocity);
                }
                met.in_contact += usize::from(arrives);
                let relative = *velocity - surface.velocity(&place);
                let slid = (relative - place.normal * relative.dot(&place.normal)).norm() * step;
                track.slid += slid;
                if track.extra > 0.0 {
                    track.extra *= (-slid / FORGETTING).exp();
                }
                let after =
                    |place: &Place| place.distance + (*velocity - surface.velocity(place)).dot(&place.normal) * step;
                track.close = after(&place).min(other.as_ref().map_or(f64::INFINITY, after)) < CLOSE;
            }
            met
        });
        met.reduce(Met::default, Met::and)
    }

    /// Takes back what has been changed since the last response in velocities, m/s, as far as it leads into the body.
    pub fn hold_off(&self, velocities: &mut [Vector3]) {
        for_all(velocities, |p, velocity| self.hold(p, velocity));
    }

    /// The same for one particle.
    pub fn hold(&self, particle: usize, velocity: &mut Vector3) {
        self.tracks[particle].hold(velocity);
    }

    /// Which particles are between two skins that leave them no room.
    pub fn pinched(&self) -> Vec<bool> {
        self.tracks.iter().map(|track| track.pinched).collect()
    }

    /// Has particles keep farther off where the body comes through the cloth between them: at the middles of edges and
    /// triangles, given by their corners, of cloth that is at `positions`, m.
    pub fn look_between(&mut self, surface: &Surface, positions: &[Vector3], middles: &Middles) {
        let (tracks, margin) = (&self.tracks, MARGIN * self.clearance);
        let missing = |corners: &[u32]| {
            let mut start: Option<Place> = None;
            let mut middle = Vector3::zeros();
            for &p in corners {
                let place = tracks[p as usize].place.filter(|_| !tracks[p as usize].pinched)?;
                if start.is_none_or(|nearest| place.distance < nearest.distance) {
                    start = Some(place);
                }
                middle += positions[p as usize];
            }
            let start = start.filter(|nearest| nearest.distance < middles.reach)?;
            let place = surface.refine(middle / corners.len() as f64, start.triangle);
            // What lies on the far side of a limb is not what these particles lie on.
            let there = place.normal.dot(&start.normal) > 0.0;
            let missing = margin - place.distance;
            (there && missing > 0.0).then_some(missing.min(MOST_EXTRA))
        };
        let found = |all: &[u32], size: usize| -> Vec<(u32, f64)> {
            let chunks = all.par_chunks(CHUNK * size).enumerate().map(|(chunk, corners)| {
                let at = corners.chunks_exact(size).enumerate();
                at.filter_map(|(k, corners)| Some(((chunk * CHUNK + k) as u32, missing(corners)?))).collect::<Vec<_>>()
            });
            chunks.collect::<Vec<_>>().concat()
        };
        let (edges, triangles) = (middles.edges.as_flattened(), middles.triangles.as_flattened());
        let mut more = vec![0.0f64; positions.len()];
        for (all, size) in [(edges, 2), (triangles, 3)] {
            for (k, missing) in found(all, size) {
                for &p in &all[k as usize * size..][..size] {
                    more[p as usize] = more[p as usize].max(missing);
                }
            }
        }
        for (track, more) in self.tracks.iter_mut().zip(more) {
            if more > 0.0 {
                // It may lie farther off than it has to already.
                let kept = track.place.map_or(0.0, |place| (place.distance - self.clearance).max(0.0));
                track.extra = track.extra.max((kept.min(MOST_EXTRA) + more).min(MOST_EXTRA));
                track.slack = f64::NEG_INFINITY;
            }
        }
    }

    /// Puts particles that are in the body after `step`, s, back on the skin, and has them move with it.
    pub fn put_back(
        &mut self,
        surface: &Surface,
        positions: &mut [Vector3],
        velocities: &mut [Vector3],
        step: f64,
    ) -> Met {
        let chunks =
            self.tracks.par_chunks(CHUNK).zip(positions.par_chunks_mut(CHUNK)).zip(velocities.par_chunks_mut(CHUNK));
        let met = chunks.map(|((tracks, positions), velocities)| {
            let mut met = Met::default();
            for ((track, position), velocity) in tracks.iter().zip(positions).zip(velocities) {
                for place in [track.place, track.other].into_iter().flatten().filter(|_| track.close) {
                    if surface.carried(*position, &place).distance > 0.5 * CLOSE {
                        continue;
                    }
                    let place = surface.refine(*position, place.triangle);
                    if place.distance < 0.0 {
                        met.interfering += 1;
                        met.deepest = met.deepest.max(-place.distance);
                        *position = match -place.distance < DEEP {
                            true => place.point + place.normal * ON_TOP,
                            false => *position + place.normal * (RETURN * step),
                        };
                        let inward = (*velocity - surface.velocity(&place)).dot(&place.normal).min(0.0);
                        *velocity -= place.normal * inward;
                    }
                }
            }
            met
        });
        met.reduce(Met::default, Met::and)
    }
}

/// How a particle meets one skin.
struct Against {
    friction: f64,
    restitution: f64,
    /// With what the particle keeps beyond it, m.
    clearance: f64,
    /// s.
    step: f64,
}

impl Against {
    /// Changes a velocity, m/s, so that it keeps the clearance from a place; returns the least along its normal that does, with
    /// the normal, and whether they touch.
    fn meet(&self, surface: &Surface, place: &Place, velocity: &mut Vector3) -> ((Vector3, f64), bool) {
        let skin = surface.velocity(place);
        let (normal, relative) = (place.normal, *velocity - skin);
        let approach = relative.dot(&normal);
        let gap = place.distance - self.clearance;
        let touches = gap <= 0.0 || gap + approach * self.step <= 0.0;
        let least = if touches {
            let rebound = if approach < -SLOWEST_IMPACT { -self.restitution * approach } else { f64::NEG_INFINITY };
            (-gap / self.step).min(RECOVERY).max(rebound)
        } else if gap < BAND && self.restitution == 0.0 {
            approach * (gap / BAND)
        } else {
            // It moves as it likes.
            f64::NEG_INFINITY
        };
        if approach < least {
            let push = least - approach;
            let along = relative - normal * approach;
            let speed = along.norm();
            // Neither a rebound nor the way back to the clearance presses.
            let grip = (self.friction * (push - least.max(0.0))).min(speed);
            let slowed = if speed > 0.0 { along * (1.0 - grip / speed) } else { along };
            *velocity = skin + slowed + normal * least;
        }
        ((normal, skin.dot(&normal) + least.max((-gap / self.step).min(RECOVERY))), touches)
    }
}

/// Do two skins that face each other hold a particle fast between them?
fn no_room(one: &Place, other: &Place, clearance: f64) -> bool {
    one.distance + other.distance < 2.0 * clearance && one.normal.dot(&other.normal) < SHARP
}

/// Changes the velocity, m/s, of a particle between two skins that leave it no room, so that it goes along with both, to the
/// middle between them and out of the fold; returns the velocity of the skins.
fn between(surface: &Surface, places: [&Place; 2], velocity: &mut Vector3, friction: f64, step: f64) -> Vector3 {
    let [one, other] = places;
    let skin = (surface.velocity(one) + surface.velocity(other)) * 0.5;
    // Facing skins have normals that differ by one at least.
    let across = (one.normal - other.normal).normalize();
    let missing = 0.5 * (other.distance - one.distance) / one.normal.dot(&across);
    let wanted = (missing / step).clamp(-TO_MIDDLE, TO_MIDDLE);
    let relative = *velocity - skin;
    let speed_across = relative.dot(&across);
    let along = relative - across * speed_across;
    let speed = along.norm();
    let grip = (friction * (wanted - speed_across).abs()).min(speed);
    let mut along = if speed > 0.0 { along * (1.0 - grip / speed) } else { along };
    let out = (one.normal + other.normal).try_normalize(PARALLEL).unwrap_or_else(Vector3::zeros);
    along += out * (SQUEEZE * out.norm() - along.dot(&out)).max(0.0);
    *velocity = skin + along + across * wanted;
    skin
}

/// Two skins whose normals differ from opposite ones by less have no fold that opens to any side.
const PARALLEL: f64 = 0.02;

/// The most that is taken over, m: what is farther out does not touch.
const MOST_EXTRA: f64 = 3e-3;
/// Sliding over the skin by this, m, leaves a third of what a particle keeps beyond the clearance: what it was for is
/// somewhere else now.
const FORGETTING: f64 = 0.02;

/// What was put back lies this far above the skin, m.
const ON_TOP: f64 = 1e-5;

impl Track {
    /// Takes back what of a velocity, m/s, leads into the skins.
    #[inline]
    fn hold(&self, velocity: &mut Vector3) {
        let mut raise = |held: Option<(Vector3, f64)>| {
            if let Some((normal, least)) = held {
                *velocity += normal * (least - velocity.dot(&normal)).max(0.0);
            }
        };
        raise(self.least[0]);
        if self.least[1].is_some() {
            self.least.into_iter().rev().for_each(raise);
        }
    }

    /// The nearest place, and that of skin which faces it, if the particle can touch them within the step.
    fn follow(
        &mut self,
        surface: &Surface,
        position: Vector3,
        velocity: Vector3,
        step: f64,
        clearance: f64,
    ) -> Option<(Place, Option<Place>)> {
        self.slack -= (velocity.norm() + surface.largest_speed()) * step;
        self.age += 1;
        self.carried += 1;
        self.close = false;
        if self.slack > 0.0 || self.free {
            return None;
        }
        let (place, other) = match self.place.filter(|_| self.age <= REMEMBERED) {
            Some(place) if self.carried <= CARRIED && self.slid < SLID => {
                let carried = |place: Place| surface.carried(position, &place);
                return Some((carried(place), self.other.map(carried)));
            }
            Some(place) => {
                let refined = |place: Place| surface.refine(position, place.triangle);
                let place = refined(place);
                (place, self.other.map(refined).filter(|other| Surface::face(&place, other)))
            }
            None => {
                self.age = 0;
                match surface.nearest(position, REACH) {
                    Some(nearest) => {
                        let place = self.on_its_side(surface, position, nearest);
                        (place, across(surface, position, &place))
                    }
                    None => {
                        *self = Track { slack: REACH - NEAR, side: NOWHERE, extra: self.extra, ..Track::UNKNOWN };
                        return None;
                    }
                }
            }
        };
        // Beyond the reach of one it may be in the other.
        let (place, other) = match other.filter(|other| place.distance >= NEAR && other.distance < NEAR) {
            Some(other) => (other, None),
            None => (place, other),
        };
        (self.carried, self.slid) = (0, 0.0);
        if self.extra > 0.0 && surface.faces_another_way(&place, self.side) {
            // What it keeps was for another part of the body.
            self.extra = 0.0;
        }
        let near = place.distance < NEAR;
        self.place = near.then_some(place);
        self.other = other.filter(|_| near);
        self.pinched &= self.other.is_some();
        self.side = self.place.map_or(NOWHERE, |place| place.triangle);
        let nearer = other.map_or(place.distance, |other| place.distance.min(other.distance));
        self.slack = nearer - clearance - self.extra - BAND;
        (self.slack < (velocity.norm() + surface.largest_speed()) * step).then_some((place, other))
    }

    /// The nearest place, unless the particle would be inside the body there and lies well on a skin that faces this one:
    /// where a body passes through itself, as at an armpit, neither side lets go of what the other presses into it.
    fn on_its_side(&self, surface: &Surface, position: Vector3, nearest: Place) -> Place {
        if nearest.distance >= 0.0 || self.side as usize >= surface.triangles().len() {
            return nearest;
        }
        let own = surface.refine(position, self.side);
        let keeps = own.distance >= -CLOSE && own.distance < NEAR && own.normal.dot(&nearest.normal) < 0.0;
        if keeps { own } else { nearest }
    }
}

/// The place of skin that faces that at a place, where both are near to a particle, or where they pass through each other and
/// it is between. The two sides of a thin limb look the same from there, but for how often the surface winds around it.
fn across(surface: &Surface, position: Vector3, place: &Place) -> Option<Place> {
    if place.distance >= NEAR {
        return None;
    }
    let reach = if place.distance < 0.0 { OVERLAP } else { ACROSS };
    let other = surface.nearest_facing(position, reach, place.normal)?;
    let inside = [place, &other].into_iter().filter(|p| p.distance < 0.0).count() as i32;
    let faces = place.distance + other.distance >= 0.0 || surface.winding_number(position) == inside;
    (faces && Surface::face(place, &other)).then_some(other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shapes;
    use crate::dynamics::settings::BroadPhase;

    /// The top of a large flat box, y = 0.
    fn floor() -> Surface {
        let corner = |k: usize| {
            let side = |bit: usize| if k >> bit & 1 == 1 { 2.0 } else { -2.0 };
            Vector3::new(side(0), if k >> 1 & 1 == 1 { 0.0 } else { -1.0 }, side(2))
        };
        let positions: Vec<Vector3> = (0..8).map(corner).collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Surface::new(&positions, &triangles, BroadPhase::Tree)
    }

    const STEP: f64 = 1e-3;
    const GRAVITY: f64 = 9.81;

    /// One particle under gravity; its path.
    fn fall(
        surface: &mut Surface,
        response: &mut Response,
        start: Vector3,
        velocity: Vector3,
        steps: usize,
    ) -> Vec<Vector3> {
        let (mut x, mut v) = ([start], [velocity]);
        let path = (0..steps).map(|_| {
            v[0].y -= GRAVITY * STEP;
            response.respond(surface, &x, &mut v, STEP);
            x[0] += v[0] * STEP;
            response.put_back(surface, &mut x, &mut v, STEP);
            x[0]
        });
        path.collect()
    }

    #[test]
    fn what_falls_comes_to_rest_at_its_clearance() {
        let path = fall(
            &mut floor(),
            &mut Response::new(1, 0.002, 0.4, 0.0),
            Vector3::new(0.1, 0.05, 0.2),
            Vector3::zeros(),
            1000,
        );
        assert!(path.iter().all(|p| p.y > 0.002 - 1e-12));
        assert!((path.last().unwrap().y - 0.002).abs() < 1e-4, "{}", path.last().unwrap());
    }

    #[test]
    fn what_runs_into_nothing_falls_through_the_body() {
        let mut response = Response::new(1, 0.002, 0.4, 0.0).without(vec![true]);
        let path = fall(&mut floor(), &mut response, Vector3::new(0.1, 0.05, 0.2), Vector3::zeros(), 500);
        let expected = 0.05 - 0.5 * GRAVITY * 0.25;
        assert!((path.last().unwrap().y - expected).abs() < 0.01, "{}", path.last().unwrap());
        // And after it was remembered and looked for afresh.
        response.look_afresh();
        let path = fall(&mut floor(), &mut response, Vector3::new(0.1, 0.05, 0.2), Vector3::zeros(), 500);
        assert!(path.last().unwrap().y < -1.0);
    }

    #[test]
    fn a_share_of_the_speed_of_an_impact_is_kept() {
        let path = fall(
            &mut floor(),
            &mut Response::new(1, 0.0, 0.4, 0.5),
            Vector3::new(0.1, 0.2, 0.2),
            Vector3::zeros(),
            450,
        );
        // It falls for 0.2 s and rises for half of that: to a quarter of the height.
        let height = path[250..].iter().map(|p| p.y).fold(0.0, f64::max);
        assert!((height - 0.05).abs() < 0.01, "{height}");
    }

    #[test]
    fn sliding_is_slowed_by_friction_as_coulomb_has_it() {
        let start = Vector3::new(-1.5, 0.001, 0.0);
        let path = fall(&mut floor(), &mut Response::new(1, 0.001, 0.3, 0.0), start, Vector3::new(1.0, 0.0, 0.0), 1000);
        // v²/2μg
        let expected = 1.0 / (2.0 * 0.3 * GRAVITY);
        let slid = path.last().unwrap().x - start.x;
        assert!((slid / expected - 1.0).abs() < 0.02, "slid {slid} m, not {expected}");
    }

    #[test]
    fn what_lies_on_a_body_is_carried_along_and_never_left_inside() {
        let mut surface = floor();
        let mut response = Response::new(1, 0.001, 1.0, 0.0);
        let start = Vector3::new(0.0, 0.001, 0.0);
        fall(&mut surface, &mut response, start, Vector3::zeros(), 10);
        let (mut x, mut v) = ([start], [Vector3::zeros()]);
        let (frame, steps) = (0.04, 40);
        for k in 1..=10 {
            let end: Vec<Vector3> = surface.positions().iter().map(|p| p + Vector3::new(0.01, 0.03, 0.0)).collect();
            surface.move_to(&end, frame);
            for s in 1..=steps {
                v[0].y -= GRAVITY * STEP;
                response.respond(&surface, &x, &mut v, STEP);
                x[0] += v[0] * STEP;
                surface.advance(f64::from(s) / f64::from(steps));
                response.put_back(&surface, &mut x, &mut v, STEP);
            }
            let top = 0.03 * f64::from(k);
            assert!(x[0].y > top, "frame {k}: {} is below {top}", x[0].y);
        }
        assert!((x[0].y - 0.301).abs() < 2e-3 && (x[0].x - 0.1).abs() < 5e-3, "{}", x[0]);
    }

    /// Two boxes a metre wide, above and below y = 0, whose skins that face each other are this far apart, m; they overlap
    /// where that is negative.
    fn jaws(apart: f64) -> (Vec<Vector3>, Vec<[u32; 3]>) {
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for (first, low) in [(0, -0.2 - 0.5 * apart), (8, 0.5 * apart)] {
            let corner = |k: usize| {
                let side = |bit: usize, size: f64| if k >> bit & 1 == 1 { size } else { 0.0 };
                Vector3::new(side(0, 1.0) - 0.5, low + side(1, 0.2), side(2, 1.0) - 0.5)
            };
            positions.extend((0..8).map(corner));
            triangles.extend(quads.iter().flat_map(|q| {
                let [a, b, c, d] = q.map(|v| v + first);
                [[a, b, c], [a, c, d]]
            }));
        }
        (positions, triangles)
    }

    /// Cloth behind a knee that bends: with one contact only it was held on the skin of the one limb, deep in the other, or
    /// torn between them.
    #[test]
    fn what_two_limbs_close_upon_is_let_be_between_them_and_clear_when_they_part() {
        let (positions, triangles) = jaws(0.02);
        let mut surface = Surface::new(&positions, &triangles, BroadPhase::Tree);
        let mut response = Response::new(2, 0.001, 0.4, 0.0);
        let (mut x, mut v) = ([Vector3::new(0.0, -0.008, 0.01), Vector3::new(0.1, 0.007, 0.0)], [Vector3::zeros(); 2]);
        let (frame, steps) = (0.04, 40);
        // They close, pass through each other by 10 mm, and part again.
        let apart = [0.012, 0.004, -0.004, -0.01, -0.01, -0.004, 0.004, 0.012];
        for (k, apart) in apart.into_iter().enumerate() {
            let start = x;
            surface.move_to(&jaws(apart).0, frame);
            response.look_afresh();
            for s in 1..=steps {
                v.iter_mut().for_each(|v| v.y -= GRAVITY * STEP);
                response.respond(&surface, &x, &mut v, STEP);
                x.iter_mut().zip(&v).for_each(|(x, v)| *x += v * STEP);
                surface.advance(f64::from(s) / f64::from(steps));
                response.put_back(&surface, &mut x, &mut v, STEP);
            }
            let pinched = response.pinched();
            for p in 0..2 {
                assert!((x[p] - start[p]).norm() < 0.012, "frame {k} throws it from {} to {}", start[p], x[p]);
                assert_eq!(pinched[p], apart < 0.002, "frame {k}, {} m apart", apart);
                match pinched[p] {
                    true => assert!(x[p].y.abs() < 1e-3, "frame {k}: {} is not in the middle", x[p]),
                    false => assert!(x[p].y.abs() < 0.5 * apart, "frame {k}: {} is inside", x[p]),
                }
            }
        }
    }

    /// A finger is no fold: its far side faces away from the near one as well.
    #[test]
    fn the_two_sides_of_a_thin_limb_are_no_fold() {
        let (positions, triangles) = shapes::sphere(Vector3::zeros(), 0.004, 12);
        let surface = Surface::new(&positions, &triangles, BroadPhase::Tree);
        for distance in [0.0015, 0.0003] {
            let point = Vector3::new(0.0, 0.004 + distance, 0.0003);
            let place = surface.nearest(point, 0.1).unwrap();
            assert!(place.distance > 0.0 && across(&surface, point, &place).is_none(), "{place:?}");
        }
    }
}
