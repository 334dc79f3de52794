//! Which pixels and samples a triangle covers.
//!
//! Corners are snapped to a fixed-point grid and tested with exact integer edge functions (J. Pineda, "A parallel
//! algorithm for polygon rasterization", SIGGRAPH 1988) and the top-left rule, so two triangles that share an edge
//! leave no gap between them and never both claim a sample, whatever the order and the number of threads.

/// Fixed-point units in a pixel. A 256th is finer than the eye and than the sixteen samples of a pixel.
const UNITS: i64 = 256;

/// Farthest place that is rasterized, pixels from the corner of the picture. Keeps products in 64 bits: two factors
/// of 2²⁹ units, and a sum of two.
const FARTHEST: f64 = (1 << 20) as f64;

/// A corner of a triangle on the fixed-point grid of a picture or map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Units from the left and from the top.
    units: [i64; 2],
    /// Anything that is linear over the picture.
    pub depth: f64,
}

impl Corner {
    /// A corner that cannot be drawn; nor can any triangle that has it.
    pub const OUTSIDE: Self = Self { units: [i64::MIN; 2], depth: 0.0 };

    /// The corner at a place, pixels; [`Corner::OUTSIDE`] if that is too far away or not a number.
    pub fn new(x: f64, y: f64, depth: f64) -> Self {
        // A NaN fails both comparisons.
        let is_near = x.abs() <= FARTHEST && y.abs() <= FARTHEST;
        if !is_near {
            return Self::OUTSIDE;
        }
        let units = [x, y].map(|pixels| (pixels * UNITS as f64).round() as i64);
        Self { units, depth }
    }

    pub fn is_outside(&self) -> bool {
        self.units == Self::OUTSIDE.units
    }

    /// Pixels from the left and from the top, as snapped.
    pub fn pixels(&self) -> [f64; 2] {
        self.units.map(|units| units as f64 / UNITS as f64)
    }
}

/// Samples in a pixel.
pub const SAMPLES: usize = 16;

/// The samples of a pixel, units from its upper left corner: a sheared 4 × 4 grid, which has sixteen different rows
/// and sixteen different columns, so that nearly level and nearly upright edges get all sixteen shades.
const SAMPLE_OFFSETS: [[i64; 2]; SAMPLES] = {
    let mut offsets = [[0; 2]; SAMPLES];
    let step = UNITS / SAMPLES as i64;
    let mut k = 0;
    while k < SAMPLES {
        let (i, j) = (k as i64 % 4, k as i64 / 4);
        offsets[k] = [step * (4 * i + j) + step / 2, step * (4 * j + i) + step / 2];
        k += 1;
    }
    offsets
};

/// Where a sample lies in its pixel, pixels from the upper left corner.
pub fn sample_offset(sample: usize) -> [f64; 2] {
    SAMPLE_OFFSETS[sample].map(|units| units as f64 / UNITS as f64)
}

/// Pixels `x0..x1` × `y0..y1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    pub x0: i64,
    pub y0: i64,
    pub x1: i64,
    pub y1: i64,
}

impl Rect {
    /// Number of pixels.
    pub fn area(self) -> i64 {
        (self.x1 - self.x0).max(0) * (self.y1 - self.y0).max(0)
    }

    pub fn intersection(self, other: Self) -> Self {
        Self {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }
}

/// How often triangles may cover a whole picture or map. A dressed body covers one two or three times; a garment that
/// has exploded, each triangle across the whole picture, would keep the rasterizer busy for an hour.
const MOST_COVERINGS: i64 = 100;

/// The work that may still be spent on a picture or map, pixels.
pub struct Budget(i64);

impl Budget {
    pub fn new(picture: Rect) -> Self {
        Self(MOST_COVERINGS * picture.area().max(1))
    }

    /// Takes the work for an area from what is left; false when there is none.
    pub fn spend(&mut self, area: Rect) -> bool {
        self.0 -= area.area();
        self.0 >= 0
    }
}

/// A triangle on the grid, ready to be asked for the pixels it covers.
pub struct Coverage {
    /// Edge functions `a x + b y + c`, x and y in units; a sample is covered when all three are at least zero.
    edges: [[i64; 3]; 3],
    /// Pixels that may be covered.
    pub bounds: Rect,
    /// Depth value of the corners as a plane over the picture: at the corner of the bounds, per pixel right, per
    /// pixel down.
    plane: [f64; 3],
}

impl Coverage {
    /// For asking about samples. None for a triangle without area or with a corner [`Corner::OUTSIDE`].
    pub fn of_samples(corners: &[Corner; 3]) -> Option<Self> {
        Self::new(corners, |low, high| [low.div_euclid(UNITS), high.div_euclid(UNITS) + 1])
    }

