//! How each panel stands: which way it faces, how it is turned in its own plane, whether it is bent around a limb.

use super::facing::{Draft, Look, flow, heads, look};
use super::figure::Figure;
use super::names::{Hints, Zone};
use super::rims::Opening;
use super::surface::Surface;
use super::{Limb, Override};
use crate::geometry::{Vector2, Vector3};
use crate::pattern::{Bend, Pattern, Seam};
use nalgebra::{Matrix3, Rotation3, Unit};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A panel without its position.
#[derive(Clone, Debug)]
pub struct Stance {
    pub limb: Limb,
    /// Unit outward normal, of a bent panel along the line where it touches its cylinder; world.
    pub face: Vector3,
    pub rotation: Rotation3<f64>,
    pub bend: Option<Bend>,
    /// Orthogonal unit vectors, world, or zero: where the panel may still move.
    pub free: [Vector3; 2],
    /// A point that the panel's middle keeps along all other directions, m, world.
    pub through: Vector3,
    /// Of the outline, m, panel coordinates.
    pub middle: Vector2,
    /// Its middle in the draft, m, world.
    pub drafted: Vector3,
    /// As an [`Override`] has them, rad.
    pub angle: f64,
    pub turn: f64,
}

/// Panels are drawn along their grain: those of the torso stand upright, and on limbs a turn this near to a quarter is one.
const UPRIGHT: f64 = 28.0 / 180.0 * PI;
/// A face this near to front, back or side is taken for it.
const SQUARE: f64 = 32.0 / 180.0 * PI;
/// Below this share of its size, what faces all ways is bent around.
const BENT: f64 = 0.35;
/// What the flow to an opening, from 0 to 1, has to be on a panel for it to belong to that limb; a name counts as much as...
const ON_LIMB: f64 = 0.45;
const NAMED: f64 = 0.4;
/// ... and so much it counts that a panel without a name goes down one leg.
const DOWN_ONE_LEG: f64 = 0.2;
/// How far outside the body panels stand, m: the torso's, those of arms, those of the head. A hood farther out has its tips in the
/// shoulders, where they get caught.
const TORSO_GAP: f64 = 0.09;
const ARM_GAP: f64 = 0.07;
const HEAD_GAP: f64 = 0.015;
/// A cylinder around a limb is wider than it by this, m, at least, and a panel on it leaves this share of its girth open.
const BEND_GAP: f64 = 0.025;
const BEND_OPEN: f64 = 0.12;

pub struct Standing<'a> {
    pub pattern: &'a Pattern,
    pub surface: &'a Surface,
    pub hints: &'a [Hints],
    pub figure: &'a Figure<'a>,
}

