//! What moves cloth: its energy and its contact with itself, as in the fit, and what only moving cloth feels.
//!
//! ```text
//!     m a = -∂E/∂x  -  drag m v  +  pressure of the wind                                    (theory, equation 24)
//! ```
//!
//! The first term is the gradient that the fit minimizes. Contact with the body is no force but changes velocities
//! (`response.rs`), and so does the viscosity of the cloth: after a step's forces
//!
//! ```text
//!     m_i v_i  ←  m_i v_i + Σ w min(m_i, m_j) / 6 (v_j - v_i)                               (theory, equation 25)
//! ```
//!
//! over the edges of a particle. What trembles from particle to particle dies away within a few steps, a wrinkle within
//! hundredths of a second, and a sleeve or a skirt swings on, as the second derivative of its velocities is small.
//! Damping along edges alone, as of springs, leaves bending waves ringing for seconds. As it follows the forces it
//! makes a step more stable, never less: where it leaves the share `f` of a vibration, `ω² Δt² ≤ 2 (1 + f) / f`.

use super::integrator::for_all;
use super::settings::{Integrator, Settings};
use super::stability::Pace;
use crate::contact::{SelfContact, SelfContactSettings};
use crate::energy::{Energy, GRAVITY, Model, Terms};
use crate::garment::Level;
use crate::geometry::{EdgeTable, Incidence, Vector3};
use crate::minimize::{CHUNK, dot};
use crate::pattern::{Cut, Fabric};
use rayon::prelude::*;

/// Of air, kg/m³.
const AIR_DENSITY: f64 = 1.2;
/// Drag coefficient of a plate across the wind.
const PLATE_DRAG: f64 = 1.2;
/// Share of what two layers are too near to each other that they may part in one step: below one, as a particle's
/// pairs do not know of each other.
const PARTING: f64 = 0.2;
/// Rounds of power iteration; what they miss of the fastest vibration is in the reserve.
const POWER_ROUNDS: usize = 40;
/// Steps of `2 / ω` are the longest that are stable; this much is used, as stretched cloth is a little stiffer.
const USED: f64 = 1.85;
/// The most of its velocity against its neighbours that a particle loses in a step: more would turn it around.
const MOST_LOST: f64 = 0.66;

/// All forces on the cloth of one level.
pub struct Forces {
    pub energy: Energy,
    cloth: Option<SelfContact>,
    /// Are pairs of layers bounded, as explicit steps need it?
    bounded: bool,
    /// How many pairs each particle is in.
    pairs_at: Vec<u32>,
    pub pace: Pace,
    /// The other ends of each particle's edges.
    neighbours: Neighbours,
    /// See [`Settings::damping`].
    damping: f64,
    drag: f64,
    wind: Option<Wind>,
    /// Energies of the last evaluation.
    pub terms: Terms,
}

