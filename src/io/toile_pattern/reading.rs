//! From the file to a pattern, and all that can be wrong with it.

use super::file::*;
use super::{FORMAT, VERSION};
use crate::geometry::{Vector2, Vector3};
use crate::io::length::Unit;
use crate::pattern::{
    Arc, Bend, Curve, Markings, Notch, Panel, Path, Pattern, Placement, Seam, Segment, SegmentId, Shape,
};
use crate::{Error, Warning};
use nalgebra::{Matrix3, Rotation3};
use std::collections::HashMap;

/// More than any pattern or panel has; a file with more is damaged, and comparing all edges of a panel takes long.
const MOST_EDGES: usize = 5_000;
const MOST_EDGES_PER_PANEL: usize = 1_000;
const MOST_PATH_POINTS: usize = 200_000;
/// How far an arc may miss its own ends, and a rotation be from a rotation.
const TOLERANCE: f64 = 1e-6;
/// How far the ease that a seam declares may be from that of its sides before it is told.
const EASE_TOLERANCE: f64 = 0.005;

pub fn pattern_of(file: File, name: &str) -> Result<(Pattern, Vec<Warning>), Error> {
    if file.format != FORMAT {
        return Err(Error::new(
            format!("The format is \"{}\".", file.format),
            format!("A pattern of toile has `format = \"{FORMAT}\"`."),
        ));
    }
    if file.version != VERSION {
        return Err(Error::new(
            format!("The pattern has version {}; this toile reads version {VERSION}.", file.version),
            "Use a newer toile, or write the pattern again.",
        ));
    }
    check_counts(&file)?;
    let unit = file.unit.unwrap_or(Unit::Metre);
    let panels = file
        .panels
        .iter()
        .map(|p| panel_from_file(p, unit).map_err(|e| e.within(format!("panel \"{}\"", p.name))))
        .collect::<Result<Vec<_>, _>>()?;
    let mut index_of: HashMap<&str, usize> = HashMap::new();
    for (k, panel) in panels.iter().enumerate() {
        index_of.entry(&panel.name).or_insert(k);
    }
    let mut seams = Vec::with_capacity(file.seams.len());
    for (k, seam) in file.seams.iter().enumerate() {
        let sides = [&seam.sides[0], &seam.sides[1]];
        let [a, b] = sides.map(|side| side_of(side, &index_of, &panels).map_err(|e| e.within(seam_place(seam, k))));
        seams.push(Seam { sides: [a?, b?], sense: seam.sense.into() });
    }
    let pattern = Pattern { name: file.name.unwrap_or_else(|| name.to_owned()), panels, seams };
    pattern.check()?;
    let warnings = file.seams.iter().zip(&pattern.seams).enumerate().filter_map(|(k, (declared, seam))| {
        let [a, b] = pattern.seam_lengths(seam);
        let (ease, drawn) = (declared.ease?, b / a - 1.0);
        ((ease - drawn).abs() > EASE_TOLERANCE).then(|| {
            let error = Error::new(
                format!(
                    "Its ease is to be {:.1} %, but the sides are drawn with {:.1} %.",
                    100.0 * ease,
                    100.0 * drawn
                ),
                "Correct the outline or the figure; the sides are sewn as they are drawn.",
            );
            Warning(error.coded(crate::Code::EaseNotAsStated).within(seam_place(declared, k)))
        })
    });
    let warnings = warnings.collect();
    Ok((pattern, warnings))
}

fn seam_place(seam: &FileSeam, index: usize) -> String {
    seam.name.as_ref().map_or_else(|| format!("seam {index}"), |name| format!("seam \"{name}\""))
}

fn check_counts(file: &File) -> Result<(), Error> {
    let edges: usize = file.panels.iter().map(|p| p.outline.len()).sum();
    let most = file.panels.iter().map(|p| p.outline.len()).max().unwrap_or(0);
    let points: usize = file.panels.iter().flat_map(|p| &p.outline).filter_map(|s| s.path.as_ref()).map(Vec::len).sum();
    let limits = [
        (edges, MOST_EDGES, "edges"),
        (most, MOST_EDGES_PER_PANEL, "edges in one panel"),
        (points, MOST_PATH_POINTS, "points in its paths"),
    ];
    match limits.iter().find(|(count, most, _)| count > most) {
        None => Ok(()),
        Some((count, most, what)) => Err(Error::new(
            format!("The pattern has {count} {what}."),
            format!("More than {most} are taken as damage; export it again, with curves instead of many points."),
        )),
    }
}

fn side_of(side: &FileSide, index_of: &HashMap<&str, usize>, panels: &[Panel]) -> Result<SegmentId, Error> {
    let Some(&panel) = index_of.get(side.panel.as_str()) else {
        return Err(Error::new(
            format!("It names panel \"{}\", which does not exist.", side.panel),
            "Check the spelling of the panel's name.",
        )
        .coded(crate::Code::SeamUnknownEdge));
    };
    let count = panels[panel].segments.len();
    if side.segment >= count {
        return Err(Error::new(
            format!("It names segment {} of panel \"{}\", which does not exist.", side.segment, side.panel),
            format!("The panel has {count} segments, counted from 0."),
        )
        .coded(crate::Code::SeamUnknownEdge));
    }
    Ok(SegmentId { panel, segment: side.segment })
}

