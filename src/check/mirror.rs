//! Forgotten seams: an edge that is free on the one side of the garment and sewn on the other.

use super::Finding;
use crate::Code;
use crate::pattern::sewing::Measured;
use crate::pattern::{Pattern, SegmentId};
use std::collections::BTreeSet;

/// Edges of mirror images differ in length by no more than this, m: programs round to tenths of a millimetre.
const SAME_LENGTH: f64 = 5e-4;
/// A panel of fewer edges is its own mirror image.
const LEAST_EDGES: usize = 4;

/// Free edges whose partner on a panel that is the mirror image is sewn.
pub fn unsewn(pattern: &Pattern, measured: &Measured) -> Vec<Finding> {
    let sewn: BTreeSet<SegmentId> = pattern.seams.iter().flat_map(|seam| seam.sides).collect();
    let mut findings = Vec::new();
    let count = pattern.panels.len();
    let images: Vec<Vec<usize>> = (0..count).map(|p| images_of(pattern, measured, p)).collect();
    for (panel, of) in images.iter().enumerate() {
        // One image, and one that knows of no other: of four equal panels nobody can tell which belong together.
        let [image] = of[..] else { continue };
        if images[image] != [panel] {
            continue;
        }
        let Some(partner) = partners(pattern, measured, panel, image) else { continue };
        for (segment, &of) in partner.iter().enumerate() {
            let (own, other) = (SegmentId { panel, segment }, SegmentId { panel: image, segment: of });
            if !sewn.contains(&own) && sewn.contains(&other) {
                let finding = Finding::new(
                    Code::MirrorUnsewn,
                    format!(
                        "It is sewn to nothing, but edge {of} of panel \"{}\", its mirror image, is sewn.",
                        pattern.panels[image].name
                    ),
                    "Add the seam if it was forgotten; leave it if the garment is open on one side.",
                );
                let place = format!("panel \"{}\"", pattern.panels[panel].name);
                findings.push(finding.within(format!("edge {segment}")).within(place));
            }
        }
    }
    findings
}

/// Panels that are mirror images of one that has no symmetry of its own.
fn images_of(pattern: &Pattern, measured: &Measured, panel: usize) -> Vec<usize> {
    let count = pattern.panels[panel].segments.len();
    if count < LEAST_EDGES || partners(pattern, measured, panel, panel).is_some() {
        return Vec::new();
    }
    let others = (0..pattern.panels.len()).filter(|&other| other != panel);
    others.filter(|&other| partners(pattern, measured, panel, other).is_some()).collect()
}

/// For each edge of a panel the one of its mirror image, if the other is that: the same lengths around the outline, in the
/// other direction where both outlines run the same way, from one start only, and the same area.
fn partners(pattern: &Pattern, measured: &Measured, panel: usize, image: usize) -> Option<Vec<usize>> {
    let (a, b) = (&measured.length[panel], &measured.length[image]);
    let areas = [panel, image].map(|p| pattern.panels[p].signed_area());
    let n = a.len();
    if n != b.len() || (areas[0].abs() - areas[1].abs()).abs() > 0.01 * areas[0].abs() {
        return None;
    }
    let same_way = areas[0].signum() == areas[1].signum();
    let of = |start: usize, k: usize| if same_way { (start + n - k) % n } else { (start + k) % n };
    let fits = |start: &usize| (0..n).all(|k| (a[k] - b[of(*start, k)]).abs() < SAME_LENGTH);
    let mut starts = (0..n).filter(fits);
    let start = starts.next()?;
    // A panel is compared with itself to see whether it is symmetric: any start tells.
    if panel != image && starts.next().is_some() {
        return None;
    }
    Some((0..n).map(|k| of(start, k)).collect())
}
