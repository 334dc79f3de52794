//! The sewn garment as binary glTF 2.0 (GLB), for viewers and animation programs.
//!
//! One mesh, node and material for each panel. `POSITION` and `NORMAL` are f32, the normals smooth
//! over the whole welded garment, so that seams do not show as creases. `TEXCOORD_0` is the rest
//! coordinates in metres, *not* flipped: glTF lays the origin of a texture at its upper left, so a
//! picture drawn on a panel with y up has to be turned over by whoever applies it; in return the
//! figures are those of the pattern. The right side of the fabric is the front of each triangle.
//!
//! A garment that moves has a morph target for each frame but the first, and one animation in which their weights are
//! one in turn: between two frames positions move on straight lines.
//!
//! What has no place in the format is left out: panels without triangles, and numbers that are not
//! finite, which are written as 0. The exact garment is `garment.obj`.

use super::export::{Frames, Sequence};
use super::picture::color_from_srgb;
use crate::Error;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::pattern::Pattern;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::animation::{Channel, Interpolation, Property, Sampler, Target as ChannelTarget};
use gltf_json::buffer::{Stride, Target, View};
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Accessor, Animation, Asset, Buffer, Index, Material, Mesh, Node, Root, Scene, Value};
use std::collections::BTreeMap;

/// Colors of the panels in turn, sRGB: muted like dyed cloth, neighbours in the list far apart.
const COLORS: [u32; 12] = [
    0x5b84b1, 0xd98e5f, 0x7ba37c, 0xc4698b, 0xd9bd62, 0x8a76b5, 0x58a6a6, 0xc7645c, 0x9bb05a, 0xb58bb8, 0x8c6f56,
    0x93a1ad,
];
/// Cloth is matt.
const ROUGHNESS: f32 = 0.85;

/// The largest file that is written, bytes: it is made in memory, and viewers hold it there too.
const MOST_BYTES: usize = 1 << 30;

/// The bytes of the file. `positions` are the level's, one per particle, m, world.
pub fn write(pattern: &Pattern, level: &Level, positions: &[Vector3]) -> Vec<u8> {
    let still = write_frames(pattern, level, &mut Sequence::still(positions.to_vec()));
    still.expect("a garment of five million particles at rest has less than a gigabyte")
}

/// The bytes of the file of a garment in motion.
pub fn write_frames(pattern: &Pattern, level: &Level, frames: &mut dyn Frames) -> Result<Vec<u8>, Error> {
    check_size(level, frames.frame_count())?;
    let mut first = Vec::new();
    frames.read(0, &mut first)?;
    let mut streams = Streams::default();
    let mut root = Root {
        asset: Asset { generator: Some(format!("toile {}", env!("CARGO_PKG_VERSION"))), ..Asset::default() },
        ..Root::default()
    };
    let shown: Vec<usize> = (0..level.panels.len()).filter(|&k| !level.panels[k].triangles.is_empty()).collect();
    let normals = smooth_normals(level, &first);
    for &panel in &shown {
        still_panel(&mut root, &mut streams, pattern, level, panel, [&first, &normals]);
    }
    if frames.frame_count() > 1 {
        let base = [first, normals];
        let mut positions = Vec::new();
        for frame in 1..frames.frame_count() {
            frames.read(frame, &mut positions)?;
            let normals = smooth_normals(level, &positions);
            for (mesh, &panel) in shown.iter().enumerate() {
                let target = morph_target(&mut root, &mut streams, level, panel, &base, [&positions, &normals]);
                root.meshes[mesh].primitives[0].targets.get_or_insert_default().push(target);
            }
        }
        animate(&mut root, &mut streams, frames.frame_rate(), frames.frame_count());
    }
    if !root.nodes.is_empty() {
        let nodes = (0..root.nodes.len() as u32).map(Index::new).collect();
        let name = Some(pattern.name.clone());
        root.scene = Some(root.push(Scene { name, nodes, extensions: None, extras: Default::default() }));
    }
    let data = streams.finish(&mut root);
    Ok(container(&root, data))
}

/// Positions and normals of all frames, and a weight of each frame at each.
fn check_size(level: &Level, frame_count: usize) -> Result<(), Error> {
    let bytes = (24.0 * level.rest.len() as f64 + 4.0 * frame_count as f64) * frame_count as f64;
    if frame_count == 1 || bytes <= MOST_BYTES as f64 {
        return Ok(());
    }
    Err(Error::new(
        format!(
            "{frame_count} frames as GLB have {:.0} MiB; up to {} are written.",
            bytes / 1048576.0,
            MOST_BYTES >> 20
        ),
        "Choose fewer frames with --frames, or export a point cache (pc2, mdd) or usd.",
    ))
}

