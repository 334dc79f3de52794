//! `preview.png`: what the garment looks like on the body.

use super::color::{Color, Oklab, color_from_srgb, linear_from_oklab, oklab_from_linear};
use super::scene::{Coloring, Lighting, Scene, Surface};
use super::sheet::{self, Strips};
use super::subject::{BodyView, Focus, GarmentView};

/// Where the viewer stands: front, three quarters from the body's left, back. Radians.
const AZIMUTHS: [f64; 3] = [0.0, 0.7, std::f64::consts::PI];

/// Width of the picture, pixels: twice the column of text of a code host's front page, for dense screens.
const WIDTH: u32 = 1800;

/// Body: warm grey, matte, lighter than most cloth. Garment: a muted blue, of medium lightness so that both lit and
/// shaded sides of a fold have room. sRGB.
pub(super) const BODY_COLOR: u32 = 0xc9beb4;
const GARMENT_COLOR: u32 = 0x5585a2;

/// How far the tint of a panel may differ from the garment's color, in Oklab: just enough to tell neighbours apart.
const TINT_LIGHTNESS: f32 = 0.017;
const TINT_HUE: f32 = 0.005;

/// The garment on the body from the front, at three quarters and from the back, as a PNG file.
///
/// Any finite input gives a picture; particles that are not finite are left out with their triangles.
pub fn preview(garment: &GarmentView, body: &BodyView) -> Vec<u8> {
    let tints;
    let colors = if garment.colors.is_empty() {
        tints = panel_tints(garment);
        &tints
    } else {
        garment.colors
    };
    let scene = Scene {
        surfaces: vec![
            body.surface(color_from_srgb(BODY_COLOR)),
            Surface {
                positions: garment.positions,
                triangles: garment.triangles,
                coloring: Coloring::PerTriangle(colors),
                lines: garment.seams,
            },
        ],
        floor: body.floor(),
        lighting: Lighting::Studio,
    };
    let focus = Focus::new(garment, body);
    let strips = Strips { width: WIDTH, ..Strips::default() };
    let (canvas, _) = sheet::draw(&scene, &focus, &AZIMUTHS, strips);
    canvas.to_image().to_png()
}

/// One color per triangle: the garment's, a little different for each panel.
pub(super) fn panel_tints(garment: &GarmentView) -> Vec<Color> {
    let base = oklab_from_linear(color_from_srgb(GARMENT_COLOR));
    let panel = |triangle: usize| garment.panels.get(triangle).copied().unwrap_or(0);
    (0..garment.triangles.len()).map(|triangle| tint(base, panel(triangle))).collect()
}

/// Walks around the base color in steps of the golden ratio, so that consecutive panels are far apart.
fn tint(base: Oklab, panel: u32) -> Color {
    const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;
    let turn = (f64::from(panel) * GOLDEN_RATIO).fract() * std::f64::consts::TAU;
    let (sin, cos) = (turn.sin() as f32, turn.cos() as f32);
    linear_from_oklab(base + Oklab::new(TINT_LIGHTNESS * cos, TINT_HUE * sin, TINT_HUE * cos))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    const CORNERS: [Point3<f64>; 4] = [
        Point3::new(-0.5, 0.0, 0.0),
        Point3::new(0.5, 0.0, 0.0),
        Point3::new(0.5, 1.0, 0.0),
        Point3::new(-0.5, 1.0, 0.0),
    ];

    fn is_png(bytes: &[u8]) -> bool {
        bytes.starts_with(b"\x89PNG")
    }

    #[test]
    fn panels_are_told_apart_but_hardly() {
        let garment = GarmentView { triangles: &[[0, 1, 2]; 7], panels: &[0, 1, 2, 3, 4, 5], ..GarmentView::default() };
        let tints = panel_tints(&garment);
        assert_eq!(tints.len(), 7);
        for (i, a) in tints[..6].iter().enumerate() {
            for b in &tints[..i] {
                let difference = (oklab_from_linear(*a) - oklab_from_linear(*b)).norm();
                assert!((0.003..0.06).contains(&difference), "{difference}");
            }
        }
        assert_eq!(tints[6], tints[0]);
    }

    #[test]
    fn any_garment_and_body_give_a_picture() {
        let cloth = GarmentView {
            positions: &CORNERS,
            triangles: &[[0, 1, 2], [0, 2, 3], [0, 9, 1], [1, 1, 1]],
            panels: &[3],
            seams: &[[0, 2], [7, 8]],
            colors: &[],
        };
        let skin = BodyView { positions: &CORNERS, triangles: &[[2, 1, 0]] };
        let broken = [Point3::new(f64::NAN, 0.0, 0.0), Point3::new(f64::INFINITY, 0.0, 0.0), Point3::origin()];
        let broken = BodyView { positions: &broken, triangles: &[[0, 1, 2]] };
        for garment in [GarmentView::default(), cloth] {
            for body in [BodyView::default(), skin, broken] {
                assert!(is_png(&preview(&garment, &body)));
            }
        }
    }

    #[test]
    fn given_colors_replace_the_tints() {
        let garment = GarmentView { positions: &CORNERS, triangles: &[[0, 1, 2], [0, 2, 3]], ..GarmentView::default() };
        let marked = GarmentView { colors: &[Color::new(0.8, 0.0, 0.0); 2], ..garment };
        let body = BodyView::default();
        assert_ne!(preview(&garment, &body), preview(&marked, &body));
    }
}
