//! A body that moves: one mesh, and where its vertices are at each frame.
//!
//! Frames follow one another at an even rate. Their positions are either all there (baked), or follow from a rest
//! shape and the bones that carry it (skinned), which takes a hundredth of the memory and is computed when it is
//! asked for. A frame is the same, byte for byte, whenever and on however many threads it is computed.
//!
//! Skinned positions are linear blends: with the bones `B_b(k)` of frame `k` (rest to world, affine), the weights `w`
//! of a vertex, which sum to one, and its rest position `p` displaced by the morphs `m` with their weights `g_m(k)`,
//!
//! ```text
//! x(k) = Σ_b w_b B_b(k) (p + Σ_m g_m(k) d_m)
//! ```
//!
//! (Magnenat-Thalmann, Laperrière and Thalmann 1988; glTF 2.0, section 3.7.3.) Joints that bend far lose volume
//! there, as in every program that plays such files; what is dressed is what the animator saw.

use super::Body;
use crate::geometry::Vector3;
use crate::{Error, Warning};
use rayon::prelude::*;

/// The most memory that all frames together may take, bytes: two thousand frames of a body of 20,000 vertices.
pub const MOST_BYTES: usize = 1 << 30;
/// Frames of an hour at 24 a second; more are a mistake.
pub const MOST_FRAMES: usize = 86_400;
/// Nothing that is dressed lies farther from the origin, m. It keeps every sum finite, too.
pub const FARTHEST: f64 = 1e6;
/// Frames a second, from one in a hundred seconds to a camera for collisions.
pub const FRAME_RATES: std::ops::RangeInclusive<f64> = 0.01..=10_000.0;
/// Vertices that one thread works on at a time.
const CHUNK: usize = 2048;

/// From one space to another: the linear part in the first three columns, the translation in the last, m.
pub type Affine = nalgebra::Matrix3x4<f64>;

/// A mesh with positions at every frame, m, y up.
#[derive(Clone, Debug)]
pub struct Motion {
    triangles: Vec<[u32; 3]>,
    frame_rate: f64,
    poses: Poses,
    parts: Parts,
}

/// Which named part of the body each vertex belongs to; empty where the file names none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    pub names: Vec<String>,
    /// Into `names`, one per vertex.
    pub of_vertex: Vec<u32>,
}

#[derive(Clone, Debug)]
enum Poses {
    /// One list per frame, one position per vertex.
    Baked(Vec<Vec<Vector3>>),
    Skinned(Skinned),
}

/// A rest shape and the bones that carry it.
#[derive(Clone, Debug, Default)]
pub struct Skinned {
    /// m, one per vertex, in the space that the bones lead out of.
    pub rest: Vec<Vector3>,
    /// Where the influences of each vertex end in `influences`; those of the next begin there.
    pub influence_ends: Vec<u32>,
    /// Bone and weight; the weights of a vertex sum to one.
    pub influences: Vec<(u32, f64)>,
    /// The bones of a frame.
    pub bone_count: usize,
    /// Rest to world, all bones of the first frame, then of the second, and so on.
    pub bones: Vec<Affine>,
    pub morphs: Vec<Morph>,
    /// All weights of the first frame, one per morph, then of the second, and so on.
    pub morph_weights: Vec<f64>,
}

/// A change of the rest shape: vertices in ascending order, and where each moves at weight one, m.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Morph(pub Vec<(u32, Vector3)>);

impl Motion {
    /// A motion of which every frame is given: `frames[k][v]`, m.
    pub fn baked(triangles: Vec<[u32; 3]>, frame_rate: f64, frames: Vec<Vec<Vector3>>) -> Result<Self, Error> {
        let vertices = frames.first().map_or(0, Vec::len);
        check_counts(vertices, frames.len(), frame_rate)?;
        check_baked_size(vertices, frames.len())?;
        check_triangles(&triangles, vertices)?;
        for (k, frame) in frames.iter().enumerate() {
            if frame.len() != vertices {
                let problem = format!("It has {} vertices, the first frame has {vertices}.", frame.len());
                return Err(Error::new(problem, SAME_MESH).within(format!("frame {k}")));
            }
            check_positions(frame).map_err(|e| e.within(format!("frame {k}")))?;
        }
        Ok(Self { triangles, frame_rate, poses: Poses::Baked(frames), parts: Parts::default() })
    }

