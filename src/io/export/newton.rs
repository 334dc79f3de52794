//! What Newton's cloth builders take (NVIDIA's simulator, version 1.8), by the names of their parameters, as arrays for NumPy;
//! `load_into_newton.py` hands them over.
//!
//! *Style3D* (`newton.solvers.style3d.add_cloth_mesh`) takes sewn vertices and flat panels apart, which is what a garment
//! is. Triangles whose panel runs clockwise it would drop, as their flat area is negative: their panels are turned over
//! (x → -x), which changes no length and leaves the warp on y. Its membrane has no Poisson's ratio; the stretch figures are
//! those of a strip, so that a strip is as stiff as the fabric's.
//!
//! *VBD* and others (`ModelBuilder.add_cloth_mesh`) take the pose that the vertices are in for the rest shape; the script
//! overwrites it with that of the panels. Their membrane is neo-Hookean and isotropic with the two constants of Lamé in the
//! plane; `tri_ke` is `μ = E / 2(1 + ν)`, `tri_ka` is `λ = E ν / (1 - ν²)`, both N/m, with `E` the mean of warp and weft.
//! Their hinges cost `½ k L θ²` each; the quadratic bending energy of `energy/bending.rs` costs `½ B L² θ² / (A₀ + A₁)`, which
//! makes `k = B L / (A₀ + A₁)`, another for each hinge. Style3D has the form of Bergou et al. with `3B`, of which a bent mesh
//! costs three times `B`: it is given a third.

use super::npz::Npz;
use super::{Isotropic, Source};
use crate::garment::{Hinge, Level};
use crate::geometry::{Vector2, Vector3, signed_area};
use crate::pattern::Fabric;
use std::io::{self, Seek, Write};

/// Writes the arrays. `positions` are those of the particles, m, world.
pub fn write(source: &Source, positions: &[Vector3], out: impl Write + Seek) -> io::Result<()> {
    let (level, fabric) = (source.level, source.fabric);
    let corners = level.particle_triangles();
    let mut npz = Npz::new(out);
    npz.array("vertices", &[positions.len(), 3], positions.iter().flatten().copied())?;
    npz.array("indices", &[3 * corners.len()], corners.iter().flatten().map(|&i| i as i32))?;
    let panel_verts = facing_panels(source);
    npz.array("panel_verts", &[panel_verts.len(), 2], panel_verts.iter().flatten().copied())?;
    npz.array("panel_indices", &[3 * corners.len()], level.triangles.iter().flatten().map(|&i| i as i32))?;
    npz.array("density", &[], [fabric.areal_density])?;
    npz.array("particle_radius", &[], [particle_radius(source)])?;
    npz.array("friction", &[], [fabric.friction])?;
    npz.array("tri_aniso_ke", &[3], [fabric.stretch.weft, fabric.stretch.warp, fabric.shear])?;
    npz.array("edge_aniso_ke", &[3], style3d_bending(fabric))?;
    let [mu, lambda] = Isotropic::of(fabric).lame(fabric.poisson_ratio);
    npz.array("tri_ke", &[], [mu])?;
    npz.array("tri_ka", &[], [lambda])?;
    let hinges: Vec<RestHinge> = level.hinges.iter().map(|hinge| RestHinge::of(level, hinge, fabric)).collect();
    npz.array("hinges", &[hinges.len(), 4], hinges.iter().flat_map(|h| h.particles.map(|p| p as i32)))?;
    npz.array("hinge_lengths", &[hinges.len()], hinges.iter().map(|h| h.length))?;
    npz.array("hinge_ke", &[hinges.len()], hinges.iter().map(|h| h.stiffness))?;
    npz.finish()
}

/// Flat points, m, such that every triangle has a positive area.
fn facing_panels(source: &Source) -> Vec<Vector2> {
    let mut points = source.level.rest.clone();
    for (panel, range) in source.pattern.panels.iter().zip(&source.level.panels) {
        if panel.signed_area() < 0.0 {
            points[range.points.clone()].iter_mut().for_each(|p| p.x = -p.x);
        }
    }
    points
}

/// Newton keeps a particle this far from bodies and twice as far from each other: at most what the fit has kept, so that
/// nothing begins with a push, m.
fn particle_radius(source: &Source) -> f64 {
    source.clearance.min(0.5 * source.fabric.thickness)
}

/// Style3D's bending for edges along v, along u, and at 45°, N·m. Cloth bends *across* an edge: over one that runs along
/// the warp (v) it bends with the rigidity of the weft. At 45° the first two still count by `2⁻⁶` each.
fn style3d_bending(fabric: &Fabric) -> [f64; 3] {
    let mean = 0.5 * (fabric.bending.warp + fabric.bending.weft);
    [fabric.bending.weft, fabric.bending.warp, mean * (1.0 - 1.0 / 32.0)].map(|bending| bending / 3.0)
}

