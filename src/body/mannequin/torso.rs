//! Hips to neck: rows of seven points from the middle of the front, around the left side, to the middle of the back.
//!
//! ```text
//!        6             middle of the back, x = 0
//!      5
//!     4
//!     3                the side
//!     2
//!      1               tip of the bust
//!        0             middle of the front, x = 0
//! ```

use super::cage::Cage;
use super::grading::Grading;
use super::section::{Radii, superellipse};

/// Open ends of the half torso.
pub(super) struct Torso {
    /// Top of the neck, front to back.
    pub neck: [u32; 7],
    /// From the armpit, over front, shoulder point and back.
    pub armhole: [u32; 8],
    /// From the crotch, over front, side and back.
    pub leg_opening: [u32; 8],
}

/// A level section between hips and armpits. Lengths in m.
struct Section {
    height: f64,
    half_width: f64,
    /// z of its frontmost and backmost points.
    front: f64,
    back: f64,
    squareness: f64,
    /// Added to z, one per column: bust, seat, the hollow of the spine.
    relief: [f64; 7],
}

const SECTIONS: [Section; 6] = [
    Section {
        height: 0.880,
        half_width: 0.1745,
        front: 0.096,
        back: -0.127,
        squareness: 2.4,
        relief: [0.0, 0.0, 0.0, 0.0, 0.0, -0.012, 0.012],
    },
    Section {
        height: 0.975,
        half_width: 0.160,
        front: 0.101,
        back: -0.101,
        squareness: 2.4,
        relief: [0.0, 0.0, 0.0, 0.0, 0.0, -0.002, 0.003],
    },
    Section {
        height: 1.080,
        half_width: 0.1325,
        front: 0.0945,
        back: -0.0835,
        squareness: 2.35,
        relief: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.003],
    },
    Section {
        height: 1.165,
        half_width: 0.1375,
        front: 0.1025,
        back: -0.0925,
        squareness: 2.3,
        relief: [0.0, 0.010, 0.002, 0.0, 0.0, 0.0, 0.004],
    },
    Section {
        height: 1.240,
        half_width: 0.147,
        front: 0.110,
        back: -0.105,
        squareness: 2.4,
        relief: [0.005, 0.043, 0.015, 0.0, 0.0, 0.0, 0.005],
    },
    Section {
        height: 1.300,
        half_width: 0.148,
        front: 0.102,
        back: -0.108,
        squareness: 2.5,
        relief: [0.003, 0.012, 0.005, 0.0, 0.0, 0.0, 0.005],
    },
];

/// Lowers the side of the topmost section, which is the floor of the armhole, m.
const ARMPIT_DROP: f64 = 0.016;

/// From crotch over front (1 to 3), side (4) and back (5 to 7), m.
const LEG_OPENING: [[f64; 3]; 8] = [
    [0.0, 0.800, -0.004],
    [0.0, 0.822, 0.062],
    [0.082, 0.806, 0.085],
    [0.147, 0.818, 0.064],
    [0.1735, 0.826, -0.010],
    [0.151, 0.808, -0.084],
    [0.082, 0.796, -0.117],
    [0.0, 0.818, -0.078],
];

/// Rows above the armpits, m: middle of the armhole, shoulders, base of the neck, middle of the neck.
const UPPER_ROWS: [[[f64; 3]; 7]; 4] = [
    [
        [0.0, 1.348, 0.088],
        [0.080, 1.350, 0.086],
        [0.149, 1.350, 0.046],
        UNUSED,
        [0.152, 1.355, -0.076],
        [0.085, 1.365, -0.112],
        [0.0, 1.365, -0.106],
    ],
    [
        [0.0, 1.391, 0.065],
        [0.078, 1.402, 0.056],
        [0.152, 1.399, 0.031],
        [0.190, 1.410, -0.016],
        [0.156, 1.408, -0.063],
        [0.082, 1.422, -0.092],
        [0.0, 1.426, -0.093],
    ],
    [
        [0.0, 1.418, 0.047],
        [0.037, 1.420, 0.036],
        [0.062, 1.431, 0.011],
        [0.069, 1.446, -0.022],
        [0.056, 1.459, -0.055],
        [0.031, 1.468, -0.073],
        [0.0, 1.471, -0.078],
    ],
    [
        [0.0, 1.468, 0.041],
        [0.026, 1.470, 0.034],
        [0.045, 1.477, 0.014],
        [0.0505, 1.488, -0.012],
        [0.044, 1.499, -0.040],
        [0.025, 1.506, -0.056],
        [0.0, 1.508, -0.061],
    ],
];

/// The armhole has no point in its middle.
const UNUSED: [f64; 3] = [f64::NAN; 3];

/// Rows and columns whose quads are left out for the arm.
const ARMHOLE_ROWS: std::ops::Range<usize> = 6..8;
const ARMHOLE_COLUMNS: std::ops::Range<usize> = 2..4;

pub(super) fn build(cage: &mut Cage, grading: &Grading) -> Torso {
    let middle = 0.5 * (LEG_OPENING[1][2] + LEG_OPENING[7][2]);
    let leg_opening = LEG_OPENING.map(|point| cage.add(grading.torso_point(point, middle)));
    let mut rows: Vec<[u32; 7]> = vec![std::array::from_fn(|column| leg_opening[column + 1])];
    rows.extend(SECTIONS.iter().enumerate().map(|(i, section)| {
        let drop = if i + 1 == SECTIONS.len() { ARMPIT_DROP } else { 0.0 };
        std::array::from_fn(|column| cage.add(grading.torso_point(section.point(column, drop), section.middle())))
    }));
    rows.extend(UPPER_ROWS.iter().map(|row| add_row(cage, grading, row)));

    for row in 0..rows.len() - 1 {
        for column in 0..6 {
            if !(ARMHOLE_ROWS.contains(&row) && ARMHOLE_COLUMNS.contains(&column)) {
                let (below, above) = (&rows[row], &rows[row + 1]);
                cage.quads.push([below[column], below[column + 1], above[column + 1], above[column]]);
            }
        }
    }
    let (bottom, side, top) = (rows[6], rows[7], rows[8]);
    Torso {
        neck: rows[rows.len() - 1],
        armhole: [bottom[3], bottom[2], side[2], top[2], top[3], top[4], side[4], bottom[4]],
        leg_opening,
    }
}

/// Adds a row of given points; depths scale about its middle. [`UNUSED`] points get no vertex.
pub(super) fn add_row(cage: &mut Cage, grading: &Grading, row: &[[f64; 3]; 7]) -> [u32; 7] {
    let middle = 0.5 * (row[0][2] + row[6][2]);
    row.map(|point| if point[0].is_nan() { u32::MAX } else { cage.add(grading.torso_point(point, middle)) })
}

impl Section {
    fn middle(&self) -> f64 {
        0.5 * (self.front + self.back)
    }

    fn point(&self, column: usize, side_drop: f64) -> [f64; 3] {
        let depth = self.front - self.middle();
        let radii = Radii { outward: self.half_width, inward: self.half_width, front: depth, back: depth };
        let (x, z) = superellipse(radii, self.squareness, 90.0 - 30.0 * column as f64);
        let on_mirror_plane = column == 0 || column == 6;
        let drop = if column == 3 { side_drop } else { 0.0 };
        [if on_mirror_plane { 0.0 } else { x }, self.height - drop, self.middle() + z + self.relief[column]]
    }
}
