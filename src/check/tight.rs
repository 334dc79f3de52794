//! Is the garment smaller than the body somewhere?
//!
//! The sewn garment is cut at even distances along torso, legs and arms; closed rings around them are compared with the girth
//! of a taut tape there. Cloth may come to lie a little higher or lower than it was placed: it is compared with the least
//! girth near by. Rings that do not go around one limb alone (a skirt below the crotch) are not judged.

use super::rings::{Ring, rings};
use super::{Finding, Given, Sewn, listed};
use crate::Code;
use crate::body::{Landmarks, Limb};
use crate::geometry::Vector3;
use std::f64::consts::TAU;

/// Distance of the rings, m.
const SPACING: f64 = 0.02;
/// How far the garment may come to lie below and above where it was placed, in spacings: patterns are placed too low rather than
/// too high, and what is tight rides up.
const SLIDES: std::ops::RangeInclusive<isize> = -2..=5;
/// How much farther the lower end of what is loose above it rides up, in spacings: the rib of a hoodie, placed at the hips, goes to
/// the waist, and the cloth above it folds over.
const BLOUSES: isize = 5;
/// Cloth folds over where it is longer than the tape by this factor.
const LOOSE: f64 = 1.1;
/// A height is called by a landmark that is so near, m.
const NEAR: f64 = 0.05;

/// Where a limb is cut.
struct Station {
    /// Value of the ring: a height, or a length along the limb, m.
    at: f64,
    center: Vector3,
    axis: Vector3,
    /// Of a taut tape, m.
    girth: f64,
}

/// A limb with the places at which it is cut, upwards.
struct Zone {
    name: &'static str,
    /// Per particle.
    values: Vec<f64>,
    stations: Vec<Station>,
    /// Rings that go around these as well are of a skirt.
    apart_from: Vec<Limb>,
}

/// A ring, and where it comes to lie.
struct Fitted<'a> {
    ring: &'a Ring,
    station: &'a Station,
}

impl Fitted<'_> {
    /// How many times as long as the ring the tape is.
    fn ratio(&self) -> f64 {
        self.station.girth / self.ring.length
    }
}

pub fn findings(given: &Given, sewn: &Sewn, marks: &Landmarks) -> Vec<Finding> {
    // Heights are known to some centimetres only: what the fabric can make up for is not told.
    let bears = 1.0 + given.fabric.stretch_limit;
    let mut findings = Vec::new();
    for zone in zones(sewn, marks) {
        let around: Vec<Option<Ring>> = zone.stations.iter().map(|station| ring_around(sewn, &zone, station)).collect();
        let fitted = |slide: isize| -> Vec<(usize, Fitted)> {
            let rings = around.iter().enumerate().filter_map(|(k, ring)| Some((k, ring.as_ref()?)));
            let last = zone.stations.len() as isize - 1;
            let at = |k: usize| &zone.stations[(k as isize + slide).clamp(0, last) as usize];
            rings.map(|(k, ring)| (k, Fitted { ring, station: at(k) })).collect()
        };
        let worst = |slide: isize| fitted(slide).iter().map(|(_, fitted)| fitted.ratio()).fold(0.0, f64::max);
        // Of equal ones the least slide.
        let slides = SLIDES.map(|slide| (worst(slide).max(bears), slide.abs(), slide));
        let best = slides.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let slide = best.map_or(0, |best| best.2);
        let too_small = fitted(slide).into_iter().filter(|(_, fitted)| fitted.ratio() > bears);
        // One finding for each stretch of the limb, at its tightest place.
        let too_small: Vec<(usize, Fitted)> = too_small.collect();
        let lowest = around.iter().position(Option::is_some);
        for stretch in too_small.chunk_by(|a, b| b.0 <= a.0 + 2) {
            let (first, last) = (stretch[0].0, stretch[stretch.len() - 1].0);
            // What the zone cuts off below may go on there.
            let is_end = first > 0 && Some(first) == lowest;
            if is_end && (1..=BLOUSES).any(|rise| rides_up(&fitted, first..=last, slide, rise, bears)) {
                continue;
            }
            let tightest = stretch.iter().max_by(|a, b| a.1.ratio().total_cmp(&b.1.ratio()));
            findings.extend(tightest.map(|(_, tightest)| told(given, &zone, tightest, marks)));
        }
    }
    findings
}

/// Do these rings fit where they are when they have gone up by `rise` more than all do, and folds the cloth above them over? It has to
/// be loose for twice that height, as it lies double.
fn rides_up<'a>(
    fitted: &impl Fn(isize) -> Vec<(usize, Fitted<'a>)>,
    rings: std::ops::RangeInclusive<usize>,
    slide: isize,
    rise: isize,
    bears: f64,
) -> bool {
    let around = fitted(slide);
    let is_ring = |k: usize| around.iter().any(|(other, _)| *other == k);
    let is_loose = |k: usize| around.iter().any(|(other, fitted)| *other == k && fitted.ratio() * LOOSE <= 1.0);
    // What is not loose above them goes up with them.
    let mut last = *rings.end();
    while is_ring(last + 1) && !is_loose(last + 1) {
        last += 1;
    }
    let rings = *rings.start()..=last;
    let fit = fitted(slide + rise).iter().filter(|(k, _)| rings.contains(k)).all(|(_, fitted)| fitted.ratio() <= bears);
    fit && (last + 1..=last + 2 * rise as usize).all(is_loose)
}

