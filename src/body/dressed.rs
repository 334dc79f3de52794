//! A body that wears something: what is worn over it has to lie outside both.
//!
//! Cloth is a sheet, and a sheet has no inside. Closed over its openings (hem, cuffs, neckline) by caps it encloses a
//! volume, and the union of that with the body's is a body like any other: the skin below the cloth is hidden, as
//! is a cap where a limb passes through it. The caps are no cloth. They keep an outer garment from entering an inner one
//! while it is sewn, and count no longer when both are relaxed together.

use super::skin::Skin;
use super::validate::volume;
use super::{Body, BoxTree};
use crate::geometry::{EdgeTable, Vector3};
use std::collections::{BTreeMap, VecDeque};

/// Distance between the rings of a cap, m.
const CAP_SPACING: f64 = 0.05;

impl Body {
    /// The body with a garment on it, given by its particles, m, world, and its triangles.
    pub fn dressed(&self, positions: &[Vector3], triangles: &[[u32; 3]]) -> Body {
        let (mut all, mut mesh) = (self.positions.clone(), self.triangles.clone());
        let first = all.len() as u32;
        let closed = Closed::new(positions, triangles);
        all.extend(closed.positions);
        mesh.extend(closed.triangles.iter().map(|t| t.map(|p| p + first)));
        Body::unchecked(all, mesh)
    }

    fn unchecked(positions: Vec<Vector3>, triangles: Vec<[u32; 3]>) -> Body {
        let corners = triangles.iter().map(|t| t.map(|v| positions[v as usize]));
        let (tree, skin) = rayon::join(|| BoxTree::of_triangles(corners, 0.0), || Skin::new(&positions, &triangles));
        Self { positions, triangles, tree, skin }
    }
}

/// What a garment encloses.
pub struct Enclosure {
    body: Body,
    is_cap: Vec<bool>,
}

impl Enclosure {
    /// Of a garment's particles, m, world, and its triangles.
    pub fn new(positions: &[Vector3], triangles: &[[u32; 3]]) -> Self {
        let Closed { positions, triangles, is_cap } = Closed::new(positions, triangles);
        Self { body: Body::unchecked(positions, triangles), is_cap }
    }

    /// Is the point on the inside of the garment?
    pub fn contains(&self, point: Vector3) -> bool {
        self.body.contains(point)
    }

    /// The nearest point of the cloth within `reach`, m; none where a cap is nearer: who goes through an opening is
    /// neither outside nor inside.
    pub fn nearest_cloth(&self, point: Vector3, reach: f64) -> Option<Vector3> {
        let nearest = self.body.nearest(point, reach)?;
        (!self.is_cap[nearest.triangle as usize]).then_some(nearest.point)
    }
}

/// A sheet that was closed.
struct Closed {
    /// Those of the sheet, then those of the caps, m, world.
    positions: Vec<Vector3>,
    /// Counter-clockwise from outside.
    triangles: Vec<[u32; 3]>,
    /// One per triangle.
    is_cap: Vec<bool>,
}

impl Closed {
    fn new(positions: &[Vector3], triangles: &[[u32; 3]]) -> Self {
        let mut closed = Self { positions: positions.to_vec(), triangles: Vec::new(), is_cap: Vec::new() };
        for mut piece in pieces(triangles) {
            let cloth = piece.len();
            cap(&mut closed.positions, &mut piece);
            if volume(&closed.positions, &piece) < 0.0 {
                piece.iter_mut().for_each(|t| t.swap(1, 2));
            }
            closed.is_cap.extend((0..piece.len()).map(|k| k >= cloth));
            closed.triangles.extend(piece);
        }
        closed
    }
}

/// The connected pieces of a sheet, each turned to one side all over.
fn pieces(triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 3]>> {
    let mut beside = vec![Vec::new(); triangles.len()];
    for edge in EdgeTable::new(triangles).edges {
        // Where more than two meet nothing tells which of them go on into each other.
        if let [t, u] = *edge.triangles {
            beside[t as usize].push(u);
            beside[u as usize].push(t);
        }
    }
    let mut seen = vec![false; triangles.len()];
    let mut pieces = Vec::new();
    for start in 0..triangles.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut piece = Vec::new();
        let mut queue = VecDeque::from([(start as u32, triangles[start])]);
        while let Some((t, turned)) = queue.pop_front() {
            piece.push(turned);
            for &u in &beside[t as usize] {
                if !std::mem::replace(&mut seen[u as usize], true) {
                    let mut next = triangles[u as usize];
                    // Neighbours run through their common edge in opposite directions.
                    if sides(next).iter().any(|side| sides(turned).contains(side)) {
                        next.swap(1, 2);
                    }
                    queue.push_back((u, next));
                }
            }
        }
        pieces.push(piece);
    }
    pieces
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Closes the openings of a piece: every edge is then run through as often one way as the other.
fn cap(positions: &mut Vec<Vector3>, piece: &mut Vec<[u32; 3]>) {
    for rim in rims(piece) {
        let at = |p: &u32| positions[*p as usize];
        let middle = rim.iter().map(at).sum::<Vector3>() / rim.len() as f64;
        let reach = rim.iter().map(|p| (at(p) - middle).norm()).fold(0.0, f64::max);
        let rings = (reach / CAP_SPACING).ceil().max(1.0) as usize;
        let mut outer = rim;
        for ring in 1..rings {
            // Each ring is the one before it, drawn towards the middle.
            let share = 1.0 / (rings - ring + 1) as f64;
            let first = positions.len() as u32;
            let drawn: Vec<Vector3> = outer.iter().map(|&p| positions[p as usize].lerp(&middle, share)).collect();
            positions.extend(drawn);
            let inner: Vec<u32> = (first..positions.len() as u32).collect();
            for k in 0..outer.len() {
                let next = (k + 1) % outer.len();
                piece.push([outer[k], outer[next], inner[next]]);
                piece.push([outer[k], inner[next], inner[k]]);
            }
            outer = inner;
        }
        let tip = positions.len() as u32;
        positions.push(middle);
        (0..outer.len()).for_each(|k| piece.push([outer[k], outer[(k + 1) % outer.len()], tip]));
    }
}

