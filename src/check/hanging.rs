//! At which height the panels will hang: patterns place skirts and waistbands below bodices with gaps between them, which the
//! seams close.

use crate::body::Landmarks;
use crate::garment::Garment;
use crate::geometry::Vector3;
use crate::pattern::Pattern;

/// Panels whose tops are within this of the highest hang from the same height, m.
const LEVEL: f64 = 0.03;
/// Rounds in which every panel goes to where its seams pull it; along a chain of four panels heights settle to a millimetre.
const ROUNDS: usize = 100;

/// How far each panel rises until its seams close, on average, m. Panels beside the armpits stay, which hang from the
/// shoulders; of a garment that ends below them its highest ones do.
pub fn rises(pattern: &Pattern, garment: &Garment, placed: &[Vector3], marks: &Landmarks) -> Vec<f64> {
    let extent = |panel: usize| {
        let points = &placed[garment.open.panels[panel].points.clone()];
        let low = points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        (low, points.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max))
    };
    let extents: Vec<(f64, f64)> = (0..pattern.panels.len()).map(extent).collect();
    let armpits = 0.5 * (marks.armpits[0].y + marks.armpits[1].y);
    let beside = |&(low, high): &(f64, f64)| low < armpits && high > armpits;
    let top = extents.iter().map(|e| e.1).fold(f64::NEG_INFINITY, f64::max);
    let stays: Vec<bool> = match extents.iter().any(beside) {
        true => extents.iter().map(beside).collect(),
        false => extents.iter().map(|e| e.1 > top - LEVEL).collect(),
    };
    // Per panel: the panels sewn to it, how much higher their sides of the seam start, and the length of the seam.
    let mut ties: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new(); pattern.panels.len()];
    for (seam, [a, b]) in pattern.seams.iter().zip(&garment.open.seams) {
        let [p, q] = seam.sides.map(|side| side.panel);
        if p == q {
            continue;
        }
        let higher = a.iter().zip(b).map(|(&a, &b)| placed[b as usize].y - placed[a as usize].y);
        let higher = higher.sum::<f64>() / a.len() as f64;
        let length = pattern.seam_lengths(seam)[0];
        ties[p].push((q, higher, length));
        ties[q].push((p, -higher, length));
    }
    let mut rises = vec![0.0; pattern.panels.len()];
    for _ in 0..ROUNDS {
        for panel in (0..rises.len()).filter(|&panel| !stays[panel] && !ties[panel].is_empty()) {
            let weight: f64 = ties[panel].iter().map(|tie| tie.2).sum();
            let pull: f64 = ties[panel].iter().map(|&(other, higher, length)| length * (higher + rises[other])).sum();
            rises[panel] = pull / weight;
        }
    }
    rises
}
