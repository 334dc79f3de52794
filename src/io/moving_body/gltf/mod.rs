//! Animated bodies from glTF 2.0 files: skins, moving nodes and morph targets, as one mesh with bones.
//!
//! [`Rig`] is what the file holds: nodes, surface, clips. [`Rig::play`] plays one of its clips; `retarget` moves
//! the same bones by a motion from elsewhere.

mod accessor;
mod clip;
mod document;
mod nodes;
mod skin;
mod surface;
mod weld;

pub use clip::slerp;
pub use document::Fetch;
pub use nodes::{affine, compose};
pub use skin::{Carrier, Skin, SkinChannel, SkinClip};

use super::Options;
use crate::body::motion::{self, Affine, Motion, Parts, Skinned};
use crate::{Error, Warning};
use clip::Clip;
use document::{Document, named};
use nodes::Nodes;
use surface::Surface;

/// Nodes and channels looked at in all frames together; beyond it a file would be played for minutes.
const MOST_WORK: usize = 200_000_000;
const FEWER: &str = "Ask for fewer frames a second, or export a shorter shot.";

/// A body on its skeleton.
pub struct Rig {
    document: Document,
    nodes: Nodes,
    surface: Surface,
    /// The weights of the morph targets of each node, at rest.
    rest_weights: Vec<Vec<f64>>,
    warnings: Vec<Warning>,
}

impl Rig {
    /// Reads the bytes of a `.glb` or `.gltf` file; `fetch` reads the files that it names. With `meshes` only the nodes or
    /// meshes of these names are taken, else all of the scene.
    pub fn read(bytes: &[u8], meshes: &[String], fetch: Fetch) -> Result<Self, Error> {
        let mut document = Document::open(bytes, fetch)?;
        let nodes = Nodes::of(&document)?;
        let which = mesh_nodes(&document, &nodes, meshes)?;
        let mut surface = Surface::of(&mut document, &nodes, &which)?;
        surface.weld();
        let rest_weights = document.root.nodes.iter().map(|node| rest_weights(&document, node)).collect();
        let mut warnings = Vec::new();
        let (count, least) = surface.unnormalized;
        if count > 0 {
            warnings.push(Warning(Error::new(
                format!("The weights of {count} vertices do not sum to one, but to as little as {least:.2}."),
                "They were made to; normalize the weights in the program that made the skin.",
            )));
        }
        Ok(Self { document, nodes, surface, rest_weights, warnings })
    }

    /// The body moved by the clip that the options name, or by the first; without any clip it stands still.
    pub fn play(mut self, options: &Options) -> Result<(Motion, Vec<Warning>), Error> {
        let Some(number) = self.clip_number(options.clip.as_deref())? else {
            let still = "The file has no animation: the body stands still.";
            self.warnings.push(Warning(Error::new(still, "Export the animation with the body if it is to move.")));
            let (locals, weights) = (self.nodes.locals.clone(), self.rest_weights.clone());
            let mut globals = Vec::new();
            self.nodes.globals(&locals, &mut globals);
            return self.moved(1, options.frame_rate.unwrap_or(24.0), |_, out, morphs| {
                out.clone_from(&globals);
                morphs.clone_from(&weights);
            });
        };
        let morphs: Vec<usize> = self.rest_weights.iter().map(Vec::len).collect();
        let clip = Clip::of(&mut self.document, number, &self.nodes, &morphs)?;
        let rate = options.frame_rate.unwrap_or_else(|| clip.frame_rate());
        let frames = super::frames_within(clip.end - clip.start, rate)?;
        if frames.saturating_mul(self.nodes.order.len() + clip.channel_count()) > MOST_WORK {
            return Err(Error::new(format!("The animation has {frames} frames of too many nodes."), FEWER));
        }
        let nodes = std::mem::take(&mut self.nodes);
        let (mut locals, rest_weights) = (nodes.locals.clone(), self.rest_weights.clone());
        let pose = |k: usize, out: &mut Vec<Affine>, weights: &mut Vec<Vec<f64>>| {
            weights.clone_from(&rest_weights);
            clip.pose(clip.start + k as f64 / rate, &mut locals, weights);
            nodes.globals(&locals, out);
        };
        self.nodes.names.clone_from(&nodes.names);
        self.moved(frames, rate, pose)
    }

    /// The body in `frames` poses, `rate` a second: `pose` puts the nodes of frame `k` into the world.
    pub fn moved(
        self,
        frames: usize,
        rate: f64,
        mut pose: impl FnMut(usize, &mut Vec<Affine>, &mut Vec<Vec<f64>>),
    ) -> Result<(Motion, Vec<Warning>), Error> {
        let Surface { vertices, triangles, bones, morphs, .. } = self.surface;
        let per_frame = bones.len() * size_of::<Affine>() + morphs.len() * size_of::<f64>();
        if per_frame.saturating_mul(frames) > motion::MOST_BYTES {
            let problem = format!("{frames} frames of {} bones take more than can be held.", bones.len());
            return Err(Error::new(problem, FEWER));
        }
        let mut skinned = Skinned { bone_count: bones.len(), ..Skinned::default() };
        let mut parts = Parts::default();
        for bone in &bones {
            parts.names.push(self.nodes.names[bone.node].clone().unwrap_or_else(|| format!("node {}", bone.node)));
        }
        for vertex in vertices {
            let heaviest = vertex.influences.iter().fold((0, 0.0), |a, &b| if b.1 > a.1 { b } else { a });
            parts.of_vertex.push(heaviest.0);
            skinned.rest.push(vertex.position);
            skinned.influences.extend(vertex.influences);
            skinned.influence_ends.push(skinned.influences.len() as u32);
        }
        let (mut globals, mut weights) = (Vec::new(), self.rest_weights);
        for k in 0..frames {
            pose(k, &mut globals, &mut weights);
            skinned.bones.extend(bones.iter().map(|bone| compose(&globals[bone.node], &bone.inverse_bind)));
            let weight = |&(node, target, _): &(usize, usize, _)| weights[node].get(target).copied().unwrap_or(0.0);
            skinned.morph_weights.extend(morphs.iter().map(weight));
        }
        skinned.morphs = morphs.into_iter().map(|(_, _, morph)| morph).collect();
        Ok((Motion::skinned(triangles, rate, skinned)?.with_parts(parts), self.warnings))
    }