/// Closed lines along all edges that are run through more often one way than the other, against that way.
fn rims(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut balance: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for [a, b] in triangles.iter().flat_map(|&t| sides(t)) {
        *balance.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
    }
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ([low, high], count) in balance {
        let (from, to) = if count > 0 { (high, low) } else { (low, high) };
        (0..count.abs()).for_each(|_| next.entry(from).or_default().push(to));
    }
    let mut rims = Vec::new();
    // As many lead to a particle as away from it: who walks on comes back.
    while let Some(start) = next.keys().next().copied() {
        let (mut rim, mut at) = (Vec::new(), start);
        while let Some(ways) = next.get_mut(&at) {
            rim.push(at);
            let to = ways.pop().expect("a particle without a way on is not kept");
            if ways.is_empty() {
                next.remove(&at);
            }
            at = to;
            if at == start {
                break;
            }
        }
        rims.push(rim);
    }
    rims
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shapes;

    /// A tube around the y axis, open above and below: positions and triangles, some of them turned.
    fn tube(radius: f64, low: f64, high: f64) -> (Vec<Vector3>, Vec<[u32; 3]>) {
        let (columns, rows) = (40u32, 12u32);
        let mut positions = Vec::new();
        for row in 0..=rows {
            for column in 0..columns {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(column) / f64::from(columns)).sin_cos();
                let y = low + (high - low) * f64::from(row) / f64::from(rows);
                positions.push(Vector3::new(radius * sin, y, radius * cos));
            }
        }
        let at = |row: u32, column: u32| row * columns + column % columns;
        let quad = |(row, column): (u32, u32)| {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            // Every other column is wound the other way, as panels may be.
            if column % 2 == 0 { [[a, b, d], [a, d, c]] } else { [[a, d, b], [a, c, d]] }
        };
        let triangles = (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))).flat_map(quad).collect();
        (positions, triangles)
    }

    #[test]
    fn a_ball_in_a_tube_is_a_drum_with_bulges() {
        // The ball has a radius of half a metre around (0, 0.5, 0).
        let ball = shapes::ball();
        let (positions, triangles) = tube(0.52, 0.2, 0.7);
        let dressed = ball.dressed(&positions, &triangles);
        assert!((volume(&dressed.positions, &dressed.triangles[ball.triangles.len()..]) - 0.421).abs() < 0.01);
        // Beside the tube, above the ball, and between them where the tube is open above.
        let distance = |x: f64, y: f64| dressed.signed_distance(Vector3::new(x, y, 0.0));
        assert!((distance(0.6, 0.5) - 0.08).abs() < 2e-3, "{}", distance(0.6, 0.5));
        assert!((distance(0.0, 1.1) - 0.1).abs() < 2e-3, "{}", distance(0.0, 1.1));
        assert!((distance(0.51, 0.71) - 0.01).abs() < 1e-3, "the cap is skin: {}", distance(0.51, 0.71));
        // Just inside the tube the body below it is no skin.
        assert!((distance(0.51, 0.5) + 0.01).abs() < 3e-3, "{}", distance(0.51, 0.5));
        assert!(distance(0.0, 0.5) < -0.4);
    }

    #[test]
    fn every_edge_of_a_dressed_body_is_run_through_as_often_one_way_as_the_other() {
        let (positions, mut triangles) = tube(0.52, 0.2, 0.7);
        // A flap that is sewn on: three triangles at one edge.
        let positions = [positions, vec![Vector3::new(0.6, 0.45, 0.1)]].concat();
        triangles.push([triangles[0][0], triangles[0][1], positions.len() as u32 - 1]);
        let dressed = shapes::ball().dressed(&positions, &triangles);
        assert!(rims(&dressed.triangles).is_empty());
    }
}
