//! Frames as morph targets, and the animation that plays them.

use super::narrow;
use super::streams::Streams;
use crate::garment::Level;
use crate::geometry::Vector3;
use gltf_json::animation::{Channel, Interpolation, Property, Sampler, Target as ChannelTarget};
use gltf_json::mesh::MorphTarget;
use gltf_json::validation::Checked;
use gltf_json::{Animation, Index, Root};

/// What a frame differs by from the first; each array positions, then normals.
pub fn morph_target(
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
pub fn animate(root: &mut Root, streams: &mut Streams, rate: f64, frame_count: usize) {
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
