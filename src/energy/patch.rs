//! A piece of parallel work: some particles, and all that pulls at them.
//!
//! A patch owns particles that follow one another, and nobody else writes their gradient. It works on
//! copies of their positions, and of those of the few particles around it, which are small enough for
//! the innermost cache. Triangles and springs that reach across its rim are computed by the patches on both
//! sides; their energy is counted by one. So an evaluation is one parallel loop without a second
//! pass to gather what belongs to a particle, and all sums run in an order that the number of
//! threads does not change.

use super::bending::{CrossSpring, HingeForm};
use super::block::{SpringBlock, Steps, TriangleBlock};
use super::lanes::Lanes;
use super::membrane::Triangle;
use crate::geometry::Incidence;
use crate::geometry::Vector3;
use std::ops::Range;

/// Particles of a patch: with its rim, positions and forces just fit into the innermost cache (48 kB).
/// Part of a result's bytes, since sums run patch by patch.
pub const PATCH: usize = 1024;

/// What all patches are cut from.
pub struct Cloth<'a> {
    pub triangles: &'a [Triangle],
    pub forms: &'a [HingeForm],
    pub springs: &'a [CrossSpring],
    /// Of the forms' particles.
    pub hinges_at: &'a Incidence,
}

/// Particles and what pulls at them. *Places* count the patch's own particles first, then its rim.
pub struct Patch {
    particles: Range<usize>,
    /// Particles of other patches, ascending.
    rim: Vec<u32>,
    own: Share,
    /// Reaches in from other patches, which count the energy.
    foreign: Share,
}

/// What pulls at the particles of a patch.
#[derive(Default)]
struct Share {
    triangles: Vec<TriangleBlock>,
    pairs: Pairs,
    springs: Vec<SpringBlock>,
}

/// Quadratic bending, `½ Σ w |xᵢ - xⱼ|²` over pairs: minus the upper half of the rows of its Hessian.
///
/// Its rows add up to zero, so that differences of positions are all it needs. That keeps the
/// rounding of positions, a thousand times larger than bends, out of energies and forces.
#[derive(Default)]
struct Pairs {
    /// Where each place's partners start; one more than there are places.
    starts: Vec<u32>,
    partners: Vec<u32>,
    /// `w`, N/m.
    weights: Vec<f64>,
}

/// Copies that a thread works on.
#[derive(Default)]
pub struct Scratch {
    positions: Vec<Lanes>,
    forces: Vec<Lanes>,
    steps: Steps,
}

/// Energies of a patch, J.
#[derive(Clone, Copy, Debug, Default)]
pub struct PatchTerms {
    pub membrane: f64,
    pub bending: f64,
    pub gravity: f64,
}

impl Patch {
    /// Cuts all patches.
    pub fn all(particle_count: usize, cloth: &Cloth) -> Vec<Self> {
        use rayon::prelude::*;
        let patch_count = particle_count.div_ceil(PATCH);
        let triangles = Sorted::new(patch_count, cloth.triangles.iter().map(|t| t.particles));
        let springs = Sorted::new(patch_count, cloth.springs.iter().map(|s| s.particles));
        (0..patch_count)
            .into_par_iter()
            .map(|patch| {
                let particles = patch * PATCH..((patch + 1) * PATCH).min(particle_count);
                Self::new(particles, cloth, &triangles[patch], &springs[patch])
            })
            .collect()
    }

