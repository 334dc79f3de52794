//! Several garments as one, for when they are worn together.

use super::correspondence::Location;
use super::level::{Eased, Hinge, Level, PanelRange};
use super::{Correspondence, Garment};
use crate::pattern::{Pattern, Seam, SegmentId};

impl Garment {
    /// Garments of the same resolutions side by side, level by level.
    pub fn together(garments: Vec<Garment>) -> Garment {
        if garments.len() == 1 {
            return garments.into_iter().next().expect("there is one");
        }
        let levels = |k: usize| garments.iter().map(move |garment| &garment.levels[k]).collect::<Vec<_>>();
        let onto = |k: usize| {
            let mut first = 0;
            let mut locations = Vec::new();
            for garment in &garments {
                let shifted = |at: &Location| Location { triangle: at.triangle + first, ..*at };
                locations.extend(garment.correspondences[k].locations.iter().map(shifted));
                first += garment.levels[k].triangles.len() as u32;
            }
            Correspondence { locations }
        };
        Garment {
            open: Level::together(&garments.iter().map(|garment| &garment.open).collect::<Vec<_>>()),
            levels: (0..garments[0].levels.len()).map(|k| Level::together(&levels(k))).collect(),
            correspondences: (0..garments[0].correspondences.len()).map(onto).collect(),
        }
    }
}

impl Level {
    /// The levels side by side: panels, points, particles and triangles of the first, then those of the second, and so
    /// on. Nothing is sewn between them. The resolution is the coarsest.
    pub fn together(levels: &[&Level]) -> Level {
        let mut all = Level {
            resolution: levels.iter().map(|l| l.resolution).fold(0.0, f64::max),
            particle_count: 0,
            panels: Vec::new(),
            rest: Vec::new(),
            particle_of: Vec::new(),
            triangles: Vec::new(),
            stitches: Vec::new(),
            hinges: Vec::new(),
            seams: Vec::new(),
            segments: Vec::new(),
            eased: Vec::new(),
        };
        for level in levels {
            let (particles, points, triangles) = (all.particle_count as u32, all.rest.len(), all.triangles.len());
            let point = |p: &u32| p + points as u32;
            let side = |side: &Vec<u32>| side.iter().map(point).collect::<Vec<u32>>();
            let shifted = |range: &std::ops::Range<usize>, by: usize| range.start + by..range.end + by;
            all.panels.extend(level.panels.iter().map(|panel| PanelRange {
                points: shifted(&panel.points, points),
                triangles: shifted(&panel.triangles, triangles),
            }));
            all.rest.extend(&level.rest);
            all.particle_of.extend(level.particle_of.iter().map(|p| p + particles));
            all.triangles.extend(level.triangles.iter().map(|t| t.map(|p| point(&p))));
            all.stitches.extend(level.stitches.iter().map(|s| s.map(|p| p + particles)));
            let hinge = |h: &Hinge| Hinge { triangles: h.triangles.map(|t| t + triangles as u32), ..*h };
            all.hinges.extend(level.hinges.iter().map(hinge));
            all.seams.extend(level.seams.iter().map(|[a, b]| [side(a), side(b)]));
            all.segments.extend(level.segments.iter().map(|panel| panel.iter().map(side).collect::<Vec<_>>()));
            all.eased.extend(level.eased.iter().map(|e| Eased { triangle: e.triangle + triangles as u32, ..*e }));
            all.particle_count += level.particle_count;
        }
        all
    }
}

/// The panels and seams of several patterns, in the order of [`Level::together`]. Panels of different garments may
/// have the same name.
pub fn patterns_together(patterns: &[&Pattern]) -> Pattern {
    let names: Vec<&str> = patterns.iter().map(|p| p.name.as_str()).collect();
    let mut all = Pattern { name: names.join(" + "), panels: Vec::new(), seams: Vec::new() };
    for pattern in patterns {
        let first = all.panels.len();
        let shifted = |side: SegmentId| SegmentId { panel: side.panel + first, ..side };
        all.seams.extend(pattern.seams.iter().map(|s| Seam { sides: s.sides.map(shifted), ..*s }));
        all.panels.extend(pattern.panels.iter().cloned());
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::Garment;
    use crate::pattern::shapes;

    #[test]
    fn levels_side_by_side_are_what_the_patterns_side_by_side_give() {
        let patterns = [shapes::tube(0.3, 0.1), shapes::two_rectangles(0.2, 0.3)];
        let garments = patterns.each_ref().map(|p| Garment::build(p, &[0.06, 0.03]).unwrap());
        let together = Garment::together(garments.to_vec());
        let all = &together.levels[1];
        all.sanity_check();
        let anew = Correspondence::new(&together.levels[0], all);
        assert_eq!(together.correspondences[0].locations, anew.locations);
        assert_eq!(together.open.stitches.len(), garments.iter().map(|g| g.open.stitches.len()).sum::<usize>());
        let of_patterns = patterns_together(&[&patterns[0], &patterns[1]]);
        let built = Garment::build(&of_patterns, &[0.03]).unwrap().levels.remove(0);
        assert_eq!(all.particle_count, built.particle_count);
        assert_eq!((&all.rest, &all.particle_of, &all.triangles), (&built.rest, &built.particle_of, &built.triangles));
        assert_eq!((&all.panels, &all.seams, &all.segments), (&built.panels, &built.seams, &built.segments));
        assert_eq!(all.eased, built.eased);
    }
}
