//! Body meshes from OBJ, read by tobj and then checked, since tobj accepts what no body can be.

use crate::body::Body;
use crate::geometry::Vector3;
use crate::{Error, Warning};

/// More vertices than any body scan worth dressing.
const MOST_VERTICES: usize = 5_000_000;

/// Reads a body from the text of an OBJ file: all its objects together, polygons cut into triangles.
pub fn parse(bytes: &[u8]) -> Result<(Body, Vec<Warning>), Error> {
    if bytes.iter().all(|b| b.is_ascii_whitespace()) {
        return Err(Error::new("The body file is empty.", "Give an OBJ file with a closed triangle mesh of the body."));
    }
    let options = tobj::LoadOptions { triangulate: true, single_index: false, ..Default::default() };
    let (models, _) = tobj::load_obj_buf(&mut &bytes[..], &options, |_| Ok(Default::default())).map_err(|e| {
        Error::new(
            format!("The body cannot be read as OBJ: {e}."),
            "Export the body as OBJ with triangles, in metres, y up.",
        )
    })?;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for model in &models {
        let offset = positions.len() as u32;
        positions.extend(model.mesh.positions.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])));
        triangles.extend(model.mesh.indices.chunks_exact(3).map(|t| [t[0] + offset, t[1] + offset, t[2] + offset]));
    }
    if positions.len() > MOST_VERTICES {
        return Err(Error::new(
            format!("The body has {} vertices.", positions.len()),
            format!("Reduce it to fewer than {MOST_VERTICES}; 10,000 to 50,000 are plenty."),
        ));
    }
    Body::new(positions, triangles)
}
