//! The hierarchy of nodes: who hangs on whom, and where each is.

use super::document::{Document, EXPORT_AGAIN, named};
use crate::Error;
use crate::body::motion::Affine;
use crate::geometry::Vector3;
use gltf_json::scene::Node;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion};

/// A node's place in its parent.
#[derive(Clone, Copy, Debug)]
pub enum Local {
    Matrix(Affine),
    Parts { translation: Vector3, rotation: UnitQuaternion<f64>, scale: Vector3 },
}

impl Local {
    pub fn affine(&self) -> Affine {
        match self {
            Self::Matrix(matrix) => *matrix,
            Self::Parts { translation, rotation, scale } => {
                affine(rotation.to_rotation_matrix().matrix() * Matrix3::from_diagonal(scale), *translation)
            }
        }
    }
}

pub fn affine(linear: Matrix3<f64>, translation: Vector3) -> Affine {
    let c = |k: usize| linear.column(k).into_owned();
    Affine::from_columns(&[c(0), c(1), c(2), translation])
}

/// First `b`, then `a`.
pub fn compose(a: &Affine, b: &Affine) -> Affine {
    let linear = a.fixed_view::<3, 3>(0, 0);
    affine(linear * b.fixed_view::<3, 3>(0, 0), linear * b.column(3) + a.column(3))
}

#[derive(Default)]
pub struct Nodes {
    pub names: Vec<Option<String>>,
    pub parents: Vec<Option<usize>>,
    pub locals: Vec<Local>,
    /// Parents before their children.
    pub order: Vec<usize>,
}

impl Nodes {
    pub fn of(document: &Document) -> Result<Self, Error> {
        let nodes = &document.root.nodes;
        let mut parents = vec![None; nodes.len()];
        for (k, node) in nodes.iter().enumerate() {
            let place = || named("node", k, node.name.as_ref());
            for child in node.children.iter().flatten() {
                document.get(*child, "node").map_err(|e| e.within(place()))?;
                if let Some(other) = parents[child.value()].replace(k) {
                    let problem = format!("Its child {} is a child of node {other} as well.", child.value());
                    return Err(Error::new(problem, EXPORT_AGAIN).within(place()));
                }
            }
        }
        // With one parent each, what cannot be reached from a root hangs on itself.
        let mut order: Vec<usize> = (0..nodes.len()).filter(|&k| parents[k].is_none()).collect();
        let mut next = 0;
        while let Some(&k) = order.get(next) {
            order.extend(nodes[k].children.iter().flatten().map(|child| child.value()));
            next += 1;
        }
        if order.len() < nodes.len() {
            let mut reached = vec![false; nodes.len()];
            order.iter().for_each(|&k| reached[k] = true);
            let k = reached.iter().position(|r| !r).unwrap_or(0);
            let problem = "The node is its own ancestor: the hierarchy runs in a circle.";
            return Err(Error::new(problem, EXPORT_AGAIN).within(named("node", k, nodes[k].name.as_ref())));
        }
        let local = |(k, node): (usize, &Node)| local(node).map_err(|e| e.within(named("node", k, node.name.as_ref())));
        let locals = nodes.iter().enumerate().map(local).collect::<Result<_, _>>()?;
        Ok(Self { names: nodes.iter().map(|n| n.name.clone()).collect(), parents, locals, order })
    }

    /// How node `k` is called in messages.
    pub fn place(&self, k: usize) -> String {
        named("node", k, self.names[k].as_ref())
    }

    /// Where every node is in the world when `locals` tell where it is in its parent.
    pub fn globals(&self, locals: &[Local], out: &mut Vec<Affine>) {
        out.clear();
        out.resize(self.parents.len(), Affine::identity());
        for &k in &self.order {
            let local = locals[k].affine();
            out[k] = self.parents[k].map_or(local, |parent| compose(&out[parent], &local));
        }
    }
}

fn local(node: &Node) -> Result<Local, Error> {
    let problem = |what: &str| Error::new(format!("Its {what}."), EXPORT_AGAIN);
    let wide = |v: [f32; 3]| Vector3::from(v.map(f64::from));
    let finite = |v: &Vector3| v.iter().all(|c| c.is_finite());
    if let Some(m) = node.matrix {
        let m = m.map(f64::from);
        return affine_of(&m).map(Local::Matrix).ok_or_else(|| problem("matrix is no affine map of finite numbers"));
    }
    let translation = node.translation.map_or_else(Vector3::zeros, wide);
    let scale = node.scale.map_or_else(|| Vector3::repeat(1.0), wide);
    if !finite(&translation) || !finite(&scale) {
        return Err(problem("translation or scale is not finite"));
    }
    let rotation = match &node.rotation {
        None => UnitQuaternion::identity(),
        Some(q) => rotation(&q.0.map(f64::from)).ok_or_else(|| problem("rotation is no quaternion of length one"))?,
    };
    Ok(Local::Parts { translation, rotation, scale })
}

/// The rotation of a quaternion in glTF's order `x y z w`, if it has a direction. Many exporters round so that its length is not
/// quite one.
pub fn rotation(xyzw: &[f64]) -> Option<UnitQuaternion<f64>> {
    let q = Quaternion::new(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
    UnitQuaternion::try_new(q, 1e-6)
}

/// A 4x4 matrix in columns, if it is an affine map.
pub fn affine_of(m: &[f64]) -> Option<Affine> {
    let last = [m[3], m[7], m[11], m[15] - 1.0];
    let is_affine = m.iter().all(|c| c.is_finite()) && last.iter().all(|c| c.abs() < 1e-4);
    is_affine.then(|| Affine::from_fn(|row, column| m[4 * column + row]))
}
