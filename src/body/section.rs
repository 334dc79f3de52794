//! Plane sections of a closed mesh: the curves in which a plane cuts it, and the tape measure around them.
//!
//! A closed mesh is cut in closed curves: every crossed edge belongs to two crossed triangles, and every crossed triangle has
//! two crossed edges. A vertex in the plane counts as above it, so that no case is special.

use super::Body;
use crate::geometry::{Vector2, Vector3, cross};

/// A closed curve in which a plane cuts a mesh.
#[derive(Clone, Debug)]
pub struct Loop {
    /// In order around the curve, m, world; the last is followed by the first.
    pub points: Vec<Vector3>,
    /// For each point the triangle in which the curve goes on to the next one.
    pub triangles: Vec<u32>,
    /// Of the plane, unit length.
    pub normal: Vector3,
}

/// What a tape measure around a part of the body tells.
#[derive(Clone, Debug)]
pub struct Girth {
    /// Along the skin, into each hollow, m.
    pub along_skin: f64,
    /// Of a taut tape, which spans the hollows: the length of the convex hull, m.
    pub tape: f64,
    /// Middle of the area that the curve encloses, m, world.
    pub center: Vector3,
}

impl Loop {
    /// The length of the curve, m.
    pub fn length(&self) -> f64 {
        let next = self.points.iter().cycle().skip(1);
        self.points.iter().zip(next).map(|(a, b)| (b - a).norm()).sum()
    }

    /// The middle of the area that the curve encloses, m, world; of the points, where it encloses none.
    pub fn center(&self) -> Vector3 {
        let (origin, across, up) = self.frame();
        let flat: Vec<Vector2> = self.points.iter().map(|p| flattened(p - origin, across, up)).collect();
        let (mut area, mut moment) = (0.0, Vector2::zeros());
        for (a, b) in flat.iter().zip(flat.iter().cycle().skip(1)) {
            let doubled = cross(*a, *b);
            area += doubled;
            moment += (a + b) * doubled;
        }
        let extent = flat.iter().map(|p| p.norm_squared()).fold(0.0, f64::max);
        // A sliver's middle is nowhere near it when it is divided by an area of rounding errors.
        if area.abs() <= 1e-6 * extent {
            return self.points.iter().sum::<Vector3>() / self.points.len() as f64;
        }
        let middle = moment / (3.0 * area);
        origin + across * middle.x + up * middle.y
    }

    /// The area that the curve encloses, m².
    pub fn area(&self) -> f64 {
        let (origin, across, up) = self.frame();
        let flat: Vec<Vector2> = self.points.iter().map(|p| flattened(p - origin, across, up)).collect();
        flat.iter().zip(flat.iter().cycle().skip(1)).map(|(a, b)| 0.5 * cross(*a, *b)).sum::<f64>().abs()
    }

    pub fn girth(&self) -> Girth {
        Girth { along_skin: self.length(), tape: tape(&self.points, self.normal), center: self.center() }
    }

    fn frame(&self) -> (Vector3, Vector3, Vector3) {
        let (across, up) = plane_axes(self.normal);
        (self.points[0], across, up)
    }
}

/// Two unit vectors that span the plane with this normal.
pub fn plane_axes(normal: Vector3) -> (Vector3, Vector3) {
    let helper = if normal.z.abs() < 0.5 { Vector3::z() } else { Vector3::x() };
    let across = normal.cross(&helper).normalize();
    (across, normal.cross(&across).normalize())
}

fn flattened(p: Vector3, across: Vector3, up: Vector3) -> Vector2 {
    Vector2::new(p.dot(&across), p.dot(&up))
}

/// The length of a taut tape around points of a plane, m.
pub fn tape(points: &[Vector3], normal: Vector3) -> f64 {
    let hull = hull(points, normal);
    hull.iter().zip(hull.iter().cycle().skip(1)).map(|(a, b)| (b - a).norm()).sum()
}

