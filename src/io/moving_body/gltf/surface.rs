//! The meshes of a glTF scene as one surface, carried by bones.
//!
//! A vertex of a skinned mesh follows the joints of its skin; the mesh's own node has no say. A vertex of any other mesh
//! follows its node, which counts as a bone of weight one.

use super::accessor::Wanted;
use super::document::{Document, EXPORT_AGAIN, named};
use super::nodes::{Nodes, affine_of};
use crate::Error;
use crate::body::motion::{Affine, Morph};
use crate::geometry::Vector3;
use gltf_json::accessor::Type;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index};
use std::collections::BTreeMap;

/// More vertices than any body worth dressing, as for bodies that stand still.
const MOST_VERTICES: usize = 5_000_000;
/// Weights that sum to less carry nothing.
const LEAST_WEIGHT: f64 = 1e-3;
/// How far weights may be from a sum of one without a word; a byte's rounding is less.
const ROUNDING: f64 = 0.02;

/// What looking at a primitive costs, in numbers read: many nodes may name one mesh.
const PRIMITIVE_COST: usize = 64;

pub struct Bone {
    pub node: usize,
    /// From the mesh to the bone at rest.
    pub inverse_bind: Affine,
}

/// One vertex: what moves it.
#[derive(Clone, Debug)]
pub struct Vertex {
    /// m, as in the file.
    pub position: Vector3,
    /// Bone and weight, bones ascending, weights summing to one.
    pub influences: Vec<(u32, f64)>,
}

#[derive(Default)]
pub struct Surface {
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<[u32; 3]>,
    pub bones: Vec<Bone>,
    /// With the node and the number of the target there, which tell its weight.
    pub morphs: Vec<(usize, usize, Morph)>,
    /// Vertices whose weights did not sum to one, and the smallest sum.
    pub unnormalized: (usize, f64),
    /// The first bone of each skin that was met.
    skins: BTreeMap<usize, u32>,
}

impl Surface {
    /// Of the mesh nodes `which`.
    pub fn of(document: &mut Document, nodes: &Nodes, which: &[usize]) -> Result<Self, Error> {
        let mut surface = Self { unnormalized: (0, 1.0), ..Self::default() };
        let mut globals = Vec::new();
        nodes.globals(&nodes.locals, &mut globals);
        for &node in which {
            surface.add(document, node, &globals[node]).map_err(|e| e.within(nodes.place(node)))?;
        }
        if surface.triangles.is_empty() {
            return Err(Error::new(
                "There are no triangles in the scene.",
                "Export the body together with its skeleton.",
            ));
        }
        Ok(surface)
    }