/// The mesh, node and material of a panel; positions and normals are those of the particles.
fn still_panel(
    root: &mut Root,
    streams: &mut Streams,
    pattern: &Pattern,
    level: &Level,
    index: usize,
    [positions, normals]: [&[Vector3]; 2],
) {
    let (panel, range) = (&pattern.panels[index], &level.panels[index]);
    let first = range.points.start as u32;
    let particles = || level.particle_of[range.points.clone()].iter().map(|&p| p as usize);
    let place = particles().map(|p| positions[p].map(narrow).into());
    let normal = particles().map(|p| normals[p].map(narrow).into());
    let rest = level.rest[range.points.clone()].iter().map(|r| r.map(narrow).into());
    let corners = level.triangles[range.triangles.clone()].iter().flatten().map(|&point| point - first);
    let attributes = BTreeMap::from([
        (Checked::Valid(Semantic::Positions), streams.positions(root, place.collect())),
        (Checked::Valid(Semantic::Normals), streams.normals(root, normal.collect())),
        (Checked::Valid(Semantic::TexCoords(0)), streams.rest(root, rest.collect())),
    ]);
    let primitive = Primitive {
        attributes,
        indices: Some(streams.indices(root, corners.collect())),
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

/// What a frame differs by from the first; each array positions, then normals.
fn morph_target(
    root: &mut Root,
    streams: &mut Streams,
    level: &Level,
    panel: usize,
    base: &[Vec<Vector3>; 2],
    now: [&[Vector3]; 2],
) -> MorphTarget {
    let particles = &level.particle_of[level.panels[panel].points.clone()];
    let [moved, turned] = [0, 1].map(|k| {
        let difference = |&p: &u32| -> [f32; 3] {
            let (base, now) = (base[k][p as usize], now[k][p as usize]);
            // From the base as it stands in the file, so that its rounding does not add to that of the difference.
            std::array::from_fn(|axis| narrow(now[axis] - f64::from(narrow(base[axis]))))
        };
        particles.iter().map(difference).collect::<Vec<_>>()
    });
    MorphTarget {
        positions: Some(streams.positions(root, moved)),
        normals: Some(streams.normals(root, turned)),
        tangents: None,
    }
}

/// One animation of all nodes: at the time of each frame its target alone has the weight one.
fn animate(root: &mut Root, streams: &mut Streams, rate: f64, frame_count: usize) {
    let targets = frame_count - 1;
    for mesh in &mut root.meshes {
        mesh.weights = Some(vec![0.0; targets]);
    }
    let times: Vec<f32> = (0..frame_count).map(|frame| (frame as f64 / rate) as f32).collect();
    let weights = (0..frame_count).flat_map(|frame| (1..=targets).map(move |t| if t == frame { 1.0 } else { 0.0 }));
    let input = streams.times(root, &times);
    let output = streams.weights(root, &weights.collect::<Vec<f32>>());
    let sampler = Sampler {
        input,
        interpolation: Checked::Valid(Interpolation::Linear),
        output,
        extensions: None,
        extras: Default::default(),
    };
    let channel = |node: u32| Channel {
        sampler: Index::new(0),
        target: ChannelTarget {
            node: Index::new(node),
            path: Checked::Valid(Property::MorphTargetWeights),
            extensions: None,
            extras: Default::default(),
        },
        extensions: None,
        extras: Default::default(),
    };
    let channels = (0..root.nodes.len() as u32).map(channel).collect();
    root.push(Animation {
        name: Some("motion".to_owned()),
        channels,
        samplers: vec![sampler],
        extensions: None,
        extras: Default::default(),
    });
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

/// The views of the buffer while they grow, each of one kind of element: positions, normals, rest coordinates, indices,
/// and the numbers of an animation, which only a garment in motion has.
#[derive(Default)]
struct Streams {
    bytes: [Vec<u8>; 5],
}

/// Sizes of the elements of the views, bytes; all are multiples of four, as the format asks.
const STRIDES: [usize; 5] = [12, 12, 8, 4, 4];
/// Which of the views are indices and the numbers of an animation.
const INDICES: usize = 3;
const ANIMATION: usize = 4;

impl Streams {
    fn positions(&mut self, root: &mut Root, values: Vec<[f32; 3]>) -> Index<Accessor> {
        let low = values.iter().fold([f32::INFINITY; 3], |a, v| [0, 1, 2].map(|k| a[k].min(v[k])));
        let high = values.iter().fold([f32::NEG_INFINITY; 3], |a, v| [0, 1, 2].map(|k| a[k].max(v[k])));
        let accessor = self.push(root, 0, Type::Vec3, bytemuck::cast_slice::<_, f32>(&values));
        bound(root, low.to_vec(), high.to_vec());
        accessor
    }

    /// Times in seconds, ascending.
    fn times(&mut self, root: &mut Root, values: &[f32]) -> Index<Accessor> {
        let accessor = self.push(root, ANIMATION, Type::Scalar, values);
        bound(root, vec![values[0]], vec![values[values.len() - 1]]);
        accessor
    }

    fn weights(&mut self, root: &mut Root, values: &[f32]) -> Index<Accessor> {
        self.push(root, ANIMATION, Type::Scalar, values)
    }

    fn normals(&mut self, root: &mut Root, values: Vec<[f32; 3]>) -> Index<Accessor> {
        self.push(root, 1, Type::Vec3, bytemuck::cast_slice::<_, f32>(&values))
    }

    fn rest(&mut self, root: &mut Root, values: Vec<[f32; 2]>) -> Index<Accessor> {
        self.push(root, 2, Type::Vec2, bytemuck::cast_slice::<_, f32>(&values))
    }

    fn indices(&mut self, root: &mut Root, values: Vec<u32>) -> Index<Accessor> {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes());
        self.push_bytes(root, INDICES, Type::Scalar, ComponentType::U32, bytes)
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
        for (view, bytes) in self.bytes.into_iter().enumerate() {
            if view == ANIMATION && bytes.is_empty() {
                break;
            }
            let target = match view {
                INDICES => Some(Target::ElementArrayBuffer),
                ANIMATION => None,
                _ => Some(Target::ArrayBuffer),
            };
            root.push(View {
                buffer,
                byte_length: USize64::from(bytes.len()),
                byte_offset: Some(USize64::from(data.len())),
                byte_stride: (view < INDICES).then_some(Stride(STRIDES[view])),
                name: None,
                target: target.map(Checked::Valid),
                extensions: None,
                extras: Default::default(),
            });
            data.extend(bytes);
        }
        data
    }
}

/// Names the bounds of the accessor that was made last.
fn bound(root: &mut Root, low: Vec<f32>, high: Vec<f32>) {
    if let Some(accessor) = root.accessors.last_mut() {
        (accessor.min, accessor.max) = (Some(Value::from(low)), Some(Value::from(high)));
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
    fn another_reader_finds_every_frame_at_its_time() {
        let (pattern, garment, positions) = two_panels();
        let level = &garment.levels[1];
        let moved = |k: usize| positions.iter().map(|p| p + Vector3::new(0.1, p.x, 0.0) * (k * k) as f64).collect();
        let mut motion = Sequence { frame_rate: 24.0, frames: (0..4).map(moved).collect() };
        let file = write_frames(&pattern, level, &mut motion).unwrap();
        let gltf = gltf::Gltf::from_slice(&file).unwrap();
        let blob = gltf.blob.as_deref().unwrap();
        let animation = gltf.animations().next().unwrap();
        assert_eq!(animation.channels().count(), 2);
        for channel in animation.channels() {
            let reader = channel.reader(|_| Some(blob));
            let times: Vec<f32> = reader.read_inputs().unwrap().collect();
            assert_eq!(times, [0.0, 1.0 / 24.0, 2.0 / 24.0, 3.0 / 24.0]);
            let gltf::animation::util::ReadOutputs::MorphTargetWeights(weights) = reader.read_outputs().unwrap() else {
                panic!("the animation is not of morph targets")
            };
            let weights: Vec<f32> = weights.into_f32().collect();
            let node = channel.target().node();
            let range = &level.panels[node.index()];
            let primitive = node.mesh().unwrap().primitives().next().unwrap();
            let reader = primitive.reader(|_| Some(blob));
            let base: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            let targets: Vec<Vec<[f32; 3]>> =
                reader.read_morph_targets().map(|(positions, ..)| positions.unwrap().collect()).collect();
            for (frame, weights) in weights.chunks(3).enumerate() {
                for (k, point) in range.points.clone().enumerate() {
                    let mut place = Vector3::from(base[k].map(f64::from));
                    for (target, &weight) in targets.iter().zip(weights) {
                        place += Vector3::from(target[k].map(f64::from)) * f64::from(weight);
                    }
                    let expected = motion.frames[frame][level.particle_of[point] as usize];
                    assert!((place - expected).norm() < 2e-7, "frame {frame}: {place} {expected}");
                }
            }
        }
    }

    #[test]
    fn a_motion_too_long_for_a_viewer_is_refused_before_it_is_read() {
        struct Endless;
        impl Frames for Endless {
            fn frame_rate(&self) -> f64 {
                24.0
            }
            fn frame_count(&self) -> usize {
                usize::MAX
            }
            fn read(&mut self, _: usize, _: &mut Vec<Vector3>) -> Result<(), Error> {
                panic!("it is read")
            }
        }
        let (pattern, garment, _) = two_panels();
        let error = write_frames(&pattern, &garment.levels[1], &mut Endless).unwrap_err();
        assert!(error.remedy().contains("--frames"));
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
