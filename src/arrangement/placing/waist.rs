//! What hangs from the waist: how high, and by which edges.

use super::facing::Draft;
use super::figure::Figure;
use super::names::{Hints, Zone};
use super::rims::Opening;
use super::surface::Surface;
use crate::pattern::{Pattern, SegmentId, SegmentLabel};

/// Is it a top that is held by its upper edge?
pub fn is_strapless(pattern: &Pattern, hints: &[Hints], panels: &[usize], draft: &Draft) -> bool {
    panels.iter().any(|&p| {
        let labeled = pattern.panels[p].segments.iter().any(|s| s.label == Some(SegmentLabel::StraplessTop));
        labeled || (hints[p].zone == Some(Zone::Torso) && draft.is_tube)
    })
}

/// How high a waist line is worn, m: where the torso is as wide, but not so low that the crotch would hang; then at the waist.
pub fn height(surface: &Surface, figure: &Figure, draft: &Draft, rim: usize) -> f64 {
    let as_wide = figure.waist_for(surface.rims[rim].length);
    let leg = |side: usize| draft.openings.iter().find(|(_, o)| *o == Opening::Leg(side)).map(|(rim, _)| *rim);
    let (Some(left), Some(right)) = (leg(0), leg(1)) else { return as_wide };
    let way = |from: usize, to: usize| {
        let distances = surface.distances(surface.rims[from].indices());
        surface.rims[to].indices().map(|p| distances[p as usize]).fold(f64::INFINITY, f64::min)
    };
    // The shortest way from hem to hem leads through the crotch.
    let rise = 0.5 * (way(rim, left) + way(rim, right) - way(left, right));
    as_wide.max((figure.marks.crotch.y + rise).min(figure.marks.waist))
}

/// The upper edge of what hangs from the waist is the line that holds it up, if the pattern names none: drawings do not.
pub fn label(pattern: &mut Pattern, surface: &Surface, panels: &[usize], draft: &Draft) {
    let Some(&(rim, _)) = draft.openings.iter().find(|(_, opening)| *opening == Opening::Top) else { return };
    let hints: Vec<Hints> = pattern.panels.iter().map(Hints::of).collect();
    let held = |label| matches!(label, Some(SegmentLabel::LowerInterface | SegmentLabel::StraplessTop));
    if is_strapless(pattern, &hints, panels, draft)
        || panels.iter().any(|&p| pattern.panels[p].segments.iter().any(|s| held(s.label)))
    {
        return;
    }
    let mut on_rim = vec![false; surface.level.particle_count];
    surface.rims[rim].indices().for_each(|p| on_rim[p as usize] = true);
    let mut sewn: Vec<_> = pattern.seams.iter().flat_map(|seam| seam.sides).collect();
    sewn.sort_unstable();
    for &panel in panels {
        for (segment, points) in surface.level.segments[panel].iter().enumerate() {
            let is_open = sewn.binary_search(&SegmentId { panel, segment }).is_err();
            if is_open && points.iter().all(|&p| on_rim[surface.level.particle_of[p as usize] as usize]) {
                pattern.panels[panel].segments[segment].label.get_or_insert(SegmentLabel::LowerInterface);
            }
        }
    }
}