    fn add(&mut self, document: &mut Document, node: usize, global: &Affine) -> Result<(), Error> {
        let (mesh, skin) = (document.root.nodes[node].mesh, document.root.nodes[node].skin);
        let Some(mesh) = mesh else { return Ok(()) };
        let number = mesh.value();
        let primitives = document.get(mesh, "mesh")?.primitives.len();
        document.charge(PRIMITIVE_COST.saturating_mul(primitives))?;
        let mesh = document.root.meshes[number].clone();
        let carrier = match skin {
            Some(skin) => {
                let first = self.skin(document, skin.value())?;
                Carrier::Skin { first, joints: document.root.skins[skin.value()].joints.len() }
            }
            None => {
                self.bones.push(Bone { node, inverse_bind: Affine::identity() });
                // A node that mirrors turns its triangles over.
                let mirrors = global.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
                Carrier::Node { bone: self.bones.len() as u32 - 1, mirrors }
            }
        };
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            self.add_primitive(document, primitive, &carrier, node)
                .map_err(|e| e.within(format!("{}, primitive {k}", named("mesh", number, mesh.name.as_ref()))))?;
        }
        Ok(())
    }

    /// The first bone of a skin.
    fn skin(&mut self, document: &mut Document, number: usize) -> Result<u32, Error> {
        if let Some(&first) = self.skins.get(&number) {
            return Ok(first);
        }
        let skin: &gltf_json::Skin = document.get(Index::new(number as u32), "skin")?;
        let place = named("skin", number, skin.name.as_ref());
        let skin = skin.clone();
        let first = self.bones.len() as u32;
        let bones = bones_of(document, &skin).map_err(|e| e.within(place))?;
        self.bones.extend(bones);
        self.skins.insert(number, first);
        Ok(first)
    }

    fn add_primitive(
        &mut self,
        document: &mut Document,
        primitive: &Primitive,
        carrier: &Carrier,
        node: usize,
    ) -> Result<(), Error> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err(Error::new("It is drawn in a mode that glTF does not know.", EXPORT_AGAIN));
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let Some(positions) = attribute(Semantic::Positions) else {
            return Err(Error::new("It has no positions.", "Export it without compression (Draco, meshopt)."));
        };
        let positions = document.numbers(positions, Type::Vec3, Wanted::Real)?;
        let count = positions.count();
        let first = self.vertices.len();
        if first + count > MOST_VERTICES {
            let problem = format!("The body has more than {MOST_VERTICES} vertices.");
            return Err(Error::new(problem, "Reduce it; 10,000 to 50,000 vertices are plenty."));
        }
        let influences = match *carrier {
            Carrier::Node { bone, .. } => vec![vec![(bone, 1.0)]; count],
            Carrier::Skin { first, joints } => self.influences(document, primitive, count, first, joints)?,
        };
        let position = |k: usize| Vector3::from_column_slice(positions.element(k));
        let vertices = influences.into_iter().enumerate();
        self.vertices.extend(vertices.map(|(k, influences)| Vertex { position: position(k), influences }));

        for (target, morph) in primitive.targets.iter().flatten().enumerate() {
            let Some(moved) = morph.positions else { continue };
            let place = format!("morph target {target}");
            let moved = document.numbers(moved, Type::Vec3, Wanted::Real).map_err(|e| e.within(&place))?;
            if moved.count() != count {
                let problem = format!("It moves {} vertices of {count}.", moved.count());
                return Err(Error::new(problem, EXPORT_AGAIN).within(place));
            }
            let displaced = (0..count).map(|k| ((first + k) as u32, Vector3::from_column_slice(moved.element(k))));
            let displaced = displaced.filter(|(_, by)| *by != Vector3::zeros()).collect();
            self.morphs.push((node, target, Morph(displaced)));
        }
        let mut triangles = triangles(document, primitive.indices, mode, count)?;
        if matches!(carrier, Carrier::Node { mirrors: true, .. }) {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self.triangles.extend(triangles.into_iter().map(|t| t.map(|v| v + first as u32)));
        Ok(())
    }

    /// The bones of each vertex of a skinned primitive, with weights that sum to one.
    fn influences(
        &mut self,
        document: &mut Document,
        primitive: &Primitive,
        count: usize,
        first: u32,
        joints: usize,
    ) -> Result<Vec<Vec<(u32, f64)>>, Error> {
        let mut influences: Vec<Vec<(u32, f64)>> = vec![Vec::new(); count];
        for set in 0.. {
            let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
            let (which, weights) = match (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set))) {
                (Some(which), Some(weights)) => (which, weights),
                (None, None) if set > 0 => break,
                _ => {
                    let problem = format!("It has a skin, but not both JOINTS_{set} and WEIGHTS_{set}.");
                    return Err(Error::new(problem, EXPORT_AGAIN));
                }
            };
            let which_place = format!("JOINTS_{set}, accessor {}", which.value());
            let weights_place = format!("WEIGHTS_{set}, accessor {}", weights.value());
            let which = document.numbers(which, Type::Vec4, Wanted::Index)?;
            let weights = document.numbers(weights, Type::Vec4, Wanted::Real)?;
            for (place, numbers) in [(&which_place, &which), (&weights_place, &weights)] {
                if numbers.count() != count {
                    let problem = format!("It is of {} vertices, the positions of {count}.", numbers.count());
                    return Err(Error::new(problem, EXPORT_AGAIN).within(place));
                }
            }
            for (v, influences) in influences.iter_mut().enumerate() {
                for (&joint, &weight) in which.element(v).iter().zip(weights.element(v)) {
                    if weight < 0.0 {
                        let problem = format!("Vertex {v} has the negative weight {weight}.");
                        return Err(Error::new(problem, EXPORT_AGAIN).within(weights_place));
                    }
                    if weight > 0.0 && joint as usize >= joints {
                        let problem = format!("Vertex {v} follows joint {joint}, but the skin has {joints} joints.");
                        return Err(Error::new(problem, EXPORT_AGAIN).within(which_place));
                    }
                    if weight > 0.0 {
                        influences.push((first + joint as u32, weight));
                    }
                }
            }
        }
        for (v, influences) in influences.iter_mut().enumerate() {
            let sum = normalize(influences);
            if sum < LEAST_WEIGHT {
                return Err(Error::new(
                    format!("Vertex {v} follows no joint: its weights sum to {:.3}.", sum.max(0.0)),
                    "Give every vertex a weight in the program that made the skin, and export it again.",
                ));
            }
            if (sum - 1.0).abs() > ROUNDING {
                self.unnormalized = (self.unnormalized.0 + 1, self.unnormalized.1.min(sum));
            }
        }
        Ok(influences)
    }
}