    /// The clip by its name, or by its number counted from 0; the first if none is named.
    fn clip_number(&mut self, asked: Option<&str>) -> Result<Option<usize>, Error> {
        let clips = &self.document.root.animations;
        let listed: Vec<String> =
            clips.iter().zip(0..).map(|(c, k)| named("animation", k, c.name.as_ref())).take(20).collect();
        let Some(asked) = asked else {
            if clips.len() > 1 {
                self.warnings.push(Warning(Error::new(
                    format!("The file has {} animations; the first is played.", clips.len()),
                    format!("Name another one by its name or number: {}.", listed.join(", ")),
                )));
            }
            return Ok((!clips.is_empty()).then_some(0));
        };
        let by_name = clips.iter().position(|c| c.name.as_deref() == Some(asked));
        let by_number = || asked.parse().ok().filter(|&k: &usize| k < clips.len());
        match by_name.or_else(by_number) {
            Some(number) => Ok(Some(number)),
            None if clips.is_empty() => {
                Err(Error::new("The file has no animation.", "Export the animation with the body."))
            }
            None => Err(Error::new(
                format!("The file has no animation \"{}\".", asked.escape_debug()),
                format!("Name one of these by its name or number: {}.", listed.join(", ")),
            )),
        }
    }

    /// The nodes' names, parents and places at rest; parents before their children in `order`.
    pub fn skeleton(&self) -> Skeleton {
        let mut globals = Vec::new();
        self.nodes.globals(&self.nodes.locals, &mut globals);
        Skeleton {
            names: self.nodes.names.iter().map(|n| n.clone().unwrap_or_default()).collect(),
            parents: self.nodes.parents.clone(),
            order: self.nodes.order.clone(),
            globals,
        }
    }

    /// The nodes that carry vertices of skins.
    pub fn joints(&self) -> Vec<usize> {
        let mut joints: Vec<usize> =
            self.document.root.skins.iter().flat_map(|s| &s.joints).map(|j| j.value()).collect();
        joints.retain(|&j| j < self.nodes.order.len());
        joints.sort_unstable();
        joints.dedup();
        joints
    }
}

/// A hierarchy of joints and its rest pose.
pub struct Skeleton {
    pub names: Vec<String>,
    pub parents: Vec<Option<usize>>,
    pub order: Vec<usize>,
    /// Joint to world.
    pub globals: Vec<Affine>,
}

/// The weights that a node gives its morph targets at rest, one per target.
fn rest_weights(document: &Document, node: &gltf_json::Node) -> Vec<f64> {
    let Some(mesh) = node.mesh.and_then(|mesh| document.root.get(mesh)) else { return Vec::new() };
    let targets = mesh.primitives.iter().map(|p| p.targets.as_ref().map_or(0, Vec::len)).max().unwrap_or(0);
    let given = node.weights.as_ref().or(mesh.weights.as_ref());
    let weight = |k: usize| given.and_then(|w| w.get(k)).copied().filter(|w| w.is_finite()).unwrap_or(0.0);
    (0..targets).map(|k| f64::from(weight(k))).collect()
}

/// The nodes with meshes of the scene that is shown, in the file's order.
fn mesh_nodes(document: &Document, nodes: &Nodes, names: &[String]) -> Result<Vec<usize>, Error> {
    let root = &document.root;
    // Without any scene all is shown; one that is named has to be there.
    let named = root.scene.is_some() || !root.scenes.is_empty();
    let mut shown = vec![!named; nodes.order.len()];
    if named {
        let scene = document.get(root.scene.unwrap_or(gltf_json::Index::new(0)), "scene")?;
        for node in &scene.nodes {
            document.get(*node, "node").map_err(|e| e.within("scene"))?;
            shown[node.value()] = true;
        }
    }
    for &k in &nodes.order {
        shown[k] |= nodes.parents[k].is_some_and(|parent| shown[parent]);
    }
    let name_of_mesh =
        |k: usize| root.nodes[k].mesh.and_then(|mesh| root.get(mesh)).and_then(|mesh| mesh.name.as_ref());
    let is_asked = |name: Option<&String>| name.is_some_and(|name| names.contains(name));
    let mut found: Vec<usize> = (0..shown.len()).filter(|&k| shown[k] && root.nodes[k].mesh.is_some()).collect();
    let listed: Vec<String> = found.iter().take(20).map(|&k| nodes.place(k)).collect();
    if !names.is_empty() {
        found.retain(|&k| is_asked(nodes.names[k].as_ref()) || is_asked(name_of_mesh(k)));
    }
    if found.is_empty() {
        return Err(if listed.is_empty() {
            Error::new("There is no mesh in the scene.", "Export the body together with its skeleton.")
        } else {
            let problem = format!("There is no mesh of the names {}.", names.join(", ").escape_debug());
            Error::new(problem, format!("The meshes are: {}.", listed.join(", ")))
        });
    }
    Ok(found)
}
