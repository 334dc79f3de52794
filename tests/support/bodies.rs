//! Small bodies, made here.

use std::fmt::Write;

/// A mesh of vertices, m, and polygons that count them from 0.
#[derive(Clone, Default)]
pub struct Mesh {
    pub vertices: Vec<[f64; 3]>,
    pub faces: Vec<Vec<usize>>,
}

impl Mesh {
    /// A ball of quads with triangles at its poles, facing outwards.
    pub fn ball(center: [f64; 3], radius: f64, rings: usize) -> Self {
        let columns = 2 * rings;
        let mut mesh = Self::default();
        for ring in 1..rings {
            let (r, y) = (std::f64::consts::PI * ring as f64 / rings as f64).sin_cos();
            for column in 0..columns {
                let (x, z) = (std::f64::consts::TAU * column as f64 / columns as f64).sin_cos();
                mesh.vertices.push([center[0] + radius * r * x, center[1] + radius * y, center[2] + radius * r * z]);
            }
        }
        let (top, bottom) = (mesh.vertices.len(), mesh.vertices.len() + 1);
        mesh.vertices.push([center[0], center[1] + radius, center[2]]);
        mesh.vertices.push([center[0], center[1] - radius, center[2]]);
        let at = |ring: usize, column: usize| ring * columns + column % columns;
        for column in 0..columns {
            mesh.faces.push(vec![top, at(0, column), at(0, column + 1)]);
            mesh.faces.push(vec![bottom, at(rings - 2, column + 1), at(rings - 2, column)]);
            for ring in 0..rings - 2 {
                let (above, below) = (at(ring, column), at(ring + 1, column));
                mesh.faces.push(vec![above, below, at(ring + 1, column + 1), at(ring, column + 1)]);
            }
        }
        mesh
    }

    /// What a profile of `[radius, y]`, from below upwards, sweeps when it is turned around y; both ends are closed.
    pub fn turned(profile: &[[f64; 2]], columns: usize) -> Self {
        let mut mesh = Self::default();
        for [radius, y] in profile {
            for column in 0..columns {
                let (x, z) = (std::f64::consts::TAU * column as f64 / columns as f64).sin_cos();
                mesh.vertices.push([radius * x, *y, radius * z]);
            }
        }
        let at = |ring: usize, column: usize| ring * columns + column % columns;
        let (bottom, top) = (mesh.vertices.len(), mesh.vertices.len() + 1);
        mesh.vertices.extend([[0.0, profile[0][1], 0.0], [0.0, profile[profile.len() - 1][1], 0.0]]);
        for column in 0..columns {
            mesh.faces.push(vec![bottom, at(0, column + 1), at(0, column)]);
            mesh.faces.push(vec![top, at(profile.len() - 1, column), at(profile.len() - 1, column + 1)]);
            for ring in 0..profile.len() - 1 {
                let (low, high) = (at(ring, column), at(ring + 1, column));
                mesh.faces.push(vec![low, at(ring, column + 1), at(ring + 1, column + 1), high]);
            }
        }
        mesh
    }

    /// Two legs and a trunk, 1.75 m tall, as three balls that overlap a little.
    pub fn figure() -> Self {
        let mut mesh = Self::default();
        for (center, radius) in [([0.0, 1.15, 0.0], 0.6), ([0.2, 0.3, 0.0], 0.3), ([-0.2, 0.3, 0.0], 0.3)] {
            let part = Self::ball(center, radius, 8);
            let offset = mesh.vertices.len();
            mesh.vertices.extend(part.vertices);
            mesh.faces.extend(part.faces.iter().map(|f| f.iter().map(|v| v + offset).collect()));
        }
        mesh
    }

    /// A box of 1.2 by 0.4 by 1 m whose top slopes down towards +x by `angle`, rad.
    pub fn incline(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let corner = |k: usize| [[-0.6, 0.6][k & 1], [-0.2, 0.2][k >> 1 & 1], [-0.5, 0.5][k >> 2 & 1]];
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Self { vertices: (0..8).map(corner).collect(), faces: faces.map(Vec::from).into() }
            .mapped(|[x, y, z]| [cos * x + sin * y, cos * y - sin * x + 0.6, z])
    }

    /// A block of 1.2 by 0.8 by 1 m with a groove along its top.
    pub fn groove() -> Self {
        let profile = [[0.0, 0.3], [-0.6, 0.8], [-0.6, 0.0], [0.6, 0.0], [0.6, 0.7]];
        let vertices = [0.5, -0.5].iter().flat_map(|&z| profile.map(|[x, y]| [x, y, z])).collect();
        let mut faces = vec![vec![0, 1, 2, 3, 4], vec![5, 9, 8, 7, 6]];
        faces.extend((0..5).map(|k| vec![(k + 1) % 5, k, k + 5, (k + 1) % 5 + 5]));
        Self { vertices, faces }
    }

    pub fn body(&self) -> toile::body::Body {
        toile::io::body_obj::parse(self.obj().as_bytes()).unwrap().0
    }

    pub fn mapped(mut self, map: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        self.vertices.iter_mut().for_each(|v| *v = map(*v));
        self
    }

    pub fn obj(&self) -> String {
        let mut text = "# made by a test\no body\n".to_owned();
        for [x, y, z] in &self.vertices {
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
        for face in &self.faces {
            text.push('f');
            face.iter().for_each(|v| write!(text, " {}", v + 1).unwrap());
            text.push('\n');
        }
        text
    }
}
