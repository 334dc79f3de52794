//! Contact with the body: a one-sided quadratic energy over sample points of the cloth, with friction.
//!
//! ```text
//!     E = ½ k (δ - d(x))²   where d(x) < δ, else 0
//! ```
//!
//! `d` is the distance to the body and `δ` the clearance. Its gradient is continuous, so that a
//! minimizer may cross the border of contact freely; what is left of the clearance's violation,
//! pressure over `k`, is taken away by [`BodyContact::hold`] at the end of a level.
//!
//! On fine levels the particles are the sample points. On coarse ones a triangle can cut through an
//! arm between its particles, so its face carries samples as well.
//!
//! Friction is Coulomb's, as springs from where a sample first touched (its anchor); an anchor that
//! is pulled harder than `μ N` slips after. Anchors move in [`BodyContact::update_anchors`] only:
//! between two calls the energy is a function of the positions.

use crate::body::{Body, DistanceField};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::CHUNK;
use rayon::prelude::*;

/// How the cloth is held clear of the body.
#[derive(Clone, Copy, Debug)]
pub struct BodyContactSettings {
    /// Distance to be kept, m.
    pub clearance: f64,
    /// Stiffness of each particle's contact, N/m.
    pub stiffness: f64,
    /// Coulomb coefficient.
    pub friction: f64,
    /// Faces carry samples at least this near to each other, m.
    pub sample_spacing: f64,
}

/// A point of the cloth that is held clear: a place on a triangle.
#[derive(Clone, Copy, Debug)]
struct FaceSample {
    particles: [u32; 3],
    weights: [f64; 3],
    /// N/m.
    stiffness: f64,
    /// How far the cloth bulges out over the chord here, m.
    sag: f64,
}

/// What a sample feels at the last evaluation.
#[derive(Clone, Copy, Debug, Default)]
struct Touch {
    /// Unit vector away from the body; zero when there is no contact.
    normal: Vector3,
    /// Clearance minus distance, m, positive in contact.
    depth: f64,
}

/// Where a sample sticks.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    point: Vector3,
    normal: Vector3,
}

/// Contact of one level with the body.
pub struct BodyContact<'a> {
    body: &'a Body,
    field: &'a DistanceField,
    pub settings: BodyContactSettings,
    particle_count: usize,
    faces: Vec<FaceSample>,
    /// One per particle, then one per face sample.
    touches: Vec<Touch>,
    anchors: Vec<Option<Anchor>>,
}

/// Radius of the limbs and curves that cloth is bent around, m.
const LIMB_RADIUS: f64 = 0.06;

/// Tangential stiffness of a sticking sample over its normal one.
const STICKING: f64 = 0.3;

impl<'a> BodyContact<'a> {
    pub fn new(body: &'a Body, field: &'a DistanceField, level: &Level, settings: BodyContactSettings) -> Self {
        let faces = face_samples(level, &settings);
        let count = level.particle_count + faces.len();
        Self {
            body,
            field,
            settings,
            particle_count: level.particle_count,
            faces,
            touches: vec![Touch::default(); count],
            anchors: vec![None; count],
        }
    }

