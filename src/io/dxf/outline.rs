//! The loops of a block: chains of polylines closed to outlines, corners found, curves drawn through points.

use crate::geometry::{Vector2, cross};
use crate::pattern::{Curve, through};

/// A polyline of one layer.
#[derive(Clone, Debug)]
pub struct Polyline {
    pub points: Vec<Vector2>,
    pub closed: bool,
}

/// A closed loop with, for each vertex, whether it was the end of a polyline of a chain.
#[derive(Clone, Debug)]
pub struct Loop {
    pub points: Vec<Vector2>,
    pub joint: Vec<bool>,
    /// How far its ends were apart where it had to be closed.
    pub gap: f64,
}

/// Vertices nearer to each other than this share of the extent of the drawing are one.
const SAME_PLACE: f64 = 2e-5;
/// How far the ends of two polylines of one chain may be apart, as a share of the extent of the drawing.
const GAP: f64 = 2e-3;
/// A vertex at which the outline turns by more is a corner if the drawing does not say what it is, rad.
const CORNER: f64 = 30.0 / 180.0 * std::f64::consts::PI;
/// A joint of a chain that the drawing does not call a corner is one if the outline turns by more, rad.
const CORNER_AT_JOINT: f64 = 10.0 / 180.0 * std::f64::consts::PI;
/// A vertex that the drawing calls smooth is a corner all the same if the outline turns by more, rad.
const CORNER_IN_CURVE: f64 = 75.0 / 180.0 * std::f64::consts::PI;
/// Chords of a bulge, rad: the spline through their ends is exact to a millionth.
const BULGE_STEP: f64 = 0.1;

/// Points that the drawing marks on its curves.
#[derive(Default)]
pub struct Marked {
    pub corners: Vec<Vector2>,
    pub smooth: Vec<Vector2>,
}

/// Adds the vertices of a polyline to `points`, an arc for each bulge (tangent of a quarter of its angle).
pub fn with_bulges(vertices: &[(Vector2, f64)], closed: bool) -> Vec<Vector2> {
    let mut points = Vec::with_capacity(vertices.len());
    for (k, &(from, bulge)) in vertices.iter().enumerate() {
        points.push(from);
        let last = k + 1 == vertices.len();
        let to = vertices[(k + 1) % vertices.len()].0;
        let chord = to - from;
        if bulge == 0.0 || !bulge.is_finite() || chord.norm() == 0.0 || (last && !closed) {
            continue;
        }
        let angle = 4.0 * bulge.clamp(-1e3, 1e3).atan();
        let left = Vector2::new(-chord.y, chord.x);
        let center = from + chord * 0.5 + left * (0.5 / (0.5 * angle).tan());
        let steps = (angle.abs() / BULGE_STEP).ceil() as usize;
        for i in 1..steps {
            let (sin, cos) = (angle * i as f64 / steps as f64).sin_cos();
            let r = from - center;
            points.push(center + Vector2::new(cos * r.x - sin * r.y, sin * r.x + cos * r.y));
        }
    }
    points
}

/// The largest loop that the polylines close, as drawn: one of them that is closed, or a chain of open ones in the order
/// of the file, else each continued by the one whose end is nearest. `extent` is the size of the drawing.
pub fn largest_loop(polylines: &[Polyline], extent: f64) -> Option<Loop> {
    let gap = GAP * extent;
    let mut loops: Vec<Loop> = Vec::new();
    let mut open: Vec<&Polyline> = Vec::new();
    for line in polylines.iter().filter(|line| line.points.len() > 1) {
        let ends = line.points[line.points.len() - 1] - line.points[0];
        if line.closed || (line.points.len() > 3 && ends.norm() <= SAME_PLACE * extent) {
            loops.push(Loop { points: line.points.clone(), joint: vec![false; line.points.len()], gap: 0.0 });
        } else {
            open.push(line);
        }
    }
    loops.extend(chained(&open, gap));
    let cleaned = loops.into_iter().map(|l| without_repeats(l, SAME_PLACE * extent)).filter(|l| l.points.len() > 2);
    cleaned.max_by(|a, b| a.area().abs().total_cmp(&b.area().abs()))
}

/// More open polylines on one layer of a piece are damage; matching their ends takes long.
const MOST_OPEN: usize = 2_000;

