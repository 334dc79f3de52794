//! The sewn garment as binary glTF 2.0 (GLB), for viewers and animation programs.
//!
//! One mesh, node and material for each panel. `POSITION` and `NORMAL` are f32, the normals smooth
//! over the whole welded garment, so that seams do not show as creases. `TEXCOORD_0` is the rest
//! coordinates in metres, *not* flipped: glTF lays the origin of a texture at its upper left, so a
//! picture drawn on a panel with y up has to be turned over by whoever applies it; in return the
//! figures are those of the pattern. The right side of the fabric is the front of each triangle.
//!
//! What has no place in the format is left out: panels without triangles, and numbers that are not
//! finite, which are written as 0. The exact garment is `garment.obj`.

use super::picture::color_from_srgb;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::pattern::Pattern;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Stride, Target, View};
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Accessor, Asset, Buffer, Index, Material, Mesh, Node, Root, Scene, Value};
use std::collections::BTreeMap;

/// Colors of the panels in turn, sRGB: muted like dyed cloth, neighbours in the list far apart.
const COLORS: [u32; 12] = [
    0x5b84b1, 0xd98e5f, 0x7ba37c, 0xc4698b, 0xd9bd62, 0x8a76b5, 0x58a6a6, 0xc7645c, 0x9bb05a, 0xb58bb8, 0x8c6f56,
    0x93a1ad,
];
/// Cloth is matt.
const ROUGHNESS: f32 = 0.85;

/// The bytes of the file. `positions` are the level's, one per particle, m, world.
pub fn write(pattern: &Pattern, level: &Level, positions: &[Vector3]) -> Vec<u8> {
    let normals = smooth_normals(level, positions);
    let mut streams = Streams::default();
    let mut root = Root {
        asset: Asset { generator: Some(format!("toile {}", env!("CARGO_PKG_VERSION"))), ..Asset::default() },
        ..Root::default()
    };
    for (index, (panel, range)) in pattern.panels.iter().zip(&level.panels).enumerate() {
        if range.triangles.is_empty() {
            continue;
        }
        let first = range.points.start as u32;
        let particles = || level.particle_of[range.points.clone()].iter().map(|&p| p as usize);
        let place = particles().map(|p| positions[p].map(narrow).into());
        let normal = particles().map(|p| normals[p].map(narrow).into());
        let rest = level.rest[range.points.clone()].iter().map(|r| r.map(narrow).into());
        let corners = level.triangles[range.triangles.clone()].iter().flatten().map(|&point| point - first);
        let attributes = BTreeMap::from([
            (Checked::Valid(Semantic::Positions), streams.positions(&mut root, place.collect())),
            (Checked::Valid(Semantic::Normals), streams.normals(&mut root, normal.collect())),
            (Checked::Valid(Semantic::TexCoords(0)), streams.rest(&mut root, rest.collect())),
        ]);
        let primitive = Primitive {
            attributes,
            indices: Some(streams.indices(&mut root, corners.collect())),
            material: Some(root.push(material(&panel.name, index))),
            mode: Checked::Valid(Mode::Triangles),
            extensions: None,
            extras: Default::default(),
            targets: None,
        };
        let name = Some(panel.name.clone());
        let mesh = Mesh {
            name: name.clone(),
            primitives: vec![primitive],
            extensions: None,
            extras: Default::default(),
            weights: None,
        };
        let mesh = Some(root.push(mesh));
        root.push(Node { name, mesh, ..Node::default() });
    }
    if !root.nodes.is_empty() {
        let nodes = (0..root.nodes.len() as u32).map(Index::new).collect();
        let name = Some(pattern.name.clone());
        root.scene = Some(root.push(Scene { name, nodes, extensions: None, extras: Default::default() }));
    }
    let data = streams.finish(&mut root);
    container(&root, data)
}

fn narrow(number: f64) -> f32 {
    let number = number as f32;
    if number.is_finite() { number } else { 0.0 }
}

/// Unit normals of the particles, each the mean of its triangles' by their angles, which does not
/// depend on how a flat part is cut into triangles (Thürmer and Wüthrich 1998).
fn smooth_normals(level: &Level, positions: &[Vector3]) -> Vec<Vector3> {
    let mut normals = vec![Vector3::zeros(); positions.len()];
    for t in 0..level.triangles.len() {
        let particles = level.particles(t).map(|p| p as usize);
        let corners = particles.map(|p| positions[p]);
        for k in 0..3 {
            let [a, b] = [1, 2].map(|next| corners[(k + next) % 3] - corners[k]);
            let normal = a.cross(&b);
            // Triangles without area, or without finite corners, have no say.
            if let Some(unit) = normal.try_normalize(0.0).filter(|n| n.iter().all(|x| x.is_finite())) {
                normals[particles[k]] += unit * normal.norm().atan2(a.dot(&b));
            }
        }
    }
    // A particle whose triangles cancel out, in a fold, has no normal; the format asks for some.
    normals.into_iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vector3::z)).collect()
}

