//! What positions cost, and the gradient of it: membrane, bending, sewing and gravity.
//!
//! Each term is a small pure function of a few points in a file of its own; they are added up patch
//! by patch (`patch.rs`). Sums run in a fixed order, so that a result has the same bytes on any number
//! of threads.

mod bending;
mod block;
mod hold;

mod lanes;
mod membrane;
mod patch;
mod stitch;
mod tangent;
mod wall;

pub use bending::{Bending, CrossSpring, HingeForm, hinge_form};
pub use hold::Hold;
pub use membrane::{Membrane, Triangle};
pub use stitch::Stitches;
pub use tangent::Tangent;
pub use wall::Wall;

use crate::garment::Level;
use crate::geometry::Incidence;
use crate::geometry::Vector3;
use crate::pattern::Cut;
use patch::{Cloth, PATCH, Patch, PatchTerms, Scratch};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use std::sync::Arc;

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

/// The energy of cloth on one level, ready to be evaluated.
pub struct Energy {
    patches: Vec<Patch>,
    /// Which instructions the processor has.
    arch: Arch,
    /// kg, one per particle; shared with those who watch an evaluation.
    masses: Arc<[f64]>,
    /// The part of the diagonal that never changes, N/m.
    elastic_diagonal: Vec<f64>,
    /// m/s²; zero while the seams close.
    pub gravity: f64,
    /// What closes the seams; nothing once they are closed.
    pub stitches: Stitches,
    /// What keeps parts of the garment up while it is put on.
    pub holds: Vec<Hold>,
    /// What parts garments that are sewn one over the other.
    pub walls: Vec<Wall>,
}

impl Energy {
    pub fn new<'a>(level: &Level, cut: impl Into<Cut<'a>>, model: Model) -> Self {
        let cut = cut.into();
        let triangles = membrane::triangles(level, cut, model.membrane);
        let panel_of = level.panel_of_triangle();
        // A seam between two fabrics bends like the first of them.
        let hinges = level.hinges.par_iter().map(|h| (h, cut.of_panel(panel_of[h.triangles[0] as usize] as usize)));
        let (forms, springs): (Vec<_>, Vec<_>) = match model.bending {
            Bending::Quadratic => (hinges.map(|(h, fabric)| hinge_form(level, h, fabric)).collect(), Vec::new()),
            Bending::Springs => (Vec::new(), hinges.map(|(h, fabric)| CrossSpring::of(level, h, fabric)).collect()),
        };
        let hinges_at = Incidence::new(level.particle_count, forms.iter().map(|f| f.particles));
        let cloth = Cloth { triangles: &triangles, forms: &forms, springs: &springs, hinges_at: &hinges_at };
        Self {
            patches: Patch::all(level.particle_count, &cloth),
            arch: Arch::new(),
            masses: level.particle_masses(|panel| cut.of_panel(panel).areal_density).into(),
            elastic_diagonal: elastic_diagonal(level.particle_count, &cloth),
            gravity: GRAVITY,
            stitches: Stitches::new(level.stitches.clone()),
            holds: Vec::new(),
            walls: Vec::new(),
        }
    }

    /// kg, one per particle.
    pub fn masses(&self) -> &Arc<[f64]> {
        &self.masses
    }

    /// An estimate of each particle's diagonal of the Hessian, N/m.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = self.elastic_diagonal.clone();
        self.stitches.add_diagonal(&mut diagonal);
        diagonal
    }

    /// Energy at `positions`, with its gradient, N, one per particle.
    pub fn evaluate(&mut self, positions: &[Vector3], gradient: &mut [Vector3]) -> Terms {
        let (arch, masses, gravity) = (self.arch, &self.masses, self.gravity);
        let patches = self.patches.par_iter().zip(gradient.par_chunks_mut(PATCH));
        let sums: Vec<PatchTerms> = patches
            .map_init(Scratch::default, |scratch, (patch, gradient)| {
                arch.dispatch(Evaluate { patch, positions, masses, gravity, gradient, scratch })
            })
            .collect();
        let mut terms = Terms {
            membrane: sums.iter().map(|s| s.membrane).sum(),
            bending: sums.iter().map(|s| s.bending).sum(),
            sewing: 0.0,
            gravity: sums.iter().map(|s| s.gravity).sum(),
        };
        // Few or none: stitches of the open coarsest level, and what is held.
        terms.sewing = self.stitches.evaluate(positions, gradient)
            + self.holds.iter().map(|hold| hold.evaluate(positions, gradient)).sum::<f64>()
            + self.walls.iter().map(|wall| wall.evaluate(positions, gradient)).sum::<f64>();
        terms
    }

    /// `dᵀ H d` at `positions` without what buckling would make negative, N·m per unit squared.
    pub fn curvature(&self, positions: &[Vector3], direction: &[Vector3]) -> f64 {
        let arch = self.arch;
        let elastic: Vec<f64> = self
            .patches
            .par_iter()
            .map_init(Scratch::default, |scratch, patch| {
                arch.dispatch(Curvature { patch, positions, direction, scratch })
            })
            .collect();
        let holds: f64 = self.holds.iter().map(|hold| hold.curvature(positions, direction)).sum();
        let walls: f64 = self.walls.iter().map(|wall| wall.curvature(positions, direction)).sum();
        elastic.iter().sum::<f64>() + self.stitches.curvature(direction) + holds + walls
    }
}