    /// A motion of a skinned shape.
    ///
    /// # Panics
    /// If the lists do not go together; that is a mistake of the caller's, not of a file's.
    pub fn skinned(triangles: Vec<[u32; 3]>, frame_rate: f64, skinned: Skinned) -> Result<Self, Error> {
        let frames = skinned.frame_count();
        check_counts(skinned.rest.len(), frames, frame_rate)?;
        check_triangles(&triangles, skinned.rest.len())?;
        check_positions(&skinned.rest).map_err(|e| e.within("rest shape"))?;
        skinned.sanity_check();
        for (k, bones) in skinned.bones.chunks(skinned.bone_count).enumerate() {
            let far = |bone: &Affine| !bone.iter().all(|c| c.abs() <= FARTHEST);
            if let Some(bone) = bones.iter().position(far) {
                let problem = format!("Bone {bone} is moved or stretched beyond every measure.");
                return Err(Error::new(problem, EXPORT_AGAIN).within(format!("frame {k}")));
            }
        }
        Ok(Self { triangles, frame_rate, poses: Poses::Skinned(skinned), parts: Parts::default() })
    }

    /// The same motion, whose vertices belong to these parts.
    ///
    /// # Panics
    /// If there are parts, but not one for each vertex.
    pub fn with_parts(mut self, parts: Parts) -> Self {
        assert!(parts.names.is_empty() || parts.of_vertex.len() == self.vertex_count(), "one part per vertex");
        self.parts = parts;
        self
    }

    /// Vertices of each triangle, counter-clockwise from outside; the same in every frame.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Frames a second.
    pub fn frame_rate(&self) -> f64 {
        self.frame_rate
    }

    /// At least one.
    pub fn frame_count(&self) -> usize {
        match &self.poses {
            Poses::Baked(frames) => frames.len(),
            Poses::Skinned(skinned) => skinned.frame_count(),
        }
    }

    pub fn vertex_count(&self) -> usize {
        match &self.poses {
            Poses::Baked(frames) => frames[0].len(),
            Poses::Skinned(skinned) => skinned.rest.len(),
        }
    }

    /// From the first frame to the last, s.
    pub fn duration(&self) -> f64 {
        (self.frame_count() - 1) as f64 / self.frame_rate
    }

    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Writes the positions of frame `k` into `out`, m, world; one per vertex.
    ///
    /// # Panics
    /// If there are not so many frames.
    pub fn frame(&self, k: usize, out: &mut Vec<Vector3>) {
        assert!(k < self.frame_count(), "there is no frame {k} of {}", self.frame_count());
        match &self.poses {
            Poses::Baked(frames) => out.clone_from(&frames[k]),
            Poses::Skinned(skinned) => skinned.frame(k, out),
        }
    }

    /// The bones of frame `k`, from rest to world; none of a motion of which every frame was given.
    ///
    /// # Panics
    /// If there are not so many frames.
    pub fn bones(&self, k: usize) -> Option<&[Affine]> {
        match &self.poses {
            Poses::Baked(_) => None,
            Poses::Skinned(skinned) => Some(&skinned.bones[k * skinned.bone_count..][..skinned.bone_count]),
        }
    }

    /// The positions of frame `k`; see [`Self::frame`].
    pub fn positions(&self, k: usize) -> Vec<Vector3> {
        let mut positions = Vec::new();
        self.frame(k, &mut positions);
        positions
    }

    /// The body at frame `k`, checked as every other body is.
    pub fn body(&self, k: usize) -> Result<(Body, Vec<Warning>), Error> {
        Body::new(self.positions(k), self.triangles.clone()).map_err(|e| e.within(format!("frame {k}")))
    }

    /// The lowest and highest coordinates of frame `k`, m.
    pub fn bounds(&self, k: usize) -> (Vector3, Vector3) {
        let positions = self.positions(k);
        let low = positions.iter().fold(Vector3::repeat(f64::INFINITY), |a, p| a.inf(p));
        let high = positions.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
        (low, high)
    }
}