    fn new(particles: Range<usize>, cloth: &Cloth, triangles: &Sorted, springs: &Sorted) -> Self {
        let [own_pairs, foreign_pairs] = pairs(&particles, cloth);
        let mut rim: Vec<u32> = Vec::new();
        let mut reach = |p: u32| {
            if !particles.contains(&(p as usize)) {
                rim.push(p);
            }
        };
        let all = |sorted: &Sorted| sorted.own.iter().chain(&sorted.foreign).map(|&k| k as usize).collect::<Vec<_>>();
        all(triangles).into_iter().flat_map(|t| cloth.triangles[t].particles).for_each(&mut reach);
        all(springs).into_iter().flat_map(|s| cloth.springs[s].particles).for_each(&mut reach);
        own_pairs.iter().chain(&foreign_pairs).for_each(|pair| reach(pair.1));
        rim.sort_unstable();
        rim.dedup();
        let place = |p: u32| match particles.contains(&(p as usize)) {
            true => p - particles.start as u32,
            false => (particles.len() + rim.binary_search(&p).expect("the rim has all that is reached")) as u32,
        };
        let share = |triangles: &[u32], springs: &[u32], pairs: &[(u32, u32, f64)]| {
            let placed = |&t: &u32| (cloth.triangles[t as usize].particles.map(place), &cloth.triangles[t as usize]);
            let spring = |&s: &u32| (cloth.springs[s as usize].particles.map(place), &cloth.springs[s as usize]);
            Share {
                triangles: TriangleBlock::all(&triangles.iter().map(placed).collect::<Vec<_>>()),
                pairs: Pairs::new(particles.len(), pairs.iter().map(|&(i, j, w)| (place(i), place(j), w))),
                springs: SpringBlock::all(&springs.iter().map(spring).collect::<Vec<_>>()),
            }
        };
        let own = share(&triangles.own, &springs.own, &own_pairs);
        let foreign = share(&triangles.foreign, &springs.foreign, &foreign_pairs);
        Self { particles, rim, own, foreign }
    }

    /// The vectors of the patch and its rim, by place.
    #[inline(always)]
    fn copy(&self, vectors: &[Vector3], copies: &mut Vec<Lanes>) {
        copies.clear();
        copies.extend(vectors[self.particles.clone()].iter().map(Lanes::of));
        copies.extend(self.rim.iter().map(|&p| Lanes::of(&vectors[p as usize])));
    }

    /// Energies, and the gradient at the patch's own particles, N. Masses are those of all particles, kg.
    #[inline(always)]
    pub fn evaluate(
        &self,
        positions: &[Vector3],
        masses: &[f64],
        gravity: f64,
        gradient: &mut [Vector3],
        scratch: &mut Scratch,
    ) -> PatchTerms {
        let Scratch { positions: at, forces, steps } = scratch;
        self.copy(positions, at);
        forces.clear();
        forces.resize(at.len(), Lanes::ZERO);
        let (at, forces, own) = (&at[..], &mut forces[..], self.particles.len());
        self.own.pairs.pull(at, forces);
        self.foreign.pairs.pull(at, forces);
        // The whole rows of the Hessian times positions are there now.
        let mut bending = Lanes::ZERO;
        for (f, x) in forces[..own].iter().zip(&at[..own]) {
            bending += *f * *x;
        }
        let (mut membrane, mut counted_elsewhere) = (Lanes::ZERO, Lanes::ZERO);
        for springs in &self.own.springs {
            springs.evaluate(at, forces, steps, &mut bending);
        }
        for springs in &self.foreign.springs {
            springs.evaluate(at, forces, steps, &mut counted_elsewhere);
        }
        for triangles in &self.own.triangles {
            triangles.evaluate(at, forces, steps, &mut membrane);
        }
        for triangles in &self.foreign.triangles {
            triangles.evaluate(at, forces, steps, &mut counted_elsewhere);
        }
        let mut height = 0.0;
        let masses = &masses[self.particles.clone()];
        for ((gradient, force), (x, mass)) in gradient.iter_mut().zip(&*forces).zip(at.iter().zip(masses)) {
            let weight = mass * gravity;
            height += weight * x.0[1];
            *gradient = force.xyz();
            gradient.y += weight;
        }
        PatchTerms { membrane: 0.5 * membrane.sum(), bending: 0.5 * bending.sum(), gravity: height }
    }

    /// `dᵀ H d` without what buckling would make negative.
    #[inline(always)]
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3], scratch: &mut Scratch) -> f64 {
        let Scratch { positions: at, forces: along, steps } = scratch;
        self.copy(positions, at);
        self.copy(direction, along);
        let (at, along) = (&at[..], &along[..]);
        let mut sum = self.own.pairs.curvature(along);
        for triangles in &self.own.triangles {
            triangles.curvature(at, along, steps, &mut sum);
        }
        for springs in &self.own.springs {
            springs.curvature(at, along, steps, &mut sum);
        }
        sum.sum()
    }
}

