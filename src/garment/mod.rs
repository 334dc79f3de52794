//! The garment: the pattern discretized on all its levels, coarse to fine.

mod correspondence;
mod level;
mod order;
mod outline;
mod together;
mod triangulate;

pub use correspondence::{Correspondence, Location};
pub use level::{Eased, Hinge, Level, PanelRange};
pub use together::patterns_together;

use crate::geometry::{UnionFind, Vector2, Vector3};
use crate::pattern::surface::{Surface, pieces};
use crate::pattern::{Pattern, Sense};
use crate::{Code, Error};
use level::{RimEdge, panel_edges};
use order::morton_order;
use outline::{Outline, Outlines};
use rayon::prelude::*;
use triangulate::triangulate;

/// The finest resolution that is of use, m; finer ones are a slip of the unit.
pub const FINEST_RESOLUTION: f64 = 0.0005;
/// The coarsest, m: coarser than that a sleeve would have less than three edges around it.
pub const COARSEST_RESOLUTION: f64 = 0.1;

/// The most particles on a level: a long dress at one millimetre, five gigabytes with all its levels.
pub const MOST_PARTICLES: f64 = 5e6;

/// The pattern discretized on all its levels.
#[derive(Clone, Debug)]
pub struct Garment {
    /// The coarsest discretization with its seams open: panels as they are arranged, stitches to close.
    pub open: Level,
    /// Sewn, coarsest first; the first has the points of `open`.
    pub levels: Vec<Level>,
    /// `correspondences[k]` locates the points of `levels[k + 1]` on `levels[k]`.
    pub correspondences: Vec<Correspondence>,
}

impl Garment {
    /// Discretizes a pattern at the given resolutions, coarsest first, m.
    pub fn build(pattern: &Pattern, resolutions: &[f64]) -> Result<Self, Error> {
        check_resolutions(resolutions)?;
        check_particle_count(pattern, resolutions[resolutions.len() - 1])?;
        check_openings(pattern)?;
        let outlines = Outlines::new(pattern, resolutions)?;
        // In the order of the levels, so that of several errors always the same one is told.
        let unsewn: Vec<Result<(Level, Vec<RimEdge>), Error>> =
            (0..resolutions.len()).into_par_iter().map(|k| build_open(pattern, &outlines, k, resolutions[k])).collect();
        let unsewn: Vec<(Level, Vec<RimEdge>)> = unsewn.into_iter().collect::<Result<_, Error>>()?;
        let open = unsewn.first().map(|(open, _)| open.clone());
        let levels: Vec<Level> = unsewn.into_par_iter().map(|(open, rim)| sewn(open, &rim, pattern)).collect();
        for level in &levels {
            check_sewn(level, pattern)?;
        }
        let correspondences = levels.par_windows(2).map(|w| Correspondence::new(&w[0], &w[1])).collect();
        let open = open.expect("there is at least one resolution");
        Ok(Self { open, levels, correspondences })
    }

    /// Positions of the coarsest sewn level from those of the open one: partners meet half-way.
    pub fn weld(&self, positions: &[Vector3]) -> Vec<Vector3> {
        let first = &self.levels[0];
        let mut sums = vec![(Vector3::zeros(), 0.0); first.particle_count];
        for (position, &particle) in positions.iter().zip(&first.particle_of) {
            sums[particle as usize].0 += position;
            sums[particle as usize].1 += 1.0;
        }
        sums.into_iter().map(|(sum, count)| sum / count).collect()
    }
}

/// Can a garment be discretized at these resolutions, m?
pub fn check_resolutions(resolutions: &[f64]) -> Result<(), Error> {
    let range = FINEST_RESOLUTION..=COARSEST_RESOLUTION;
    if resolutions.is_empty() {
        return Err(Error::new("No resolution is given.", "Give at least one, such as \"10 mm\"."));
    }
    if let Some(bad) = resolutions.iter().find(|r| !range.contains(r)) {
        return Err(Error::new(
            format!("A resolution of {} mm cannot be used.", bad * 1e3),
            format!("Give one from {} mm to {} mm.", FINEST_RESOLUTION * 1e3, COARSEST_RESOLUTION * 1e3),
        ));
    }
    if resolutions.windows(2).any(|w| w[1] >= w[0]) {
        return Err(Error::new(
            "The resolutions of the levels do not descend.",
            "List them from coarse to fine, such as \"40,20,10,5 mm\".",
        ));
    }
    Ok(())
}