impl Skinned {
    fn frame_count(&self) -> usize {
        self.bones.len().checked_div(self.bone_count).unwrap_or(0)
    }

    fn sanity_check(&self) {
        let (vertices, frames) = (self.rest.len(), self.frame_count());
        assert_eq!(self.bones.len(), frames * self.bone_count, "a bone of each kind in every frame");
        assert_eq!(self.morph_weights.len(), frames * self.morphs.len(), "a weight of each morph in every frame");
        assert_eq!(self.influence_ends.len(), vertices, "influences of each vertex");
        assert!(self.influence_ends.is_sorted() && self.influence_ends.last() == Some(&(self.influences.len() as u32)));
        assert!(self.influences.iter().all(|&(bone, _)| (bone as usize) < self.bone_count));
        assert!(self.morphs.iter().flat_map(|m| &m.0).all(|&(v, _)| (v as usize) < vertices));
    }

    fn frame(&self, k: usize, out: &mut Vec<Vector3>) {
        let bones = &self.bones[k * self.bone_count..][..self.bone_count];
        out.clone_from(&self.rest);
        let weights = &self.morph_weights[k * self.morphs.len()..];
        for (Morph(displacements), &weight) in self.morphs.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            displacements.iter().for_each(|&(v, by)| out[v as usize] += by * weight);
        }
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, positions)| {
            for (position, v) in positions.iter_mut().zip(chunk * CHUNK..) {
                let start = if v == 0 { 0 } else { self.influence_ends[v - 1] as usize };
                let rest = position.push(1.0);
                let blended = |sum, &(bone, weight): &(u32, f64)| sum + bones[bone as usize] * rest * weight;
                *position =
                    self.influences[start..self.influence_ends[v] as usize].iter().fold(Vector3::zeros(), blended);
            }
        });
    }
}

const SAME_MESH: &str = "All frames must be of one mesh, with the same vertices in the same order.";
const EXPORT_AGAIN: &str = "Export the animation again, in metres.";

/// May so many positions be held? To be asked before they are read.
pub fn check_baked_size(vertices: usize, frames: usize) -> Result<(), Error> {
    let bytes = vertices.saturating_mul(frames).saturating_mul(size_of::<Vector3>());
    if bytes <= MOST_BYTES {
        return Ok(());
    }
    Err(Error::new(
        format!("{frames} frames of {vertices} vertices take more than {} MiB.", MOST_BYTES >> 20),
        "Export fewer frames or a coarser body, or the skinned body itself as glTF, which takes far less.",
    ))
}

fn check_counts(vertices: usize, frames: usize, frame_rate: f64) -> Result<(), Error> {
    if frames == 0 || vertices == 0 {
        return Err(Error::new("The animation has no frames of any body.", "Export the animation again."));
    }
    if frames > MOST_FRAMES {
        let problem = format!("The animation has {frames} frames, the limit is {MOST_FRAMES}.");
        return Err(Error::new(problem, "Cut it into shots, or ask for fewer frames a second."));
    }
    if !FRAME_RATES.contains(&frame_rate) {
        return Err(Error::new(
            format!("It has {frame_rate} frames a second."),
            format!("Between {} and {} are possible; films have 24.", FRAME_RATES.start(), FRAME_RATES.end()),
        ));
    }
    Ok(())
}

fn check_triangles(triangles: &[[u32; 3]], vertices: usize) -> Result<(), Error> {
    if triangles.is_empty() {
        return Err(Error::new("The animated body has no triangles.", "Export a triangle mesh of the body."));
    }
    match triangles.iter().position(|t| t.iter().any(|&v| v as usize >= vertices)) {
        None => Ok(()),
        Some(t) => {
            let problem = format!("Triangle {} names a vertex that does not exist.", t + 1);
            Err(Error::new(problem, "Export the animated body again."))
        }
    }
}