impl Pairs {
    /// Pairs whose first places ascend.
    fn new(places: usize, pairs: impl Iterator<Item = (u32, u32, f64)>) -> Self {
        let count = pairs.size_hint().0;
        let (partners, weights) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut built = Self { starts: vec![0; places + 1], partners, weights };
        for (i, j, weight) in pairs {
            built.starts[i as usize + 1] += 1;
            built.partners.push(j);
            built.weights.push(weight);
        }
        for i in 0..places {
            built.starts[i + 1] += built.starts[i];
        }
        built
    }

    #[inline(always)]
    fn row(&self, place: usize) -> impl Iterator<Item = (usize, Lanes)> {
        let range = self.starts[place] as usize..self.starts[place + 1] as usize;
        let partners = self.partners[range.clone()].iter().map(|&j| j as usize);
        partners.zip(self.weights[range].iter().map(|&w| Lanes::splat(w)))
    }

    /// Adds the gradient.
    #[inline(always)]
    fn pull(&self, at: &[Lanes], forces: &mut [Lanes]) {
        for i in 0..self.starts.len() - 1 {
            let mut sum = Lanes::ZERO;
            for (j, weight) in self.row(i) {
                let pull = (at[i] - at[j]) * weight;
                sum += pull;
                forces[j] -= pull;
            }
            forces[i] += sum;
        }
    }

    /// `Σ w |dᵢ - dⱼ|²`, by lanes.
    #[inline(always)]
    fn curvature(&self, along: &[Lanes]) -> Lanes {
        let mut sum = Lanes::ZERO;
        for i in 0..self.starts.len() - 1 {
            for (j, weight) in self.row(i) {
                let span = along[i] - along[j];
                sum += span * span * weight;
            }
        }
        sum
    }
}

/// Pairs that the particles have: those counted here, with later particles, and those with particles of
/// earlier patches, which count them. `w = -Σ cᵢ cⱼ` over the hinges with both.
fn pairs(particles: &Range<usize>, cloth: &Cloth) -> [Vec<(u32, u32, f64)>; 2] {
    let mut shares = [Vec::new(), Vec::new()];
    let mut row: Vec<(u32, f64)> = Vec::new();
    for i in particles.clone() {
        row.clear();
        for &slot in cloth.hinges_at.slots(i) {
            let form = &cloth.forms[slot as usize / 4];
            let c = form.coefficients[slot as usize % 4];
            for (&j, d) in form.particles.iter().zip(form.coefficients) {
                if j as usize > i || (j as usize) < particles.start {
                    row.push((j, -c * d));
                }
            }
        }
        // Stable: entries of one pair are added in the order of the hinges.
        row.sort_by_key(|&(j, _)| j);
        for same in row.chunk_by(|a, b| a.0 == b.0) {
            let share = &mut shares[usize::from((same[0].0 as usize) < particles.start)];
            share.push((i as u32, same[0].0, same.iter().map(|&(_, w)| w).sum()));
        }
    }
    shares
}

/// Numbers of the triangles, or springs, of a patch.
#[derive(Clone, Default)]
struct Sorted {
    /// Those whose first particle is the patch's.
    own: Vec<u32>,
    /// The others that pull at its particles.
    foreign: Vec<u32>,
}

impl Sorted {
    fn new<const N: usize>(patch_count: usize, elements: impl Iterator<Item = [u32; N]>) -> Vec<Self> {
        let mut sorted = vec![Self::default(); patch_count];
        for (k, particles) in elements.enumerate() {
            let patches = particles.map(|p| p as usize / PATCH);
            sorted[patches[0]].own.push(k as u32);
            for (n, patch) in patches.iter().enumerate().skip(1) {
                if !patches[..n].contains(patch) {
                    sorted[*patch].foreign.push(k as u32);
                }
            }
        }
        sorted
    }
}
