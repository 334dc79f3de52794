//! Body meshes from OBJ, read with [`tobj`].
//!
//! What tobj cannot do for a body is done on the way to it, line by line: numbers and indices are
//! checked, so that a message can name the line that is wrong; and only vertices and the corners of
//! faces are handed on, because tobj cuts a mesh into parts wherever its group or its material
//! changes, each with vertices of its own, and a closed body would come out full of cracks.

use crate::body::Body;
use crate::geometry::Vector3;
use crate::{Error, Warning};
use std::fmt::Write;

/// More vertices than any body scan worth dressing.
const MOST_VERTICES: usize = 5_000_000;
/// A closed mesh has twice as many triangles as vertices.
const MOST_TRIANGLES: usize = 2 * MOST_VERTICES;

/// Reads a body from the text of an OBJ file: all its objects together, polygons cut into triangles.
pub fn parse(bytes: &[u8]) -> Result<(Body, Vec<Warning>), Error> {
    let (positions, triangles) = mesh(bytes)?;
    Body::new(positions, triangles)
}

/// Positions, m, and triangles of an OBJ file, which need not be those of a body.
pub fn mesh(bytes: &[u8]) -> Result<(Vec<Vector3>, Vec<[u32; 3]>), Error> {
    mesh_of(&checked(bytes)?.text)
}

/// The same with every vertex in its place in the file, used or not: what vertex caches count on, and what tobj does not keep.
pub fn mesh_in_file_order(bytes: &[u8]) -> Result<(Vec<Vector3>, Vec<[u32; 3]>), Error> {
    let checked = checked(bytes)?;
    let (mut positions, mut triangles) = (Vec::with_capacity(checked.vertices), Vec::with_capacity(checked.triangles));
    // The lines have been checked: what does not parse cannot be there.
    for line in checked.text.lines() {
        let mut words = line.split(' ');
        if words.next() == Some("v") {
            let mut coordinate = || words.next().and_then(|w| w.parse().ok()).unwrap_or(f64::NAN);
            positions.push(Vector3::new(coordinate(), coordinate(), coordinate()));
        } else {
            let corners: Vec<u32> = words.filter_map(|w| w.parse().ok()).map(|v: u32| v - 1).collect();
            let fan = corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]);
            triangles.extend(fan.filter(|&[a, b, c]| a != b && b != c && c != a));
        }
    }
    Ok((positions, triangles))
}

fn checked(bytes: &[u8]) -> Result<CheckedLines, Error> {
    if bytes.iter().all(|b| b.is_ascii_whitespace()) {
        return Err(Error::new("The body file is empty.", "Give an OBJ file with a closed triangle mesh of the body."));
    }
    let mut lines = CheckedLines::default();
    // Names may be in any encoding; numbers are ASCII.
    for (line, number) in bytes.split(|&b| b == b'\n').zip(1u32..) {
        lines.read(&String::from_utf8_lossy(line), number).map_err(|e| e.within(format!("line {number}")))?;
    }
    lines.check_indices()?;
    Ok(lines)
}

/// A mesh as an OBJ file; reading it gives the same numbers.
pub fn write(positions: &[Vector3], triangles: &[[u32; 3]]) -> String {
    let mut text = String::with_capacity(64 * positions.len() + 24 * triangles.len());
    text.push_str("# metres, y up, facing +z\n");
    // Writing to a string cannot fail.
    for p in positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

/// Positions, m, and triangles of checked lines.
fn mesh_of(text: &str) -> Result<(Vec<Vector3>, Vec<[u32; 3]>), Error> {
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials).map_err(|e| {
        Error::new(format!("The body file cannot be read ({e})."), "Export the body again as a triangle mesh in OBJ.")
    })?;
    let Some(mesh) = models.into_iter().next().map(|model| model.mesh) else { return Ok(Default::default()) };
    let positions = mesh.positions.as_chunks().0.iter().copied().map(Vector3::from).collect();
    // A corner that is listed twice makes a triangle without area, which is left out.
    let distinct = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    Ok((positions, mesh.indices.as_chunks().0.iter().copied().filter(distinct).collect()))
}

/// The vertices and faces of a file, checked.
#[derive(Default)]
struct CheckedLines {
    /// `v` and `f` lines alone, corners without their texture and normal.
    text: String,
    vertices: usize,
    triangles: usize,
    /// The largest vertex that a face names, counted from 1, and the line of that face.
    largest: (u64, u32),
}

