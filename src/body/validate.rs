//! Is a mesh a body that can be dressed?

use crate::geometry::Vector3;
use crate::{Code, Error, Warning};

/// Bodies from infants' to giants', m.
const HEIGHTS: std::ops::RangeInclusive<f64> = 0.3..=3.0;
/// No body has less than a tenth of a litre, m³.
const LEAST_VOLUME: f64 = 1e-4;
/// How far below or above the floor the feet may stand before it is worth a word, m.
const FLOOR_TOLERANCE: f64 = 0.05;
/// How many bad edges are listed in a message.
const MOST_LISTED: usize = 3;

/// All that keeps a mesh from being dressed, the first fault carrying the others; else what is doubtful about it.
pub fn validate(positions: &[Vector3], triangles: &[[u32; 3]]) -> Result<Vec<Warning>, Error> {
    check_numbers(positions, triangles)?;
    let faults = [check_size(positions), check_closed(triangles)].into_iter().filter_map(Result::err);
    if let Some(fault) = Error::all(faults) {
        return Err(fault);
    }
    let volume = volume(positions, triangles);
    if volume.abs() < LEAST_VOLUME {
        return Err(Error::new(
            "The body encloses no volume.",
            "Give a closed mesh of the whole body; a flat sheet cannot be dressed.",
        )
        .coded(Code::BodyWithoutVolume));
    }
    let inside_out = Error::new(
        "The body is inside out: its triangles face inwards.",
        "Flip the normals of the mesh in the program that made it, and export it again.",
    );
    let facing = if volume < 0.0 { Err(inside_out.coded(Code::BodyInsideOut)) } else { Ok(()) };
    match (facing, check_upright(positions, triangles)) {
        (Ok(()), upright) => upright,
        (Err(fault), Ok(_)) => Err(fault),
        (Err(fault), Err(other)) => Err(Error::all([fault, other]).expect("there are two")),
    }
}

/// Are there triangles, and are all their corners points in space?
pub fn check_numbers(positions: &[Vector3], triangles: &[[u32; 3]]) -> Result<(), Error> {
    if positions.is_empty() || triangles.is_empty() {
        return Err(Error::new(
            "The body has no triangles.",
            "Give an OBJ file with a closed triangle mesh of the body.",
        ));
    }
    for (k, p) in positions.iter().enumerate() {
        if !p.iter().all(|c| c.is_finite()) {
            return Err(Error::new(
                format!("Vertex {} has a coordinate that is not a finite number.", k + 1),
                "Export the body again.",
            ));
        }
    }
    for (k, t) in triangles.iter().enumerate() {
        if t.iter().any(|&v| v as usize >= positions.len()) {
            return Err(Error::new(
                format!("Triangle {} names a vertex that does not exist.", k + 1),
                "Export the body again.",
            ));
        }
        let [a, b, c] = *t;
        if a == b || b == c || c == a {
            return Err(Error::new(
                format!("Triangle {} has the same vertex twice.", k + 1),
                "Remove triangles without area and export the body again.",
            ));
        }
    }
    Ok(())
}

fn extent(positions: &[Vector3]) -> (Vector3, Vector3) {
    let low = positions.iter().fold(Vector3::repeat(f64::INFINITY), |a, p| a.inf(p));
    let high = positions.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
    (low, high)
}

fn check_size(positions: &[Vector3]) -> Result<(), Error> {
    let (low, high) = extent(positions);
    let size = (high - low).max();
    if HEIGHTS.contains(&size) {
        return Ok(());
    }
    let units = [("centimetres", 0.01), ("millimetres", 0.001), ("inches", 0.0254)];
    let fitting = units.iter().filter(|(_, metres)| HEIGHTS.contains(&(size * metres)));
    let guesses: Vec<String> = fitting.map(|(unit, metres)| format!("in {unit}, scale it by {metres}")).collect();
    let remedy = if guesses.is_empty() {
        format!("Bodies are in metres, from {} to {} m tall.", HEIGHTS.start(), HEIGHTS.end())
    } else {
        format!("If it is {}.", guesses.join("; if it is "))
    };
    Err(Error::new(format!("The body is {size:.4} m tall."), remedy).coded(Code::BodyWrongSize))
}

/// Every edge must be run through once in each direction.
fn check_closed(triangles: &[[u32; 3]]) -> Result<(), Error> {
    let mut sides: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    sides.sort_unstable();
    if let Some(w) = sides.windows(2).find(|w| w[0] == w[1]) {
        return Err(Error::new(
            format!(
                "The edge between vertices {} and {} belongs to triangles that face opposite ways, or to more than two.",
                w[0][0] + 1,
                w[0][1] + 1
            ),
            "Make the mesh a manifold with all its normals outward.",
        )
        .coded(Code::BodyNotManifold));
    }
    let open: Vec<[u32; 2]> = sides.iter().filter(|[a, b]| sides.binary_search(&[*b, *a]).is_err()).copied().collect();
    if open.is_empty() {
        return Ok(());
    }
    let listed: Vec<String> = open.iter().take(MOST_LISTED).map(|[a, b]| format!("{}-{}", a + 1, b + 1)).collect();
    Err(Error::new(
        format!(
            "The body is not closed: {} edges have a triangle on one side only ({}, as vertex numbers).",
            open.len(),
            listed.join(", ")
        ),
        "Close the holes. Vertices split at texture seams must be merged before export, without merging others.",
    )
    .coded(Code::BodyOpen))
}

pub fn volume(positions: &[Vector3], triangles: &[[u32; 3]]) -> f64 {
    let corner = |v: u32| positions[v as usize];
    triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0).sum()
}