fn told(given: &Given, zone: &Zone, Fitted { ring, station }: &Fitted, marks: &Landmarks) -> Finding {
    let girth = station.girth;
    let height = station.center.y - marks.floor;
    let short = girth - ring.length;
    let share = girth / ring.length - 1.0;
    let known =
        marks.heights().into_iter().filter(|(name, _)| zone.name == "torso" && !["neck", "crotch"].contains(name));
    let nearest = known
        .map(|(name, y)| ((y - station.center.y).abs(), name))
        .filter(|(distance, _)| *distance < NEAR)
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let name = nearest.map_or(zone.name, |(_, name)| name);
    let panels = listed(ring.panels.iter().map(|&p| given.pattern.panels[p as usize].name.as_str()));
    Finding::new(
        Code::SmallerThanBody,
        format!(
            "Around the {name}, {height:.2} m above the floor, it measures {:.1} cm and the body {:.1} cm: {:.1} cm too little, {:.1} % ({panels}).",
            100.0 * ring.length,
            100.0 * girth,
            100.0 * short,
            100.0 * share
        ),
        format!(
            "Take a larger size or let out its seams by {:.1} cm in all, or a fabric that stretches: {} bears {:.1} %.",
            100.0 * short,
            given.fabric.name,
            100.0 * given.fabric.stretch_limit
        ),
    )
    .within(name)
    .measured("height_m", height)
    .measured("garment_m", ring.length)
    .measured("body_m", girth)
    .measured("shortfall_m", short)
}

/// The smallest ring around a limb, and nothing else, at a place.
fn ring_around(sewn: &Sewn, zone: &Zone, station: &Station) -> Option<Ring> {
    let alone = |ring: &Ring| {
        let around =
            |other: &Limb| level_of(other, station.center.y).is_some_and(|(p, _)| ring.encloses(p, station.axis));
        ring.encloses(station.center, station.axis) && !zone.apart_from.iter().any(around)
    };
    let around = rings(sewn, &zone.values, station.at).into_iter().filter(alone);
    around.min_by(|a, b| a.length.total_cmp(&b.length))
}

fn zones(sewn: &Sewn, marks: &Landmarks) -> Vec<Zone> {
    let heights: Vec<f64> = sewn.positions.iter().map(|p| p.y).collect();
    let upright = |limb: &Limb, low: f64, high: f64| -> Vec<Station> {
        let count = ((high - low) / SPACING).max(0.0) as usize;
        let station = |k: usize| {
            let at = low + SPACING * k as f64;
            let (center, girth) = level_of(limb, at)?;
            Some(Station { at, center, axis: Vector3::y(), girth })
        };
        (0..=count).filter_map(station).collect()
    };
    let under_the_arms = marks.armpits[0].y.min(marks.armpits[1].y) - SPACING;
    let mut zones = vec![Zone {
        name: "torso",
        values: heights.clone(),
        stations: upright(&marks.torso, marks.crotch.y + SPACING, under_the_arms),
        apart_from: Vec::new(),
    }];
    for (side, name) in ["left leg", "right leg"].into_iter().enumerate() {
        zones.push(Zone {
            name,
            values: heights.clone(),
            stations: upright(&marks.legs[side], marks.ankles[side].y, marks.crotch.y - 2.0 * SPACING),
            apart_from: vec![marks.legs[1 - side].clone()],
        });
    }
    for (side, name) in ["left arm", "right arm"].into_iter().enumerate() {
        let arm = &marks.arms[side];
        // Where the arm is free of the torso.
        let from = arm.length_of(marks.armpits[side]) + 2.0 * SPACING;
        let count = ((arm.length() - from) / SPACING).max(0.0) as usize;
        let station = |k: usize| {
            let at = from + SPACING * k as f64;
            let (center, axis, radius) = arm.at(at);
            Station { at, center, axis, girth: TAU * radius }
        };
        zones.push(Zone {
            name,
            values: sewn.positions.iter().map(|&p| arm.length_of(p)).collect(),
            stations: (0..=count).rev().map(station).collect(),
            apart_from: vec![marks.torso.clone()],
        });
    }
    zones
}

/// The middle of a limb at a height, and its girth there, m; none beyond its ends.
pub fn level_of(limb: &Limb, height: f64) -> Option<(Vector3, f64)> {
    let step = limb.axis.windows(2).position(|w| (w[0].y - height) * (w[1].y - height) <= 0.0)?;
    let [from, to] = [limb.axis[step], limb.axis[step + 1]];
    let rise = to.y - from.y;
    let share = if rise == 0.0 { 0.0 } else { (height - from.y) / rise };
    let radius = limb.radii[step] + share * (limb.radii[step + 1] - limb.radii[step]);
    Some((from.lerp(&to, share), TAU * radius))
}