    /// Adds the gradient, N, and returns the energy, J.
    pub fn evaluate(&mut self, positions: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        let (at_particles, at_faces) = self.touches.split_at_mut(self.particle_count);
        let (body, field, settings) = (self.body, self.field, &self.settings);
        let sums: Vec<f64> = at_particles
            .par_chunks_mut(CHUNK)
            .zip(positions.par_chunks(CHUNK))
            .zip(gradient.par_chunks_mut(CHUNK))
            .zip(self.anchors[..self.particle_count].par_chunks(CHUNK))
            .map(|(((touches, positions), gradient), anchors)| {
                let mut sum = 0.0;
                for (((touch, position), gradient), anchor) in
                    touches.iter_mut().zip(positions).zip(gradient).zip(anchors)
                {
                    *touch = touch_at(body, field, *position, settings.clearance);
                    let (energy, pull) = pull(touch, anchor, *position, settings.stiffness);
                    sum += energy;
                    *gradient += pull;
                }
                sum
            })
            .collect();
        let mut energy: f64 = sums.iter().sum();
        let anchors = &self.anchors[self.particle_count..];
        let pulls: Vec<(f64, Vector3)> = self
            .faces
            .par_iter()
            .zip(at_faces)
            .zip(anchors)
            .with_min_len(CHUNK)
            .map(|((sample, touch), anchor)| {
                let position = sample.position(positions);
                *touch = touch_at(body, field, position, settings.clearance - sample.sag);
                pull(touch, anchor, position, sample.stiffness)
            })
            .collect();
        for (sample, (sample_energy, pull)) in self.faces.iter().zip(pulls) {
            if sample_energy > 0.0 {
                energy += sample_energy;
                for (p, w) in sample.particles.iter().zip(sample.weights) {
                    gradient[*p as usize] += pull * w;
                }
            }
        }
        energy
    }

    /// `dᵀ H d` at the last evaluation, without the curvature of the body.
    pub fn curvature(&self, direction: &[Vector3]) -> f64 {
        let along = |touch: &Touch, anchor: &Option<Anchor>, d: Vector3, stiffness: f64| {
            let normal = stiffness * touch.normal.dot(&d).powi(2);
            let sticking = anchor.as_ref().map_or(0.0, |a| STICKING * stiffness * tangential(d, a.normal).norm_squared());
            normal + sticking
        };
        let particles: f64 = (0..self.particle_count)
            .map(|p| along(&self.touches[p], &self.anchors[p], direction[p], self.settings.stiffness))
            .sum();
        let faces: f64 = (self.faces.iter().zip(self.particle_count..))
            .map(|(f, k)| along(&self.touches[k], &self.anchors[k], f.position(direction), f.stiffness))
            .sum();
        particles + faces
    }

    /// Lets touching samples stick where they are, and those that are pulled too hard slip.
    pub fn update_anchors(&mut self, positions: &[Vector3]) {
        for k in 0..self.touches.len() {
            let (position, stiffness) = match k.checked_sub(self.particle_count) {
                None => (positions[k], self.settings.stiffness),
                Some(face) => (self.faces[face].position(positions), self.faces[face].stiffness),
            };
            let touch = self.touches[k];
            self.anchors[k] = (touch.depth > 0.0 && self.settings.friction > 0.0).then(|| {
                let Some(anchor) = self.anchors[k] else { return Anchor { point: position, normal: touch.normal } };
                let span = tangential(position - anchor.point, touch.normal);
                let most = self.settings.friction * touch.depth / STICKING;
                let slip = (span.norm() - most).max(0.0);
                let point = anchor.point + if slip > 0.0 { span.normalize() * slip } else { Vector3::zeros() };
                let _ = stiffness;
                Anchor { point, normal: touch.normal }
            });
        }
    }

    /// Forgets where samples stuck.
    pub fn release_anchors(&mut self) {
        self.anchors.fill(None);
    }

    /// Moves each particle that is too near out to its clearance, by exact distances.
    pub fn hold(&self, positions: &mut [Vector3]) {
        let clearance = self.settings.clearance;
        positions.par_iter_mut().with_min_len(256).for_each(|position| {
            // A second round serves creases, where moving out of one side leads to the other.
            for _ in 0..3 {
                let near = self.field.sample(*position);
                if near.is_some_and(|s| s.distance > clearance + self.field.cell()) {
                    return;
                }
                let Some(nearest) = self.body.nearest(*position, clearance.max(self.field.band())) else { return };
                let inside = self.body.contains(*position);
                if !inside && nearest.distance >= clearance {
                    return;
                }
                let away = if inside { nearest.point - *position } else { *position - nearest.point };
                let [a, b, c] = self.body.corners(nearest.triangle);
                let normal = away.try_normalize(1e-9).unwrap_or_else(|| (b - a).cross(&(c - a)).normalize());
                *position = nearest.point + normal * (clearance * (1.0 + 1e-6));
            }
        });
    }

