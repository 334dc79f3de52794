//! Contact with the body: a one-sided quadratic energy over sample points of the cloth, with friction.
//!
//! ```text
//!     E = ½ k (δ - d(x))²   where d(x) < δ, else 0                        (theory, equation 8)
//! ```
//!
//! `d` is the distance to the body and `δ` the clearance. Its gradient is continuous, so that a
//! minimizer may cross the border of contact freely; what is left of the clearance's violation,
//! pressure over `k`, is taken away by [`BodyContact::hold`] at the end of a level.
//!
//! On fine levels the particles are the sample points. On coarse ones a triangle can cut through an
//! arm between its particles, so its edges carry samples as well.
//!
//! Friction is Coulomb's, as a spring from where a sample first touched (its anchor) that pulls with
//! `μ N` at most. Anchors move, and learn the normal force `N`, in [`BodyContact::update_anchors`] only:
//! between two calls the energy is a function of the positions, with a continuous gradient.

mod correction;
mod friction;

use crate::body::{Body, DistanceField, STEEPEST};
use crate::garment::Level;
use crate::geometry::{Edge, EdgeTable, Vector3};
use crate::minimize::CHUNK;
use correction::Aim;
use friction::{Anchor, STICKING};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// How the cloth is held clear of the body.
#[derive(Clone, Copy, Debug)]
pub struct BodyContactSettings {
    /// Distance to be kept, m. Negative while the seams close around a body that is thought thinner.
    pub clearance: f64,
    /// Stiffness of each particle's contact, N/m.
    pub stiffness: f64,
    /// Coulomb coefficient.
    pub friction: f64,
}

/// The middle of an edge of the cloth.
#[derive(Clone, Copy, Debug)]
struct Middle {
    ends: [u32; 2],
    /// How far the cloth bulges out over the chord here, m.
    sag: f64,
}

/// What was found of a sample at the last evaluation.
#[derive(Clone, Copy, Debug)]
enum Finding {
    Touching {
        /// Direction away from the body.
        normal: Vector3,
        /// Clearance minus distance, m, positive.
        depth: f64,
    },
    /// It need not be looked at again before it has come near enough to touch.
    Free {
        /// Where it was when it was last looked at.
        place: Vector3,
        /// Distance of the place from the body, at least, m.
        distance: f64,
    },
}

impl Finding {
    const UNKNOWN: Finding = Finding::Free { place: Vector3::new(0.0, 0.0, 0.0), distance: f64::NEG_INFINITY };

    /// Looks at a sample that has moved: most move little in a step.
    #[inline]
    fn update(&mut self, field: &DistanceField, position: Vector3, clearance: f64) {
        if let Finding::Free { place, distance } = *self {
            let free = (distance - clearance).max(0.0) / STEEPEST;
            if (position - place).norm_squared() < free * free {
                return;
            }
        }
        *self = match field.sample_below(position, clearance) {
            Ok(s) => Finding::Touching { normal: s.gradient, depth: clearance - s.distance },
            Err(distance) => Finding::Free { place: position, distance },
        };
    }

    /// Normal and depth.
    #[inline]
    fn touch(&self) -> Option<(Vector3, f64)> {
        match *self {
            Finding::Touching { normal, depth } => Some((normal, depth)),
            Finding::Free { .. } => None,
        }
    }
}

/// Contact of one level with the body.
pub struct BodyContact<'a> {
    body: &'a Body,
    field: &'a DistanceField,
    pub settings: BodyContactSettings,
    /// What each particle keeps beyond the clearance, m: more where a sharp part of the body would
    /// come through between the particles.
    extra: Vec<f64>,
    /// Where each particle aims at beyond that.
    aims: Vec<Aim>,
    middles: Vec<Middle>,
    /// One per sample, as what follows: the particles, then the middles.
    findings: Vec<Finding>,
    /// Where the sample's anchor stands among the anchors, or [`LOOSE`].
    anchor_of: Vec<u32>,
    /// Of the samples that stick.
    anchors: Vec<Anchor>,
}

