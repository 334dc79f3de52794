//! What positions cost, and the gradient of it: membrane, bending, sewing and gravity.
//!
//! Each term is a small pure function of a few points in a file of its own; here they are added up.
//! Sums run in a fixed order, triangle by triangle and then particle by particle, so that a result
//! has the same bytes on any number of threads.

mod bending;
mod hold;
mod membrane;
mod stitch;

pub use bending::{Bending, CrossSpring, HingeForm, QuadraticForm, hinge_form};
pub use hold::Hold;
pub use membrane::{Membrane, Triangle};
pub use stitch::Stitches;

use crate::garment::Level;
use crate::geometry::Vector3;
use crate::minimize::CHUNK;
use crate::pattern::Fabric;
use rayon::prelude::*;

/// Which formulas stand for the cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Model {
    pub membrane: Membrane,
    pub bending: Bending,
}

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;

/// Energy by term, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    pub membrane: f64,
    pub bending: f64,
    pub sewing: f64,
    pub gravity: f64,
}

impl Terms {
    pub fn total(&self) -> f64 {
        self.membrane + self.bending + self.sewing + self.gravity
    }
}

/// For each particle the triangle corners that are its own, for gathering what triangles computed.
pub struct Corners {
    starts: Vec<u32>,
    /// `3 * triangle + corner`.
    slots: Vec<u32>,
}

impl Corners {
    pub fn new(particle_count: usize, triangles: impl Iterator<Item = [u32; 3]> + Clone) -> Self {
        let mut starts = vec![0u32; particle_count + 1];
        for p in triangles.clone().flatten() {
            starts[p as usize + 1] += 1;
        }
        for i in 0..particle_count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut slots = vec![0; starts[particle_count] as usize];
        for (slot, p) in triangles.flatten().enumerate() {
            slots[next[p as usize] as usize] = slot as u32;
            next[p as usize] += 1;
        }
        Self { starts, slots }
    }

    /// Sum of a particle's shares of `at_corners`.
    #[inline]
    pub fn gather(&self, particle: usize, at_corners: &[[Vector3; 3]]) -> Vector3 {
        let range = self.starts[particle] as usize..self.starts[particle + 1] as usize;
        let mut sum = Vector3::zeros();
        for &slot in &self.slots[range] {
            sum += at_corners[slot as usize / 3][slot as usize % 3];
        }
        sum
    }
}

/// The energy of cloth on one level, with the memory to evaluate it.
pub struct Energy {
    triangles: Vec<Triangle>,
    corners: Corners,
    at_corners: Vec<[Vector3; 3]>,
    quadratic: QuadraticForm,
    cross_springs: Vec<CrossSpring>,
    /// kg, one per particle.
    masses: Vec<f64>,
    diagonal: Vec<f64>,
    /// m/s²; zero while the seams close.
    pub gravity: f64,
    /// Multiplies the membrane stiffness: below one while a level is brought near its shape.
    pub membrane_scale: f64,
    /// What closes the seams; nothing once they are closed.
    pub stitches: Stitches,
    /// What keeps parts of the garment up while it is put on.
    pub holds: Vec<Hold>,
}

impl Energy {
    pub fn new(level: &Level, fabric: &Fabric, model: Model) -> Self {
        let triangles = membrane::triangles(level, fabric, model.membrane);
        let corners = Corners::new(level.particle_count, triangles.iter().map(|t| t.particles));
        let (forms, cross_springs): (Vec<_>, Vec<_>) = match model.bending {
            Bending::Quadratic => (level.hinges.iter().map(|h| hinge_form(level, h, fabric)).collect(), Vec::new()),
            Bending::Springs => (Vec::new(), level.hinges.iter().map(|h| CrossSpring::of(level, h, fabric)).collect()),
        };
        let masses = level.particle_areas().iter().map(|a| a * fabric.areal_density).collect();
        let mut energy = Self {
            at_corners: vec![[Vector3::zeros(); 3]; triangles.len()],
            triangles,
            corners,
            quadratic: QuadraticForm::new(level.particle_count, &forms),
            cross_springs,
            stitches: Stitches::new(level.stitches.clone()),
            masses,
            diagonal: Vec::new(),
            gravity: GRAVITY,
            membrane_scale: 1.0,
            holds: Vec::new(),
        };
        energy.update_diagonal();
        energy
    }