fn material(name: &str, index: usize) -> Material {
    let color = color_from_srgb(COLORS[index % COLORS.len()]);
    // Each further turn through the list is darker.
    let shade = 0.75f32.powi((index / COLORS.len()) as i32);
    let [r, g, b] = [color.x * shade, color.y * shade, color.z * shade];
    Material {
        name: Some(name.to_owned()),
        double_sided: true,
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor([r, g, b, 1.0]),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(ROUGHNESS),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    }
}

/// The four views of the buffer while they grow, each of one kind of element.
#[derive(Default)]
struct Streams {
    bytes: [Vec<u8>; 4],
}

/// Sizes of the elements of the four views, bytes; all are multiples of four, as the format asks.
const STRIDES: [usize; 4] = [12, 12, 8, 4];

impl Streams {
    fn positions(&mut self, root: &mut Root, values: Vec<[f32; 3]>) -> Index<Accessor> {
        let low = values.iter().fold([f32::INFINITY; 3], |a, v| [0, 1, 2].map(|k| a[k].min(v[k])));
        let high = values.iter().fold([f32::NEG_INFINITY; 3], |a, v| [0, 1, 2].map(|k| a[k].max(v[k])));
        let accessor = self.push(root, 0, Type::Vec3, bytemuck::cast_slice::<_, f32>(&values));
        if let Some(accessor) = root.accessors.last_mut() {
            (accessor.min, accessor.max) = (Some(Value::from(low.to_vec())), Some(Value::from(high.to_vec())));
        }
        accessor
    }

    fn normals(&mut self, root: &mut Root, values: Vec<[f32; 3]>) -> Index<Accessor> {
        self.push(root, 1, Type::Vec3, bytemuck::cast_slice::<_, f32>(&values))
    }

    fn rest(&mut self, root: &mut Root, values: Vec<[f32; 2]>) -> Index<Accessor> {
        self.push(root, 2, Type::Vec2, bytemuck::cast_slice::<_, f32>(&values))
    }