/// Whether a point keeps its clearance.
enum Reach {
    /// It does: its distance is this at least, m.
    Beyond(f64),
    /// It does not, and has to go there.
    Out(Vector3),
}

/// A sample without an anchor.
const LOOSE: u32 = u32::MAX;

/// Edges longer than this carry a sample in their middle, m: a wrist is 50 mm thick.
const LONGEST_UNSAMPLED: f64 = 0.022;
/// Radius of the limbs and curves that cloth is bent around, m: tells how far an edge cuts the curve.
const LIMB_RADIUS: f64 = 0.06;
/// What may be missing from a clearance without being held out, m. A micrometre's move of one particle
/// is a force of many times its weight; a state in balance is worth more than the last of them.
const HOLD_TOLERANCE: f64 = 5e-5;
/// Where a particle is as near to its clearance as this it aims no better, m: every correction is a
/// new force, and corrections without end would never let the cloth come to rest.
const CORRECTION_TOLERANCE: f64 = 2e-5;
/// By so much the distance field may be wrong in all but the deepest creases, m: who is farther away is not measured.
const FIELD_ERROR: f64 = 1e-3;
/// The most that a particle keeps beyond its clearance, m: an ear, or a thumb, lies between it and the next.
const MOST_EXTRA: f64 = 0.03;
/// After so many steps a particle that has to keep farther from the body does so twice as far each time.
const GENTLE_STEPS: f64 = 6.5;
/// Chunks of particles to a thread at least, for sweeps as cheap as a sum.
const LEAST_CHUNKS: usize = 4;

/// How far an edge of a length, m, cuts into a limb: a chord `h` over a radius `R` sags by `h²/8R`.
pub fn sag(length: f64) -> f64 {
    length * length / (8.0 * LIMB_RADIUS)
}

impl<'a> BodyContact<'a> {
    pub fn new(body: &'a Body, field: &'a DistanceField, level: &Level, settings: BodyContactSettings) -> Self {
        let middles = middles(level);
        let count = level.particle_count + middles.len();
        Self {
            body,
            field,
            settings,
            extra: vec![0.0; level.particle_count],
            aims: vec![Aim::default(); level.particle_count],
            middles,
            findings: vec![Finding::UNKNOWN; count],
            anchor_of: vec![LOOSE; count],
            anchors: Vec::new(),
        }
    }

    /// Adds the gradient, N, and returns the energy, J.
    pub fn evaluate(&mut self, positions: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let (field, BodyContactSettings { clearance, stiffness, .. }) = (self.field, self.settings);
        let (anchors, particles) = (&self.anchors, positions.len());
        let (at_particles, at_middles) = self.findings.split_at_mut(particles);
        let (anchors_of_particles, anchors_of_middles) = self.anchor_of.split_at(particles);
        let sums: Vec<f64> = at_particles
            .par_chunks_mut(CHUNK)
            .zip(positions.par_chunks(CHUNK))
            .zip(gradient.par_chunks_mut(CHUNK))
            .zip(anchors_of_particles.par_chunks(CHUNK))
            .zip(self.extra.par_chunks(CHUNK).zip(self.aims.par_chunks(CHUNK)))
            .map(|((((findings, positions), gradient), anchor_of), (extra, aims))| {
                let mut sum = 0.0;
                for k in 0..findings.len() {
                    findings[k].update(field, positions[k], clearance + extra[k] + aims[k].offset());
                    let anchor = anchors.get(anchor_of[k] as usize);
                    let (energy, pull) = push(&findings[k], anchor, positions[k], stiffness);
                    sum += energy;
                    gradient[k] += pull;
                }
                sum
            })
            .collect();
        let mut energy: f64 = sums.iter().sum();
        for (middle, (finding, &anchor_of)) in self.middles.iter().zip(at_middles.iter_mut().zip(anchors_of_middles)) {
            let position = middle.of(positions);
            finding.update(field, position, clearance - middle.sag);
            let (sample_energy, pull) = push(finding, anchors.get(anchor_of as usize), position, stiffness);
            energy += sample_energy;
            for p in middle.ends {
                gradient[p as usize] += pull * 0.5;
            }
        }
        energy
    }