    /// For asking about the middles of pixels. None also for a triangle that is too small to cover any, which in a
    /// coarse map most are.
    pub fn of_middles(corners: &[Corner; 3]) -> Option<Self> {
        let half = UNITS / 2;
        Self::new(corners, |low, high| [(low + half - 1).div_euclid(UNITS), (high + half).div_euclid(UNITS)])
    }

    /// `range` gives the first pixel and the one after the last for the lowest and highest unit.
    fn new(corners: &[Corner; 3], range: impl Fn(i64, i64) -> [i64; 2]) -> Option<Self> {
        if corners.iter().any(Corner::is_outside) {
            return None;
        }
        let bounds = bounds(corners, range);
        if bounds.x0 >= bounds.x1 || bounds.y0 >= bounds.y1 {
            return None;
        }
        let double_area = double_area(corners.each_ref().map(|corner| corner.units));
        if double_area == 0 {
            return None;
        }
        let [a, mut b, mut c] = *corners;
        if double_area < 0 {
            (b, c) = (c, b);
        }
        Some(Self {
            edges: [edge(a.units, b.units), edge(b.units, c.units), edge(c.units, a.units)],
            bounds,
            plane: plane([a, b, c], double_area.abs(), bounds),
        })
    }

    /// The depth value at a place, pixels.
    pub fn depth(&self, x: f64, y: f64) -> f64 {
        let [at_corner, right, down] = self.plane;
        at_corner + right * (x - self.bounds.x0 as f64) + down * (y - self.bounds.y0 as f64)
    }

    /// Calls `visit(x, y)` for every pixel within `clip` whose middle is covered.
    pub fn for_each_pixel(&self, clip: Rect, mut visit: impl FnMut(i64, i64)) {
        let area = self.bounds.intersection(clip);
        for y in area.y0..area.y1 {
            let mut at = self.edges_at(area.x0 * UNITS + UNITS / 2, y * UNITS + UNITS / 2);
            for x in area.x0..area.x1 {
                if at[0] | at[1] | at[2] >= 0 {
                    visit(x, y);
                }
                for (value, edge) in at.iter_mut().zip(&self.edges) {
                    *value += edge[0] * UNITS;
                }
            }
        }
    }

    /// Calls `visit(x, y, mask)` for every pixel within `clip` that has a covered sample; bit k of the mask is
    /// sample k.
    pub fn for_each_sample_mask(&self, clip: Rect, mut visit: impl FnMut(i64, i64, u16)) {
        let area = self.bounds.intersection(clip);
        let [first, second, third]: [[i64; SAMPLES]; 3] =
            self.edges.map(|[a, b, _]| SAMPLE_OFFSETS.map(|[x, y]| a * x + b * y));
        for y in area.y0..area.y1 {
            let mut at = self.edges_at(area.x0 * UNITS, y * UNITS);
            for x in area.x0..area.x1 {
                let mut mask = 0;
                for (sample, ((a, b), c)) in first.iter().zip(&second).zip(&third).enumerate() {
                    let signs = (at[0] + a) | (at[1] + b) | (at[2] + c);
                    mask |= u16::from(signs >= 0) << sample;
                }
                if mask != 0 {
                    visit(x, y, mask);
                }
                for (value, edge) in at.iter_mut().zip(&self.edges) {
                    *value += edge[0] * UNITS;
                }
            }
        }
    }

