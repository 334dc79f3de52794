//! What of a drawing is the mirror image of what: garments are alike on both sides, and so are their seams.

use crate::geometry::Vector2;
use crate::pattern::sewing::Measured;
use crate::pattern::{Pattern, SegmentId};

/// Corners and middles this near to their images are these, m: drafts are rounded to a tenth of a millimetre and cut by hand.
const SAME: f64 = 1.5e-3;

/// Mirror images about the line that is upright in the drawing, as grainlines are.
pub struct Symmetry {
    /// Per panel: its mirror image; itself where it is symmetric; none where it has none.
    pub panels: Vec<Option<usize>>,
    /// Per panel and segment: the segment that is its mirror image, on the panel's image.
    segments: Vec<Vec<usize>>,
}

impl Symmetry {
    pub fn new(pattern: &Pattern, measured: &Measured) -> Self {
        let outlines: Vec<Outline> = (0..pattern.panels.len()).map(|k| Outline::new(pattern, measured, k)).collect();
        let mut made = Self { panels: vec![None; outlines.len()], segments: vec![Vec::new(); outlines.len()] };
        for a in 0..outlines.len() {
            for b in a + 1..outlines.len() {
                if made.panels[a].is_some() || made.panels[b].is_some() {
                    continue;
                }
                let images = (outlines[a].images_on(&outlines[b]), outlines[b].images_on(&outlines[a]));
                if let (Some(of_a), Some(of_b)) = images {
                    (made.panels[a], made.panels[b]) = (Some(b), Some(a));
                    (made.segments[a], made.segments[b]) = (of_a, of_b);
                }
            }
        }
        for (k, outline) in outlines.iter().enumerate() {
            if made.panels[k].is_none()
                && let Some(images) = outline.images_on(outline)
            {
                (made.panels[k], made.segments[k]) = (Some(k), images);
            }
        }
        made
    }

    /// The mirror image of a segment.
    pub fn image(&self, id: SegmentId) -> Option<SegmentId> {
        Some(SegmentId { panel: self.panels[id.panel]?, segment: self.segments[id.panel][id.segment] })
    }
}

/// A panel from the middle of its bounding box: start, middle and end of each segment, m.
struct Outline {
    points: Vec<[Vector2; 3]>,
}

impl Outline {
    fn new(pattern: &Pattern, measured: &Measured, panel: usize) -> Self {
        let at = |segment: usize| {
            let id = SegmentId { panel, segment };
            [0.0, 0.5, 1.0].map(|t| measured.point(id, t))
        };
        let mut points: Vec<[Vector2; 3]> = (0..pattern.panels[panel].segments.len()).map(at).collect();
        let all = || points.iter().flatten();
        let low = all().fold(Vector2::repeat(f64::INFINITY), |l, p| l.inf(p));
        let high = all().fold(Vector2::repeat(f64::NEG_INFINITY), |h, p| h.sup(p));
        let middle = (low + high) * 0.5;
        points.iter_mut().flatten().for_each(|p| *p -= middle);
        Self { points }
    }

    /// For each segment the one of the other outline that is its mirror image; none if one has none.
    fn images_on(&self, other: &Self) -> Option<Vec<usize>> {
        if self.points.len() != other.points.len() {
            return None;
        }
        let flipped = |p: &Vector2| Vector2::new(-p.x, p.y);
        let image = |[start, middle, end]: &[Vector2; 3]| {
            let wanted = [flipped(end), flipped(middle), flipped(start)];
            let is = |other: &[Vector2; 3]| other.iter().zip(&wanted).all(|(p, q)| (p - q).norm() < SAME);
            other.points.iter().position(is)
        };
        // What was drawn the other way round, or turned over, has start and end alike.
        let same_way = |[start, middle, end]: &[Vector2; 3]| {
            let wanted = [flipped(start), flipped(middle), flipped(end)];
            let is = |other: &[Vector2; 3]| other.iter().zip(&wanted).all(|(p, q)| (p - q).norm() < SAME);
            other.points.iter().position(is)
        };
        let all = |image: &dyn Fn(&[Vector2; 3]) -> Option<usize>| self.points.iter().map(image).collect();
        let images: Option<Vec<usize>> = all(&image);
        images.or_else(|| all(&same_way))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::shapes::two_rectangles;

    #[test]
    fn equal_panels_are_images_of_each_other_and_others_of_themselves() {
        let pattern = two_rectangles(0.2, 0.3);
        let symmetry = Symmetry::new(&pattern, &Measured::new(&pattern));
        let lone = Pattern { panels: vec![pattern.panels[0].clone()], seams: Vec::new(), ..pattern.clone() };
        assert_eq!(Symmetry::new(&lone, &Measured::new(&lone)).panels, [Some(0)]);
        for (panel, image) in symmetry.panels.iter().enumerate() {
            let Some(image) = *image else { continue };
            for segment in 0..pattern.panels[panel].segments.len() {
                let id = SegmentId { panel, segment };
                let there = symmetry.image(id).unwrap();
                assert_eq!((there.panel, symmetry.image(there).unwrap()), (image, id));
            }
        }
    }
}