    /// Stiffness that contact adds to each particle's diagonal, N/m.
    pub fn diagonal(&self) -> f64 {
        self.settings.stiffness
    }
}

impl FaceSample {
    fn position(&self, at: &[Vector3]) -> Vector3 {
        let [a, b, c] = self.particles.map(|p| at[p as usize]);
        a * self.weights[0] + b * self.weights[1] + c * self.weights[2]
    }
}

fn tangential(v: Vector3, normal: Vector3) -> Vector3 {
    v - normal * normal.dot(&v)
}

fn touch_at(body: &Body, field: &DistanceField, position: Vector3, clearance: f64) -> Touch {
    match field.sample(position) {
        Some(s) if s.distance >= clearance => Touch::default(),
        Some(s) if s.distance > -field.band() => Touch { normal: s.gradient, depth: clearance - s.distance },
        None if !field.is_deep_inside(position) => Touch::default(),
        _ => {
            // Deep inside, where the field ends.
            let Some(nearest) = body.nearest(position, f64::INFINITY) else { return Touch::default() };
            let normal = (nearest.point - position).try_normalize(1e-9).unwrap_or_else(Vector3::y);
            Touch { normal, depth: clearance + nearest.distance }
        }
    }
}

/// Energy and gradient of one sample.
fn pull(touch: &Touch, anchor: &Option<Anchor>, position: Vector3, stiffness: f64) -> (f64, Vector3) {
    if touch.depth <= 0.0 {
        return (0.0, Vector3::zeros());
    }
    let mut energy = 0.5 * stiffness * touch.depth * touch.depth;
    let mut gradient = touch.normal * (-stiffness * touch.depth);
    if let Some(anchor) = anchor {
        let span = tangential(position - anchor.point, anchor.normal) ;
        energy += 0.5 * STICKING * stiffness * span.norm_squared();
        gradient += span * (STICKING * stiffness);
    }
    (energy, gradient)
}

/// Points on the faces between the particles, on a lattice that is finer than `sample_spacing`.
fn face_samples(level: &Level, settings: &BodyContactSettings) -> Vec<FaceSample> {
    let mut samples = Vec::new();
    for t in 0..level.triangles.len() {
        let rest = level.rest_corners(t);
        let longest = (0..3).map(|k| (rest[(k + 1) % 3] - rest[k]).norm()).fold(0.0, f64::max);
        let steps = (longest / settings.sample_spacing).ceil() as usize;
        for i in 0..=steps {
            for j in 0..=steps - i {
                let k = steps - i - j;
                if i.max(j).max(k) < steps {
                    // Samples on an edge belong to two triangles, half each.
                    let share = if i.min(j).min(k) == 0 { 0.5 } else { 1.0 };
                    samples.push(FaceSample {
                        particles: level.particles(t),
                        weights: [i, j, k].map(|n| n as f64 / steps as f64),
                        stiffness: share * settings.stiffness / (steps * steps) as f64,
                        // A chord of length h over radius R sags h²/8R.
                        sag: longest * longest / (8.0 * LIMB_RADIUS) * 3.0 * [[i, j], [j, k], [k, i]].iter().map(|[a, b]| (a * b) as f64).sum::<f64>() / (steps * steps) as f64,
                    });
                }
            }
        }
    }
    samples
}

impl BodyContact<'_> {
    /// debug
    pub fn forces(&self, positions: &[Vector3]) -> Vec<(Vector3, Vector3)> {
        (0..self.touches.len()).filter(|&k| self.touches[k].depth > 0.0).map(|k| {
            let (p, s) = match k.checked_sub(self.particle_count) { None => (positions[k], self.settings.stiffness), Some(f) => (self.faces[f].position(positions), self.faces[f].stiffness) };
            (p, self.touches[k].normal * (self.touches[k].depth * s))
        }).collect()
    }
}
