//! Spatial order: neighbours on the cloth are neighbours in memory.

use crate::geometry::Vector2;

/// Bits of each coordinate in a Morton code: cells of a ten-thousandth of a panel.
const BITS: u32 = 16;

/// The order that sorts `points` along a Morton curve: `order[new] = old`.
pub fn morton_order(points: &[Vector2]) -> Vec<u32> {
    let low = points.iter().fold(Vector2::repeat(f64::INFINITY), |a, p| a.inf(p));
    let high = points.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
    let scale = f64::from((1u32 << BITS) - 1) / (high - low).max().max(f64::MIN_POSITIVE);
    let code = |p: &Vector2| {
        let cell = (p - low) * scale;
        spread(cell.x as u32) | (spread(cell.y as u32) << 1)
    };
    let codes: Vec<u64> = points.iter().map(code).collect();
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by_key(|&i| (codes[i as usize], i));
    order
}

/// Puts a zero between the bits.
fn spread(value: u32) -> u64 {
    let mut v = u64::from(value);
    v = (v | (v << 16)) & 0x0000_ffff_0000_ffff;
    v = (v | (v << 8)) & 0x00ff_00ff_00ff_00ff;
    v = (v | (v << 4)) & 0x0f0f_0f0f_0f0f_0f0f;
    v = (v | (v << 2)) & 0x3333_3333_3333_3333;
    (v | (v << 1)) & 0x5555_5555_5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_visited_in_z_order() {
        let grid: Vec<Vector2> = (0..4).map(|i| Vector2::new((i % 2) as f64, (i / 2) as f64)).collect();
        assert_eq!(morton_order(&grid), [0, 1, 2, 3]);
        assert_eq!(spread(0b1011), 0b1000101);
    }
}
