//! A garment on the skeleton of a body, so that it goes along with the body's animation in any viewer.
//!
//! Each particle follows the joints of the place of the skin that is nearest to it in the pose of the fit: the weights
//! of that place's three vertices, blended, the four largest of them, made to sum to one. With the matrices `B` of the
//! joints in that pose (rest to world) a particle at `x` has the rest position
//!
//! ```text
//!     p = (Σ w B)⁻¹ x
//! ```
//!
//! so that in the pose of the fit it is where the fit put it, whatever the bind pose is. It is no simulation: cloth goes
//! along as if it were skin, and what hangs between two legs follows the nearer one.

use super::shading::smooth_normals;
use super::streams::{Streams, container};
use super::{asset, narrow, still_panel};
use crate::Error;
use crate::body::motion::{Affine, FARTHEST};
use crate::dynamics::{BroadPhase, Place, Surface};
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::io::moving_body::gltf::{Carrier, Skin, SkinClip};
use crate::pattern::Pattern;
use gltf_json::animation::{Channel, Property, Sampler, Target};
use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use gltf_json::{Animation, Index, Node, Root, Scene};
use nalgebra::Matrix3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// glTF viewers are bound to follow so many joints of a vertex.
const MOST_JOINTS: usize = 4;
/// Particles deeper in the body than this were fitted on another pose, m; a share of them may be all the same.
const ANOTHER_POSE: f64 = 5e-3;
const FEW: f64 = 1e-3;
/// A garment that touches the body nowhere within this was fitted on another one, m.
const ANOTHER_BODY: f64 = 0.05;
/// Blended matrices whose volume is a smaller share of the cube of their size flatten what they carry.
const SINGULAR: f64 = 1e-6;

/// What a particle follows: carrier and weight, at most four, the weights summing to one.
type Follows = Vec<(u32, f32)>;

/// The bytes of the file. `positions` are the level's, one per particle, m, world, in the pose of `skin`.
pub fn write_skinned(pattern: &Pattern, level: &Level, positions: &[Vector3], skin: &Skin) -> Result<Vec<u8>, Error> {
    let follows = follow(skin, positions)?;
    let (mut rest, mut normals) = (positions.to_vec(), smooth_normals(level, positions));
    for ((place, normal), follows) in rest.iter_mut().zip(&mut normals).zip(&follows) {
        let blended = blend(skin, follows);
        let linear = blended.fixed_view::<3, 3>(0, 0).into_owned();
        let back = inverse(&linear).ok_or_else(|| flattened(skin, follows))?;
        *place = back * (*place - blended.column(3));
        // Viewers turn normals by the linear part, and make them of length one.
        *normal = (back * *normal).try_normalize(0.0).unwrap_or_else(Vector3::z);
    }

    let mut streams = Streams::default();
    let mut root = Root { asset: asset(), nodes: skin.nodes.clone(), ..Root::default() };
    let used: BTreeSet<u32> = follows.iter().flatten().map(|(carrier, _)| *carrier).collect();
    let joint_of: BTreeMap<u32, u16> = used.iter().copied().zip(0..).collect();
    if joint_of.len() < used.len() {
        return Err(Error::new(format!("The garment follows {} joints.", used.len()), "Up to 65536 are possible."));
    }
    let hung = add_skin(&mut root, &mut streams, skin, &used, &pattern.name);
    let mut top: Vec<Index<Node>> = skin.roots.iter().map(|&k| Index::new(k as u32)).collect();
    for (index, panel) in level.panels.iter().enumerate().filter(|(_, panel)| !panel.triangles.is_empty()) {
        still_panel(&mut root, &mut streams, pattern, level, index, [&rest, &normals]);
        let of_point = || level.particle_of[panel.points.clone()].iter().map(|&p| &follows[p as usize]);
        let four = |follows: &Follows, k: usize| follows.get(k).copied();
        let joints = of_point().map(|f| [0, 1, 2, 3].map(|k| four(f, k).map_or(0, |(carrier, _)| joint_of[&carrier])));
        let weights = of_point().map(|f| [0, 1, 2, 3].map(|k| four(f, k).map_or(0.0, |(_, weight)| weight)));
        let joints = streams.joints(&mut root, joints.collect());
        let weights = streams.joint_weights(&mut root, weights.collect());
        let (mesh, node) = (root.meshes.len() - 1, root.nodes.len() - 1);
        let attributes = &mut root.meshes[mesh].primitives[0].attributes;
        attributes.insert(Checked::Valid(Semantic::Joints(0)), joints);
        attributes.insert(Checked::Valid(Semantic::Weights(0)), weights);
        root.nodes[node].skin = Some(hung);
        top.push(Index::new(node as u32));
    }
    for clip in &skin.clips {
        add_clip(&mut root, &mut streams, clip);
    }
    let name = Some(pattern.name.clone());
    root.scene = Some(root.push(Scene { name, nodes: top, extensions: None, extras: Default::default() }));
    let data = streams.finish(&mut root);
    Ok(container(&root, data))
}

