//! A body as something that other meshes can hang on: its skin in one pose, what carries it, and the nodes and clips that
//! move it.

use super::super::Options;
use super::Rig;
use super::clip::Clip;
use super::document::{Document, named};
use crate::body::motion::Affine;
use crate::geometry::Vector3;
use crate::{Error, Warning};
use gltf_json::Node;
use gltf_json::animation::{Interpolation, Property};

/// A body in the pose of one frame.
#[derive(Clone, Debug)]
pub struct Skin {
    /// m, world, one per vertex.
    pub positions: Vec<Vector3>,
    pub triangles: Vec<[u32; 3]>,
    /// Into `carriers`, with weights that sum to one; one list per vertex.
    pub influences: Vec<Vec<(u32, f64)>>,
    pub carriers: Vec<Carrier>,
    /// All nodes of the file, without meshes, skins and cameras.
    pub nodes: Vec<Node>,
    /// Those that the scene begins with.
    pub roots: Vec<usize>,
    pub clips: Vec<SkinClip>,
}

/// A node that vertices follow.
#[derive(Clone, Debug)]
pub struct Carrier {
    pub node: usize,
    /// From the mesh to the node at rest.
    pub inverse_bind: Affine,
    /// From the mesh to the world, in the pose.
    pub world_from_rest: Affine,
}

/// An animation of nodes; what it does to morph targets is left out.
#[derive(Clone, Debug)]
pub struct SkinClip {
    pub name: Option<String>,
    pub channels: Vec<SkinChannel>,
}

/// Keys of a node.
#[derive(Clone, Debug)]
pub struct SkinChannel {
    pub node: usize,
    /// Translation, rotation or scale.
    pub property: Property,
    pub interpolation: Interpolation,
    /// Ascending, s.
    pub times: Vec<f32>,
    /// As in the file: of a cubic spline each value with its tangents.
    pub values: Vec<f32>,
}

impl Rig {
    /// The body at a frame of the clip that the options name, or of the first; a body without clips is at rest.
    pub fn skin(mut self, options: &Options, frame: usize) -> Result<(Skin, Vec<Warning>), Error> {
        let morphs: Vec<usize> = self.rest_weights.iter().map(Vec::len).collect();
        let (mut clips, mut left_out) = (Vec::new(), Vec::new());
        for number in 0..self.document.root.animations.len() {
            match Clip::of(&mut self.document, number, &self.nodes, &morphs) {
                Ok(clip) => clips.push(skin_clip(&self.document, number, &clip)),
                Err(error) => left_out.push(Warning(error)),
            }
        }
        // Of a clip that moves morph targets alone nothing is left.
        clips.retain(|clip| !clip.channels.is_empty());
        let (nodes, roots) = hierarchy(&self.document, &self.nodes.parents);
        let bones: Vec<(usize, Affine)> = self.surface.bones.iter().map(|b| (b.node, b.inverse_bind)).collect();
        let influences = self.surface.vertices.iter().map(|v| v.influences.clone()).collect();
        let (motion, mut warnings) = self.play(options)?;
        warnings.extend(left_out);
        if frame >= motion.frame_count() {
            let problem = format!("It has no frame {frame}; its last is {}.", motion.frame_count() - 1);
            return Err(Error::new(problem, "Name the frame in whose pose the garment is, counted from 0."));
        }
        let matrices = motion.bones(frame).expect("what a rig moves has bones");
        let carrier = |(&(node, inverse_bind), &world_from_rest): (&(usize, Affine), &Affine)| Carrier {
            node,
            inverse_bind,
            world_from_rest,
        };
        let skin = Skin {
            positions: motion.positions(frame),
            triangles: motion.triangles().to_vec(),
            influences,
            carriers: bones.iter().zip(matrices).map(carrier).collect(),
            nodes,
            roots,
            clips,
        };
        Ok((skin, warnings))
    }
}

/// The nodes without what they show, and those that the scene begins with.
fn hierarchy(document: &Document, parents: &[Option<usize>]) -> (Vec<Node>, Vec<usize>) {
    let root = &document.root;
    let bare = |node: &Node| Node {
        name: node.name.clone(),
        children: node.children.clone(),
        matrix: node.matrix,
        translation: node.translation,
        rotation: node.rotation,
        scale: node.scale,
        ..Node::default()
    };
    let scene = root.scene.and_then(|scene| root.get(scene)).or(root.scenes.first());
    // A node that the scene names below its parent as well is shown once.
    let top = |k: &usize| *k < parents.len() && parents[*k].is_none();
    let roots = match scene {
        Some(scene) => scene.nodes.iter().map(|node| node.value()).filter(top).collect(),
        None => (0..parents.len()).filter(top).collect(),
    };
    (root.nodes.iter().map(bare).collect(), roots)
}

fn skin_clip(document: &Document, number: usize, clip: &Clip) -> SkinClip {
    let narrow = |values: &[f64]| values.iter().map(|v| *v as f32).collect();
    let moves_nodes = clip.channels.iter().filter(|channel| channel.property != Property::MorphTargetWeights);
    let channels = moves_nodes.map(|channel| SkinChannel {
        node: channel.node,
        property: channel.property,
        interpolation: channel.interpolation,
        times: narrow(&channel.times),
        values: narrow(&channel.values),
    });
    let name = document.root.animations[number].name.clone();
    SkinClip { name: name.or_else(|| Some(named("animation", number, None))), channels: channels.collect() }
}