    /// `dᵀ H d` at the last evaluation, without the curvature of the body.
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3]) -> f64 {
        let k = self.settings.stiffness;
        let along = |finding: &Finding, anchor_of: u32, position: &dyn Fn() -> Vector3, d: &dyn Fn() -> Vector3| {
            let pressing = finding.touch().map_or(0.0, |(normal, _)| k * normal.dot(&d()).powi(2));
            let sticking = |a: &Anchor| d().dot(&(a.hessian(position(), STICKING * k) * d()));
            pressing + self.anchors.get(anchor_of as usize).map_or(0.0, sticking)
        };
        let (at_particles, at_middles) = self.findings.split_at(positions.len());
        let (anchors_of_particles, anchors_of_middles) = self.anchor_of.split_at(positions.len());
        let sums: Vec<f64> = at_particles
            .par_chunks(CHUNK)
            .zip(anchors_of_particles.par_chunks(CHUNK))
            .zip(positions.par_chunks(CHUNK).zip(direction.par_chunks(CHUNK)))
            .with_min_len(LEAST_CHUNKS)
            .map(|((findings, anchor_of), (positions, direction))| {
                let samples = findings.iter().zip(anchor_of).zip(positions.iter().zip(direction));
                samples.map(|((finding, &anchor_of), (p, d))| along(finding, anchor_of, &|| *p, &|| *d)).sum()
            })
            .collect();
        let middles = at_middles.iter().zip(anchors_of_middles).zip(&self.middles);
        let at_middles = middles
            .map(|((finding, &anchor_of), m)| along(finding, anchor_of, &|| m.of(positions), &|| m.of(direction)));
        sums.into_iter().sum::<f64>() + at_middles.sum::<f64>()
    }

    /// Block of the Hessian of a particle's own contact at the last evaluation, N/m: the pressing with
    /// the sticking, and what the curvature of the body adds to it.
    pub fn hessian_of(&self, particle: usize, position: Vector3) -> [Matrix3<f64>; 2] {
        let k = self.settings.stiffness;
        let (mut definite, mut curved) = (Matrix3::zeros(), Matrix3::zeros());
        if let Some((normal, depth)) = self.findings[particle].touch() {
            definite += normal * normal.transpose() * k;
            curved = self.field_curvature(position) * (-k * depth);
        }
        if let Some(anchor) = self.anchor(particle) {
            definite += anchor.hessian(position, STICKING * k);
        }
        [definite, curved]
    }

    /// `∇²d`, 1/m, by differences: the field is quadratic between its nodes.
    fn field_curvature(&self, at: Vector3) -> Matrix3<f64> {
        const STEP: f64 = 1e-6;
        let slope = |by: Vector3| self.field.sample(at + by).map_or(Vector3::zeros(), |s| s.gradient);
        let columns: [Vector3; 3] = std::array::from_fn(|axis| {
            let by = Vector3::from_fn(|k, _| if k == axis { STEP } else { 0.0 });
            (slope(by) - slope(-by)) / (2.0 * STEP)
        });
        let curvature = Matrix3::from_columns(&columns);
        (curvature + curvature.transpose()) * 0.5
    }

    /// Adds the Hessian of the contacts at the middles of edges, at the last evaluation, times a direction.
    pub fn middles_times(&self, positions: &[Vector3], direction: &[Vector3], product: &mut [Vector3]) {
        for (middle, block) in self.middle_hessians(positions) {
            let pull = block * middle.of(direction) * 0.5;
            for p in middle.ends {
                product[p as usize] += pull;
            }
        }
    }

    /// Adds an upper bound of the same to the particles' own blocks.
    pub fn add_middles(&self, positions: &[Vector3], bounds: &mut [Matrix3<f64>]) {
        for (middle, block) in self.middle_hessians(positions) {
            for p in middle.ends {
                bounds[p as usize] += block * 0.5;
            }
        }
    }

    fn middle_hessians<'b>(&'b self, positions: &'b [Vector3]) -> impl Iterator<Item = (&'b Middle, Matrix3<f64>)> {
        let k = self.settings.stiffness;
        self.middles.iter().zip(positions.len()..).filter_map(move |(middle, sample)| {
            let (touch, anchor) = (self.findings[sample].touch(), self.anchor(sample));
            if touch.is_none() && anchor.is_none() {
                return None;
            }
            let pressing = touch.map_or(Matrix3::zeros(), |(normal, _)| normal * normal.transpose() * k);
            let sticking = anchor.map_or(Matrix3::zeros(), |a| a.hessian(middle.of(positions), STICKING * k));
            Some((middle, pressing + sticking))
        })
    }

    /// Lets touching samples stick where they are, and those that are pulled too hard slip.
    pub fn update_anchors(&mut self, positions: &[Vector3]) {
        let BodyContactSettings { friction, stiffness, .. } = self.settings;
        let sticking = if friction > 0.0 { self.findings.iter().filter(|f| f.touch().is_some()).count() } else { 0 };
        let before = std::mem::replace(&mut self.anchors, Vec::with_capacity(sticking));
        for (k, (finding, anchor_of)) in self.findings.iter().zip(&mut self.anchor_of).enumerate() {
            let anchor = before.get(std::mem::replace(anchor_of, LOOSE) as usize);
            let touch = finding.touch().filter(|_| friction > 0.0);
            // Where sides of a crease meet the distance hardly has a slope, and what is deep does not press.
            let held =
                |(slope, depth): (Vector3, f64)| (slope.normalize(), friction * stiffness * depth * slope.norm());
            let touch = touch.map(held);
            let position =
                || positions.get(k).copied().unwrap_or_else(|| self.middles[k - positions.len()].of(positions));
            let mut anchor = match (anchor, touch) {
                (Some(anchor), _) => *anchor,
                (None, Some((normal, _))) => Anchor::at(position(), normal),
                (None, None) => continue,
            };
            anchor.follow(position(), touch, STICKING * stiffness);
            *anchor_of = self.anchors.len() as u32;
            self.anchors.push(anchor);
        }
    }

    /// Of a sample, if it sticks.
    fn anchor(&self, sample: usize) -> Option<&Anchor> {
        self.anchors.get(self.anchor_of[sample] as usize)
    }

    /// Corrects where each touching particle aims at by how far it is from its clearance, by exact
    /// distances: the multiplier step of an augmented Lagrangian (theory, equation 9).
    pub fn correct(&mut self, positions: &[Vector3]) {
        let corrected: Vec<Aim> = positions
            .par_iter()
            .enumerate()
            .with_min_len(256)
            .map(|(p, &position)| {
                let (mut aim, target) = (self.aims[p], self.settings.clearance + self.extra[p]);
                // In a crease the field can be off by this much, and show no contact where there is one.
                let seen = |at| self.field.sample(at).is_some_and(|s| s.distance < target + FIELD_ERROR);
                let touches = self.findings[p].touch().is_some();
                let idle = !touches && aim.offset() == 0.0;
                if idle && !seen(position) {
                    return aim;
                }
                match self.exact_distance(position, target) {
                    Some((distance, _)) if (target - distance).abs() < CORRECTION_TOLERANCE => (),
                    // What would touch nothing either way, and is far enough away, has nothing to aim at.
                    Some((distance, error)) if !touches && distance.min(distance + error) > target => aim.let_go(),
                    Some((distance, error)) => aim.correct(target - distance, error),
                    None => aim.let_go(),
                }
                aim
            })
            .collect();
        self.aims = corrected;
    }

    /// Signed distance of a point that may be nearer to the body than `clearance`, and by how much the field says more.
    fn exact_distance(&self, point: Vector3, clearance: f64) -> Option<(f64, f64)> {
        let rough = self.field.sample(point)?;
        let reach = rough.distance.abs() + clearance.abs() + 2.0 * self.field.cell();
        let distance = self.body.nearest(point, reach)?.distance;
        let distance = if self.body.contains(point) { -distance } else { distance };
        Some((distance, rough.distance - distance))
    }

    /// `moves` become those that take each particle that is nearer than its clearance, by more than a twentieth of a
    /// millimetre, out to it, by exact distances; zero for the others. Particles that are known to be far enough away, by lower
    /// bounds of their distances, m, are not measured; the bounds of the others become what is measured.
    pub fn hold(&self, positions: &[Vector3], bounds: &mut [f64], moves: &mut [Vector3]) {
        // A second round serves creases, where moving out of one side leads to the other.
        const ROUNDS: usize = 3;
        let moved = |((&position, extra), bound): ((&Vector3, &f64), &mut f64)| {
            let clearance = self.settings.clearance + extra;
            if *bound >= clearance - HOLD_TOLERANCE {
                return Vector3::zeros();
            }
            let mut held = position;
            for _ in 0..ROUNDS {
                match self.out_of_reach(held, clearance) {
                    Reach::Out(out) => held = out,
                    Reach::Beyond(distance) => {
                        *bound = distance - (held - position).norm();
                        break;
                    }
                }
            }
            held - position
        };
        let each = positions.par_iter().zip(&self.extra).zip(bounds).zip(moves).with_min_len(256);
        each.for_each(|(particle, by)| *by = moved(particle));
    }

    /// Where a point that is nearer than `clearance` has to go.
    fn out_of_reach(&self, point: Vector3, clearance: f64) -> Reach {
        let Some(rough) = self.field.sample(point) else { return Reach::Beyond(self.field.band() - self.field.cell()) };
        // Beyond the field's error nothing needs an exact query.
        if rough.distance > clearance + self.field.cell() {
            return Reach::Beyond(rough.distance - self.field.cell());
        }
        let reach = rough.distance.abs() + clearance.abs() + 2.0 * self.field.cell();
        let Some(nearest) = self.body.nearest(point, reach) else { return Reach::Beyond(clearance) };
        let inside = self.body.contains(point);
        if !inside && nearest.distance >= clearance - HOLD_TOLERANCE {
            return Reach::Beyond(nearest.distance);
        }
        let away = if inside { nearest.point - point } else { point - nearest.point };
        let [a, b, c] = self.body.corners(nearest.triangle);
        let normal = away.try_normalize(1e-9).unwrap_or_else(|| (b - a).cross(&(c - a)).normalize());
        // A nanometre more than asked, so that rounding does not ask again.
        Reach::Out(nearest.point + normal * (clearance + 1e-9))
    }

    /// Asks some particles to keep farther from the body: some times by `step` more, m, then by twice as much each
    /// time. What still comes through between them sticks out far, as an ear does on coarse cloth.
    pub fn widen(&mut self, particles: impl IntoIterator<Item = u32>, step: f64) {
        for p in particles {
            let extra = &mut self.extra[p as usize];
            let more = if *extra < GENTLE_STEPS * step { step } else { *extra };
            *extra = (*extra + more).min(MOST_EXTRA);
        }
    }

    /// Lets particles that keep farther from the body than their clearance come nearer, each by so much, m.
    pub fn let_nearer(&mut self, less: impl IntoIterator<Item = (u32, f64)>) {
        for (p, by) in less {
            let extra = &mut self.extra[p as usize];
            *extra = (*extra - by).max(0.0);
        }
    }

    /// Asks particles to keep farther from the body, each by so much more than it does, m.
    pub fn keep_farther(&mut self, more: impl IntoIterator<Item = (u32, f64)>) {
        for (p, by) in more {
            let extra = &mut self.extra[p as usize];
            *extra = (*extra + by).min(MOST_EXTRA);
        }
    }

    /// Stiffness that contact adds to each particle's diagonal, N/m.
    pub fn diagonal(&self) -> f64 {
        self.settings.stiffness
    }
}

