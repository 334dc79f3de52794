//! Several garments, worn one over the other.
//!
//! They are sewn in turn, on the coarsest level: the innermost around the body, each further one around the body with
//! all inner ones on it ([`Body::dressed`]), where the inner ones keep still. Where an inner one is too wide for an outer
//! one both then give way (`layering.rs`). What comes of that crosses nothing, and all are one garment of many
//! panels from there on: contact of the cloth with itself keeps the layers in their order.

use super::layering::bring_into_order;
use super::relaxing::{relax, relax_over};
use super::sewing::Sewn;
use super::waist_line::Waist;
use super::{Event, LevelSummary, Observer, Outcome, Scene, Settings, distance_field, sew, worn_heights};
use crate::arrangement::Arrangement;
use crate::assess::{Layers, assess_knowing, gather_allowance, tight_places};
use crate::body::{Body, DistanceField};
use crate::garment::{Garment, Level, patterns_together};
use crate::geometry::Vector3;
use crate::pattern::{Cut, Fabric, Pattern};

/// What is worn: patterns and what they are cut from, innermost first.
pub type Garments<'a> = [(&'a Pattern, &'a Fabric)];

/// Garments as they are worn together.
pub struct Outfit {
    /// Innermost first. The figures of their levels are those of all together, but for the counts of particles and
    /// triangles.
    pub garments: Vec<Outcome>,
    pub layers: Layers,
}

/// All garments as one.
pub(super) struct Together<'a> {
    pub pattern: Pattern,
    /// By panel.
    pub fabrics: Vec<&'a Fabric>,
    /// How the fabrics touch.
    pub touching: Fabric,
    pub garment: Garment,
}

impl<'a> Together<'a> {
    pub fn new(garments: &Garments<'a>, built: Vec<Garment>) -> Self {
        let by_panel = |&(pattern, fabric): &(&Pattern, &'a Fabric)| std::iter::repeat_n(fabric, pattern.panels.len());
        Self {
            pattern: patterns_together(&garments.iter().map(|(pattern, _)| *pattern).collect::<Vec<_>>()),
            fabrics: garments.iter().flat_map(by_panel).collect(),
            touching: Fabric::touching(&garments.iter().map(|(_, fabric)| *fabric).collect::<Vec<_>>()),
            garment: Garment::together(built),
        }
    }

    pub fn scene<'b>(
        &'b self,
        garments: usize,
        body: &'b Body,
        field: &'b DistanceField,
        settings: &'b Settings,
    ) -> Scene<'b> {
        Scene {
            pattern: &self.pattern,
            fabric: &self.touching,
            cut: Cut::ByPanel(&self.fabrics),
            garment: &self.garment,
            garments,
            body,
            field,
            settings,
        }
    }
}

/// Garments whose seams are closed.
pub(super) struct Clothes {
    /// Of the coarsest level of all together, m, world.
    pub positions: Vec<Vector3>,
    pub waists: Vec<Waist>,
    /// Of each garment: where its panels started, and how its seams closed.
    pub sewn: Vec<(Arrangement, Sewn)>,
}

/// Sews garments, one over the other.
pub(super) fn sew_in_turn(
    garments: &Garments,
    built: &[Garment],
    (body, field): (&Body, &DistanceField),
    settings: &Settings,
    disturb: &(dyn Fn(&mut [Vector3]) + Sync),
    observer: &mut dyn Observer,
) -> Clothes {
    let mut clothes = Clothes { positions: Vec::new(), waists: Vec::new(), sewn: Vec::new() };
    for (k, &(pattern, fabric)) in garments.iter().enumerate() {
        if garments.len() > 1 {
            observer.event(&Event::GarmentStarted { garment: k, garments: garments.len(), name: &pattern.name });
        }
        let own_settings =
            Settings { clearance: settings.clearance.max(over(&garments[..k], fabric)), ..settings.clone() };
        let dressed = (k > 0).then(|| {
            let dressed = dress(body, &built[..k], &clothes.positions);
            let field = distance_field(&dressed, own_settings.clearance, worn_heights([pattern]));
            (dressed, field)
        });
        let (on, around) = dressed.as_ref().map_or((body, field), |(dressed, field)| (dressed, field));
        let scene = Scene {
            pattern,
            fabric,
            cut: fabric.into(),
            garment: &built[k],
            garments: 1,
            body: on,
            field: around,
            settings: &own_settings,
        };
        let (arrangement, mut sewn) = sew(&scene, disturb, observer);
        let mut own = built[k].weld(&sewn.positions);
        let waist = Waist::of(pattern, &built[k], &arrangement);
        if k > 0 {
            sewn.evaluations += relax_over(&scene, &waist, &mut own);
        }
        let panels = garments[..k].iter().map(|(inner, _)| inner.panels.len()).sum();
        clothes.waists.extend(waist.map(|waist| waist.among(panels)));
        clothes.positions.extend(own);
        if k > 0 {
            let worn = (&garments[..=k], &built[..=k]);
            sewn.evaluations += bring_into_order(worn, (body, field), settings, 0, &mut clothes.positions);
        }
        if k + 1 < garments.len() {
            // The next one is to find them as they lie.
            let inner = Together::new(&garments[..=k], built[..=k].to_vec());
            let scene = inner.scene(k + 1, body, field, settings);
            sewn.evaluations += relax(&scene, 0, &clothes.waists, None, &mut clothes.positions, &mut ()).0.evaluations;
        }
        clothes.sewn.push((arrangement, sewn));
    }
    clothes
}