fn chained(open: &[&Polyline], gap: f64) -> Vec<Loop> {
    let mut loops = Vec::new();
    let mut left: Vec<&Polyline> = open.iter().take(MOST_OPEN).copied().collect();
    while !left.is_empty() {
        let first = left.remove(0);
        let mut points = first.points.clone();
        let mut joint = vec![false; points.len()];
        joint[0] = true;
        loop {
            let end = points[points.len() - 1];
            *joint.last_mut().expect("it has points") = true;
            let near = |p: &Vector2| (p - end).norm();
            // The next in the file if it fits, else the nearest end of any.
            let fits = left.first().is_some_and(|next| near(&next.points[0]) <= gap);
            let to_start = near(&points[0]);
            let ends = left.iter().enumerate().flat_map(|(k, line)| {
                [(k, false, near(&line.points[0])), (k, true, near(&line.points[line.points.len() - 1]))]
            });
            let next = if fits { Some((0, false, 0.0)) } else { ends.min_by(|a, b| a.2.total_cmp(&b.2)) };
            let next = next.filter(|&(_, _, distance)| distance <= gap && (fits || distance <= to_start));
            let Some((k, backwards, _)) = next else { break };
            let line = left.remove(k);
            let mut more = line.points.clone();
            if backwards {
                more.reverse();
            }
            // Half-way where the two ends are not quite the same.
            let last = points.len() - 1;
            points[last] = (points[last] + more[0]) * 0.5;
            points.extend(&more[1..]);
            joint.resize(points.len(), false);
        }
        let last = points.len() - 1;
        // A chain that does not close is closed by a line: the drawing has left it out.
        let mut open = (points[last] - points[0]).norm();
        if open <= gap && points.len() > 3 {
            points.pop();
            joint.pop();
            open = 0.0;
        }
        loops.push(Loop { points, joint, gap: open });
    }
    loops
}

fn without_repeats(old: Loop, tolerance: f64) -> Loop {
    let mut new = Loop { points: Vec::new(), joint: Vec::new(), gap: old.gap };
    for (&p, &joint) in old.points.iter().zip(&old.joint) {
        match new.points.last() {
            Some(&before) if (p - before).norm() <= tolerance => {
                *new.joint.last_mut().expect("as many as points") |= joint;
            }
            _ => {
                new.points.push(p);
                new.joint.push(joint);
            }
        }
    }
    while new.points.len() > 1 && (new.points[0] - new.points[new.points.len() - 1]).norm() <= tolerance {
        new.points.pop();
        let joint = new.joint.pop().unwrap_or(false);
        new.joint[0] |= joint;
    }
    new
}

impl Loop {
    pub fn area(&self) -> f64 {
        let next = self.points.iter().cycle().skip(1);
        self.points.iter().zip(next).map(|(a, b)| 0.5 * cross(*a, *b)).sum()
    }

    /// Which vertices are corners: those the drawing calls so, else by the angle.
    fn corners(&self, marked: &Marked, extent: f64) -> Vec<bool> {
        let count = self.points.len();
        let same = 4.0 * SAME_PLACE * extent;
        let corners = Places::new(&marked.corners, same);
        let smooth = Places::new(&marked.smooth, same);
        let turn = |k: usize| {
            let (a, p, b) = (self.points[(k + count - 1) % count], self.points[k], self.points[(k + 1) % count]);
            cross(p - a, b - p).atan2((p - a).dot(&(b - p))).abs()
        };
        let is_corner = |k: usize| {
            let p = self.points[k];
            if corners.has(p) {
                return true;
            }
            let limit = match (smooth.has(p), self.joint[k], marked.corners.is_empty()) {
                (true, ..) => CORNER_IN_CURVE,
                (false, true, true) => 0.0,
                (false, true, false) => CORNER_AT_JOINT,
                (false, false, _) => CORNER,
            };
            turn(k) >= limit
        };
        (0..count).map(is_corner).collect()
    }

    /// One curve from each corner to the next. A loop with fewer than two corners is cut where it is widest.
    pub fn curves(&self, marked: &Marked, extent: f64) -> Vec<Curve> {
        let count = self.points.len();
        let mut corner = self.corners(marked, extent);
        let mut cut = vec![false; count];
        while corner.iter().filter(|&&c| c).count() < 2 {
            let from = corner.iter().position(|&c| c).unwrap_or(0);
            let far = |k: &usize| (self.points[*k] - self.points[from]).norm();
            let farthest = (0..count).max_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0);
            for k in [from, farthest] {
                cut[k] |= !corner[k];
                corner[k] = true;
            }
        }
        let first = corner.iter().position(|&c| c).unwrap_or(0);
        let mut curves = Vec::new();
        let mut run = vec![self.points[first]];
        let mut start = first;
        for step in 1..=count {
            let k = (first + step) % count;
            run.push(self.points[k]);
            if corner[k] {
                // Where a loop was cut it goes on smoothly.
                let before = cut[start].then(|| self.points[(start + count - 1) % count]);
                let after = cut[k].then(|| self.points[(k + 1) % count]);
                curves.push(through(&run, [before, after]));
                run = vec![self.points[k]];
                start = k;
            }
        }
        curves
    }
}