fn check_positions(positions: &[Vector3]) -> Result<(), Error> {
    match positions.iter().position(|p| !p.iter().all(|c| c.abs() <= FARTHEST)) {
        None => Ok(()),
        Some(v) => {
            let problem = format!("Vertex {} has a coordinate that is no number or beyond every measure.", v + 1);
            Err(Error::new(problem, EXPORT_AGAIN))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes::sphere;
    use super::*;

    /// A ball of which the upper half follows a second bone, which rises by 1 m a frame, and a morph that moves it all in x.
    fn rising() -> (Vec<[u32; 3]>, Skinned) {
        let (rest, triangles) = sphere(Vector3::new(0.0, 0.5, 0.0), 0.5, 8);
        let bone =
            |y: f64| Affine::identity().map_with_location(|row, column, c| if (row, column) == (1, 3) { y } else { c });
        let skinned = Skinned {
            influence_ends: (1..=rest.len() as u32).collect(),
            influences: rest.iter().map(|p| (u32::from(p.y > 0.5), 1.0)).collect(),
            bone_count: 2,
            bones: (0..3).flat_map(|k| [bone(0.0), bone(f64::from(k))]).collect(),
            morphs: vec![Morph((0..rest.len() as u32).map(|v| (v, Vector3::x())).collect())],
            morph_weights: vec![0.0, 0.0, 0.25],
            rest,
        };
        (triangles, skinned)
    }

    #[test]
    fn each_vertex_follows_its_bones_and_morphs() {
        let (triangles, skinned) = rising();
        let rest = skinned.rest.clone();
        let motion = Motion::skinned(triangles, 24.0, skinned).unwrap();
        assert_eq!((motion.frame_count(), motion.vertex_count(), motion.duration()), (3, rest.len(), 2.0 / 24.0));
        for (p, moved) in rest.iter().zip(motion.positions(2)) {
            let expected = Vector3::new(p.x + 0.25, p.y + if p.y > 0.5 { 2.0 } else { 0.0 }, p.z);
            assert!((moved - expected).norm() < 1e-12);
        }
    }

    #[test]
    fn a_baked_motion_gives_what_it_was_given() {
        let (triangles, skinned) = rising();
        let skinned = Motion::skinned(triangles.clone(), 24.0, skinned).unwrap();
        let frames: Vec<_> = (0..3).map(|k| skinned.positions(k)).collect();
        let baked = Motion::baked(triangles, 24.0, frames.clone()).unwrap();
        let mut out = Vec::new();
        for k in [2, 0, 1] {
            baked.frame(k, &mut out);
            assert_eq!(out, frames[k]);
            assert_eq!(baked.bounds(k), skinned.bounds(k));
        }
        assert_eq!(baked.body(0).unwrap().0.positions(), frames[0]);
        assert!(
            baked.with_parts(Parts { names: vec!["all".into()], of_vertex: vec![0; out.len()] }).parts().names.len()
                == 1
        );
    }

    #[test]
    fn what_is_no_motion_is_told_so() {
        let (triangles, skinned) = rising();
        let rest = skinned.rest.clone();
        let problem = |rate: f64, frames: &[&[Vector3]]| {
            let frames = frames.iter().map(|f| f.to_vec()).collect();
            Motion::baked(triangles.clone(), rate, frames).unwrap_err().to_string()
        };
        assert!(problem(24.0, &[]).contains("no frames"));
        assert!(problem(f64::NAN, &[&rest]).contains("frames a second"));
        assert!(problem(24.0, &[&rest, &rest[1..]]).contains("frame 1: It has"));
        assert!(problem(24.0, &[&rest[1..]]).contains("does not exist"));
        let mut wild = rest.clone();
        wild[4].z = f64::NAN;
        assert!(problem(24.0, &[&rest, &wild]).contains("frame 1: Vertex 5"));
        let mut torn = skinned;
        torn.bones[3][(0, 0)] = 1e9;
        assert!(Motion::skinned(triangles.clone(), 24.0, torn).unwrap_err().to_string().contains("frame 1: Bone 1"));
        assert!(check_baked_size(usize::MAX, usize::MAX).is_err() && check_baked_size(13_348, 2000).is_ok());
    }
}