    fn edges_at(&self, x: i64, y: i64) -> [i64; 3] {
        self.edges.map(|[a, b, c]| a * x + b * y + c)
    }
}

/// Twice the area, positive when the corners run clockwise as seen on the screen, where y points down.
fn double_area([p, q, r]: [[i64; 2]; 3]) -> i64 {
    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
}

/// The edge function of the directed edge from `p` to `q`, inside at the right hand on the screen. Samples exactly on
/// an edge belong to it only if it is a top edge or a left edge: the others are moved inward by one.
fn edge(p: [i64; 2], q: [i64; 2]) -> [i64; 3] {
    let [a, b] = [p[1] - q[1], q[0] - p[0]];
    let is_top_or_left = a > 0 || (a == 0 && b > 0);
    [a, b, -(a * p[0] + b * p[1]) - i64::from(!is_top_or_left)]
}

fn bounds(corners: &[Corner; 3], range: impl Fn(i64, i64) -> [i64; 2]) -> Rect {
    let along = |axis: usize| {
        let [a, b, c] = corners.each_ref().map(|corner| corner.units[axis]);
        range(a.min(b).min(c), a.max(b).max(c))
    };
    let [[x0, x1], [y0, y1]] = [along(0), along(1)];
    Rect { x0, y0, x1, y1 }
}

/// The plane through the three corners' depth values, see [`Coverage::plane`].
fn plane(corners: [Corner; 3], double_area: i64, bounds: Rect) -> [f64; 3] {
    let [p, q, r] = corners.each_ref().map(Corner::pixels);
    let [depth, dq, dr] = [corners[0].depth, corners[1].depth - corners[0].depth, corners[2].depth - corners[0].depth];
    let scale = (UNITS * UNITS) as f64 / double_area as f64;
    let right = (dq * (r[1] - p[1]) - dr * (q[1] - p[1])) * scale;
    let down = (dr * (q[0] - p[0]) - dq * (r[0] - p[0])) * scale;
    let at_corner = depth + right * (bounds.x0 as f64 - p[0]) + down * (bounds.y0 as f64 - p[1]);
    [at_corner, right, down]
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLIP: Rect = Rect { x0: 0, y0: 0, x1: 12, y1: 12 };

    fn corners(places: [[f64; 2]; 3]) -> [Corner; 3] {
        [0, 1, 2].map(|i| Corner::new(places[i][0], places[i][1], i as f64 + 1.0))
    }

    #[test]
    fn a_fan_around_a_point_covers_every_sample_exactly_once() {
        let rim = [[0.0, 0.0], [4.3, 0.0], [12.0, 0.0], [12.0, 5.5], [12.0, 12.0], [3.0, 12.0], [0.0, 12.0]];
        let middle = [5.03, 6.5];
        let mut counts = [[0; SAMPLES]; 144];
        for i in 0..rim.len() {
            // Every other triangle is wound the other way round.
            let mut triangle = [middle, rim[i], rim[(i + 1) % rim.len()]];
            if i % 2 == 0 {
                triangle.swap(0, 1);
            }
            Coverage::of_samples(&corners(triangle)).unwrap().for_each_sample_mask(CLIP, |x, y, mask| {
                for (sample, count) in counts[(y * 12 + x) as usize].iter_mut().enumerate() {
                    *count += mask >> sample & 1;
                }
            });
        }
        assert!(counts.iter().flatten().all(|&count| count == 1));
    }

    #[test]
    fn pixels_and_depths_of_a_known_triangle() {
        let triangle = Coverage::of_middles(&corners([[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]])).unwrap();
        let mut pixels = Vec::new();
        triangle.for_each_pixel(CLIP, |x, y| pixels.push([x, y]));
        // The middles of the diagonal pixels lie on the hypotenuse, which is neither a top nor a left edge.
        assert_eq!(pixels, [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [0, 2]]);
        assert_eq!(triangle.depth(0.0, 0.0), 1.0);
        assert_eq!(triangle.depth(4.0, 0.0), 2.0);
        assert_eq!(triangle.depth(0.0, 4.0), 3.0);
    }

    #[test]
    fn triangles_without_area_or_out_of_reach_are_left_out() {
        let is_left_out = |places| Coverage::of_samples(&corners(places)).is_none();
        assert!(is_left_out([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]));
        assert!(is_left_out([[1.0, 1.0], [1.0, 1.0], [1.0, 1.0]]));
        assert!(is_left_out([[f64::NAN, 1.0], [9.0, 1.0], [1.0, 8.0]]));
        assert!(is_left_out([[1.0e30, 1.0], [9.0, 1.0], [1.0, 8.0]]));
        let between_middles = corners([[1.6, 1.0], [2.4, 1.0], [2.0, 3.0]]);
        assert!(Coverage::of_middles(&between_middles).is_none());
        assert!(Coverage::of_samples(&between_middles).is_some());
    }

    #[test]
    fn samples_have_sixteen_rows_and_columns() {
        for axis in 0..2 {
            let mut places: Vec<i64> = SAMPLE_OFFSETS.iter().map(|offset| offset[axis]).collect();
            places.sort_unstable();
            places.dedup();
            assert_eq!(places.len(), SAMPLES);
        }
    }
}
