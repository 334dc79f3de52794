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
//! On the skeleton of a body it follows that body's animation: `skinned.rs`.
//!
//! What has no place in the format is left out: panels without triangles, and numbers that are not
//! finite, which are written as 0. The exact garment is `garment.obj`.

mod morphs;
mod shading;
mod skinned;
mod streams;

pub use skinned::write_skinned;

use super::export::{Frames, Sequence};
use crate::Error;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::pattern::Pattern;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Asset, Index, Mesh, Node, Root, Scene};
use morphs::{animate, morph_target};
use shading::{material, smooth_normals};
use std::collections::BTreeMap;
use streams::{Streams, container};

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
    let mut root = Root { asset: asset(), ..Root::default() };
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

fn asset() -> Asset {
    Asset { generator: Some(format!("toile {}", env!("CARGO_PKG_VERSION"))), ..Asset::default() }
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

fn narrow(number: f64) -> f32 {
    let number = number as f32;
    if number.is_finite() { number } else { 0.0 }
}

#[cfg(test)]
mod tests;