/// Memory is asked for by the particle, about a kilobyte each on all levels.
fn check_particle_count(pattern: &Pattern, resolution: f64) -> Result<(), Error> {
    let counts = pattern.panels.iter().map(|panel| {
        // Each particle of a hexagonal lattice stands for the area √3/2 h².
        let inside = panel.signed_area().abs() / (0.75f64.sqrt() * resolution * resolution);
        inside + panel.perimeter() / resolution
    });
    let counts: Vec<f64> = counts.collect();
    let total: f64 = counts.iter().sum();
    if total <= MOST_PARTICLES {
        return Ok(());
    }
    let largest = (0..counts.len()).max_by(|&a, &b| counts[a].total_cmp(&counts[b])).unwrap_or(0);
    Err(Error::new(
        format!(
            "At a resolution of {} mm the garment would have {:.1} million particles, {:.1} of them in this panel.",
            resolution * 1e3,
            total / 1e6,
            counts[largest] / 1e6
        ),
        format!(
            "Ask for a coarser resolution, with at most {} million; or is the pattern's unit wrong?",
            MOST_PARTICLES / 1e6
        ),
    )
    .coded(Code::TooManyParticles)
    .within(format!("panel \"{}\"", pattern.panels[largest].name)))
}

/// One panel at one resolution, as if it were alone.
struct BuiltPanel {
    outline: Outline,
    /// In spatial order.
    points: Vec<Vector2>,
    /// Where each of the mesh's own points is in that order.
    place: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

fn build_panel(
    pattern: &Pattern,
    outlines: &Outlines,
    index: usize,
    level: usize,
    h: f64,
) -> Result<BuiltPanel, Error> {
    let panel = &pattern.panels[index];
    let outline = outlines.outline(pattern, index, level);
    let mesh = triangulate(&outline, h).map_err(|e| e.within(format!("panel \"{}\"", panel.name)))?;
    if cfg!(debug_assertions) {
        mesh.sanity_check();
    }
    let order = morton_order(&mesh.points);
    let mut place = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old as usize] = new as u32;
    }
    // A clockwise outline has its right side on -z: its triangles run clockwise too.
    let turned = panel.signed_area() < 0.0;
    let mut triangles: Vec<[u32; 3]> = mesh
        .triangles
        .iter()
        .map(|t| if turned { [t[0], t[2], t[1]] } else { *t }.map(|p| place[p as usize]))
        .map(|t| {
            let first = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
            [t[first], t[(first + 1) % 3], t[(first + 2) % 3]]
        })
        .collect();
    triangles.sort_unstable();
    let points = order.iter().map(|&old| mesh.points[old as usize]).collect();
    Ok(BuiltPanel { outline, points, place, triangles })
}

