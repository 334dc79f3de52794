//! What there is to see: surfaces, a floor, a light; and the one mesh that the renderer makes of them.

use nalgebra::{Point3, Vector3};

use super::color::Color;

/// A triangle mesh and its colors, borrowed.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// One per vertex, m, world (y up). A vertex that is not finite, or farther than a thousand kilometres from the
    /// origin, is left out together with its triangles and lines.
    pub positions: &'a [Point3<f64>],
    /// Vertex indices, counter-clockwise seen from the right side of the fabric (outside). A triangle that names a
    /// vertex that does not exist is left out.
    pub triangles: &'a [[u32; 3]],
    /// Linear-light albedo.
    pub coloring: Coloring<'a>,
    /// Pairs of vertices to be joined by thin dark lines, for seams.
    pub lines: &'a [[u32; 2]],
}

/// Where the color of a surface comes from. A slice that is too short is completed with [`MISSING_COLOR`].
#[derive(Clone, Copy, Debug)]
pub enum Coloring<'a> {
    /// One color for all.
    Constant(Color),
    /// One per triangle.
    PerTriangle(&'a [Color]),
    /// One per vertex, interpolated between.
    PerVertex(&'a [Color]),
}

/// Shown where a color is missing: a magenta that nobody takes for intended.
pub const MISSING_COLOR: Color = Color::new(0.6, 0.0, 0.6);

impl Coloring<'_> {
    /// The colors at the three corners of a triangle.
    fn corners(&self, triangle_index: usize, triangle: [u32; 3]) -> [Color; 3] {
        let pick = |colors: &[Color], index: usize| {
            let color = colors.get(index).copied().unwrap_or(MISSING_COLOR);
            color.map(|channel| if channel.is_finite() { channel.clamp(0.0, 1.0) } else { 0.0 })
        };
        match *self {
            Self::Constant(color) => [pick(&[color], 0); 3],
            Self::PerTriangle(colors) => [pick(colors, triangle_index); 3],
            Self::PerVertex(colors) => triangle.map(|vertex| pick(colors, vertex as usize)),
        }
    }
}

/// How a scene is lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// A key light from the viewer's upper left and a softer sky: shows form and folds.
    #[default]
    Studio,
    /// Mostly sky, little shadow: keeps colors that carry a meaning readable.
    Even,
}

/// Everything to be rendered.
#[derive(Clone, Debug, Default)]
pub struct Scene<'a> {
    pub surfaces: Vec<Surface<'a>>,
    /// Height of the floor, m, which receives a soft contact shadow; none without.
    pub floor: Option<f64>,
    pub lighting: Lighting,
}

/// Largest coordinate that is drawn, m: beyond it the single precision of the renderer means nothing.
const REACH: f64 = 1.0e6;

/// All surfaces of a scene as one mesh of valid triangles, in metres around [`Mesh::origin`].
///
/// Single precision resolves a tenth of a micrometre at the size of a body, far below a pixel.
#[derive(Clone, Debug, Default)]
pub(super) struct Mesh {
    /// World position of the mesh's own zero: middle of the bounding box, m.
    pub(super) origin: Point3<f64>,
    /// Radius of a sphere around the origin that holds every vertex, m; positive also when there is none.
    pub(super) radius: f32,
    /// One per vertex of all surfaces in turn, m, around the origin.
    pub(super) positions: Vec<Vector3<f32>>,
    /// One per vertex, unit length or zero where no triangle has an area.
    pub(super) normals: Vec<Vector3<f32>>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Three per triangle, linear albedo.
    pub(super) corner_colors: Vec<[Color; 3]>,
    pub(super) lines: Vec<[u32; 2]>,
    /// One per line, linear albedo of the fabric around it.
    pub(super) line_colors: Vec<Color>,
}

impl Mesh {
    pub(super) fn new(surfaces: &[Surface]) -> Self {
        let (origin, radius) = bounding_sphere(surfaces);
        let mut mesh = Self { origin, radius, ..Self::default() };
        for surface in surfaces {
            mesh.append(surface);
        }
        mesh.normals = vertex_normals(&mesh.positions, &mesh.triangles);
        mesh
    }

    fn append(&mut self, surface: &Surface) {
        let base = self.positions.len() as u32;
        let drawable = |vertex: u32| surface.positions.get(vertex as usize).is_some_and(is_drawable);
        let place = |position: &Point3<f64>| {
            if is_drawable(position) { (position - self.origin).cast() } else { Vector3::zeros() }
        };
        let positions: Vec<_> = surface.positions.iter().map(place).collect();
        self.positions.extend(positions);

        let mut vertex_colors = vec![MISSING_COLOR; surface.positions.len()];
        for (index, &triangle) in surface.triangles.iter().enumerate() {
            if triangle.iter().all(|&vertex| drawable(vertex)) {
                let colors = surface.coloring.corners(index, triangle);
                self.triangles.push(triangle.map(|vertex| base + vertex));
                self.corner_colors.push(colors);
                for (vertex, color) in triangle.into_iter().zip(colors) {
                    vertex_colors[vertex as usize] = color;
                }
            }
        }
        for &line in surface.lines {
            if line.iter().all(|&vertex| drawable(vertex)) {
                self.lines.push(line.map(|vertex| base + vertex));
                self.line_colors.push(vertex_colors[line[0] as usize]);
            }
        }
    }

