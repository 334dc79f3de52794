//! From a pattern to the file.

use super::file::*;
use super::{FORMAT, VERSION};
use crate::geometry::Vector2;
use crate::pattern::{Bend, Curve, Markings, Notch, Panel, Pattern, Placement, Seam, Segment, SegmentId, Shape};
use nalgebra::Matrix3;

pub fn file_of(pattern: &Pattern) -> File {
    let side = |id: SegmentId| FileSide { panel: pattern.panels[id.panel].name.clone(), segment: id.segment };
    let seam = |s: &Seam| FileSeam { name: None, ease: None, sense: s.sense.into(), sides: s.sides.map(side) };
    File {
        format: FORMAT.to_owned(),
        version: VERSION,
        name: Some(pattern.name.clone()),
        unit: None,
        panels: pattern.panels.iter().map(panel_to_file).collect(),
        seams: pattern.seams.iter().map(seam).collect(),
    }
}

fn point(p: Vector2) -> Point {
    [p.x, p.y]
}

fn panel_to_file(panel: &Panel) -> FilePanel {
    let Markings { notches, grainline, lines, drill_holes } = &panel.markings;
    let placement = |p: &Placement| {
        let rows = |m: &Matrix3<f64>| [0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], m[(i, 2)]]);
        let rotation = Some(rows(p.rotation.matrix()));
        FilePlacement {
            translation: p.translation.into(),
            rotation,
            angles_deg: None,
            bend: p.bend.as_ref().map(file_bend),
            raised: p.raised,
        }
    };
    let notch = |n: &Notch| FileNotch { segment: n.segment, fraction: n.fraction, kind: n.kind.into() };
    let next = |k: usize| panel.segments[(k + 1) % panel.segments.len()].curve.start;
    FilePanel {
        name: panel.name.clone(),
        part: panel.part.map(Into::into),
        fabric: panel.fabric.clone(),
        grainline: grainline.map(|ends| ends.map(point)),
        drill_holes: drill_holes.iter().copied().map(point).collect(),
        internal_lines: lines.iter().map(|line| line.iter().copied().map(point).collect()).collect(),
        placement: panel.placement.as_ref().map(placement),
        outline: panel.segments.iter().enumerate().map(|(k, s)| segment_to_file(s, next(k))).collect(),
        notches: notches.iter().map(notch).collect(),
    }
}

fn segment_to_file(segment: &Segment, next: Vector2) -> FileSegment {
    let Curve { start, end, shape } = &segment.curve;
    let mut file = FileSegment {
        from: point(*start),
        to: (*end != next).then(|| point(*end)),
        label: segment.label.map(Into::into),
        quadratic: None,
        cubic: None,
        path: None,
        arc: None,
    };
    match shape {
        Shape::Line => {}
        Shape::Quadratic(c) => file.quadratic = Some(point(*c)),
        Shape::Cubic(c, d) => file.cubic = Some([point(*c), point(*d)]),
        Shape::Arc(arc) => {
            file.arc = Some(FileArc { center: point(arc.center), radius: arc.radius, sweep: arc.sweep });
        }
        Shape::Path(path) => {
            let points = path.points();
            file.path = Some(points[1..points.len() - 1].iter().copied().map(point).collect());
        }
    }
    file
}

fn file_bend(bend: &Bend) -> FileBend {
    FileBend { origin: bend.origin.into(), along: bend.along.into(), radius: bend.radius }
}
