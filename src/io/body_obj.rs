//! Body meshes from OBJ.
//!
//! Only `v` and `f` lines matter to a body. They are read here rather than by a general loader:
//! such a loader cuts a mesh into parts wherever its group or its appearance changes, and gives each
//! part vertices of its own, so that a closed body comes out full of cracks; and it cannot tell on
//! which line the file is wrong.

use crate::body::Body;
use crate::geometry::Vector3;
use crate::{Error, Warning};

/// More vertices than any body scan worth dressing.
const MOST_VERTICES: usize = 5_000_000;
/// A closed mesh has twice as many triangles as vertices.
const MOST_TRIANGLES: usize = 2 * MOST_VERTICES;

/// Reads a body from the text of an OBJ file: all its objects together, polygons cut into triangles.
pub fn parse(bytes: &[u8]) -> Result<(Body, Vec<Warning>), Error> {
    if bytes.iter().all(|b| b.is_ascii_whitespace()) {
        return Err(Error::new("The body file is empty.", "Give an OBJ file with a closed triangle mesh of the body."));
    }
    let mut mesh = Mesh::default();
    // Names may be in any encoding; numbers are ASCII.
    for (line, number) in bytes.split(|&b| b == b'\n').zip(1u32..) {
        mesh.read(&String::from_utf8_lossy(line)).map_err(|e| e.within(format!("line {number}")))?;
        mesh.lines.resize(mesh.triangles.len(), number);
    }
    mesh.check_indices()?;
    mesh.drop_unused();
    Body::new(mesh.positions, mesh.triangles)
}

#[derive(Default)]
struct Mesh {
    positions: Vec<Vector3>,
    triangles: Vec<[u32; 3]>,
    /// The line of each triangle, counted from 1.
    lines: Vec<u32>,
}

impl Mesh {
    fn read(&mut self, line: &str) -> Result<(), Error> {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => self.read_vertex(words),
            Some("f") => self.read_face(words),
            _ => Ok(()),
        }
    }

    fn read_vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Result<(), Error> {
        let mut position = Vector3::zeros();
        for coordinate in position.iter_mut() {
            let word = words.next().unwrap_or("nothing");
            *coordinate = word.parse().ok().filter(|c: &f64| c.is_finite()).ok_or_else(|| {
                Error::new(
                    format!("A vertex has {word} where a coordinate should be."),
                    "Write vertices as \"v x y z\" with plain numbers; export the body again.",
                )
            })?;
        }
        if self.positions.len() == MOST_VERTICES {
            return Err(Error::new(
                format!("The body has more than {MOST_VERTICES} vertices."),
                "Reduce it in the program that made it; 10,000 to 50,000 vertices are plenty.",
            ));
        }
        self.positions.push(position);
        Ok(())
    }

    fn read_face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), Error> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<u32>, Error>>()?;
        let [first, rest @ ..] = corners.as_slice() else { return Ok(()) };
        // A corner that is listed twice makes a triangle without area, which is left out.
        let fan = rest.windows(2).map(|w| [*first, w[0], w[1]]);
        self.triangles.extend(fan.filter(|&[a, b, c]| a != b && b != c && c != a));
        if self.triangles.len() > MOST_TRIANGLES {
            return Err(Error::new(
                format!("The body has more than {MOST_TRIANGLES} triangles."),
                "Reduce it in the program that made it; 20,000 to 100,000 triangles are plenty.",
            ));
        }
        Ok(())
    }

    /// The vertex of a corner such as `7`, `7/2/5` or `-1`, which is the last one so far.
    fn corner(&self, word: &str) -> Result<u32, Error> {
        let index = word.split('/').next().and_then(|w| w.parse::<i64>().ok());
        let from_zero = match index {
            Some(index) if index > 0 => Some(index - 1),
            Some(index) if index < 0 => index.checked_add(self.positions.len() as i64),
            _ => None,
        };
        from_zero.and_then(|index| u32::try_from(index).ok()).ok_or_else(|| {
            Error::new(
                format!("A face has the corner \"{word}\", which names no vertex."),
                "Vertices are counted from 1, or from -1 backwards; export the body again.",
            )
        })
    }

    /// Faces may stand before their vertices, so that this can be known only at the end.
    fn check_indices(&self) -> Result<(), Error> {
        let count = self.positions.len();
        for (triangle, line) in self.triangles.iter().zip(&self.lines) {
            if let Some(missing) = triangle.iter().find(|&&v| v as usize >= count) {
                return Err(Error::new(
                    format!("A face names vertex {}, which does not exist.", u64::from(*missing) + 1),
                    format!("The file has {count} vertices, counted from 1; export the body again."),
                )
                .within(format!("line {line}")));
            }
        }
        Ok(())
    }

    /// Vertices of no triangle (markers of joints, left-overs) are no part of the body.
    fn drop_unused(&mut self) {
        let mut number = vec![u32::MAX; self.positions.len()];
        for &v in self.triangles.iter().flatten() {
            number[v as usize] = 0;
        }
        for (number, kept) in number.iter_mut().filter(|n| **n == 0).zip(0..) {
            *number = kept;
        }
        let mut numbers = number.iter();
        self.positions.retain(|_| numbers.next() != Some(&u32::MAX));
        self.triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
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
