//! Pictures of a simulation: some frames on one sheet, and all that were shot as a moving picture (animated PNG).

use super::camera::View;
use super::color::color_from_srgb;
use super::image::{Image, MAX_SIDE};
use super::preview::{BODY_COLOR, panel_tints};
use super::render::render;
use super::scene::{Coloring, Lighting, Scene, Surface};
use super::subject::{BodyView, Focus, GarmentView};
use nalgebra::{Point3, Vector3};

/// Of each picture, pixels: what fits beside a text, and six of them on a sheet.
const SIZE: [u32; 2] = [300, 480];
/// Pictures side by side on a sheet.
const COLUMNS: usize = 6;
/// The most pictures that a sheet shows.
const MOST_ON_SHEET: usize = 18;
/// From the body's left, a little from above: legs that stride are seen apart.
const AZIMUTH: f64 = 0.7;
const ELEVATION: f64 = 0.09;
/// Room around what is shown, for limbs that swing.
const ROOM: f64 = 1.12;

/// Frames that were shot one after the other, from a place that goes along with the body.
#[derive(Default)]
pub struct Film {
    view: Option<(View, Vector3<f64>)>,
    images: Vec<Image>,
}

impl Film {
    pub fn is_empty(&self) -> bool {
        self.images.is_empty()
    }

    /// Adds a picture. The first one settles how large things are shown.
    pub fn shoot(&mut self, garment: &GarmentView, body: &BodyView) {
        let middle = middle(if body.positions.is_empty() { garment.positions } else { body.positions });
        let (view, first) = self.view.get_or_insert_with(|| {
            let focus = Focus::new(garment, body);
            let framed = View::framing(&focus.0, AZIMUTH, ELEVATION, f64::from(SIZE[0]) / f64::from(SIZE[1]));
            (View { height: framed.height * ROOM, ..framed }, middle)
        });
        // It goes along, but neither up nor down: steps are to be seen.
        let along = middle - *first;
        let view = View { target: view.target + Vector3::new(along.x, 0.0, along.z), ..*view };
        let tints = panel_tints(garment);
        let scene = Scene {
            surfaces: vec![
                body.surface(color_from_srgb(BODY_COLOR)),
                Surface {
                    positions: garment.positions,
                    triangles: garment.triangles,
                    coloring: Coloring::PerTriangle(&tints),
                    lines: garment.seams,
                },
            ],
            floor: None,
            lighting: Lighting::Studio,
        };
        self.images.push(render(&scene, &view, SIZE));
    }

    /// At most eighteen of the pictures, evenly spread, as a PNG file.
    pub fn contact_sheet(&self) -> Vec<u8> {
        let count = self.images.len().min(MOST_ON_SHEET);
        let chosen: Vec<&Image> =
            (0..count).map(|k| &self.images[k * (self.images.len() - 1) / (count - 1).max(1)]).collect();
        let (columns, rows) = (count.clamp(1, COLUMNS), count.div_ceil(COLUMNS).max(1));
        let [width, height] = [SIZE[0] * columns as u32, SIZE[1] * rows as u32].map(|side| side.min(MAX_SIDE));
        let mut sheet = Image { width, height, pixels: vec![[255; 3]; width as usize * height as usize] };
        for (k, image) in chosen.into_iter().enumerate() {
            let (left, top) = (k % COLUMNS * SIZE[0] as usize, k / COLUMNS * SIZE[1] as usize);
            for (y, row) in image.pixels.chunks(image.width as usize).enumerate() {
                let start = (top + y) * width as usize + left;
                sheet.pixels[start..start + row.len()].copy_from_slice(row);
            }
        }
        sheet.to_png()
    }

    /// All pictures as an animated PNG file that repeats without end; programs that know only still ones show the first.
    pub fn animation(&self, frames_per_second: f64) -> Vec<u8> {
        let delay = (1000.0 / frames_per_second).round().clamp(1.0, f64::from(u16::MAX)) as u16;
        let mut bytes = Vec::new();
        if self.images.is_empty() {
            return Image { width: 1, height: 1, pixels: vec![[255; 3]] }.to_png();
        }
        let mut encoder = png::Encoder::new(&mut bytes, SIZE[0], SIZE[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let written = encoder
            .set_animated(self.images.len() as u32, 0)
            .and_then(|()| encoder.set_frame_delay(delay, 1000))
            .and_then(|()| encoder.write_header())
            .and_then(|mut writer| {
                self.images.iter().try_for_each(|image| writer.write_image_data(image.pixels.as_flattened()))?;
                writer.finish()
            });
        written.expect("all pictures have the same size and memory takes every byte");
        bytes
    }
}

/// Middle of the bounding box.
fn middle(points: &[Point3<f64>]) -> Vector3<f64> {
    let Some(first) = points.first() else { return Vector3::zeros() };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    nalgebra::center(&low, &high).coords
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_is_a_sheet_and_a_moving_picture() {
        let mut film = Film::default();
        for k in 0..20 {
            let at = f64::from(k) * 0.1;
            let corner = |x: f64, y: f64| Point3::new(at + x, y, 0.0);
            let positions = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
            let garment = GarmentView { positions: &positions, triangles: &[[0, 1, 2]], ..GarmentView::default() };
            film.shoot(&garment, &BodyView::default());
        }
        // The viewer went along.
        assert_eq!(film.images[0], film.images[19]);
        let reader = |bytes: Vec<u8>| png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let animation = reader(film.animation(24.0));
        assert_eq!(animation.info().animation_control.unwrap().num_frames, 20);
        let sheet = reader(film.contact_sheet());
        assert_eq!((sheet.info().width, sheet.info().height), (1800, 1440));
        assert!(reader(Film::default().contact_sheet()).info().width > 0);
    }
}
