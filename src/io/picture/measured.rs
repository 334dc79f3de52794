//! What was measured on a body: curves around it and points on it.

use super::color::{Color, color_from_srgb};
use super::preview::preview;
use super::subject::{BodyView, GarmentView};
use crate::geometry::Vector3;
use nalgebra::Point3;

/// Half the width of a curve, m: thick enough to be seen at three figures to a picture.
const CURVE_RADIUS: f64 = 0.0025;
/// Half the size of a point, m.
const POINT_RADIUS: f64 = 0.011;
/// Sections: dark blue. Girths that have a name: red. Points: orange. sRGB.
const SECTION_COLOR: u32 = 0x2f4b6e;
const GIRTH_COLOR: u32 = 0xb8322a;
const POINT_COLOR: u32 = 0xe08a1e;

/// Closed curves and points to be seen on a body, m, world.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    pub sections: Vec<Vec<Vector3>>,
    pub girths: Vec<Vec<Vector3>>,
    pub points: Vec<Vector3>,
}

/// The body with its marks from the front, at three quarters and from the back, as a PNG file. Marks inside the body do not
/// show.
pub fn measured(marks: &Marks, body: &BodyView) -> Vec<u8> {
    let mut drawn = Drawn::default();
    for (curves, color) in [(&marks.sections, SECTION_COLOR), (&marks.girths, GIRTH_COLOR)] {
        let color = color_from_srgb(color);
        for curve in curves {
            for (a, b) in curve.iter().zip(curve.iter().cycle().skip(1)) {
                drawn.rod(*a, *b, color);
            }
        }
    }
    marks.points.iter().for_each(|p| drawn.bead(*p, color_from_srgb(POINT_COLOR)));
    let view = GarmentView {
        positions: &drawn.positions,
        triangles: &drawn.triangles,
        colors: &drawn.colors,
        ..GarmentView::default()
    };
    preview(&view, body)
}

#[derive(Default)]
struct Drawn {
    positions: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    colors: Vec<Color>,
}

impl Drawn {
    /// A prism of three sides from point to point.
    fn rod(&mut self, a: Vector3, b: Vector3, color: Color) {
        let Some(along) = (b - a).try_normalize(0.0) else { return };
        let helper = if along.y.abs() < 0.7 { Vector3::y() } else { Vector3::x() };
        let across = along.cross(&helper).normalize();
        let up = across.cross(&along);
        let first = self.positions.len() as u32;
        for end in [a, b] {
            for (x, y) in [(0.0, 1.0), (0.87, -0.5), (-0.87, -0.5)] {
                self.positions.push((end + (across * x + up * y) * CURVE_RADIUS).into());
            }
        }
        for k in 0..3 {
            let (i, j) = (first + k, first + (k + 1) % 3);
            self.face([i, i + 3, j + 3], color);
            self.face([i, j + 3, j], color);
        }
    }

    /// An octahedron.
    fn bead(&mut self, center: Vector3, color: Color) {
        let first = self.positions.len() as u32;
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            self.positions.push((center + axis * POINT_RADIUS).into());
            self.positions.push((center - axis * POINT_RADIUS).into());
        }
        for (x, y, z) in (0..8u32).map(|k| (k & 1, k >> 1 & 1, k >> 2)) {
            let corners = [first + x, first + 2 + y, first + 4 + z];
            let [a, b, c] = corners;
            self.face(if (x + y + z) % 2 == 0 { [a, b, c] } else { [a, c, b] }, color);
        }
    }

    fn face(&mut self, triangle: [u32; 3], color: Color) {
        self.triangles.push(triangle);
        self.colors.push(color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rods_and_beads_are_closed_where_they_should_be_and_face_outwards() {
        let mut bead = Drawn::default();
        bead.bead(Vector3::new(0.1, 0.2, 0.3), Color::zeros());
        let volume: f64 = bead
            .triangles
            .iter()
            .map(|t| t.map(|v| bead.positions[v as usize].coords))
            .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
            .sum();
        assert!((volume - 4.0 / 3.0 * POINT_RADIUS.powi(3)).abs() < 1e-12);
        let marks = Marks { points: vec![Vector3::zeros()], girths: vec![vec![Vector3::x(); 2]], ..Marks::default() };
        assert!(measured(&marks, &BodyView::default()).starts_with(b"\x89PNG"));
    }
}