/// Nobody is this many times as deep, from chest to back, as high.
const LYING: f64 = 2.0;

/// Is y up, and the head above the feet?
fn check_upright(positions: &[Vector3], triangles: &[[u32; 3]]) -> Result<Vec<Warning>, Error> {
    let (low, high) = extent(positions);
    let size = high - low;
    if size.z > LYING * size.y {
        return Err(Error::new(
            format!("The body lies along z: it is {:.2} m long there and {:.2} m high in y.", size.z, size.y),
            "Turn it so that y is up and it faces +z; many programs have z up and offer y up on export.",
        )
        .coded(Code::BodyNotUpright));
    }
    // Just above the floor a standing body is two feet, just below the crown it is one head.
    let parts_at = |fraction: f64| slice_parts(positions, triangles, low.y + fraction * size.y);
    if parts_at(0.97) >= 2 && parts_at(0.03) == 1 {
        return Err(Error::new(
            "The body stands on its head.",
            "Turn it so that its feet are at y = 0 and its head is up.",
        )
        .coded(Code::BodyNotUpright));
    }
    let mut warnings = Vec::new();
    if low.y.abs() > FLOOR_TOLERANCE {
        warnings.push(Warning(
            Error::new(
                format!("The body's lowest point is at y = {:.3} m.", low.y),
                "Bodies stand on the floor at y = 0; check that the pattern was placed for this body.",
            )
            .coded(Code::BodyOffFloor),
        ));
    }
    Ok(warnings)
}

/// Into how many separate outlines a horizontal plane cuts the mesh.
fn slice_parts(positions: &[Vector3], triangles: &[[u32; 3]], height: f64) -> usize {
    let mut sets = crate::geometry::UnionFind::new(triangles.len());
    let above = |v: u32| positions[v as usize].y > height;
    let mut cut_edges: Vec<([u32; 2], u32)> = Vec::new();
    let mut cut = Vec::new();
    for (t, &[a, b, c]) in triangles.iter().enumerate() {
        let before = cut_edges.len();
        for [p, q] in [[a, b], [b, c], [c, a]] {
            if above(p) != above(q) {
                cut_edges.push(([p.min(q), p.max(q)], t as u32));
            }
        }
        if cut_edges.len() > before {
            cut.push(t as u32);
        }
    }
    cut_edges.sort_unstable();
    for w in cut_edges.windows(2).filter(|w| w[0].0 == w[1].0) {
        sets.union(w[0].1, w[1].1);
    }
    cut.iter().filter(|&&t| sets.find(t) == t).count()
}

#[cfg(test)]
mod tests {
    use super::super::shapes::sphere;
    use super::*;

    fn ball(scale: f64) -> (Vec<Vector3>, Vec<[u32; 3]>) {
        sphere(Vector3::new(0.0, 0.5 * scale, 0.0), 0.5 * scale, 12)
    }

    fn problem(positions: &[Vector3], triangles: &[[u32; 3]]) -> Error {
        validate(positions, triangles).unwrap_err()
    }

    #[test]
    fn a_body_in_centimetres_is_told_so() {
        let (positions, triangles) = ball(172.0);
        assert!(problem(&positions, &triangles).remedy().contains("centimetres"));
    }

    #[test]
    fn holes_and_inward_triangles_are_found() {
        let (positions, mut triangles) = ball(1.0);
        assert!(validate(&positions, &triangles).unwrap().is_empty());
        let inward: Vec<_> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!(problem(&positions, &inward).problem().contains("inside out"));
        triangles.pop();
        assert!(problem(&positions, &triangles).problem().contains("not closed"));
    }

    #[test]
    fn a_body_on_its_head_is_found() {
        // Two legs and a head, as three balls.
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for (center, radius) in [([0.0, 1.2, 0.0], 0.4), ([0.3, 0.4, 0.0], 0.25), ([-0.3, 0.4, 0.0], 0.25)] {
            let (more, faces) = sphere(Vector3::from(center), radius, 12);
            let offset = positions.len() as u32;
            positions.extend(more);
            triangles.extend(faces.iter().map(|t| t.map(|v| v + offset)));
        }
        assert!(validate(&positions, &triangles).is_ok());
        for p in &mut positions {
            *p = Vector3::new(p.x, 1.75 - p.y, -p.z);
        }
        assert!(problem(&positions, &triangles).problem().contains("head"));
    }

    #[test]
    fn numbers_that_are_none_are_found() {
        let (mut positions, triangles) = ball(1.0);
        positions[3].x = f64::NAN;
        assert!(problem(&positions, &triangles).problem().contains("Vertex 4"));
    }

    #[test]
    fn a_sheet_is_no_body_though_it_is_closed() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector3::from);
        assert!(problem(&positions, &[[0, 1, 2], [0, 2, 1]]).problem().contains("no volume"));
        assert!(problem(&positions, &[[0, 1, 1], [0, 2, 1]]).problem().contains("same vertex twice"));
        assert!(problem(&positions, &[[0, 1, 3]]).problem().contains("does not exist"));
        assert!(problem(&positions, &[]).problem().contains("no triangles"));
    }

    #[test]
    fn a_lying_body_is_told_to_stand_up() {
        let (positions, triangles) = ball(1.0);
        let lying: Vec<Vector3> = positions.iter().map(|p| Vector3::new(0.4 * p.x, 0.3 * p.z, -p.y)).collect();
        assert!(problem(&lying, &triangles).remedy().contains("y is up"));
        let hovering: Vec<Vector3> = positions.iter().map(|p| p + Vector3::y()).collect();
        assert!(validate(&hovering, &triangles).unwrap()[0].0.remedy().contains("floor"));
    }
}
