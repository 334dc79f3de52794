//! The numbers of a glTF file, and the container around them.

use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Stride, Target, View};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Accessor, Buffer, Index, Root, Value};

/// The views of the buffer while they grow, each of one kind of element: positions, normals, rest coordinates, indices,
/// the numbers of animations, and of skins the joints and weights of vertices, and matrices. What is empty is not written.
#[derive(Default)]
pub struct Streams {
    bytes: [Vec<u8>; 8],
}

/// Sizes of the elements of the views, bytes; all are multiples of four, as the format asks.
const STRIDES: [usize; 8] = [12, 12, 8, 4, 4, 8, 16, 64];
/// Which of the views are indices, the numbers of animations, and those of skins.
const INDICES: usize = 3;
const ANIMATION: usize = 4;
const JOINTS: usize = 5;
const JOINT_WEIGHTS: usize = 6;
const MATRICES: usize = 7;

impl Streams {
    pub fn positions(&mut self, root: &mut Root, values: Vec<[f32; 3]>) -> Index<Accessor> {
        let low = values.iter().fold([f32::INFINITY; 3], |a, v| [0, 1, 2].map(|k| a[k].min(v[k])));
        let high = values.iter().fold([f32::NEG_INFINITY; 3], |a, v| [0, 1, 2].map(|k| a[k].max(v[k])));
        let accessor = self.push(root, 0, Type::Vec3, bytemuck::cast_slice::<_, f32>(&values));
        bound(root, low.to_vec(), high.to_vec());
        accessor
    }

    /// Times in seconds, ascending.
    pub fn times(&mut self, root: &mut Root, values: &[f32]) -> Index<Accessor> {
        let accessor = self.push(root, ANIMATION, Type::Scalar, values);
        bound(root, vec![values[0]], vec![values[values.len() - 1]]);
        accessor
    }

    pub fn weights(&mut self, root: &mut Root, values: &[f32]) -> Index<Accessor> {
        self.push(root, ANIMATION, Type::Scalar, values)
    }

    /// Values of a node at the times of an animation, each of `WIDTH` numbers.
    pub fn keys<const WIDTH: usize>(&mut self, root: &mut Root, values: &[f32]) -> Index<Accessor> {
        self.push(root, ANIMATION, if WIDTH == 4 { Type::Vec4 } else { Type::Vec3 }, values)
    }

    pub fn joints(&mut self, root: &mut Root, values: Vec<[u16; 4]>) -> Index<Accessor> {
        let bytes = values.iter().flatten().flat_map(|v| v.to_le_bytes());
        self.push_bytes(root, JOINTS, Type::Vec4, ComponentType::U16, bytes)
    }

    pub fn joint_weights(&mut self, root: &mut Root, values: Vec<[f32; 4]>) -> Index<Accessor> {
        self.push(root, JOINT_WEIGHTS, Type::Vec4, values.as_flattened())
    }

    /// Matrices by columns.
    pub fn matrices(&mut self, root: &mut Root, values: Vec<[f32; 16]>) -> Index<Accessor> {
        self.push(root, MATRICES, Type::Mat4, values.as_flattened())
    }

    pub fn normals(&mut self, root: &mut Root, values: Vec<[f32; 3]>) -> Index<Accessor> {
        self.push(root, 1, Type::Vec3, bytemuck::cast_slice::<_, f32>(&values))
    }

    pub fn rest(&mut self, root: &mut Root, values: Vec<[f32; 2]>) -> Index<Accessor> {
        self.push(root, 2, Type::Vec2, bytemuck::cast_slice::<_, f32>(&values))
    }

    pub fn indices(&mut self, root: &mut Root, values: Vec<u32>) -> Index<Accessor> {
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
            count: USize64::from((self.bytes[view].len() - start) / (kind.multiplicity() * component.size())),
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
    pub fn finish(self, root: &mut Root) -> Vec<u8> {
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
        let mut written = [None; STRIDES.len()];
        for (view, bytes) in self.bytes.into_iter().enumerate().filter(|(_, bytes)| !bytes.is_empty()) {
            let target = match view {
                INDICES => Some(Target::ElementArrayBuffer),
                ANIMATION | MATRICES => None,
                _ => Some(Target::ArrayBuffer),
            };
            written[view] = Some(root.push(View {
                buffer,
                byte_length: USize64::from(bytes.len()),
                byte_offset: Some(USize64::from(data.len())),
                byte_stride: matches!(target, Some(Target::ArrayBuffer)).then_some(Stride(STRIDES[view])),
                name: None,
                target: target.map(Checked::Valid),
                extensions: None,
                extras: Default::default(),
            }));
            data.extend(bytes);
        }
        for accessor in &mut root.accessors {
            accessor.buffer_view = accessor.buffer_view.and_then(|view| written[view.value()]);
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
pub fn container(root: &Root, mut data: Vec<u8>) -> Vec<u8> {
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