/// Half the trace of the stiffnesses in the plane, and what bending adds, N/m, one per particle.
fn elastic_diagonal(particle_count: usize, cloth: &Cloth) -> Vec<f64> {
    let mut diagonal = vec![0.0; particle_count];
    for form in cloth.forms {
        for (&p, c) in form.particles.iter().zip(form.coefficients) {
            diagonal[p as usize] += c * c;
        }
    }
    for triangle in cloth.triangles {
        for (p, d) in triangle.particles.iter().zip(triangle.diagonal()) {
            diagonal[*p as usize] += d;
        }
    }
    for spring in cloth.springs {
        for p in spring.particles {
            diagonal[p as usize] += spring.diagonal();
        }
    }
    diagonal
}

/// [`Patch::evaluate`], for the instructions that the processor has.
struct Evaluate<'a> {
    patch: &'a Patch,
    positions: &'a [Vector3],
    masses: &'a [f64],
    gravity: f64,
    gradient: &'a mut [Vector3],
    scratch: &'a mut Scratch,
}

impl NullaryFnOnce for Evaluate<'_> {
    type Output = PatchTerms;

    #[inline(always)]
    fn call(self) -> PatchTerms {
        self.patch.evaluate(self.positions, self.masses, self.gravity, self.gradient, self.scratch)
    }
}

/// [`Patch::curvature`], for the instructions that the processor has.
struct Curvature<'a> {
    patch: &'a Patch,
    positions: &'a [Vector3],
    direction: &'a [Vector3],
    scratch: &'a mut Scratch,
}