/// Points by the cell of a grid that they lie in.
struct Places {
    cell: f64,
    cells: std::collections::HashMap<(i64, i64), Vec<Vector2>>,
}

impl Places {
    fn new(points: &[Vector2], tolerance: f64) -> Self {
        let mut places = Self { cell: tolerance.max(f64::MIN_POSITIVE), cells: std::collections::HashMap::new() };
        for &p in points {
            places.cells.entry(places.key(p)).or_default().push(p);
        }
        places
    }

    fn key(&self, p: Vector2) -> (i64, i64) {
        ((p.x / self.cell).floor() as i64, (p.y / self.cell).floor() as i64)
    }

    fn has(&self, p: Vector2) -> bool {
        let (i, j) = self.key(p);
        let around = (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (i.saturating_add(di), j.saturating_add(dj))));
        around.filter_map(|key| self.cells.get(&key)).flatten().any(|q| (p - q).norm() <= self.cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn v(x: f64, y: f64) -> Vector2 {
        Vector2::new(x, y)
    }

    fn open(points: &[(f64, f64)]) -> Polyline {
        Polyline { points: points.iter().map(|&(x, y)| v(x, y)).collect(), closed: false }
    }

    #[test]
    fn chains_close_in_the_order_of_the_file_and_out_of_it() {
        let parts = [
            open(&[(0.0, 0.0), (100.0, 0.0)]),
            open(&[(100.0, 0.0), (100.0, 50.0)]),
            open(&[(0.0, 50.0), (100.0, 50.0)]),
            open(&[(0.0, 50.05), (0.0, 0.0)]),
        ];
        for order in [[0, 1, 2, 3], [3, 1, 0, 2], [2, 0, 3, 1]] {
            let found = largest_loop(&order.map(|k| parts[k].clone()), 100.0).unwrap();
            assert_eq!(found.points.len(), 4, "{order:?}: {found:?}");
            assert!((found.area().abs() - 5000.0).abs() < 5.0);
            assert!(found.joint.iter().all(|&j| j));
        }
    }

    #[test]
    fn the_largest_loop_is_the_piece() {
        let square =
            |side: f64| Polyline { points: vec![v(0.0, 0.0), v(side, 0.0), v(side, side), v(0.0, side)], closed: true };
        let found = largest_loop(&[square(3.0), square(50.0), square(9.0)], 50.0).unwrap();
        assert_eq!(found.area(), 2500.0);
        assert!(largest_loop(&[open(&[(0.0, 0.0), (1.0, 1.0)])], 1.0).is_none());
    }

    #[test]
    fn a_circle_without_corners_is_two_smooth_halves() {
        let points: Vec<Vector2> = (0..24).map(|k| PI / 12.0 * f64::from(k)).map(|a| v(a.cos(), a.sin())).collect();
        let ring = largest_loop(&[Polyline { points, closed: true }], 2.0).unwrap();
        let curves = ring.curves(&Marked::default(), 2.0);
        assert_eq!(curves.len(), 2);
        let length: f64 = curves.iter().map(Curve::length).sum();
        assert!((length / (2.0 * PI) - 1.0).abs() < 1e-4, "{length}");
        assert!((curves[0].end_directions()[1] - curves[1].end_directions()[0]).norm() < 1e-9);
    }

    #[test]
    fn bulges_are_arcs() {
        // A stadium: two lines and two half circles of bulge 1.
        let vertices = [(v(0.0, 0.0), 0.0), (v(4.0, 0.0), 1.0), (v(4.0, 2.0), 0.0), (v(0.0, 2.0), 1.0)];
        let points = with_bulges(&vertices, true);
        let stadium = largest_loop(&[Polyline { points, closed: true }], 6.0).unwrap();
        let curves = stadium.curves(&Marked::default(), 6.0);
        let area: f64 = curves.iter().map(Curve::signed_area).sum();
        assert!((area - 8.0 - PI).abs() < 1e-3, "{area}");
    }

    #[test]
    fn marked_points_decide_what_is_a_corner() {
        let points = vec![v(0.0, 0.0), v(50.0, 5.0), v(100.0, 0.0), v(100.0, 60.0), v(50.0, 80.0), v(0.0, 60.0)];
        let found = largest_loop(&[Polyline { points: points.clone(), closed: true }], 100.0).unwrap();
        // By angle: the four outer vertices and the peak, which turns by 44 degrees.
        assert_eq!(found.curves(&Marked::default(), 100.0).len(), 5);
        let corners = vec![points[0], points[1], points[2], points[3], points[5]];
        let marked = Marked { corners, smooth: vec![points[4]] };
        assert_eq!(found.curves(&marked, 100.0).len(), 5);
        let marked = Marked { corners: vec![points[0]], smooth: vec![points[1], points[4]] };
        assert_eq!(found.curves(&marked, 100.0).len(), 4);
    }
}