fn panel_from_file(file: &FilePanel, unit: Unit) -> Result<Panel, Error> {
    let at = |[x, y]: Point| Vector2::new(unit.to_metres(x), unit.to_metres(y));
    let count = file.outline.len();
    let mut segments = Vec::with_capacity(count);
    for (k, segment) in file.outline.iter().enumerate() {
        let next = file.outline[(k + 1) % count].from;
        let curve = curve_from_file(segment, next, unit).map_err(|e| e.within(format!("edge {k}")))?;
        segments.push(Segment { curve, label: segment.label.map(Into::into) });
    }
    let mut notches = Vec::with_capacity(file.notches.len());
    for (k, notch) in file.notches.iter().enumerate() {
        if notch.segment >= count || !(0.0..=1.0).contains(&notch.fraction) {
            return Err(Error::new(
                format!("It lies at {} of segment {}.", notch.fraction, notch.segment),
                format!("Give a segment from 0 to {} and a fraction from 0 to 1.", count.saturating_sub(1)),
            )
            .within(format!("notch {k}")));
        }
        notches.push(Notch { segment: notch.segment, fraction: notch.fraction, kind: notch.kind.into() });
    }
    let markings = Markings {
        notches,
        grainline: file.grainline.map(|ends| ends.map(at)),
        lines: file.internal_lines.iter().map(|line| line.iter().copied().map(at).collect()).collect(),
        drill_holes: file.drill_holes.iter().copied().map(at).collect(),
    };
    Ok(Panel {
        placement: file.placement.as_ref().map(|p| placement_from_file(p, unit)).transpose()?,
        part: file.part.map(Into::into),
        markings,
        fabric: file.fabric.clone(),
        ..Panel::new(file.name.as_str(), segments)
    })
}

fn placement_from_file(file: &FilePlacement, unit: Unit) -> Result<Placement, Error> {
    let rotation = match (&file.rotation, file.angles_deg) {
        (Some(rows), None) => {
            let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
            let apart = (matrix.transpose() * matrix - Matrix3::identity()).amax();
            if apart.is_nan() || apart > TOLERANCE || matrix.determinant() < 0.0 {
                return Err(Error::new(
                    "The matrix of its placement is not a rotation.",
                    "Give three rows of unit length at right angles, or `angles_deg` instead.",
                ));
            }
            Rotation3::from_matrix_unchecked(matrix)
        }
        (None, Some(angles)) => {
            let [a, b, c] = angles.map(f64::to_radians);
            Rotation3::from_euler_angles(a, b, c)
        }
        (None, None) => Rotation3::identity(),
        (Some(_), Some(_)) => {
            return Err(Error::new("Its placement has both `rotation` and `angles_deg`.", "Give one of the two."));
        }
    };
    let bend = file.bend.as_ref().map(|bend| bend_from_file(bend, unit)).transpose()?;
    let translation = Vector3::from(file.translation.map(|x| unit.to_metres(x)));
    Ok(Placement { rotation, translation, bend, raised: unit.to_metres(file.raised) })
}

fn bend_from_file(file: &FileBend, unit: Unit) -> Result<Bend, Error> {
    let along = Vector2::from(file.along);
    if !((along.norm() - 1.0).abs() < TOLERANCE
        && file.radius.is_finite()
        && unit.to_metres(file.radius).abs() > LEAST_RADIUS)
    {
        return Err(Error::new(
            "The bend of its placement is no cylinder.",
            "Give `along` as a direction of length one, and a `radius` of at least a millimetre.",
        ));
    }
    let origin = Vector2::from(file.origin.map(|x| unit.to_metres(x)));
    Ok(Bend { origin, along, radius: unit.to_metres(file.radius) })
}

/// No cloth is bent to less when it starts, m.
const LEAST_RADIUS: f64 = 1e-3;

fn curve_from_file(file: &FileSegment, next: Point, unit: Unit) -> Result<Curve, Error> {
    let at = |[x, y]: Point| Vector2::new(unit.to_metres(x), unit.to_metres(y));
    let (start, end) = (at(file.from), at(file.to.unwrap_or(next)));
    let shape = match (file.quadratic, file.cubic, &file.arc, &file.path) {
        (None, None, None, None) => Shape::Line,
        (Some(c), None, None, None) => Shape::Quadratic(at(c)),
        (None, Some([c, d]), None, None) => Shape::Cubic(at(c), at(d)),
        (None, None, Some(arc), None) => {
            let arc = Arc { center: at(arc.center), radius: unit.to_metres(arc.radius), sweep: arc.sweep };
            check_arc(&arc, start, end)?;
            Shape::Arc(arc)
        }
        (None, None, None, Some(inner)) => {
            let points = [start].into_iter().chain(inner.iter().copied().map(at)).chain([end]).collect();
            let path = Path::new(points).ok_or_else(|| {
                Error::new(
                    format!("Its path has {} points.", inner.len()),
                    "Give two controls for each piece, and between pieces the point where they meet: 2, 5, 8, ... points.",
                )
            })?;
            Shape::Path(path)
        }
        _ => {
            return Err(Error::new(
                "It has more than one of `quadratic`, `cubic`, `path` and `arc`.",
                "Give one, or none for a straight line.",
            ));
        }
    };
    Ok(Curve { start, end, shape })
}

/// Do the ends lie on the circle, a sweep apart?
fn check_arc(arc: &Arc, start: Vector2, end: Vector2) -> Result<(), Error> {
    let (sin, cos) = arc.sweep.sin_cos();
    let r = start - arc.center;
    let reached = arc.center + Vector2::new(cos * r.x - sin * r.y, sin * r.x + cos * r.y);
    // Of a flat arc the last digits are lost.
    let tolerance = TOLERANCE + 1e-9 * arc.radius.abs();
    let fits = (r.norm() - arc.radius).abs() <= tolerance && (reached - end).norm() <= tolerance;
    if fits && arc.radius > 0.0 && arc.sweep.abs() < std::f64::consts::TAU && arc.sweep != 0.0 {
        return Ok(());
    }
    Err(Error::new(
        "Its arc does not lead from its start to its end.",
        "Check center, radius and sweep, radians, counter-clockwise positive.",
    ))
}