    /// Unit normal of a triangle by its winding; zero when it has no area.
    pub(super) fn face_normal(&self, [a, b, c]: [u32; 3]) -> Vector3<f32> {
        let [a, b, c] = [a, b, c].map(|vertex| self.positions[vertex as usize]);
        unit_or_zero((b - a).cross(&(c - a)))
    }
}

pub(super) fn is_drawable(position: &Point3<f64>) -> bool {
    position.iter().all(|x| x.abs() <= REACH)
}

/// The vector at unit length, or zero when it has no direction.
pub(super) fn unit_or_zero(vector: Vector3<f32>) -> Vector3<f32> {
    vector.try_normalize(f32::MIN_POSITIVE).unwrap_or_else(Vector3::zeros)
}

/// Center of the bounding box of all drawable vertices, and a radius that reaches every one of them.
fn bounding_sphere(surfaces: &[Surface]) -> (Point3<f64>, f32) {
    let vertices = || surfaces.iter().flat_map(|surface| surface.positions).filter(|p| is_drawable(p));
    let Some(&first) = vertices().next() else {
        return (Point3::origin(), 1.0);
    };
    let (low, high) = vertices().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let center = nalgebra::center(&low, &high);
    let radius = vertices().map(|p| (p - center).norm()).fold(0.0, f64::max);
    (center, radius.max(SMALLEST_RADIUS) as f32)
}

/// A scene is treated as at least this large, m, so that a single point gives finite scales.
const SMALLEST_RADIUS: f64 = 1.0e-3;

/// Smooth vertex normals: face normals weighted by the sine of the corner's angle over the lengths of its two edges,
/// which is exact on spheres and does not lean towards the side with more triangles (N. Max, "Weights for computing
/// vertex normals from facet normals", Journal of Graphics Tools 4(2), 1999).
fn vertex_normals(positions: &[Vector3<f32>], triangles: &[[u32; 3]]) -> Vec<Vector3<f32>> {
    let mut normals = vec![Vector3::zeros(); positions.len()];
    for triangle in triangles {
        let corners = triangle.map(|vertex| positions[vertex as usize]);
        for i in 0..3 {
            let left = corners[(i + 1) % 3] - corners[i];
            let right = corners[(i + 2) % 3] - corners[i];
            let weight = left.norm_squared() * right.norm_squared();
            if weight > f32::MIN_POSITIVE {
                normals[triangle[i] as usize] += left.cross(&right) / weight;
            }
        }
    }
    normals.into_iter().map(unit_or_zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface<'a>(positions: &'a [Point3<f64>], triangles: &'a [[u32; 3]]) -> Surface<'a> {
        Surface {
            positions,
            triangles,
            coloring: Coloring::Constant(Color::new(0.5, 0.5, 0.5)),
            lines: &[[0, 1], [0, 9]],
        }
    }

    #[test]
    fn bad_vertices_take_their_triangles_and_lines_with_them() {
        let positions = [
            Point3::new(0.0, 0.0, 0.0),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
            Point3::new(f64::NAN, 1.0, 0.0),
            Point3::new(1e300, 1.0, 0.0),
        ];
        let triangles = [[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 5]];
        let mesh = Mesh::new(&[surface(&positions, &triangles)]);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.lines, [[0, 1]]);
        assert_eq!(mesh.origin, Point3::new(0.5, 0.5, 0.0));
        assert!(mesh.normals.iter().all(|n| n.iter().all(|x| x.is_finite())));
    }

    #[test]
    fn normals_of_a_sphere_point_outward() {
        let (positions, triangles) = octahedron();
        let mesh = Mesh::new(&[surface(&positions, &triangles)]);
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((position - normal).norm() < 1e-5);
        }
    }

    fn octahedron() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let positions = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]
            .map(|[x, y, z]| Point3::new(f64::from(x), f64::from(y), f64::from(z)))
            .to_vec();
        let triangles = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
        (positions, triangles)
    }

    #[test]
    fn missing_colors_are_seen_and_numbers_out_of_range_are_not() {
        let positions = [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
        let wild = [Color::new(f32::NAN, 7.0, -1.0)];
        let surface = Surface { coloring: Coloring::PerVertex(&wild), ..surface(&positions, &[[0, 1, 2]]) };
        let mesh = Mesh::new(&[surface]);
        assert_eq!(mesh.corner_colors, [[Color::new(0.0, 1.0, 0.0), MISSING_COLOR, MISSING_COLOR]]);
    }
}