impl CheckedLines {
    fn read(&mut self, line: &str, number: u32) -> Result<(), Error> {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => self.read_vertex(words),
            Some("f") => self.read_face(words, number),
            _ => Ok(()),
        }
    }

    fn read_vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Result<(), Error> {
        self.text.push('v');
        for _ in 0..3 {
            let word = words.next().unwrap_or("nothing");
            if !word.parse().is_ok_and(|c: f64| c.is_finite()) {
                return Err(Error::new(
                    format!("A vertex has {word} where a coordinate should be."),
                    "Write vertices as \"v x y z\" with plain numbers; export the body again.",
                ));
            }
            self.text.push(' ');
            self.text.push_str(word);
        }
        self.text.push('\n');
        self.vertices += 1;
        if self.vertices > MOST_VERTICES {
            return Err(Error::new(
                format!("The body has more than {MOST_VERTICES} vertices."),
                "Reduce it in the program that made it; 10,000 to 50,000 vertices are plenty.",
            ));
        }
        Ok(())
    }

    fn read_face<'a>(&mut self, words: impl Iterator<Item = &'a str>, line: u32) -> Result<(), Error> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<u64>, Error>>()?;
        if corners.len() < 3 {
            return Ok(());
        }
        self.text.push('f');
        for corner in &corners {
            // Writing to a string cannot fail.
            let _ = write!(self.text, " {corner}");
            if *corner > self.largest.0 {
                self.largest = (*corner, line);
            }
        }
        self.text.push('\n');
        self.triangles += corners.len() - 2;
        if self.triangles > MOST_TRIANGLES {
            return Err(Error::new(
                format!("The body has more than {MOST_TRIANGLES} triangles."),
                "Reduce it in the program that made it; 20,000 to 100,000 triangles are plenty.",
            ));
        }
        Ok(())
    }

    /// The vertex, counted from 1, of a corner such as `7`, `7/2/5` or `-1`, which is the last one so far.
    fn corner(&self, word: &str) -> Result<u64, Error> {
        let index = word.split('/').next().and_then(|w| w.parse::<i64>().ok());
        let from_one = match index {
            Some(index) if index > 0 => u64::try_from(index).ok(),
            Some(index) if index < 0 => {
                index.checked_add(self.vertices as i64 + 1).and_then(|i| u64::try_from(i).ok()).filter(|&i| i > 0)
            }
            _ => None,
        };
        from_one.ok_or_else(|| {
            Error::new(
                format!("A face has the corner \"{word}\", which names no vertex."),
                "Vertices are counted from 1, or from -1 backwards; export the body again.",
            )
        })
    }

    /// Faces may stand before their vertices, so that this can be known only at the end.
    fn check_indices(&self) -> Result<(), Error> {
        let (largest, line) = self.largest;
        if largest <= self.vertices as u64 {
            return Ok(());
        }
        let error = Error::new(
            format!("A face names vertex {largest}, which does not exist."),
            format!("The file has {} vertices, counted from 1; export the body again.", self.vertices),
        );
        Err(error.within(format!("line {line}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of one metre; its sides are `faces`.
    fn cube(faces: &str) -> String {
        let corner = |k: usize| format!("v {} {} {}\n", k & 1, k >> 1 & 1, k >> 2 & 1);
        (0..8).map(corner).collect::<String>() + faces
    }

    const FACES: &str = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

    #[test]
    fn a_body_in_groups_stays_in_one_piece() {
        let grouped = FACES.replace("f 3", "g top\nusemtl red\nf 3");
        let (body, _) = parse(cube(&grouped).as_bytes()).unwrap();
        assert_eq!((body.positions().len(), body.triangles().len()), (8, 12));
    }

    #[test]
    fn corners_may_count_backwards_and_carry_textures() {
        let (body, _) = parse(cube("f 1/1/1 3/2/1 4/3/1 2/4/1\nf -4//2 -3//2 -1//2 -2//2\nf 1 2 6 5\nf 3 7 8 4\nf 1/1 5/2 7/3 3/4\nf 2 4 8 6 6").as_bytes()).unwrap();
        assert_eq!(body.triangles().len(), 12);
    }

    #[test]
    fn vertices_of_no_triangle_are_no_part_of_the_body() {
        let marked = cube(FACES).replace("f ", "v 0 99 0\nf ");
        let (body, _) = parse(marked.as_bytes()).unwrap();
        assert_eq!(body.positions().len(), 8);
    }
}