/// All panels at one resolution, every point a particle of its own, and the edges along their outlines by
/// their points.
fn build_open(
    pattern: &Pattern,
    outlines: &Outlines,
    level: usize,
    resolution: f64,
) -> Result<(Level, Vec<RimEdge>), Error> {
    let panels: Vec<Result<BuiltPanel, Error>> = (0..pattern.panels.len())
        .into_par_iter()
        .map(|index| build_panel(pattern, outlines, index, level, resolution))
        .collect();
    let panels: Vec<BuiltPanel> = panels.into_iter().collect::<Result<_, Error>>()?;
    let mut built = Level {
        resolution,
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
    built.rest.reserve_exact(panels.iter().map(|mesh| mesh.points.len()).sum());
    built.triangles.reserve_exact(panels.iter().map(|mesh| mesh.triangles.len()).sum());
    for (panel, mesh) in pattern.panels.iter().zip(panels) {
        let (first_point, first_triangle) = (built.rest.len(), built.triangles.len());
        let place = |p: u32| first_point as u32 + p;
        built.triangles.extend(mesh.triangles.iter().map(|t| t.map(place)));
        built.rest.extend(mesh.points);
        built.panels.push(PanelRange {
            points: first_point..built.rest.len(),
            triangles: first_triangle..built.triangles.len(),
        });
        let along = |k: usize| {
            let steps = mesh.outline.segments[k].1;
            (0..=steps).map(|s| place(mesh.place[mesh.outline.point_of(k, s)])).collect()
        };
        built.segments.push((0..panel.segments.len()).map(along).collect());
    }
    let edges: Vec<_> = built
        .panels
        .par_iter()
        .map(|range| panel_edges(&built.triangles[range.triangles.clone()], range.triangles.start as u32))
        .collect();
    let mut rim = Vec::new();
    built.hinges.reserve_exact(edges.iter().map(|panel| panel.hinges.len()).sum());
    for panel in edges {
        built.hinges.extend(panel.hinges);
        rim.extend(panel.rim);
    }
    built.particle_count = built.rest.len();
    built.particle_of = (0..built.rest.len() as u32).collect();
    for seam in &pattern.seams {
        let side = |k: usize| {
            let id = seam.sides[k];
            let mut points: Vec<u32> = built.segments[id.panel][id.segment].clone();
            if k == 1 && seam.sense == Sense::Opposed {
                points.reverse();
            }
            points
        };
        let sides = [side(0), side(1)];
        assert_eq!(sides[0].len(), sides[1].len(), "both sides of a seam have the same number of points");
        // The tip of a dart meets itself.
        let pairs = sides[0].iter().zip(&sides[1]).filter(|(a, b)| a != b).map(|(&a, &b)| [a, b]);
        built.stitches.extend(pairs);
        built.seams.push(sides);
    }
    built.eased = eased(&built, &rim, pattern);
    Ok((built, rim))
}

/// The same level with its stitches closed: partners are one particle.
fn sewn(open: Level, rim: &[RimEdge], pattern: &Pattern) -> Level {
    let mut sets = UnionFind::new(open.particle_count);
    for &[a, b] in &open.stitches {
        sets.union(a, b);
    }
    let mut number = vec![u32::MAX; open.particle_count];
    let mut count = 0;
    let particle_of: Vec<u32> = (0..open.particle_count as u32)
        .map(|point| {
            let number = &mut number[sets.find(point) as usize];
            if *number == u32::MAX {
                *number = count;
                count += 1;
            }
            *number
        })
        .collect();
    let mut level = Level { particle_count: count as usize, particle_of, stitches: Vec::new(), ..open };
    level.hinges.extend(seam_hinges(&level, rim, pattern));
    level
}

/// The edge along an outline between two neighbours; `rim` is sorted.
fn rim_edge(rim: &[RimEdge], neighbours: &[u32]) -> RimEdge {
    let [a, b] = [neighbours[0], neighbours[1]];
    let found = rim.binary_search_by_key(&[a.min(b), a.max(b)], |edge| edge.ends);
    rim[found.expect("neighbours along an outline share an edge")]
}

/// Hinges across the closed seams. A seam that folds one panel over the other has none: the fold
/// is free.
fn seam_hinges(level: &Level, rim: &[RimEdge], pattern: &Pattern) -> Vec<Hinge> {
    let mut hinges = Vec::new();
    for (seam, [side_a, side_b]) in pattern.seams.iter().zip(&level.seams) {
        if seam.sense == Sense::Aligned {
            continue;
        }
        for (a, b) in side_a.windows(2).zip(side_b.windows(2)) {
            let (a, b) = (rim_edge(rim, a), rim_edge(rim, b));
            if a.triangle != b.triangle {
                hinges.push(Hinge { triangles: [a.triangle, b.triangle], tips: [a.tip, b.tip] });
            }
        }
    }
    hinges
}

/// The edges on the longer sides of the seams.
fn eased(level: &Level, rim: &[RimEdge], pattern: &Pattern) -> Vec<Eased> {
    let mut eased = Vec::new();
    for (seam, sides) in pattern.seams.iter().zip(&level.seams) {
        let [a, b] = pattern.seam_lengths(seam);
        let (longer, ratio) = if a > b { (&sides[0], b / a) } else { (&sides[1], a / b) };
        if ratio < 1.0 - EQUAL_LENGTHS {
            eased.extend(longer.windows(2).map(|w| {
                let RimEdge { triangle, tip, .. } = rim_edge(rim, w);
                Eased { triangle, tip, ratio }
            }));
        }
    }
    eased
}

/// What is sewn up all around is worn by nobody.
fn check_openings(pattern: &Pattern) -> Result<(), Error> {
    let shut = pieces(pattern).into_iter().filter(|piece| Surface::new(pattern, piece, &pattern.seams).rims.is_empty());
    let error = |piece: Vec<usize>| {
        /// Named at the most.
        const MOST: usize = 3;
        let name = |&panel: &usize| format!("\"{}\"", pattern.panels[panel].name);
        let names: Vec<String> = piece[1..].iter().take(MOST).map(name).collect();
        let with = match piece.len() - 1 {
            0 => String::new(),
            others if others > MOST => format!(" of it, {} and {} more", names.join(", "), others - MOST),
            _ => format!(" of it and {}", names.join(", ")),
        };
        Error::new(
            format!(
                "Its seams make a bag{with}: every edge is sewn, and no opening is left for a body to pass through."
            ),
            "Leave open what is a hem, a neckline or the end of a sleeve, and sew a sleeve's cap to an armhole: \
             `toile seams show` draws what is sewn to what.",
        )
        .coded(Code::SewnShut)
        .within(format!("panel {}", name(&piece[0])))
    };
    Error::all(shut.map(error)).map_or(Ok(()), Err)
}

/// Sides of a seam that differ by less than this share are drawn equal.
const EQUAL_LENGTHS: f64 = 1e-3;

/// Sewing must neither fold a triangle onto itself nor lay two triangles on one another.
fn check_sewn(level: &Level, pattern: &Pattern) -> Result<(), Error> {
    // Only a triangle with a sewn corner can be what sewing has spoiled.
    let mut points = vec![0u8; level.particle_count];
    level.particle_of.iter().for_each(|&p| points[p as usize] = points[p as usize].saturating_add(1));
    let mut at_seams: Vec<([u32; 3], usize)> = (0..level.triangles.len())
        .map(|t| (level.particles(t), t))
        .filter(|(corners, _)| corners.iter().any(|&p| points[p as usize] > 1))
        .collect();
    at_seams.iter_mut().for_each(|(corners, _)| corners.sort_unstable());
    at_seams.sort_unstable();
    let folded = at_seams.iter().filter(|([a, b, c], _)| a == b || b == c).map(|(_, t)| (*t, None));
    let doubled = at_seams.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| (w[1].1, Some(w[0].1)));
    let Some((first, under)) = folded.chain(doubled).min() else { return Ok(()) };
    let panel_of = level.panel_of_triangle();
    let name = |triangle: usize| &pattern.panels[panel_of[triangle] as usize].name;
    let panel = name(first);
    // The triangle in a corner of an outline has a point that no other has.
    let is_in_corner = |triangle: usize| {
        let others = |p: u32| level.triangles.iter().filter(|corners| corners.contains(&p)).count();
        level.triangles[triangle].iter().any(|&p| others(p) == 1)
    };
    if let Some(under) = under.filter(|&under| panel_of[under] != panel_of[first])
        && is_in_corner(first)
        && is_in_corner(under)
    {
        return Err(Error::new(
            format!(
                "It is sewn to panel \"{}\" around a corner, where nothing else is sewn: the tip of the one would lie on that of the other.",
                name(under)
            ),
            "Look at this corner with `toile seams show`. If both seams are meant, leave one of them open near the corner, or cut it off.",
        )
        .coded(Code::PanelTooNarrow)
        .within(format!("panel \"{panel}\"")));
    }
    Err(Error::new(
        format!("It is narrower than the resolution of {} mm can sew.", (level.resolution * 1e4).round() / 10.0),
        "Ask for finer levels, such as --levels \"20,10,5 mm\".",
    )
    .coded(Code::PanelTooNarrow)
    .within(format!("panel \"{panel}\"")))
}