impl NullaryFnOnce for Curvature<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        self.patch.curvature(self.positions, self.direction, self.scratch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::geometry::Vector2;
    use crate::pattern::{Directional, Fabric, Pattern, shapes};

    const MODELS: [Model; 4] = [
        Model { membrane: Membrane::Coupled, bending: Bending::Quadratic },
        Model { membrane: Membrane::Coupled, bending: Bending::Springs },
        Model { membrane: Membrane::Springs, bending: Bending::Quadratic },
        Model { membrane: Membrane::Springs, bending: Bending::Springs },
    ];

    fn sewn(pattern: &Pattern, resolution: f64) -> Level {
        Garment::build(pattern, &[resolution]).unwrap().levels.remove(0)
    }

    /// The particles where `map` puts their points; sewn points must come to one place.
    fn lifted(level: &Level, map: impl Fn(Vector2) -> Vector3) -> Vec<Vector3> {
        let mut positions = vec![Vector3::zeros(); level.particle_count];
        for (rest, &p) in level.rest.iter().zip(&level.particle_of) {
            positions[p as usize] = map(*rest);
        }
        positions
    }

    /// Small moves that follow no pattern and are the same every time.
    fn noise(count: usize, size: f64) -> Vec<Vector3> {
        let wave = |k: usize, step: f64| (k as f64 * step + 1.0).sin() * size;
        (0..count).map(|k| Vector3::new(wave(k, 12.9898), wave(k, 78.233), wave(k, 37.719))).collect()
    }

    fn moved(positions: &[Vector3], along: &[Vector3], by: f64) -> Vec<Vector3> {
        positions.iter().zip(along).map(|(p, d)| p + d * by).collect()
    }

    fn on_cylinder(p: Vector2, radius: f64) -> Vector3 {
        let (sin, cos) = (p.x / radius).sin_cos();
        Vector3::new(radius * sin, p.y, radius * cos)
    }

    /// Two sewn rectangles, a tube with its seam still open and being drawn shut, and a rumpled tube
    /// that is held up: every term is at work in one of them.
    fn scenes(model: Model) -> Vec<(&'static str, Energy, Vec<Vector3>)> {
        let fabric = Fabric {
            stretch: Directional { warp: 500.0, weft: 250.0 },
            shear: 30.0,
            bending: Directional { warp: 2e-5, weft: 1e-5 },
            ..Fabric::default()
        };
        let pair = sewn(&shapes::two_rectangles(0.2, 0.2), 0.05);
        let right = pair.panels[1].points.start;
        let flat: Vec<Vector3> = (0..pair.rest.len())
            .map(|k| Vector3::new(pair.rest[k].x + if k < right { 0.0 } else { 0.2 }, pair.rest[k].y, 0.0))
            .collect();
        let mut at = vec![Vector3::zeros(); pair.particle_count];
        pair.particle_of.iter().zip(flat).for_each(|(&p, x)| at[p as usize] = x);
        let pair_at = moved(&at, &noise(at.len(), 0.004), 1.0);

        let open = Garment::build(&shapes::tube(0.3, 0.1), &[0.05]).unwrap().open;
        let mut closing = Energy::new(&open, &fabric, model);
        closing.stitches.stiffness = 50.0;
        closing.stitches.lengths = (0..open.stitches.len()).map(|k| 0.005 * k as f64).collect();
        let open_at = lifted(&open, |p| on_cylinder(p, 0.06));

        let tube = sewn(&shapes::tube(0.3, 0.1), 0.05);
        let tube_at = moved(
            &lifted(&tube, |p| on_cylinder(p, 0.3 / std::f64::consts::TAU)),
            &noise(tube.particle_count, 0.005),
            1.0,
        );
        let mut hung = Energy::new(&tube, &fabric, model);
        hung.holds = vec![Hold { particles: vec![0, 3, 4], height: 0.2, stiffness: 80.0 }];
        vec![
            ("pair", Energy::new(&pair, &fabric, model), pair_at),
            ("open tube", closing, open_at),
            ("tube", hung, tube_at),
        ]
    }

    #[test]
    fn the_gradient_is_the_derivative_of_every_model() {
        for model in MODELS {
            for (name, mut energy, positions) in scenes(model) {
                let mut gradient = vec![Vector3::repeat(f64::NAN); positions.len()];
                let terms = energy.evaluate(&positions, &mut gradient);
                assert!(terms.membrane > 0.0 && terms.bending > 0.0, "{name}: {terms:?}");
                assert!(terms.sewing > 0.0 || name == "pair", "{name}: {terms:?}");
                let scale = gradient.iter().map(|g| g.norm()).fold(0.0, f64::max);
                let mut ignored = gradient.clone();
                let step = 1e-7;
                for p in 0..positions.len() {
                    for axis in 0..3 {
                        let mut value = |by: f64| {
                            let mut at = positions.clone();
                            at[p][axis] += by;
                            energy.evaluate(&at, &mut ignored).total()
                        };
                        let slope = (value(step) - value(-step)) / (2.0 * step);
                        let error = (slope - gradient[p][axis]).abs();
                        assert!(error < 1e-5 * scale, "{model:?}, {name}: {slope} is not {}", gradient[p][axis]);
                    }
                }
            }
        }
    }

    #[test]
    fn the_curvature_is_the_second_derivative_where_nothing_is_compressed() {
        for model in MODELS {
            for (name, mut energy, positions) in scenes(model) {
                // Spread out, all springs pull and nothing negative is left out.
                let middle = positions.iter().sum::<Vector3>() / positions.len() as f64;
                let positions: Vec<Vector3> = positions.iter().map(|p| middle + (p - middle) * 1.8).collect();
                let direction = noise(positions.len(), 1.0);
                let mut gradient = vec![Vector3::zeros(); positions.len()];
                let mut slope = |by: f64| {
                    energy.evaluate(&moved(&positions, &direction, by), &mut gradient);
                    crate::minimize::dot(&gradient, &direction)
                };
                let step = 1e-6;
                let second = (slope(step) - slope(-step)) / (2.0 * step);
                let ours = energy.curvature(&positions, &direction);
                // Coupled springs may push although their triangle is stretched; stitches bound theirs.
                let exact = model.membrane == Membrane::Springs && name != "open tube";
                assert!(ours > (1.0 - 1e-6) * second, "{model:?}, {name}: {ours} is below {second}");
                assert!(!exact || ours < (1.0 + 1e-6) * second, "{model:?}, {name}: {ours} is above {second}");
            }
        }
    }

    /// Energy, gradient and curvature, triangle by triangle and hinge by hinge.
    fn plainly(
        level: &Level,
        fabric: &Fabric,
        model: Model,
        x: &[Vector3],
        d: &[Vector3],
    ) -> (Terms, Vec<Vector3>, f64) {
        let (mut terms, mut gradient, mut curvature) = (Terms::default(), vec![Vector3::zeros(); x.len()], 0.0);
        for t in membrane::triangles(level, fabric.into(), model.membrane) {
            let (energy, pulls) = t.evaluate(t.particles.map(|p| x[p as usize]));
            terms.membrane += energy;
            t.particles.iter().zip(pulls).for_each(|(&p, pull)| gradient[p as usize] += pull);
            curvature += t.curvature(t.particles.map(|p| x[p as usize]), t.particles.map(|p| d[p as usize]));
        }
        for hinge in &level.hinges {
            if model.bending == Bending::Quadratic {
                let form = hinge_form(level, hinge, fabric);
                let bent = |v: &[Vector3]| -> Vector3 {
                    form.particles.iter().zip(form.coefficients).map(|(&p, c)| v[p as usize] * c).sum()
                };
                terms.bending += 0.5 * bent(x).norm_squared();
                form.particles.iter().zip(form.coefficients).for_each(|(&p, c)| gradient[p as usize] += bent(x) * c);
                curvature += bent(d).norm_squared();
            } else {
                let spring = CrossSpring::of(level, hinge, fabric);
                let [a, b] = spring.particles.map(|p| p as usize);
                let (energy, pull) = spring.evaluate([x[a], x[b]]);
                terms.bending += energy;
                gradient[a] -= pull;
                gradient[b] += pull;
                curvature += spring.curvature([x[a], x[b]], [d[a], d[b]]);
            }
        }
        (terms, gradient, curvature)
    }

    #[test]
    fn patches_of_blocks_compute_what_single_triangles_and_hinges_do() {
        let level = sewn(&shapes::tube(0.6, 0.4), 0.009);
        assert!(level.particle_count > 2 * PATCH, "{} particles fill too few patches", level.particle_count);
        let fabric = Fabric::default();
        let rolled = lifted(&level, |p| on_cylinder(p, 0.6 / std::f64::consts::TAU));
        let mut positions = moved(&rolled, &noise(rolled.len(), 0.002), 1.0);
        // A collapsed edge, which has no direction.
        let [a, b, _] = level.particles(0).map(|p| p as usize);
        positions[a] = positions[b];
        let direction = noise(positions.len(), 1.0);
        for model in MODELS {
            let mut energy = Energy::new(&level, &fabric, model);
            energy.gravity = 0.0;
            let mut gradient = vec![Vector3::repeat(f64::NAN); positions.len()];
            let terms = energy.evaluate(&positions, &mut gradient);
            let curvature = energy.curvature(&positions, &direction);
            let (plain, plain_gradient, plain_curvature) = plainly(&level, &fabric, model, &positions, &direction);
            let close = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs();
            assert!(
                close(terms.membrane, plain.membrane) && close(terms.bending, plain.bending),
                "{terms:?}, {plain:?}"
            );
            assert!(close(curvature, plain_curvature), "{model:?}: {curvature} is not {plain_curvature}");
            let scale = plain_gradient.iter().map(|g| g.norm()).fold(0.0, f64::max);
            for (p, (ours, plain)) in gradient.iter().zip(&plain_gradient).enumerate() {
                assert!((ours - plain).norm() < 1e-10 * scale, "{model:?}, particle {p}: {ours} is not {plain}");
            }
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bytes() {
        for model in MODELS {
            for (name, mut energy, positions) in scenes(model) {
                let direction = noise(positions.len(), 1.0);
                let mut run = |arch| {
                    energy.arch = arch;
                    let mut gradient = vec![Vector3::zeros(); positions.len()];
                    let terms = energy.evaluate(&positions, &mut gradient);
                    (terms, gradient, energy.curvature(&positions, &direction))
                };
                assert!(run(Arch::new()) == run(Arch::Scalar), "{model:?}, {name}");
            }
        }
    }

    #[test]
    fn moving_a_garment_rigidly_changes_no_elastic_energy() {
        let turn = nalgebra::Rotation3::from_euler_angles(0.7, -1.2, 2.9);
        for model in MODELS {
            for (name, mut energy, positions) in scenes(model) {
                let mut gradient = vec![Vector3::zeros(); positions.len()];
                let before = energy.evaluate(&positions, &mut gradient);
                let moved: Vec<Vector3> = positions.iter().map(|p| turn * p + Vector3::new(0.3, 1.1, -0.4)).collect();
                let after = energy.evaluate(&moved, &mut gradient);
                for (a, b) in [(before.membrane, after.membrane), (before.bending, after.bending)] {
                    assert!((a - b).abs() < 1e-10 * a, "{model:?}, {name}: {a} became {b}");
                }
            }
        }
    }

    #[test]
    fn stretched_cloth_costs_the_same_at_every_resolution() {
        // A uniaxial strain of 2 % along the warp: A/2 times the fabric's figure times its square.
        let fabric = Fabric::default();
        let garment =
            Garment::build(&shapes::cloth(shapes::rectangle("cloth", 0.5, 0.4)), &[0.06, 0.025, 0.011]).unwrap();
        let expected = 0.5 * 0.2 * fabric.membrane_matrix()[(1, 1)] * 0.02f64.powi(2);
        for level in &garment.levels {
            let mut energy = Energy::new(level, &fabric, Model::default());
            let positions = lifted(level, |p| Vector3::new(p.x, 1.02 * p.y, 0.0));
            let terms = energy.evaluate(&positions, &mut vec![Vector3::zeros(); positions.len()]);
            // Engineering strain and strain along slanted edges agree to first order.
            assert!((terms.membrane / expected - 1.0).abs() < 0.02, "{} of {expected} J", terms.membrane);
            assert!(terms.bending < 1e-12);
        }
    }

    #[test]
    fn gravity_is_weight_times_height() {
        let fabric = Fabric::default();
        let level = sewn(&shapes::two_rectangles(0.2, 0.3), 0.04);
        let mut energy = Energy::new(&level, &fabric, Model::default());
        let weight = 0.12 * fabric.areal_density * GRAVITY;
        let mut gradient = vec![Vector3::zeros(); level.particle_count];
        let positions = lifted(&level, |p| Vector3::new(p.x, p.y, 0.0));
        let low = energy.evaluate(&positions, &mut gradient);
        let high = energy.evaluate(&moved(&positions, &vec![Vector3::y(); positions.len()], 1.5), &mut gradient);
        assert!((high.gravity - low.gravity - 1.5 * weight).abs() < 1e-9);
        let pull: Vector3 = gradient.iter().sum();
        assert!(
            (pull - Vector3::new(0.0, weight, 0.0)).norm() < 1e-9,
            "all that pulls a garment is its weight: {pull}"
        );
        assert!((energy.masses().iter().sum::<f64>() - 0.12 * fabric.areal_density).abs() < 1e-12);
    }

    /// Bending energy of a square rolled by `turned` onto a cylinder, over that of a plate, `½ B A / R²`.
    fn bending_ratio(bending: Bending, resolution: f64, turned: f64, radius: f64) -> f64 {
        let fabric = Fabric::default();
        let level = sewn(&shapes::cloth(shapes::rectangle("cloth", 0.3, 0.3)), resolution);
        let mut energy = Energy::new(&level, &fabric, Model { membrane: Membrane::Coupled, bending });
        let (sin, cos) = turned.sin_cos();
        let roll = |p: Vector2| on_cylinder(Vector2::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x), radius);
        let positions = lifted(&level, roll);
        let terms = energy.evaluate(&positions, &mut vec![Vector3::zeros(); positions.len()]);
        terms.bending / (0.5 * fabric.bending.warp * 0.09 / (radius * radius))
    }

    #[test]
    fn a_cylinder_costs_its_bending_rigidity_on_every_mesh() {
        for resolution in [0.02, 0.01, 0.005] {
            for turned in [0.0, 0.5, 1.0, std::f64::consts::FRAC_PI_2] {
                let ratio = bending_ratio(Bending::Quadratic, resolution, turned, 0.08);
                // Edges at the rim have no hinge: an error of the first order.
                assert!((ratio - 1.0).abs() < 5.0 * resolution, "{ratio} at {resolution} m, turned by {turned}");
            }
        }
    }

    #[test]
    fn springs_across_edges_cost_the_same_on_the_average_at_their_radius_and_next_to_nothing_beyond() {
        let mean = |radius: f64| {
            let angles = (0..8).map(|k| f64::from(k) * std::f64::consts::PI / 8.0);
            angles.map(|turned| bending_ratio(Bending::Springs, 0.006, turned, radius)).sum::<f64>() / 8.0
        };
        assert!((mean(0.02) - 1.0).abs() < 0.05, "{}", mean(0.02));
        assert!(mean(0.2) < 0.02, "their energy is of the fourth order");
    }
}