impl Middle {
    #[inline]
    fn of(&self, at: &[Vector3]) -> Vector3 {
        (at[self.ends[0] as usize] + at[self.ends[1] as usize]) * 0.5
    }
}

/// Energy and gradient of one sample.
#[inline]
fn push(finding: &Finding, anchor: Option<&Anchor>, position: Vector3, stiffness: f64) -> (f64, Vector3) {
    let (mut energy, mut gradient) = (0.0, Vector3::zeros());
    if let Some((normal, depth)) = finding.touch() {
        energy += 0.5 * stiffness * depth * depth;
        gradient -= normal * (stiffness * depth);
    }
    if let Some(anchor) = anchor {
        let (stuck_energy, pull) = anchor.pull(position, STICKING * stiffness);
        energy += stuck_energy;
        gradient += pull;
    }
    (energy, gradient)
}

/// The middles of the edges that are too long to do without.
fn middles(level: &Level) -> Vec<Middle> {
    let length = |t: u32, tip: usize| {
        let rest = level.rest_corners(t as usize);
        (rest[(tip + 2) % 3] - rest[(tip + 1) % 3]).norm()
    };
    let is_large = |t: &u32| (0..3).any(|tip| length(*t, tip) > LONGEST_UNSAMPLED);
    let large: Vec<u32> = (0..level.triangles.len() as u32).filter(is_large).collect();
    let particles: Vec<[u32; 3]> = large.iter().map(|&t| level.particles(t as usize)).collect();
    let edges = EdgeTable::new(&particles).edges;
    let middle = |edge: &Edge| {
        let k = edge.triangles[0] as usize;
        let tip = particles[k].iter().position(|p| !edge.ends.contains(p))?;
        let length = length(large[k], tip);
        (length > LONGEST_UNSAMPLED).then_some(Middle { ends: edge.ends, sag: sag(length) })
    };
    edges.iter().filter_map(middle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shapes;
    use crate::garment::Garment;
    use crate::geometry::Vector2;
    use crate::pattern::{Curve, Panel, Pattern, Placement, Segment};

    /// A ball of one metre and a cloth of 20 cm that dips into its top.
    fn scene() -> (Body, DistanceField, Level, Vec<Vector3>) {
        let body = shapes::ball();
        let field = DistanceField::new(&body, 0.01, 0.03);
        let corners = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]].map(Vector2::from);
        let segments = (0..4).map(|k| Segment { curve: Curve::line(corners[k], corners[(k + 1) % 4]), label: None });
        let placement = Placement::flat(nalgebra::Rotation3::identity(), Vector3::zeros());
        let panel = Panel::new("cloth", segments.collect()).at(placement);
        let pattern = Pattern { name: "cloth".into(), panels: vec![panel], seams: vec![] };
        let level = Garment::build(&pattern, &[0.03]).unwrap().levels.remove(0);
        let positions = level.rest.iter().map(|p| Vector3::new(p.x, 0.998 + 0.01 * (p.x * 40.0).sin(), p.y)).collect();
        (body, field, level, positions)
    }

    fn settings(friction: f64) -> BodyContactSettings {
        BodyContactSettings { clearance: 0.003, stiffness: 500.0, friction }
    }

    #[test]
    fn what_was_asked_to_keep_farther_may_come_nearer_again_but_not_than_its_clearance() {
        let (body, field, level, positions) = scene();
        let mut contact = BodyContact::new(&body, &field, &level, settings(0.0));
        let unknown = vec![f64::NEG_INFINITY; positions.len()];
        let least = |contact: &BodyContact| {
            let mut moves = positions.clone();
            contact.hold(&positions, &mut unknown.clone(), &mut moves);
            let held = positions.iter().zip(moves).map(|(p, by)| p + by);
            held.map(|p| body.nearest(p, 1.0).unwrap().distance).fold(f64::INFINITY, f64::min)
        };
        let all = |by: f64| (0..positions.len() as u32).map(move |p| (p, by));
        let clear = least(&contact);
        contact.keep_farther(all(0.004));
        assert!((least(&contact) - clear - 0.004).abs() < 2e-4);
        contact.let_nearer(all(0.003));
        assert!((least(&contact) - clear - 0.001).abs() < 2e-4);
        contact.let_nearer(all(0.003));
        assert!((least(&contact) - clear).abs() < 1e-12);
    }

    #[test]
    fn the_gradient_is_the_derivative_with_and_without_friction() {
        let (body, field, level, positions) = scene();
        for friction in [0.0, 0.5] {
            let mut contact = BodyContact::new(&body, &field, &level, settings(friction));
            let mut gradient = vec![Vector3::zeros(); positions.len()];
            contact.evaluate(&positions, &mut gradient);
            contact.update_anchors(&positions);
            let mut at = positions.clone();
            at.iter_mut().for_each(|p| *p += Vector3::new(0.002, 0.0, 0.001));
            gradient.fill(Vector3::zeros());
            assert!(contact.evaluate(&at, &mut gradient) > 0.0);
            let step = 1e-7;
            for p in (0..positions.len()).step_by(3) {
                for axis in 0..3 {
                    let mut energy = |by: f64| {
                        let mut moved = at.clone();
                        moved[p][axis] += by;
                        contact.evaluate(&moved, &mut vec![Vector3::zeros(); positions.len()])
                    };
                    let slope = (energy(step) - energy(-step)) / (2.0 * step);
                    assert!((slope - gradient[p][axis]).abs() < 1e-4, "{slope} {}", gradient[p][axis]);
                }
            }
        }
    }

    #[test]
    fn held_particles_keep_their_clearance() {
        let (body, field, level, mut positions) = scene();
        let contact = BodyContact::new(&body, &field, &level, settings(0.0));
        let mut bounds = vec![f64::NEG_INFINITY; positions.len()];
        let mut moves = positions.clone();
        contact.hold(&positions, &mut bounds, &mut moves);
        positions.iter_mut().zip(&moves).for_each(|(p, by)| *p += by);
        assert!(positions.iter().all(|&p| body.signed_distance(p) > 0.003 - 1e-6));
        // Of those that were moved nothing is known but that they kept too little; of the others what was measured.
        contact.hold(&positions, &mut bounds, &mut moves);
        for (&p, &bound) in positions.iter().zip(&bounds) {
            let distance = body.signed_distance(p);
            assert!(bound <= distance + 1e-12 && bound >= 0.003 - HOLD_TOLERANCE, "{bound} {distance}");
        }
    }

    #[test]
    fn friction_holds_small_pulls_and_slips_under_large_ones() {
        let (body, field, level, positions) = scene();
        let mut contact = BodyContact::new(&body, &field, &level, settings(0.5));
        let mut gradient = vec![Vector3::zeros(); positions.len()];
        contact.evaluate(&positions, &mut gradient);
        contact.update_anchors(&positions);
        let touching = (0..positions.len()).filter_map(|p| contact.findings[p].touch().map(|touch| (p, touch)));
        let (p, (normal, depth)) = touching.max_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b)).unwrap();
        let normal = normal.normalize();
        let along = (Vector3::z() - normal * normal.z).normalize();
        let limit = 0.5 * depth / STICKING;
        for (shift, slips) in [(0.5 * limit, false), (2.0 * limit, true)] {
            let mut moved = positions.clone();
            moved[p] += along * shift;
            contact.evaluate(&moved, &mut gradient);
            let before = (contact.anchors.clone(), contact.anchor_of.clone());
            contact.update_anchors(&moved);
            // An anchor that was dragged pulls at who goes back.
            let (_, pull) = contact.anchor(p).unwrap().pull(positions[p], 1.0);
            assert_eq!(pull.norm() > 0.1 * limit, slips);
            (contact.anchors, contact.anchor_of) = before;
        }
    }
}