/// The convex hull of points of a plane, in order around it: Andrew's monotone chain.
pub fn hull(points: &[Vector3], normal: Vector3) -> Vec<Vector3> {
    let Some(&origin) = points.first() else { return Vec::new() };
    let (across, up) = plane_axes(normal);
    let mut flat: Vec<(Vector2, u32)> =
        points.iter().zip(0..).map(|(p, k)| (flattened(p - origin, across, up), k)).collect();
    flat.sort_by(|(a, _), (b, _)| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = (Vector2, u32)>| {
        let mut hull: Vec<(Vector2, u32)> = Vec::new();
        for (point, k) in points {
            while let [.., (a, _), (b, _)] = hull[..]
                && cross(b - a, point - a) <= 0.0
            {
                hull.pop();
            }
            hull.push((point, k));
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut flat.iter().copied());
    hull.extend(chain(&mut flat.iter().rev().copied()));
    hull.into_iter().map(|(_, k)| points[k as usize]).collect()
}

/// The closed curves in which a plane cuts those of the triangles whose numbers are given; a curve that leaves them, where they
/// end, is left out.
pub fn loops(
    positions: &[Vector3],
    triangles: &[[u32; 3]],
    among: impl Iterator<Item = u32>,
    origin: Vector3,
    normal: Vector3,
) -> Vec<Loop> {
    let height = |v: u32| (positions[v as usize] - origin).dot(&normal);
    // Each crossed side of a crossed triangle, by its edge.
    let mut crossings: Vec<([u32; 2], u32)> = Vec::new();
    for t in among {
        let [a, b, c] = triangles[t as usize];
        let above = [height(a) >= 0.0, height(b) >= 0.0, height(c) >= 0.0];
        for (k, [p, q]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
            if above[k] != above[(k + 1) % 3] {
                crossings.push(([p.min(q), p.max(q)], t));
            }
        }
    }
    crossings.sort_unstable();
    let mut by_triangle: Vec<(u32, u32)> = crossings.iter().zip(0..).map(|(&(_, t), place)| (t, place)).collect();
    by_triangle.sort_unstable();
    let point = |place: usize| {
        let [a, b] = crossings[place].0;
        let (from, to) = (height(a), height(b));
        positions[a as usize] + (positions[b as usize] - positions[a as usize]) * (from / (from - to))
    };
    // The same edge, seen from the triangle on its other side.
    let twin = |place: usize| {
        let edge = crossings[place].0;
        [place.wrapping_sub(1), place + 1].into_iter().find(|&p| crossings.get(p).is_some_and(|c| c.0 == edge))
    };
    let other_side = |place: usize| {
        let triangle = crossings[place].1;
        let first = by_triangle.partition_point(|entry| entry.0 < triangle);
        let [one, other] = [by_triangle[first].1 as usize, by_triangle[first + 1].1 as usize];
        if one == place { other } else { one }
    };
    let mut seen = vec![false; crossings.len()];
    let mut loops = Vec::new();
    for start in 0..crossings.len() {
        let (mut points, mut along) = (Vec::new(), Vec::new());
        let mut place = start;
        let mut closed = true;
        while !seen[place] {
            seen[place] = true;
            points.push(point(place));
            along.push(crossings[place].1);
            let leaving = other_side(place);
            seen[leaving] = true;
            match twin(leaving) {
                Some(next) => place = next,
                None => {
                    closed = false;
                    break;
                }
            }
        }
        if closed && place == start && points.len() > 2 {
            loops.push(Loop { points, triangles: along, normal });
        }
    }
    loops
}

impl Body {
    /// The closed curves in which the plane through `origin` with the unit `normal` cuts the body.
    pub fn section(&self, origin: Vector3, normal: Vector3) -> Vec<Loop> {
        loops(&self.positions, &self.triangles, 0..self.triangles.len() as u32, origin, normal)
    }

    /// The girth of that part of the body, cut by the plane through `near` with the unit `normal`, whose middle is nearest to
    /// `near`; `None` where the plane misses the body.
    pub fn girth(&self, near: Vector3, normal: Vector3) -> Option<Girth> {
        let girths = self.section(near, normal).into_iter().map(|l| l.girth());
        girths.min_by(|a, b| (a.center - near).norm_squared().total_cmp(&(b.center - near).norm_squared()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    #[test]
    fn a_ball_has_round_sections() {
        let ball = shapes::ball();
        let center = Vector3::new(0.0, 0.5, 0.0);
        for normal in [Vector3::y(), Vector3::x(), Vector3::new(0.3, 0.5, -0.4).normalize()] {
            let girth = ball.girth(center + normal * 0.3, normal).unwrap();
            let circle = std::f64::consts::TAU * 0.4;
            assert!((girth.tape / circle - 1.0).abs() < 2e-3, "{}", girth.tape);
            // A circle is its own hull; sums in another order differ in their last digits.
            assert!(girth.along_skin > (1.0 - 1e-12) * girth.tape && girth.along_skin < 1.001 * girth.tape);
            assert!((girth.center - (center + normal * 0.3)).norm() < 1e-3);
            assert_eq!(ball.section(center, normal).len(), 1);
        }
        assert!(ball.girth(center + Vector3::y(), Vector3::y()).is_none());
    }

    #[test]
    fn a_tape_spans_hollows_and_planes_through_vertices_are_no_special_case() {
        // A prism over a plus sign of five unit squares, cut at the height of its vertices as well as between.
        let plus = [[1, 0], [2, 0], [2, 1], [3, 1], [3, 2], [2, 2], [2, 3], [1, 3], [1, 2], [0, 2], [0, 1], [1, 1]];
        let mut positions: Vec<Vector3> = Vec::new();
        for y in [0.0, 1.0, 2.0] {
            positions.extend(plus.map(|[x, z]| Vector3::new(f64::from(x), y, -f64::from(z))));
        }
        let mut triangles = Vec::new();
        for ring in 0..2u32 {
            for k in 0..12u32 {
                let [a, b] = [12 * ring + k, 12 * ring + (k + 1) % 12];
                triangles.extend([[a, b, b + 12], [a, b + 12, a + 12]]);
            }
        }
        for height in [0.5, 1.0, 1.7] {
            let found =
                loops(&positions, &triangles, 0..triangles.len() as u32, Vector3::new(0.0, height, 0.0), Vector3::y());
            assert_eq!(found.len(), 1);
            let girth = found[0].girth();
            assert!((girth.along_skin - 12.0).abs() < 1e-12);
            assert!((girth.tape - (4.0 + 4.0 * 2f64.sqrt())).abs() < 1e-12);
            assert!((found[0].area() - 5.0).abs() < 1e-12);
            assert!((girth.center - Vector3::new(1.5, height, -1.5)).norm() < 1e-12);
        }
    }
}
