//! The garment as arrays for NumPy: what never changes (`rest.npz`), all of it (`garment.npz`), and what ContourCraft's
//! templates are made of.

use super::Source;
use super::frames::{Frames, for_each};
use super::npz::Npz;
use crate::io::atomic::Unfinished;
use std::io::{self, Seek, Write};

/// What does not move: rest coordinates, and how the flat panels and the sewn garment belong together.
pub fn write_rest(source: &Source, out: impl Write + Seek) -> Result<(), Unfinished> {
    let mut npz = Npz::new(out);
    rest(&mut npz, source)?;
    Ok(npz.finish()?)
}

/// The same and the positions of all frames.
pub fn write_garment(source: &Source, frames: &mut dyn Frames, out: impl Write + Seek) -> Result<(), Unfinished> {
    let mut npz = Npz::new(out);
    rest(&mut npz, source)?;
    npz.array("frame_rate", &[], [frames.frame_rate()])?;
    npz.begin::<f64>("positions", &[frames.frame_count(), source.level.particle_count, 3])?;
    for_each::<Unfinished>(frames, |_, positions| Ok(npz.put(positions.iter().flatten().copied())?))?;
    Ok(npz.finish()?)
}

fn rest(npz: &mut Npz<impl Write + Seek>, source: &Source) -> io::Result<()> {
    let level = source.level;
    let (points, triangles) = (level.rest.len(), level.triangles.len());
    npz.array("rest", &[points, 2], level.rest.iter().flatten().copied())?;
    npz.array("particle_of_point", &[points], as_i32(&level.particle_of))?;
    npz.array("triangle_points", &[triangles, 3], as_i32(level.triangles.as_flattened()))?;
    npz.array("triangle_particles", &[triangles, 3], as_i32(level.particle_triangles().as_flattened()))?;
    npz.array("panel_of_triangle", &[triangles], as_i32(&level.panel_of_triangle()))?;
    let panels = level.panels.iter().zip(0i32..);
    npz.array("panel_of_point", &[points], panels.flat_map(|(range, k)| range.points.clone().map(move |_| k)))?;
    let names: Vec<&str> = source.pattern.panels.iter().map(|panel| panel.name.as_str()).collect();
    npz.texts("panel_names", &names)?;
    let seams = level.seam_edges();
    npz.array("seam_edges", &[seams.len(), 2], as_i32(seams.as_flattened()))?;
    let eased = &level.eased;
    npz.array("eased_triangles", &[eased.len()], eased.iter().map(|e| e.triangle as i32))?;
    npz.array("eased_tips", &[eased.len()], eased.iter().map(|e| i32::from(e.tip)))?;
    npz.array("eased_ratios", &[eased.len()], eased.iter().map(|e| e.ratio))?;
    let masses = level.particle_masses(|_| source.fabric.areal_density);
    npz.array("particle_masses", &[masses.len()], masses)
}

/// What a garment template of ContourCraft and HOOD holds, by their keys; `make_contourcraft_template.py` turns it into the
/// pickle that they load. `positions` are those of the particles, m, world.
pub fn write_contourcraft(
    source: &Source,
    positions: &[crate::geometry::Vector3],
    out: impl Write + Seek,
) -> io::Result<()> {
    let level = source.level;
    let (particles, triangles) = (level.particle_count, level.triangles.len());
    let corners = level.particle_triangles();
    let mut npz = Npz::new(out);
    npz.array("rest_pos", &[particles, 3], positions.iter().flatten().map(|&x| x as f32))?;
    npz.array("faces", &[triangles, 3], corners.iter().flatten().map(|&i| i64::from(i)))?;
    npz.array("node_type", &[particles, 1], (0..particles).map(|_| 0i64))?;
    npz.array("verts_uv", &[level.rest.len(), 2], level.rest.iter().flatten().map(|&x| x as f32))?;
    npz.array("faces_uv", &[triangles, 3], level.triangles.iter().flatten().map(|&i| i as i32))?;
    npz.finish()
}

fn as_i32(indices: &[u32]) -> impl Iterator<Item = i32> + '_ {
    // A level has less than five million particles.
    indices.iter().map(|&index| index as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::export::Sequence;
    use crate::io::export::npz::tests::{member, numbers};
    use crate::io::sample::two_panels;
    use crate::pattern::Fabric;
    use std::io::Cursor;

    fn integers(data: &[u8]) -> Vec<u32> {
        data.as_chunks::<4>().0.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect()
    }

    #[test]
    fn the_arrays_are_those_of_the_level() {
        let (pattern, garment, positions) = two_panels();
        let level = &garment.levels[1];
        let source = Source { pattern: &pattern, level, fabric: &Fabric::default(), clearance: 0.0007, skin: None };
        let mut frames = Sequence { frame_rate: 30.0, frames: vec![positions.clone(), positions.clone()] };
        let mut file = Cursor::new(Vec::new());
        write_garment(&source, &mut frames, &mut file).unwrap();
        let file = file.into_inner();
        let (header, data) = member(&file, "positions");
        assert!(header.contains(&format!("(2, {}, 3)", positions.len())));
        let flat: Vec<f64> = positions.iter().flatten().copied().collect();
        assert_eq!(numbers(&data), [flat.clone(), flat].concat());
        let rest: Vec<f64> = level.rest.iter().flatten().copied().collect();
        assert_eq!(numbers(&member(&file, "rest").1), rest);
        assert_eq!(integers(&member(&file, "particle_of_point").1), level.particle_of);
        assert_eq!(integers(&member(&file, "triangle_points").1), level.triangles.as_flattened());
        assert_eq!(integers(&member(&file, "panel_of_triangle").1), level.panel_of_triangle());
        let weight: f64 = numbers(&member(&file, "particle_masses").1).iter().sum();
        assert!((weight - 0.2 * 0.2 * 0.3 * 2.0).abs() < 1e-12, "{weight}");
    }
}