/// A hinge as Newton knows them.
struct RestHinge {
    /// Tip, tip, end, end: triangles run (tip 0, end, end) and (tip 1, end, end) backwards.
    particles: [u32; 4],
    /// At rest, the mean of both sides, m.
    length: f64,
    /// N: `E = ½ k L θ²`.
    stiffness: f64,
}

impl RestHinge {
    fn of(level: &Level, hinge: &Hinge, fabric: &Fabric) -> Self {
        let [first, second] = hinge.triangles.map(|t| level.particles(t as usize));
        let tips = hinge.tips.map(usize::from);
        let particles = [first[tips[0]], second[tips[1]], first[(tips[0] + 1) % 3], first[(tips[0] + 2) % 3]];
        let sides = [0, 1].map(|k| {
            let corners = level.rest_corners(hinge.triangles[k] as usize);
            let edge = corners[(tips[k] + 2) % 3] - corners[(tips[k] + 1) % 3];
            let length = edge.norm();
            // Curvature runs across the edge; the warp along y.
            (length, signed_area(corners[0], corners[1], corners[2]).abs(), fabric.bending_along(edge.x / length))
        });
        let [length, bending] = [0.5 * (sides[0].0 + sides[1].0), 0.5 * (sides[0].2 + sides[1].2)];
        Self { particles, length, stiffness: bending * length / (sides[0].1 + sides[1].1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::export::npz::tests::{member, numbers};
    use crate::io::sample::two_panels;
    use std::io::Cursor;

    fn source_file(fabric: &Fabric) -> (Vec<u8>, Level) {
        let (pattern, garment, positions) = two_panels();
        let level = garment.levels[1].clone();
        let source = Source { pattern: &pattern, level: &level, fabric, clearance: 0.0007, skin: None };
        let mut file = Cursor::new(Vec::new());
        write(&source, &positions, &mut file).unwrap();
        (file.into_inner(), level)
    }

    #[test]
    fn flat_triangles_face_up_and_keep_their_lengths() {
        let (file, level) = source_file(&Fabric::default());
        let flat = numbers(&member(&file, "panel_verts").1);
        let point = |p: u32| Vector2::new(flat[2 * p as usize], flat[2 * p as usize + 1]);
        for (t, triangle) in level.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(point);
            assert!(signed_area(a, b, c) > 0.0);
            let rest = level.rest_corners(t);
            assert!(((a - b).norm() - (rest[0] - rest[1]).norm()).abs() < 1e-15);
        }
    }

    /// A cylinder of radius r costs `B / 2r²` per area; here each hinge is bent by the angle of its two triangles on it.
    #[test]
    fn hinges_bent_to_a_cylinder_cost_the_bending_rigidity() {
        let fabric = Fabric::default();
        let (file, level) = source_file(&fabric);
        let [lengths, stiffness] = ["hinge_lengths", "hinge_ke"].map(|name| numbers(&member(&file, name).1));
        let radius = 1.0;
        let on_cylinder = |r: Vector2| {
            let angle = r.x / radius;
            Vector3::new(radius * angle.sin(), r.y, radius * angle.cos())
        };
        // The two panels lie side by side in one plane, so that their rest coordinates continue each other.
        let mut energy = 0.0;
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        for (rest, &particle) in level.rest.iter().zip(&level.particle_of) {
            positions[particle as usize] = on_cylinder(*rest);
        }
        for (k, hinge) in level.hinges.iter().enumerate() {
            let [n, m] = hinge.triangles.map(|t| {
                let [a, b, c] = level.particles(t as usize).map(|p| positions[p as usize]);
                (b - a).cross(&(c - a)).normalize()
            });
            energy += 0.5 * stiffness[k] * lengths[k] * n.angle(&m).powi(2);
        }
        let area: f64 = level.rest_areas().iter().sum();
        let exact = 0.5 * fabric.bending.warp / (radius * radius) * area;
        // Hinges are missing along the rim, where half of each outermost triangle's curvature would be.
        assert!((0.8..1.02).contains(&(energy / exact)), "{}", energy / exact);
    }

    #[test]
    fn the_two_constants_give_back_young_and_poisson() {
        let fabric = Fabric::named("cotton_shirting").unwrap();
        let (file, _) = source_file(&fabric);
        let [mu, lambda] = ["tri_ke", "tri_ka"].map(|name| numbers(&member(&file, name).1)[0]);
        // In the plane ν = λ / (λ + 2μ), E = 4μ(λ + μ) / (λ + 2μ).
        assert!((lambda / (lambda + 2.0 * mu) - fabric.poisson_ratio).abs() < 1e-12);
        let young = 4.0 * mu * (lambda + mu) / (lambda + 2.0 * mu);
        assert!((young - (500.0f64 * 250.0).sqrt()).abs() < 1e-9, "{young}");
    }
}
