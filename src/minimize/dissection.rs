//! Nested dissection: an order of elimination that keeps factors of mesh matrices sparse.
//!
//! A set of points is cut in two where few neighbours are parted, both halves are ordered first and
//! the separator last, recursively (George 1973). The cut is geometric: at the median along the
//! axis in which the points extend farthest.

use super::block_matrix::Pattern;
use crate::geometry::Vector3;

/// Sets of at most so many points are not cut again: dense elimination is as good there.
const SMALLEST_CUT: usize = 48;

/// The points in the order in which they are to be eliminated. `places` are where they lie in space, or on
/// a flat drawing of the mesh.
pub fn nested_dissection(pattern: &Pattern, places: &[Vector3]) -> Vec<u32> {
    let mut order = Vec::with_capacity(pattern.rows());
    let mut side = vec![0u8; pattern.rows()];
    let all = (0..pattern.rows() as u32).collect();
    dissect(pattern, places, all, &mut side, &mut order);
    order
}

fn dissect(pattern: &Pattern, places: &[Vector3], mut set: Vec<u32>, side: &mut [u8], order: &mut Vec<u32>) {
    if set.len() <= SMALLEST_CUT {
        order.extend(set);
        return;
    }
    let at = |p: u32| places[p as usize];
    let low = set.iter().fold(Vector3::repeat(f64::INFINITY), |low, &p| low.inf(&at(p)));
    let high = set.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |high, &p| high.sup(&at(p)));
    let axis = (high - low).imax();
    let middle = set.len() / 2;
    // Ties are cut by index, so that the order is the same every time.
    set.select_nth_unstable_by(middle, |&p, &q| at(p)[axis].total_cmp(&at(q)[axis]).then(p.cmp(&q)));
    const FIRST: u8 = 1;
    const SECOND: u8 = 2;
    set[..middle].iter().for_each(|&p| side[p as usize] = FIRST);
    set[middle..].iter().for_each(|&p| side[p as usize] = SECOND);
    // What has a neighbour in the second half separates.
    let parts = |&p: &u32| pattern.row(p as usize).iter().any(|&q| side[q as usize] == SECOND);
    let (mut separator, mut first): (Vec<u32>, Vec<u32>) = set[..middle].iter().partition(|p| parts(p));
    let mut second = set[middle..].to_vec();
    set.iter().for_each(|&p| side[p as usize] = 0);
    for part in [&mut separator, &mut first, &mut second] {
        part.sort_unstable();
    }
    drop(set);
    dissect(pattern, places, first, side, order);
    dissect(pattern, places, second, side, order);
    order.extend(separator);
}
