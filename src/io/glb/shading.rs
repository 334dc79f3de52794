//! What a garment looks like: normals and colors.

use crate::garment::Level;
use crate::geometry::Vector3;
use crate::io::picture::color_from_srgb;
use gltf_json::Material;
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};

/// Colors of the panels in turn, sRGB: muted like dyed cloth, neighbours in the list far apart.
const COLORS: [u32; 12] = [
    0x5b84b1, 0xd98e5f, 0x7ba37c, 0xc4698b, 0xd9bd62, 0x8a76b5, 0x58a6a6, 0xc7645c, 0x9bb05a, 0xb58bb8, 0x8c6f56,
    0x93a1ad,
];
/// Cloth is matt.
const ROUGHNESS: f32 = 0.85;

/// Unit normals of the particles, each the mean of its triangles' by their angles, which does not
/// depend on how a flat part is cut into triangles (Thürmer and Wüthrich 1998).
pub fn smooth_normals(level: &Level, positions: &[Vector3]) -> Vec<Vector3> {
    let mut normals = vec![Vector3::zeros(); positions.len()];
    for t in 0..level.triangles.len() {
        let particles = level.particles(t).map(|p| p as usize);
        let corners = particles.map(|p| positions[p]);
        for k in 0..3 {
            let [a, b] = [1, 2].map(|next| corners[(k + next) % 3] - corners[k]);
            let normal = a.cross(&b);
            // Triangles without area, or without finite corners, have no say.
            if let Some(unit) = normal.try_normalize(0.0).filter(|n| n.iter().all(|x| x.is_finite())) {
                normals[particles[k]] += unit * normal.norm().atan2(a.dot(&b));
            }
        }
    }
    // A particle whose triangles cancel out, in a fold, has no normal; the format asks for some.
    normals.into_iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vector3::z)).collect()
}

pub fn material(name: &str, index: usize) -> Material {
    let color = color_from_srgb(COLORS[index % COLORS.len()]);
    // Each further turn through the list is darker.
    let shade = 0.75f32.powi((index / COLORS.len()) as i32);
    let [r, g, b] = [color.x * shade, color.y * shade, color.z * shade];
    Material {
        name: Some(name.to_owned()),
        double_sided: true,
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor([r, g, b, 1.0]),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(ROUGHNESS),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    }
}