    /// kg, one per particle.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// An estimate of each particle's diagonal of the Hessian, N/m. Call [`Energy::update_diagonal`]
    /// after a stiffness was changed.
    pub fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    pub fn update_diagonal(&mut self) {
        self.diagonal = self.quadratic.diagonal().to_vec();
        for triangle in &self.triangles {
            for (p, d) in triangle.particles.iter().zip(triangle.diagonal()) {
                self.diagonal[*p as usize] += d * self.membrane_scale;
            }
        }
        for spring in &self.cross_springs {
            for p in spring.particles {
                self.diagonal[p as usize] += spring.diagonal();
            }
        }
        self.stitches.add_diagonal(&mut self.diagonal);
    }

    /// Energy at `positions`, with its gradient, N, one per particle.
    pub fn evaluate(&mut self, positions: &[Vector3], gradient: &mut [Vector3]) -> Terms {
        let scale = self.membrane_scale;
        let membrane: Vec<f64> = self
            .triangles
            .par_chunks(CHUNK)
            .zip(self.at_corners.par_chunks_mut(CHUNK))
            .map(|(triangles, at_corners)| {
                let mut sum = 0.0;
                for (triangle, at_corners) in triangles.iter().zip(at_corners) {
                    let (energy, pulls) = triangle.evaluate(triangle.particles.map(|p| positions[p as usize]));
                    sum += energy;
                    *at_corners = pulls.map(|p| p * scale);
                }
                sum
            })
            .collect();
        let (corners, at_corners, quadratic) = (&self.corners, &self.at_corners, &self.quadratic);
        let (masses, weight) = (&self.masses, self.gravity);
        let rest: Vec<(f64, f64)> = gradient
            .par_chunks_mut(CHUNK)
            .enumerate()
            .map(|(chunk, gradient)| {
                let mut sums = (0.0, 0.0);
                for (k, g) in gradient.iter_mut().enumerate() {
                    let p = chunk * CHUNK + k;
                    let bent = quadratic.row_times(p, positions);
                    let pull = masses[p] * weight;
                    sums.0 += 0.5 * bent.dot(&positions[p]);
                    sums.1 += pull * positions[p].y;
                    *g = corners.gather(p, at_corners) + bent + Vector3::new(0.0, pull, 0.0);
                }
                sums
            })
            .collect();
        let mut terms = Terms {
            membrane: membrane.iter().sum::<f64>() * scale,
            bending: rest.iter().map(|r| r.0).sum(),
            sewing: 0.0,
            gravity: rest.iter().map(|r| r.1).sum(),
        };
        // Few or none: the baseline's springs, and stitches of the open coarsest level.
        for spring in &self.cross_springs {
            let [a, b] = spring.particles.map(|p| p as usize);
            let (energy, pull) = spring.evaluate([positions[a], positions[b]]);
            terms.bending += energy;
            gradient[a] -= pull;
            gradient[b] += pull;
        }
        terms.sewing = self.stitches.evaluate(positions, gradient)
            + self.holds.iter().map(|hold| hold.evaluate(positions, gradient)).sum::<f64>();
        terms
    }

    /// `dᵀ H d` at `positions` without what buckling would make negative, N·m per unit squared.
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3]) -> f64 {
        let membrane: Vec<f64> = self
            .triangles
            .par_chunks(CHUNK)
            .map(|triangles| {
                let curvature = |t: &Triangle| {
                    t.curvature(t.particles.map(|p| positions[p as usize]), t.particles.map(|p| direction[p as usize]))
                };
                triangles.iter().map(curvature).sum()
            })
            .collect();
        let bending: Vec<f64> = direction
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, along)| {
                let row = |(k, d): (usize, &Vector3)| self.quadratic.row_times(chunk * CHUNK + k, direction).dot(d);
                along.iter().enumerate().map(row).sum()
            })
            .collect();
        let springs: f64 = self
            .cross_springs
            .iter()
            .map(|s| {
                s.curvature(s.particles.map(|p| positions[p as usize]), s.particles.map(|p| direction[p as usize]))
            })
            .sum();
        let holds: f64 = self.holds.iter().map(|hold| hold.curvature(positions, direction)).sum();
        membrane.iter().sum::<f64>() * self.membrane_scale
            + bending.iter().sum::<f64>()
            + springs
            + self.stitches.curvature(direction)
            + holds
    }
}