/// What each particle follows.
fn follow(skin: &Skin, positions: &[Vector3]) -> Result<Vec<Follows>, Error> {
    let surface = Surface::new(&skin.positions, &skin.triangles, BroadPhase::Tree);
    let places: Vec<Option<Place>> = positions.par_iter().map(|p| surface.nearest(*p, FARTHEST)).collect();
    let places: Vec<Place> = places.into_iter().flatten().collect();
    let remedy = "Give the body that the garment was fitted on, and with --skin-frame the frame in whose pose it was.";
    let nearest = places.iter().map(|place| place.distance).fold(f64::INFINITY, f64::min);
    if places.len() < positions.len() || nearest > ANOTHER_BODY {
        return Err(Error::new("The garment is nowhere near this body.", remedy));
    }
    let inside = places.iter().filter(|place| place.distance < -ANOTHER_POSE).count();
    if inside as f64 > FEW * positions.len() as f64 {
        let problem = format!("{inside} of {} particles are more than 5 mm inside the body.", positions.len());
        return Err(Error::new(problem, remedy));
    }
    Ok(places.par_iter().map(|place| largest(skin, place)).collect())
}

/// The four largest weights of a place of the skin.
fn largest(skin: &Skin, place: &Place) -> Follows {
    let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
    for (&vertex, share) in skin.triangles[place.triangle as usize].iter().zip(place.weights) {
        for (carrier, weight) in &skin.influences[vertex as usize] {
            *sums.entry(*carrier).or_default() += share * weight;
        }
    }
    let mut found: Vec<(u32, f64)> = sums.into_iter().filter(|(_, weight)| *weight > 0.0).collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    found.truncate(MOST_JOINTS);
    let sum: f64 = found.iter().map(|(_, weight)| weight).sum();
    found.into_iter().map(|(carrier, weight)| (carrier, (weight / sum) as f32)).collect()
}

/// From rest to the world, with the weights as they stand in the file.
fn blend(skin: &Skin, follows: &Follows) -> Affine {
    let sum: f64 = follows.iter().map(|(_, weight)| f64::from(*weight)).sum();
    let of =
        |(carrier, weight): &(u32, f32)| skin.carriers[*carrier as usize].world_from_rest * (f64::from(*weight) / sum);
    follows.iter().map(of).sum()
}

fn inverse(linear: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let size = linear.norm();
    (linear.determinant().abs() > SINGULAR * size.powi(3)).then(|| linear.try_inverse()).flatten()
}

fn flattened(skin: &Skin, follows: &Follows) -> Error {
    let name = |(carrier, _): &(u32, f32)| {
        let node = skin.carriers[*carrier as usize].node;
        skin.nodes[node].name.as_deref().map_or_else(|| format!("node {node}"), |n| format!("\"{}\"", n.escape_debug()))
    };
    let names: Vec<String> = follows.iter().map(name).collect();
    Error::new(
        format!("In the pose of the fit the joints {} flatten what they carry.", names.join(", ")),
        "Give their nodes a scale that is not zero, or name a frame with --skin-frame in which they have one.",
    )
}

/// The skin of the garment. A joint may be in it only once; where two carriers are one node, as meshes of their own had
/// theirs, the second is a child of it that never moves.
fn add_skin(
    root: &mut Root,
    streams: &mut Streams,
    skin: &Skin,
    used: &BTreeSet<u32>,
    name: &str,
) -> Index<gltf_json::Skin> {
    let mut joints: Vec<Index<Node>> = Vec::new();
    let mut binds = Vec::new();
    for carrier in used {
        let Carrier { node, inverse_bind, .. } = &skin.carriers[*carrier as usize];
        let mut joint = Index::new(*node as u32);
        if joints.contains(&joint) {
            joint = root.push(Node { name: skin.nodes[*node].name.clone(), ..Node::default() });
            root.nodes[*node].children.get_or_insert_default().push(joint);
        }
        joints.push(joint);
        // Four columns, of which the format wants the last row as well.
        binds.push(std::array::from_fn(|k| match (k / 4, k % 4) {
            (column, 3) => f32::from(u8::from(column == 3)),
            (column, row) => narrow(inverse_bind[(row, column)]),
        }));
    }
    let inverse_bind_matrices = Some(streams.matrices(root, binds));
    root.push(gltf_json::Skin {
        inverse_bind_matrices,
        joints,
        skeleton: None,
        name: Some(name.to_owned()),
        extensions: None,
        extras: Default::default(),
    })
}

fn add_clip(root: &mut Root, streams: &mut Streams, clip: &SkinClip) {
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for channel in &clip.channels {
        let input = streams.times(root, &channel.times);
        let output = match channel.property {
            Property::Rotation => streams.keys::<4>(root, &channel.values),
            _ => streams.keys::<3>(root, &channel.values),
        };
        channels.push(Channel {
            sampler: Index::new(samplers.len() as u32),
            target: Target {
                node: Index::new(channel.node as u32),
                path: Checked::Valid(channel.property),
                extensions: None,
                extras: Default::default(),
            },
            extensions: None,
            extras: Default::default(),
        });
        samplers.push(Sampler {
            input,
            interpolation: Checked::Valid(channel.interpolation),
            output,
            extensions: None,
            extras: Default::default(),
        });
    }
    root.push(Animation { name: clip.name.clone(), channels, samplers, extensions: None, extras: Default::default() });
}