enum Carrier {
    Skin { first: u32, joints: usize },
    Node { bone: u32, mirrors: bool },
}

/// Makes weights sum to one, each bone named once, in ascending order; returns what they summed to.
fn normalize(influences: &mut Vec<(u32, f64)>) -> f64 {
    influences.sort_by_key(|&(bone, _)| bone);
    influences.dedup_by(|again, kept| {
        let same = again.0 == kept.0;
        if same {
            kept.1 += again.1;
        }
        same
    });
    let sum: f64 = influences.iter().map(|&(_, weight)| weight).sum();
    influences.iter_mut().for_each(|(_, weight)| *weight /= sum);
    sum
}

fn bones_of(document: &mut Document, skin: &gltf_json::Skin) -> Result<Vec<Bone>, Error> {
    if skin.joints.is_empty() {
        return Err(Error::new("The skin has no joints.", EXPORT_AGAIN));
    }
    skin.joints.iter().try_for_each(|&joint| document.get(joint, "node").map(|_| ()))?;
    let Some(accessor) = skin.inverse_bind_matrices else {
        let bone = |joint: &Index<_>| Bone { node: joint.value(), inverse_bind: Affine::identity() };
        return Ok(skin.joints.iter().map(bone).collect());
    };
    let place = format!("inverse bind matrices, accessor {}", accessor.value());
    let matrices = document.numbers(accessor, Type::Mat4, Wanted::Real)?;
    if matrices.count() < skin.joints.len() {
        let problem = format!("There are {} of them for {} joints.", matrices.count(), skin.joints.len());
        return Err(Error::new(problem, EXPORT_AGAIN).within(place));
    }
    let bone = |(k, joint): (usize, &Index<gltf_json::Node>)| {
        let inverse_bind = affine_of(matrices.element(k)).ok_or_else(|| {
            let error = Error::new("It is no affine map.", EXPORT_AGAIN);
            error.within(format!("{place}, element {k}"))
        })?;
        Ok(Bone { node: joint.value(), inverse_bind })
    };
    skin.joints.iter().enumerate().map(bone).collect()
}

/// Triangles of a primitive of `count` vertices; those without area by their corners are left out.
fn triangles(
    document: &mut Document,
    indices: Option<Index<Accessor>>,
    mode: Mode,
    count: usize,
) -> Result<Vec<[u32; 3]>, Error> {
    let corners: Vec<u32> = match indices {
        None => (0..count as u32).collect(),
        Some(accessor) => {
            let numbers = document.numbers(accessor, Type::Scalar, Wanted::Index)?;
            if let Some(k) = numbers.values.iter().position(|&v| v >= count as f64) {
                let problem = format!("It names vertex {} of {count}.", numbers.values[k]);
                let error = Error::new(problem, EXPORT_AGAIN);
                return Err(error.within(format!("indices, accessor {}, element {k}", accessor.value())));
            }
            numbers.values.iter().map(|&v| v as u32).collect()
        }
    };
    if mode == Mode::Triangles && !corners.len().is_multiple_of(3) {
        let problem = format!("It has {} corners, which are no triangles.", corners.len());
        return Err(Error::new(problem, EXPORT_AGAIN));
    }
    let all: Vec<[u32; 3]> = match mode {
        Mode::TriangleFan => corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]).collect(),
        // Every other one runs the other way round.
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(k, w)| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        _ => corners.as_chunks::<3>().0.to_vec(),
    };
    Ok(all.into_iter().filter(|&[a, b, c]| a != b && b != c && c != a).collect())
}
