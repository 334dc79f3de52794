//! Stanford PLY, binary, little-endian: the sewn garment, and its panels flat.

use crate::garment::Level;
use crate::geometry::Vector3;
use std::fmt::Write;

/// The sewn garment: particles as vertices in their order, m, y up, f64; the panel of each triangle.
pub fn write_garment(level: &Level, positions: &[Vector3]) -> Vec<u8> {
    let mut header = header();
    let _ = writeln!(header, "comment the sewn garment; positions in metres, y up, the body facing +z");
    element(&mut header, "vertex", positions.len(), &["double x", "double y", "double z"]);
    element(&mut header, "face", level.triangles.len(), &["list uchar int vertex_indices", "int panel"]);
    let mut file = ended(header);
    file.extend(positions.iter().flatten().flat_map(|x| x.to_le_bytes()));
    faces(&mut file, level, |triangle| level.particles(triangle));
    file
}

/// The panels flat, each in its own frame with z = 0: points as vertices in their order, m, f64, and the particle of each.
pub fn write_rest(level: &Level) -> Vec<u8> {
    let mut header = header();
    let _ = writeln!(header, "comment the panels flat, each in its own frame; positions in metres");
    let _ = writeln!(header, "comment particle: the vertex of the sewn garment that the vertex is");
    element(&mut header, "vertex", level.rest.len(), &["double x", "double y", "double z", "int particle"]);
    element(&mut header, "face", level.triangles.len(), &["list uchar int vertex_indices", "int panel"]);
    let mut file = ended(header);
    for (rest, particle) in level.rest.iter().zip(&level.particle_of) {
        file.extend([rest.x, rest.y, 0.0].into_iter().flat_map(f64::to_le_bytes));
        file.extend(particle.to_le_bytes());
    }
    faces(&mut file, level, |triangle| level.triangles[triangle]);
    file
}

fn header() -> String {
    format!("ply\nformat binary_little_endian 1.0\ncomment by toile {}\n", env!("CARGO_PKG_VERSION"))
}

fn element(header: &mut String, name: &str, count: usize, properties: &[&str]) {
    // Writing to a string cannot fail.
    let _ = writeln!(header, "element {name} {count}");
    for property in properties {
        let _ = writeln!(header, "property {property}");
    }
}

fn ended(header: String) -> Vec<u8> {
    let mut file = header.into_bytes();
    file.extend(b"end_header\n");
    file
}

fn faces(file: &mut Vec<u8>, level: &Level, corners: impl Fn(usize) -> [u32; 3]) {
    for (triangle, panel) in level.panel_of_triangle().into_iter().enumerate() {
        file.push(3);
        file.extend(corners(triangle).into_iter().flat_map(u32::to_le_bytes));
        file.extend(panel.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::sample::two_panels;

    /// Header lines and what follows.
    fn parts(file: &[u8]) -> (Vec<&str>, &[u8]) {
        let end = file.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        (str::from_utf8(&file[..end]).unwrap().lines().collect(), &file[end..])
    }

    fn number(bytes: &[u8]) -> f64 {
        f64::from_le_bytes(bytes[..8].try_into().unwrap())
    }

    fn integer(bytes: &[u8]) -> u32 {
        u32::from_le_bytes(bytes[..4].try_into().unwrap())
    }

    #[test]
    fn the_sewn_garment_reads_back_by_its_header() {
        let (_, garment, positions) = two_panels();
        let level = &garment.levels[1];
        let file = write_garment(level, &positions);
        let (header, data) = parts(&file);
        assert!(header.contains(&format!("element vertex {}", positions.len()).as_str()));
        assert!(header.contains(&format!("element face {}", level.triangles.len()).as_str()));
        assert_eq!(data.len(), 24 * positions.len() + 17 * level.triangles.len());
        for (k, p) in positions.iter().enumerate() {
            assert_eq!(p.as_slice(), [0, 8, 16].map(|at| number(&data[24 * k + at..])));
        }
        for (t, panel) in level.panel_of_triangle().into_iter().enumerate() {
            let face = &data[24 * positions.len() + 17 * t..];
            assert_eq!((face[0], [1, 5, 9].map(|at| integer(&face[at..]))), (3, level.particles(t)));
            assert_eq!(integer(&face[13..]), panel);
        }
    }

    #[test]
    fn every_flat_vertex_knows_its_sewn_one() {
        let (_, garment, _) = two_panels();
        let level = &garment.levels[1];
        let file = write_rest(level);
        let (_, data) = parts(&file);
        for (k, (rest, particle)) in level.rest.iter().zip(&level.particle_of).enumerate() {
            let vertex = &data[28 * k..];
            assert_eq!([0, 8, 16].map(|at| number(&vertex[at..])), [rest.x, rest.y, 0.0]);
            assert_eq!(integer(&vertex[24..]), *particle);
        }
    }
}
