//! Distances along the skin.
//!
//! Fronts run over the triangles like fire over grass (R. Kimmel, J. A. Sethian, "Computing geodesic paths on manifolds", PNAS 95,
//! 1998); a front enters a triangle as from a point source unfolded into its plane (M. Novotni, R. Klein, "Computing geodesic
//! distances on triangular meshes", WSCG 2002). Distances along edges alone would be longer by up to a tenth, and not by the same
//! on both sides of a body.

use crate::geometry::Vector3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Which triangles each vertex belongs to.
pub struct Fans {
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl Fans {
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut first = vec![0u32; vertex_count + 1];
        triangles.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
        (0..vertex_count).for_each(|v| first[v + 1] += first[v]);
        let mut place = first.clone();
        let mut around = vec![0; 3 * triangles.len()];
        for (t, corners) in (0..).zip(triangles) {
            for &v in corners {
                around[place[v as usize] as usize] = t;
                place[v as usize] += 1;
            }
        }
        Self { first, triangles: around }
    }

    /// The triangles around a vertex.
    pub fn of(&self, vertex: u32) -> &[u32] {
        let v = vertex as usize;
        &self.triangles[self.first[v] as usize..self.first[v + 1] as usize]
    }
}

/// For each vertex the distance along the skin from the nearest of the `sources`, m; infinite where there is no way.
pub fn distances(positions: &[Vector3], triangles: &[[u32; 3]], fans: &Fans, sources: &[u32]) -> Vec<f64> {
    let mut distances = vec![f64::INFINITY; positions.len()];
    let mut done = vec![false; positions.len()];
    // Distances are not negative, so that their bits have their order.
    let mut front = BinaryHeap::new();
    for &source in sources {
        distances[source as usize] = 0.0;
        front.push(Reverse((0.0f64.to_bits(), source)));
    }
    while let Some(Reverse((_, vertex))) = front.pop() {
        if std::mem::replace(&mut done[vertex as usize], true) {
            continue;
        }
        for &t in fans.of(vertex) {
            let corners = triangles[t as usize];
            for k in 0..3 {
                let [a, b, c] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
                if c == vertex || done[c as usize] {
                    continue;
                }
                let at = |v: u32| positions[v as usize];
                let known = |v: u32| if done[v as usize] { distances[v as usize] } else { f64::INFINITY };
                let through = across([at(a), at(b), at(c)], [known(a), known(b)]);
                if through < distances[c as usize] {
                    distances[c as usize] = through;
                    front.push(Reverse((through.to_bits(), c)));
                }
            }
        }
    }
    distances
}

/// The distance of the third corner of a triangle by way of the side of the other two, whose distances are known.
fn across([a, b, c]: [Vector3; 3], [to_a, to_b]: [f64; 2]) -> f64 {
    let along_edges = (to_a + (c - a).norm()).min(to_b + (c - b).norm());
    let side = (b - a).norm();
    if !(to_a.is_finite() && to_b.is_finite() && side > 0.0) {
        return along_edges;
    }
    // In the plane of the triangle: a at the origin, b at (side, 0), c above, the source below.
    let x = (to_a * to_a - to_b * to_b + side * side) / (2.0 * side);
    let depth_squared = to_a * to_a - x * x;
    if depth_squared <= 0.0 {
        return along_edges;
    }
    let depth = depth_squared.sqrt();
    let c_x = (c - a).dot(&(b - a)) / side;
    let c_y = ((c - a).norm_squared() - c_x * c_x).max(0.0).sqrt();
    // Where the straight way crosses the side.
    let crossing = x + (c_x - x) * depth / (depth + c_y);
    if (0.0..=side).contains(&crossing) { (c_x - x).hypot(c_y + depth) } else { along_edges }
}

#[cfg(test)]
mod tests {
    use super::super::super::shapes;
    use super::*;

    #[test]
    fn distances_on_a_ball_are_those_along_great_circles() {
        let ball = shapes::ball();
        let fans = Fans::new(ball.positions().len(), ball.triangles());
        let center = Vector3::new(0.0, 0.5, 0.0);
        for source in [0u32, 777, 2000] {
            let found = distances(ball.positions(), ball.triangles(), &fans, &[source]);
            let from = ball.positions()[source as usize] - center;
            for (p, d) in ball.positions().iter().zip(&found) {
                let exact = 0.5 * from.angle(&(p - center));
                // Fronts are measured from one side of a triangle each: three hundredths around the poles, one elsewhere.
                assert!((d - exact).abs() < 0.03 * exact + 0.003, "{d} instead of {exact}");
            }
        }
    }
}
