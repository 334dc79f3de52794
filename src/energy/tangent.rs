//! The Hessian of the elastic energy, for minimizers of second order.
//!
//! The membrane couples particles that share a triangle; its blocks are computed anew for each state.
//! Quadratic bending couples the tips across an edge as well; its matrix never changes.

use super::Model;
use super::bending::{Bending, HingeForm, hinge_form};
use super::membrane::{self, Triangle};
use crate::garment::Level;
use crate::geometry::Incidence;
use crate::geometry::Vector3;
use crate::minimize::Pattern;
use crate::pattern::Cut;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// What the Hessian of a level's elastic energy is made from.
pub struct Tangent {
    triangles: Vec<Triangle>,
    triangles_at: Incidence,
    /// Particles that share a triangle.
    pattern: Pattern,
    bending: BendingRows,
    /// Bending by the edges of the mesh alone: see [`near_bending`].
    near: Vec<Vec<(u32, f64)>>,
}

/// The constant Hessian of quadratic bending: one number, N/m, for x, y and z alike.
struct BendingRows {
    starts: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Tangent {
    /// Bending is taken as quadratic, whatever the model: springs across edges have no stiffness
    /// about the flat state, and a method of second order nothing to go by.
    pub fn new<'a>(level: &Level, cut: impl Into<Cut<'a>>, model: Model) -> Self {
        let cut = cut.into();
        let triangles = membrane::triangles(level, cut, model.membrane);
        let panel_of = level.panel_of_triangle();
        let form = |h| hinge_form(level, h, cut.of_panel(panel_of[h.triangles[0] as usize] as usize));
        let forms: Vec<HingeForm> = level.hinges.par_iter().map(form).collect();
        let of_triangles = || triangles.iter().map(|t| t.particles);
        let forms_at = Incidence::new(level.particle_count, forms.iter().map(|f| f.particles));
        let exact = model.bending == Bending::Quadratic;
        let near: Vec<_> =
            (0..level.particle_count).into_par_iter().map(|p| near_bending(p, &forms, &forms_at)).collect();
        Self {
            pattern: Pattern::of_triangles(level.particle_count, of_triangles()),
            triangles_at: Incidence::new(level.particle_count, of_triangles()),
            bending: BendingRows::new(level.particle_count, if exact { &forms } else { &[] }, &forms_at),
            near,
            triangles,
        }
    }

    /// Particles that share a triangle.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Adds the membrane's blocks of a particle's row, N/m. `definite` leaves out what pushing edges make negative.
    pub fn add_membrane(
        &self,
        positions: &[Vector3],
        particle: usize,
        definite: bool,
        columns: &[u32],
        blocks: &mut [Matrix3<f64>],
    ) {
        for &slot in self.triangles_at.slots(particle) {
            let (triangle, corner) = (&self.triangles[slot as usize / 3], slot as usize % 3);
            let row = triangle.hessian_row(triangle.particles.map(|p| positions[p as usize]), corner, definite);
            for (p, block) in triangle.particles.iter().zip(row) {
                blocks[within(columns, *p)] += block;
            }
        }
    }

    /// Adds bending by the edges of the mesh alone to a particle's row, N/m.
    pub fn add_near_bending(&self, particle: usize, columns: &[u32], blocks: &mut [Matrix3<f64>]) {
        for &(column, value) in &self.near[particle] {
            let block = &mut blocks[within(columns, column)];
            (0..3).for_each(|k| block[(k, k)] += value);
        }
    }

    /// Diagonal entry of the bending's Hessian, N/m.
    pub fn bending_diagonal(&self, particle: usize) -> f64 {
        let BendingRows { starts, columns, values } = &self.bending;
        let range = starts[particle] as usize..starts[particle + 1] as usize;
        let own = columns[range.clone()].iter().position(|&column| column as usize == particle);
        own.map_or(0.0, |within| values[range][within])
    }

    /// Row of the bending's Hessian times a direction.
    #[inline]
    pub fn bending_times(&self, particle: usize, direction: &[Vector3]) -> Vector3 {
        let BendingRows { starts, columns, values } = &self.bending;
        let range = starts[particle] as usize..starts[particle + 1] as usize;
        let mut sum = Vector3::zeros();
        for (&column, &value) in columns[range.clone()].iter().zip(&values[range]) {
            sum += direction[column as usize] * value;
        }
        sum
    }
}

/// Place of a column in a row that has it.
fn within(columns: &[u32], column: u32) -> usize {
    columns.binary_search(&column).expect("neighbours are in every row")
}

/// A hinge's form `½ |Σ cᵢ xᵢ|²` with `Σ cᵢ = 0` is `-½ Σ cᵢ cⱼ |xᵢ - xⱼ|²` over its six pairs. Those between an
/// end and a tip weigh positive; they alone are an upper bound of it that lives on the edges.
fn near_bending(particle: usize, forms: &[HingeForm], forms_at: &Incidence) -> Vec<(u32, f64)> {
    let mut row = vec![(particle as u32, 0.0)];
    for &slot in forms_at.slots(particle) {
        let (form, corner) = (&forms[slot as usize / 4], slot as usize % 4);
        let partners = if corner < 2 { [2, 3] } else { [0, 1] };
        for partner in partners {
            let weight = (-form.coefficients[corner] * form.coefficients[partner]).max(0.0);
            row[0].1 += weight;
            row.push((form.particles[partner], -weight));
        }
    }
    row
}

impl BendingRows {
    fn new(particle_count: usize, forms: &[HingeForm], forms_at: &Incidence) -> Self {
        let row = |particle: usize| {
            let mut row: Vec<(u32, f64)> = Vec::new();
            let slots = if forms.is_empty() { &[] } else { forms_at.slots(particle) };
            for &slot in slots {
                let (form, corner) = (&forms[slot as usize / 4], slot as usize % 4);
                row.extend((0..4).map(|k| (form.particles[k], form.coefficients[corner] * form.coefficients[k])));
            }
            // Stable: what belongs to one place is added in the order of the hinges.
            row.sort_by_key(|entry| entry.0);
            row.dedup_by(|next, kept| {
                let same = next.0 == kept.0;
                if same {
                    kept.1 += next.1;
                }
                same
            });
            row
        };
        let rows: Vec<_> = (0..particle_count).into_par_iter().map(row).collect();
        let mut all = Self { starts: vec![0], columns: Vec::new(), values: Vec::new() };
        for row in rows {
            all.columns.extend(row.iter().map(|e| e.0));
            all.values.extend(row.iter().map(|e| e.1));
            all.starts.push(all.columns.len() as u32);
        }
        all
    }
}