    fn indices(&mut self, root: &mut Root, values: Vec<u32>) -> Index<Accessor> {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes());
        self.push_bytes(root, 3, Type::Scalar, ComponentType::U32, bytes)
    }

    fn push(&mut self, root: &mut Root, view: usize, kind: Type, values: &[f32]) -> Index<Accessor> {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes());
        self.push_bytes(root, view, kind, ComponentType::F32, bytes)
    }

    fn push_bytes(
        &mut self,
        root: &mut Root,
        view: usize,
        kind: Type,
        component: ComponentType,
        bytes: impl Iterator<Item = u8>,
    ) -> Index<Accessor> {
        let start = self.bytes[view].len();
        self.bytes[view].extend(bytes);
        root.push(Accessor {
            buffer_view: Some(Index::new(view as u32)),
            byte_offset: Some(USize64::from(start)),
            count: USize64::from((self.bytes[view].len() - start) / STRIDES[view]),
            component_type: Checked::Valid(GenericComponentType(component)),
            type_: Checked::Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: Default::default(),
        })
    }

    /// Names the views in `root` and lays them one after the other.
    fn finish(self, root: &mut Root) -> Vec<u8> {
        let length: usize = self.bytes.iter().map(Vec::len).sum();
        if length == 0 {
            return Vec::new();
        }
        let buffer = root.push(Buffer {
            byte_length: USize64::from(length),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        let mut data = Vec::with_capacity(length);
        for (bytes, stride) in self.bytes.into_iter().zip(STRIDES) {
            let indices = root.buffer_views.len() == 3;
            root.push(View {
                buffer,
                byte_length: USize64::from(bytes.len()),
                byte_offset: Some(USize64::from(data.len())),
                byte_stride: (!indices).then_some(Stride(stride)),
                name: None,
                target: Some(Checked::Valid(if indices { Target::ElementArrayBuffer } else { Target::ArrayBuffer })),
                extensions: None,
                extras: Default::default(),
            });
            data.extend(bytes);
        }
        data
    }
}

/// The binary container: a header, the JSON padded with spaces, the data padded with zeros.
fn container(root: &Root, mut data: Vec<u8>) -> Vec<u8> {
    let mut json = gltf_json::serialize::to_vec(root).expect("strings and finite numbers are JSON");
    json.resize(json.len().next_multiple_of(4), b' ');
    data.resize(data.len().next_multiple_of(4), 0);
    let chunks: &[(&[u8; 4], &[u8])] =
        if data.is_empty() { &[(b"JSON", &json)] } else { &[(b"JSON", &json), (b"BIN\0", &data)] };
    let length = 12 + chunks.iter().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
    let mut file = Vec::with_capacity(length);
    // Lengths of 4 GiB, a hundred million particles, do not fit the format nor any viewer.
    let word = |length: usize| u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes();
    file.extend(b"glTF");
    file.extend(2u32.to_le_bytes());
    file.extend(word(length));
    for (kind, bytes) in chunks {
        file.extend(word(bytes.len()));
        file.extend(*kind);
        file.extend(*bytes);
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::sample::two_panels;

    #[test]
    fn another_reader_finds_the_garment() {
        let (pattern, garment, positions) = two_panels();
        let level = &garment.levels[1];
        let file = write(&pattern, level, &positions);
        assert_eq!(file.len() % 4, 0);
        // Reading validates the document against the specification.
        let gltf = gltf::Gltf::from_slice(&file).unwrap();
        let blob = gltf.blob.as_deref().unwrap();
        assert_eq!(gltf.nodes().count(), 2);
        for (k, node) in gltf.nodes().enumerate() {
            let (panel, range) = (&pattern.panels[k], &level.panels[k]);
            assert_eq!(node.name(), Some(panel.name.as_str()));
            let primitive = node.mesh().unwrap().primitives().next().unwrap();
            assert!(primitive.material().double_sided());
            let reader = primitive.reader(|_| Some(blob));
            let read: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            let points: Vec<usize> = range.points.clone().collect();
            assert_eq!(read.len(), points.len());
            for (place, &point) in read.iter().zip(&points) {
                assert_eq!(*place, <[f32; 3]>::from(positions[level.particle_of[point] as usize].map(narrow)));
            }
            for (rest, &point) in reader.read_tex_coords(0).unwrap().into_f32().zip(&points) {
                assert_eq!(rest, <[f32; 2]>::from(level.rest[point].map(narrow)));
            }
            let outward = panel.outward_normal();
            for normal in reader.read_normals().unwrap() {
                assert!((Vector3::from(normal.map(f64::from)) - outward).norm() < 1e-6);
            }
            let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            assert_eq!(corners.len(), 3 * range.triangles.len());
            assert!(corners.iter().all(|&c| (c as usize) < points.len()));
            let bounds = primitive.bounding_box();
            assert!(read.iter().all(|p| (0..3).all(|k| bounds.min[k] <= p[k] && p[k] <= bounds.max[k])));
        }
    }

    #[test]
    fn normals_are_smooth_across_a_seam() {
        let (_, garment, mut positions) = two_panels();
        let level = &garment.levels[1];
        // Folded along the seam at x = 0.2 m by a right angle.
        for p in &mut positions {
            if p.x > 0.2 + 1e-9 {
                *p = Vector3::new(0.2, p.y, p.z - (p.x - 0.2));
            }
        }
        let normals = smooth_normals(level, &positions);
        let inside = level.seams[0][0][1..level.seams[0][0].len() - 1].iter();
        for &point in inside {
            let normal = normals[level.particle_of[point as usize] as usize];
            assert!((normal - Vector3::new(-1.0, 0.0, -1.0).normalize()).norm() < 1e-12, "{normal}");
        }
    }

    #[test]
    fn what_is_not_finite_does_not_spoil_the_file() {
        let (pattern, garment, mut positions) = two_panels();
        positions[3] = Vector3::new(f64::NAN, f64::INFINITY, 1e300);
        gltf::Gltf::from_slice(&write(&pattern, &garment.levels[1], &positions)).unwrap();
    }

    #[test]
    fn a_garment_without_triangles_is_an_empty_file_that_reads() {
        let (pattern, mut garment, positions) = two_panels();
        garment.levels[1].panels.iter_mut().for_each(|panel| panel.triangles = 0..0);
        let gltf = gltf::Gltf::from_slice(&write(&pattern, &garment.levels[1], &positions)).unwrap();
        assert_eq!(gltf.nodes().count(), 0);
        assert!(gltf.blob.is_none());
    }

    #[test]
    fn colors_of_many_panels_differ() {
        let colors: Vec<_> = (0..36).map(|k| material("", k).pbr_metallic_roughness.base_color_factor.0).collect();
        for (k, color) in colors.iter().enumerate() {
            assert!(!colors[..k].contains(color));
        }
    }
}