/// Distance that a fabric keeps from those of inner garments, m: half the thickness of both.
fn over(inner: &Garments, fabric: &Fabric) -> f64 {
    inner.iter().map(|(_, inner)| 0.5 * (inner.thickness + fabric.thickness)).fold(0.0, f64::max)
}

/// The body with the coarsest level of garments on it.
fn dress(body: &Body, garments: &[Garment], positions: &[Vector3]) -> Body {
    let mut rest = positions;
    let mut dressed: Option<Body> = None;
    for garment in garments {
        let level = &garment.levels[0];
        let (own, others) = rest.split_at(level.particle_count);
        dressed = Some(dressed.as_ref().unwrap_or(body).dressed(own, &level.particle_triangles()));
        rest = others;
    }
    dressed.expect("what is dressed wears something")
}

/// What all garments together came to.
pub(super) struct Relaxed {
    /// Of the finest level, m, world.
    pub positions: Vec<Vector3>,
    pub levels: Vec<LevelSummary>,
    /// No cloth crosses cloth, as far as that is known.
    pub uncrossed: bool,
}

/// Each garment's own part of what was done for all together.
pub(super) fn take_apart(
    garments: &Garments,
    built: Vec<Garment>,
    sewn: Vec<(Arrangement, Sewn)>,
    relaxed: &Relaxed,
    body: &Body,
    settings: &Settings,
) -> Outfit {
    let Relaxed { positions, levels, uncrossed } = relaxed;
    let finest = levels.len() - 1;
    let layers = layers(garments, &built, positions);
    let mut rest = &positions[..];
    let mut outcomes = Vec::new();
    for ((&(pattern, fabric), garment), (arrangement, sewn)) in garments.iter().zip(built).zip(sewn) {
        let level = &garment.levels[finest];
        let (own, others) = rest.split_at(level.particle_count);
        let counted = |(summary, level): (&LevelSummary, &Level)| LevelSummary {
            particles: level.particle_count,
            triangles: level.triangles.len(),
            ..summary.clone()
        };
        let (tight, assessment) = rayon::join(
            || tight_places(level, own, &gather_allowance(pattern, level), fabric.stretch_limit),
            || assess_knowing(pattern, level, own, body, settings.clearance, *uncrossed),
        );
        outcomes.push(Outcome {
            positions: own.to_vec(),
            shifts: arrangement.shifts,
            sewing_evaluations: sewn.evaluations,
            welded_gap: sewn.largest_gap,
            levels: levels.iter().zip(&garment.levels).map(counted).collect(),
            tight,
            assessment,
            garment,
        });
        rest = others;
    }
    Outfit { garments: outcomes, layers }
}

fn layers(garments: &Garments, built: &[Garment], positions: &[Vector3]) -> Layers {
    if garments.len() == 1 {
        return Layers::default();
    }
    let thickest = garments.iter().map(|(_, fabric)| fabric.thickness).fold(0.0, f64::max);
    let finest: Vec<&Level> = built.iter().filter_map(|garment| garment.levels.last()).collect();
    let garment_of: Vec<u32> =
        (0..).zip(&finest).flat_map(|(k, level)| std::iter::repeat_n(k, level.triangles.len())).collect();
    Layers::of(&Level::together(&finest).particle_triangles(), &garment_of, positions, 2.0 * thickest)
}