impl Forces {
    /// For cloth that is at `positions` now, m.
    pub fn new<'a>(
        level: &Level,
        cut: impl Into<Cut<'a>>,
        fabric: &Fabric,
        model: Model,
        settings: &Settings,
        positions: &[Vector3],
    ) -> Self {
        let mut energy = Energy::new(level, cut, model);
        energy.gravity = GRAVITY;
        let contact = SelfContactSettings::of(level.resolution, fabric);
        let diagonal = energy.diagonal();
        // How fast the fastest vibration is, as against what single particles would have by themselves.
        let alone = Pace::new(energy.masses(), &diagonal, settings.added_mass);
        let coupled = (fastest(&mut energy, &alone.inertia, positions) * alone.step / USED).powi(2);
        let stiffness: Vec<f64> = diagonal.iter().map(|d| coupled * d).collect();
        let pace = Pace::new(energy.masses(), &stiffness, settings.added_mass);
        let neighbours = Neighbours::new(level);
        let wind = (settings.wind != Vector3::zeros()).then(|| Wind::new(level, settings.wind));
        let classes = (0..level.particle_count as u32).collect();
        let cloth = settings.self_collision.then(|| settings.collisions.of_cloth(level, classes, contact));
        let damping = settings.damping;
        Self {
            energy,
            cloth,
            bounded: settings.integrator != Integrator::Implicit,
            pairs_at: vec![0; level.particle_count],
            pace,
            neighbours,
            damping,
            drag: settings.drag,
            wind,
            terms: Terms::default(),
        }
    }

    /// Takes particles of the same class for one where cloth meets cloth: those that will be sewn together.
    pub fn take_for_one(&mut self, level: &Level, class_of: Vec<u32>, fabric: &Fabric) {
        if self.cloth.is_some() {
            self.cloth = Some(SelfContact::new(level, class_of, SelfContactSettings::of(level.resolution, fabric)));
        }
    }

    /// Forgets what contact of the cloth with itself has followed, and looks at `positions` afresh.
    pub fn look_afresh(&mut self, positions: &[Vector3]) {
        if let Some(cloth) = &mut self.cloth {
            cloth.forget();
            cloth.rebuild(positions);
        }
    }

    /// Accelerations, m/s², of cloth at `positions`, m, that moves with `velocities`, m/s.
    pub fn accelerations(&mut self, positions: &[Vector3], velocities: &[Vector3], accelerations: &mut [Vector3]) {
        if self.bounded {
            self.terms = self.energy.evaluate(positions, accelerations);
            self.part_layers(positions, velocities, accelerations);
        } else {
            self.gradient(positions, accelerations);
        }
        let Self { energy, pace, drag, wind, .. } = self;
        let (masses, wind) = (energy.masses(), wind.as_ref());
        accelerations.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, accelerations)| {
            for (k, a) in accelerations.iter_mut().enumerate() {
                let p = chunk * CHUNK + k;
                let mut force = -*a - velocities[p] * (*drag * masses[p]);
                if let Some(wind) = wind {
                    force += wind.force(p, positions, velocities);
                }
                *a = force / pace.inertia[p];
            }
        });
    }

    /// Adds the gradient of cloth against cloth, N, no larger than a step can bear: near pairs push as stiffly as a
    /// barrier does, and as no explicit step could follow. A pair gets no more than parts it by a share of what is
    /// missing, with the velocity that it has.
    fn part_layers(&mut self, positions: &[Vector3], velocities: &[Vector3], gradient: &mut [Vector3]) {
        let Self { cloth: Some(cloth), pairs_at, pace, .. } = self else { return };
        cloth.find_active(positions);
        pairs_at.fill(0);
        for p in cloth.active().iter().flat_map(|pair| pair.particles) {
            pairs_at[p as usize] += 1;
        }
        for pair in cloth.active() {
            let at = || pair.particles.iter().map(|&p| p as usize).zip(pair.weights);
            let parting: f64 = at().map(|(p, w)| velocities[p].dot(&pair.normal) * w).sum();
            let mobility: f64 = at().map(|(p, w)| w * w * f64::from(pairs_at[p]) / pace.inertia[p]).sum();
            let missing = cloth.clearance_of(pair.particles) - pair.distance;
            let most = (PARTING * missing / pace.step - parting).max(0.0) / (mobility * pace.step);
            let push = (-pair.slope).min(most);
            at().for_each(|(p, w)| gradient[p] -= pair.normal * (w * push));
        }
    }

    /// What viscosity leaves of velocities, m/s, after `step`, s.
    pub fn dampen(&self, velocities: &[Vector3], step: f64, dampened: &mut [Vector3]) {
        let (inertia, neighbours) = (&self.pace.inertia, &self.neighbours);
        let lost = (1.0 - (1.0 - self.damping).powf(step / self.pace.step)).min(MOST_LOST);
        for_all(dampened, |p, v| {
            let mut pull = Vector3::zeros();
            for &q in neighbours.of(p) {
                pull += (velocities[q as usize] - velocities[p]) * inertia[q as usize].min(inertia[p]);
            }
            *v = velocities[p] + pull * (lost / (MOST_NEIGHBOURS * inertia[p]));
        });
    }

    /// Gradient of all energies, N.
    pub fn gradient(&mut self, positions: &[Vector3], gradient: &mut [Vector3]) {
        self.terms = self.energy.evaluate(positions, gradient);
        if let Some(cloth) = &mut self.cloth {
            cloth.evaluate(positions, gradient);
        }
    }

    /// Draws moves together, m, that would carry cloth through cloth.
    pub fn limit(&mut self, positions: &[Vector3], moves: &mut [Vector3]) -> bool {
        self.cloth.as_mut().is_some_and(|cloth| cloth.draw(positions, moves) > 0)
    }

    pub fn cloth(&self) -> Option<&SelfContact> {
        self.cloth.as_ref()
    }
}

