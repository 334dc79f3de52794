//! The tape measure: girths of a closed mesh.

use super::Mesh;
use crate::geometry::Vector3;

/// Length of a taut tape around the part of the body that `origin` lies in, in the plane through `origin`, m. Zero when
/// the plane misses the mesh.
///
/// The plane may cut several parts (both legs, torso and arms); the loop whose middle is nearest to `origin` counts.
pub fn girth(mesh: &Mesh, origin: &Vector3, normal: &Vector3) -> f64 {
    let (across, up) = plane_axes(normal);
    let curve = section(mesh, origin, normal);
    let flat = curve.iter().map(|p| [(p - origin).dot(&across), (p - origin).dot(&up)]).collect();
    perimeter(&convex_hull(flat))
}

/// The closed curve in which the plane cuts the part of the body that `origin` lies in, as its points in order, m. Empty
/// when the plane misses the mesh.
pub fn section(mesh: &Mesh, origin: &Vector3, normal: &Vector3) -> Vec<Vector3> {
    let squared_distance = |points: &[Vector3]| {
        let middle = points.iter().sum::<Vector3>() / points.len() as f64;
        (middle - origin).norm_squared()
    };
    let loops = loops(mesh, origin, normal).into_iter();
    loops.min_by(|a, b| squared_distance(a).total_cmp(&squared_distance(b))).unwrap_or_default()
}

/// Two unit vectors that span the plane.
fn plane_axes(normal: &Vector3) -> (Vector3, Vector3) {
    let helper = if normal.z.abs() < 0.5 { Vector3::z() } else { Vector3::x() };
    let across = normal.cross(&helper).normalize();
    (across, normal.cross(&across).normalize())
}

/// The closed curves in which a plane cuts the mesh, each as its points in order.
fn loops(mesh: &Mesh, origin: &Vector3, normal: &Vector3) -> Vec<Vec<Vector3>> {
    let heights: Vec<f64> = mesh.positions.iter().map(|p| (p - origin).dot(normal)).collect();
    let crosses = |a: u32, b: u32| (heights[a as usize] >= 0.0) != (heights[b as usize] >= 0.0);
    // Every crossed edge belongs to two crossed triangles, and every crossed triangle has two crossed edges.
    let mut crossings: Vec<((u32, u32), u32)> = Vec::new();
    for (index, t) in mesh.triangles.iter().enumerate() {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            if crosses(a, b) {
                crossings.push(((a.min(b), a.max(b)), index as u32));
            }
        }
    }
    crossings.sort_unstable();
    let mut by_triangle: Vec<(u32, usize)> =
        crossings.iter().enumerate().map(|(place, crossing)| (crossing.1, place)).collect();
    by_triangle.sort_unstable();
    let point = |place: usize| {
        let (a, b) = crossings[place].0;
        let (a, b) = (a as usize, b as usize);
        mesh.positions[a] + (mesh.positions[b] - mesh.positions[a]) * (heights[a] / (heights[a] - heights[b]))
    };
    let other_edge_of_triangle = |place: usize| {
        let triangle = crossings[place].1;
        let first = by_triangle.partition_point(|entry| entry.0 < triangle);
        if by_triangle[first].1 == place { by_triangle[first + 1].1 } else { by_triangle[first].1 }
    };
    let mut seen = vec![false; crossings.len()];
    let mut loops = Vec::new();
    for start in 0..crossings.len() {
        let mut curve = Vec::new();
        let mut place = start;
        while !seen[place] {
            let twin = place ^ 1; // the same edge, seen from its other triangle
            seen[place] = true;
            seen[twin] = true;
            curve.push(point(place));
            place = other_edge_of_triangle(twin);
        }
        if !curve.is_empty() {
            loops.push(curve);
        }
    }
    loops
}

/// Andrew's monotone chain, counter-clockwise.
fn convex_hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turns_left =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut hull: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while hull.len() >= 2 && !turns_left(hull[hull.len() - 2], hull[hull.len() - 1], point) {
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

fn perimeter(polygon: &[[f64; 2]]) -> f64 {
    let side = |i: usize| {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        (b[0] - a[0]).hypot(b[1] - a[1])
    };
    (0..polygon.len()).map(side).sum()
}