impl Standing<'_> {
    /// The stances of a piece's panels.
    pub fn stances(&self, panels: &[usize], draft: &Draft, overrides: &[Option<Override>]) -> Vec<Stance> {
        let flows = self.flows(draft);
        let heads = heads(self.surface, &draft.openings);
        let stance = |&panel: &usize| {
            let look = look(self.surface, panel, &draft.places);
            let asked = overrides[panel].unwrap_or_default();
            let (limb, flow) = self.limb(panel, &look, &flows, asked.limb, &heads);
            self.stance(panel, limb, &look, flow, draft, asked)
        };
        panels.iter().map(stance).collect()
    }

    /// For each arm and leg, a function on the particles that is 1 at its opening and 0 at all others, as smooth as can be.
    fn flows(&self, draft: &Draft) -> Vec<(Limb, Vec<f64>)> {
        let of = |&(rim, opening): &(usize, Opening)| {
            let limb = match opening {
                Opening::Arm(side) => Limb::Arm(side),
                Opening::Leg(side) => Limb::Leg(side),
                _ => return None,
            };
            Some((limb, flow(self.surface, &draft.openings, rim)))
        };
        draft.openings.iter().filter_map(of).collect()
    }

    fn limb<'f>(
        &self,
        panel: usize,
        look: &Look,
        flows: &'f [(Limb, Vec<f64>)],
        asked: Option<Limb>,
        heads: &[bool],
    ) -> (Limb, Option<&'f Vec<f64>>) {
        let flow_of = |limb: Limb| flows.iter().find(|(l, _)| *l == limb).map(|(_, flow)| flow);
        if let Some(limb) = asked {
            return (limb, flow_of(limb));
        }
        let hint = self.hints[panel];
        if hint.zone == Some(Zone::Head) || (hint.zone.is_none() && heads[panel]) {
            return (Limb::Head, None);
        }
        let range = &self.surface.level.panels[panel];
        let mean = |flow: &[f64]| {
            let of = range.points.clone().map(|p| flow[self.surface.level.particle_of[p] as usize]);
            of.sum::<f64>() / range.points.len() as f64
        };
        let down = self.leg_below(panel, flows);
        let score = |limb: Limb, flow: &[f64]| {
            let named = match (limb, hint.zone) {
                (Limb::Arm(_), Some(Zone::Arm)) | (Limb::Leg(_), Some(Zone::Leg)) => NAMED,
                // A front that goes down one leg, with hips and all.
                (Limb::Leg(_), None) if down == Some(limb) => DOWN_ONE_LEG,
                (_, None) => 0.0,
                _ => -NAMED,
            };
            mean(flow) + named
        };
        let scored = flows.iter().map(|(limb, flow)| (score(*limb, flow), *limb, flow));
        match scored.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((score, limb, flow)) if score > ON_LIMB => (limb, Some(flow)),
            _ => {
                let side = usize::from(hint.left.unwrap_or(look.middle.x - self.figure.middle) < 0.0);
                match hint.zone {
                    Some(Zone::Arm) => (Limb::Arm(side), flow_of(Limb::Arm(side))),
                    _ => (Limb::Torso, None),
                }
            }
        }
    }

    /// The leg that the panel reaches down; none if both or neither.
    fn leg_below(&self, panel: usize, flows: &[(Limb, Vec<f64>)]) -> Option<Limb> {
        /// Above the crotch the flow to either opening is less.
        const DOWN_A_LEG: f64 = 0.6;
        let range = &self.surface.level.panels[panel];
        let ends =
            |flow: &[f64]| range.points.clone().any(|p| flow[self.surface.level.particle_of[p] as usize] > DOWN_A_LEG);
        let mut below = flows.iter().filter(|(limb, flow)| matches!(limb, Limb::Leg(_)) && ends(flow));
        match (below.next(), below.next()) {
            (Some((limb, _)), None) => Some(*limb),
            _ => None,
        }
    }

    fn stance(
        &self,
        panel: usize,
        limb: Limb,
        look: &Look,
        flow: Option<&Vec<f64>>,
        draft: &Draft,
        asked: Override,
    ) -> Stance {
        let middle = self.middle(panel);
        let limb_axis = self.axis(limb, look);
        let spread = look.normal.norm() / look.area.max(1e-12);
        let is_bent = match asked.bend {
            Some(radius) => radius.is_finite(),
            None => self.closes_on_itself(panel) || (matches!(limb, Limb::Arm(_)) || draft.is_tube) && spread < BENT,
        };
        let face = match asked.angle {
            Some(angle) => limb_axis.facing(angle),
            None => self.face(panel, limb, look, draft, is_bent, &limb_axis),
        };
        let wound = self.pattern.panels[panel].signed_area().signum();
        // The panel's own y along `up`, its normal along the face.
        let up = limb_axis.up - face * limb_axis.up.dot(&face);
        let up = up.try_normalize(1e-6).unwrap_or_else(Vector3::y);
        let normal = face * wound;
        let right = up.cross(&normal);
        let upright = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[right, up, normal]));
        let turn = match asked.turn {
            Some(turn) => turn * wound,
            None => self.turn(panel, &upright, look, flow, draft),
        };
        let rotation = Rotation3::from_axis_angle(&Unit::new_unchecked(normal), turn) * upright;
        let along = (rotation.inverse() * up).xy();
        let bend = is_bent.then(|| self.bend(panel, along, wound, &limb_axis, asked.bend));
        let through = match (bend, limb) {
            (Some(bend), _) => limb_axis.point + face * bend.radius.abs(),
            (None, Limb::Head) => {
                Vector3::new(self.figure.middle, 0.0, self.figure.head[1]) + face * self.reach(limb, face)
            }
            (None, _) => face * self.reach(limb, face),
        };
        let origin = bend.map_or(middle, |bend| bend.origin);
        let side = up.cross(&face);
        let free = if bend.is_some() { [up, Vector3::zeros()] } else { [up, side] };
        let angle = face.dot(&limb_axis.outside).atan2(face.dot(&limb_axis.front));
        Stance {
            limb,
            face,
            rotation,
            bend,
            free,
            through,
            middle: origin,
            drafted: look.middle,
            angle,
            turn: turn * wound,
        }
    }

    /// The middle of a panel's bounding box, m.
    fn middle(&self, panel: usize) -> Vector2 {
        let (low, high) = extent(&self.pattern.panels[panel].polygon(OUTLINE_POINTS));
        (low + high) * 0.5
    }

    fn closes_on_itself(&self, panel: usize) -> bool {
        self.closing_seams(panel).next().is_some()
    }

    /// Seams of a panel with itself that are no darts: their sides do not meet in a corner.
    fn closing_seams(&self, panel: usize) -> impl Iterator<Item = &Seam> {
        let count = self.pattern.panels[panel].segments.len();
        self.pattern.seams.iter().filter(move |seam| {
            let [a, b] = seam.sides;
            let apart = a.segment.abs_diff(b.segment);
            a.panel == panel && b.panel == panel && apart > 1 && apart + 1 < count
        })
    }

    /// The level way from the seam that closes a panel around the torso to the other side, where its middle is; none without one.
    fn away_from_closing(&self, panel: usize, draft: &Draft) -> Option<Vector3> {
        let level = &self.surface.level;
        let closing = self.closing_seams(panel).flat_map(|seam| seam.sides);
        let points = closing.flat_map(|side| level.segments[side.panel][side.segment].iter());
        let axis = Vector3::new(self.figure.middle, 0.0, 0.0);
        let off = points.map(|&p| draft.places[level.particle_of[p as usize] as usize] - axis).sum::<Vector3>();
        Vector3::new(-off.x, 0.0, -off.z).try_normalize(1e-9)
    }

    fn axis(&self, limb: Limb, look: &Look) -> Axis {
        let marks = self.figure.marks;
        match limb {
            Limb::Arm(side) => {
                let (point, end) =
                    (marks.arms[side].axis[0], *marks.arms[side].axis.last().expect("an arm has sections"));
                let radius = marks.arms[side].radii.iter().copied().fold(0.0, f64::max);
                let up = (point - end).normalize();
                // What is uppermost on an arm that hangs is its outside.
                let outside = Vector3::z().cross(&up) * if side == 0 { -1.0 } else { 1.0 };
                Axis { point, up, front: Vector3::z(), outside: outside.normalize(), radius }
            }
            Limb::Leg(side) => {
                let leg = &marks.legs[side];
                let point = self.figure.leg_at(side, look.middle.y);
                let outside = Vector3::x() * if side == 0 { 1.0 } else { -1.0 };
                let radius = leg.radii.iter().copied().fold(0.0, f64::max);
                Axis { point, up: Vector3::y(), front: Vector3::z(), outside, radius }
            }
            Limb::Torso | Limb::Head => {
                let point = Vector3::new(self.figure.middle, 0.0, 0.5 * (self.figure.front + self.figure.back));
                let radius = self.reach(limb, Vector3::x()) - TORSO_GAP - self.figure.middle;
                Axis { point, up: Vector3::y(), front: Vector3::z(), outside: Vector3::x(), radius }
            }
        }
    }

    fn face(&self, panel: usize, limb: Limb, look: &Look, draft: &Draft, is_bent: bool, axis: &Axis) -> Vector3 {
        let hint = self.hints[panel];
        let front = |z: f64| Vector3::z() * if z < 0.0 { -1.0 } else { 1.0 };
        let side = hint.left.unwrap_or(look.middle.x - self.figure.middle);
        let across = Vector3::x() * if side < 0.0 { -1.0 } else { 1.0 };
        match limb {
            Limb::Head => across,
            Limb::Arm(_) | Limb::Leg(_) if is_bent => axis.outside,
            Limb::Arm(_) | Limb::Leg(_) => front(hint.front.unwrap_or(look.normal.z)),
            Limb::Torso if draft.is_tube => {
                let flat = Vector3::new(look.normal.x, 0.0, look.normal.z).try_normalize(1e-9);
                let bent = || hint.front.map(front).or_else(|| self.away_from_closing(panel, draft));
                let flat = if is_bent { bent().or(flat) } else { flat }.unwrap_or_else(Vector3::z);
                let angle = flat.x.atan2(flat.z);
                let square = (angle / FRAC_PI_2).round() * FRAC_PI_2;
                let angle = if (angle - square).abs() < SQUARE { square } else { angle };
                Vector3::new(angle.sin(), 0.0, angle.cos())
            }
            Limb::Torso => match hint.front {
                Some(z) => front(z),
                None if look.normal.norm() < SIDEWAYS * look.area && side.abs() > OFF_MIDDLE => across,
                None => front(look.normal.z),
            },
        }
    }

    /// The turn in its own plane that agrees best with the draft, rad; along the grain if that is near.
    fn turn(&self, panel: usize, upright: &Rotation3<f64>, look: &Look, flow: Option<&Vec<f64>>, draft: &Draft) -> f64 {
        let level = &self.surface.level;
        let points = level.panels[panel].points.clone();
        let count = points.len() as f64;
        let center = points.clone().map(|p| level.rest[p]).sum::<Vector2>() / count;
        let angle = match flow {
            Some(flow) => {
                // Down the limb is where the flow rises: its gradient by least squares.
                let value = |p: usize| flow[level.particle_of[p] as usize];
                let mean = points.clone().map(value).sum::<f64>() / count;
                let (mut square, mut rise) = (nalgebra::Matrix2::zeros(), Vector2::zeros());
                for p in points {
                    let off = level.rest[p] - center;
                    square += off * off.transpose();
                    rise += off * (value(p) - mean);
                }
                let down = square.try_inverse().map_or(-Vector2::y(), |inverse| inverse * rise);
                // What turns `down` to -y.
                (-FRAC_PI_2) - down.y.atan2(down.x)
            }
            None => {
                let (mut sin, mut cos) = (0.0, 0.0);
                for p in points {
                    let off = level.rest[p] - center;
                    let place = upright.inverse() * (draft.places[level.particle_of[p] as usize] - look.middle);
                    sin += off.x * place.y - off.y * place.x;
                    cos += off.x * place.x + off.y * place.y;
                }
                sin.atan2(cos)
            }
        };
        let square = (angle / FRAC_PI_2).round() * FRAC_PI_2;
        if flow.is_none() || (angle - square).abs() < UPRIGHT { square } else { angle }
    }

    fn bend(&self, panel: usize, along: Vector2, wound: f64, axis: &Axis, asked: Option<f64>) -> Bend {
        let across = Vector2::new(along.y, -along.x);
        let outline = self.pattern.panels[panel].polygon(OUTLINE_POINTS);
        let turned: Vec<Vector2> = outline.iter().map(|p| Vector2::new(p.dot(&across), p.dot(&along))).collect();
        let (low, high) = extent(&turned);
        let width = high.x - low.x;
        let radius = asked.unwrap_or_else(|| (width / (TAU * (1.0 - BEND_OPEN))).max(axis.radius + BEND_GAP));
        let origin = across * (0.5 * (low.x + high.x)) + along * (0.5 * (low.y + high.y));
        Bend { origin, along, radius: radius * wound }
    }

    /// How far a limb reaches in a direction, and what panels keep from it, m.
    fn reach(&self, limb: Limb, face: Vector3) -> f64 {
        let marks = self.figure.marks;
        let most =
            |points: &mut dyn Iterator<Item = &Vector3>| points.map(|p| p.dot(&face)).fold(f64::NEG_INFINITY, f64::max);
        match limb {
            Limb::Arm(side) => ARM_GAP + most(&mut marks.arms[side].outlines.iter().flatten()),
            Limb::Head => HEAD_GAP + self.figure.head[0],
            Limb::Torso | Limb::Leg(_) => {
                let legs = marks.legs.iter().flat_map(|leg| &leg.outlines);
                TORSO_GAP + most(&mut marks.torso.outlines.iter().chain(legs).flatten())
            }
        }
    }
}

/// Points of each curve by which a panel's extent is found.
const OUTLINE_POINTS: usize = 8;
/// Panels whose sizes in front and behind nearly cancel, and which are this far from the middle, m, stand at the side.
const SIDEWAYS: f64 = 0.2;
const OFF_MIDDLE: f64 = 0.03;

/// A limb as a straight line, and what is around it.
struct Axis {
    /// m, world.
    point: Vector3,
    /// Unit vectors: towards the limb's root, to the front, and away from the body's middle.
    up: Vector3,
    front: Vector3,
    outside: Vector3,
    /// The largest, m.
    radius: f64,
}

impl Axis {
    /// The direction at an angle, rad, from the front by way of the outside.
    fn facing(&self, angle: f64) -> Vector3 {
        (self.front * angle.cos() + self.outside * angle.sin()).normalize()
    }
}

fn extent(points: &[Vector2]) -> (Vector2, Vector2) {
    let low = points.iter().fold(Vector2::repeat(f64::INFINITY), |a, p| a.inf(p));
    let high = points.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
    (low, high)
}