/// Frequency of the fastest vibration about `positions`, rad/s, by power iteration on `M⁻¹ H`, whose products are
/// differences of gradients.
fn fastest(energy: &mut Energy, inertia: &[f64], positions: &[Vector3]) -> f64 {
    /// The longest move of a trial, m.
    const TRIAL: f64 = 1e-7;
    // No pattern that a vibration could be blind to, and the same every time.
    let wave = |k: usize, step: f64| (k as f64 * step + 1.0).sin();
    let mut mode: Vec<Vector3> =
        (0..positions.len()).map(|k| Vector3::new(wave(k, 12.9898), wave(k, 78.233), wave(k, 37.719))).collect();
    let mut gradients = [vec![Vector3::zeros(); positions.len()], vec![Vector3::zeros(); positions.len()]];
    let mut at = positions.to_vec();
    let mut squared = 0.0;
    for _ in 0..POWER_ROUNDS {
        let longest = mode.par_iter().map(|m| m.norm_squared()).reduce(|| 0.0, f64::max).sqrt();
        if longest == 0.0 {
            return 0.0;
        }
        let by = TRIAL / longest;
        for (gradient, sign) in gradients.iter_mut().zip([1.0, -1.0]) {
            for_all(&mut at, |p, x| *x = positions[p] + mode[p] * (sign * by));
            energy.evaluate(&at, gradient);
        }
        let [ahead, behind] = &gradients;
        let before = dot(&mode, &mode);
        for_all(&mut mode, |p, m| *m = (ahead[p] - behind[p]) / (2.0 * by * inertia[p]));
        squared = (dot(&mode, &mode) / before).sqrt();
        for_all(&mut mode, |_, m| *m /= squared.max(f64::MIN_POSITIVE));
    }
    squared.sqrt()
}

/// Particles have six neighbours inside a panel.
const MOST_NEIGHBOURS: f64 = 6.0;

/// For each particle the other ends of its edges, in a fixed order.
struct Neighbours {
    starts: Vec<u32>,
    ends: Vec<u32>,
}

impl Neighbours {
    fn new(level: &Level) -> Self {
        let edges = EdgeTable::new(&level.particle_triangles()).edges;
        let incidence = Incidence::new(level.particle_count, edges.iter().map(|e| e.ends));
        let (mut starts, mut ends) = (vec![0], Vec::with_capacity(2 * edges.len()));
        for p in 0..level.particle_count {
            ends.extend(incidence.slots(p).iter().map(|&slot| edges[slot as usize / 2].ends[1 - slot as usize % 2]));
            starts.push(ends.len() as u32);
        }
        Self { starts, ends }
    }

    fn of(&self, particle: usize) -> &[u32] {
        &self.ends[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }
}

/// The pressure of air that blows through the scene.
struct Wind {
    /// m/s.
    velocity: Vector3,
    triangles: Vec<[u32; 3]>,
    triangles_at: Incidence,
}

impl Wind {
    fn new(level: &Level, velocity: Vector3) -> Self {
        let triangles = level.particle_triangles();
        let triangles_at = Incidence::new(level.particle_count, triangles.iter().copied());
        Self { velocity, triangles, triangles_at }
    }

    /// On a particle, N: `½ ρ c_d A |u_n| u_n` along the normal for the share `A` of the cloth around it, where the air
    /// blows with `u` against it.
    fn force(&self, particle: usize, positions: &[Vector3], velocities: &[Vector3]) -> Vector3 {
        let slots = self.triangles_at.slots(particle).iter();
        let area: Vector3 = slots
            .map(|&slot| {
                let [a, b, c] = self.triangles[slot as usize / 3].map(|p| positions[p as usize]);
                // A third of the triangle's area.
                (b - a).cross(&(c - a)) / 6.0
            })
            .sum();
        let size = area.norm();
        if size == 0.0 {
            return area;
        }
        let normal = area / size;
        let against = (self.velocity - velocities[particle]).dot(&normal);
        normal * (0.5 * AIR_DENSITY * PLATE_DRAG * size * against * against.abs())
    }
}
