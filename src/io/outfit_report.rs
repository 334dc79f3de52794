//! `outfit.json`: garments that are worn one over the other.

use crate::prepositioning::Outfit;
use serde::Serialize;

/// A garment of an outfit.
#[derive(Clone, Debug, Serialize)]
pub struct OutfitGarment<'a> {
    /// Of its pattern.
    pub name: &'a str,
    /// Where its results are, within the outfit's folder.
    pub folder: String,
}

/// The report, field by field as in the file.
#[derive(Clone, Debug, Serialize)]
pub struct OutfitReport<'a> {
    pub format: &'static str,
    pub version: u32,
    pub toile_version: &'static str,
    /// Innermost first.
    pub garments: &'a [OutfitGarment<'a>],
    /// Pairs of triangles of two garments that cross.
    pub crossings: Vec<CrossingPart<'a>>,
    /// The least distance between two garments; `null` where none are near.
    pub least_distance_m: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
pub struct CrossingPart<'a> {
    pub inner: &'a str,
    pub outer: &'a str,
    pub pairs: usize,
}

pub fn outfit_report<'a>(garments: &'a [OutfitGarment<'a>], outfit: &Outfit) -> OutfitReport<'a> {
    let named = |k: u32| garments[k as usize].folder.as_str();
    let crossings = outfit.layers.crossing.iter();
    OutfitReport {
        format: "toile outfit",
        version: 1,
        toile_version: env!("CARGO_PKG_VERSION"),
        garments,
        crossings: crossings
            .map(|(&[inner, outer], &pairs)| CrossingPart { inner: named(inner), outer: named(outer), pairs })
            .collect(),
        least_distance_m: outfit.layers.least_distance,
    }
}
