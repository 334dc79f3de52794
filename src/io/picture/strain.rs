//! `strain.png`: where the fabric is stretched or compressed, in colors with a scale.

use super::color::{Color, color_from_srgb};
use super::diverging::Scale;
use super::image::Canvas;
use super::scene::{Coloring, Lighting, Scene, Surface};
use super::sheet::{self, Strips};
use super::subject::{BodyView, Focus, GarmentView};
use super::text::{self, Style};

/// Strain (`l/L − 1`, no unit) over a garment, borrowed. Where the slice is too short, or holds no number, the garment
/// is drawn in dark grey, which is not on the scale.
#[derive(Clone, Copy, Debug)]
pub enum StrainField<'a> {
    /// One per triangle.
    PerTriangle(&'a [f64]),
    /// One per particle, interpolated between.
    PerParticle(&'a [f64]),
}

/// Ends of the scale to choose from. The least is the largest stretch of a garment that is ready for hand-off, so that
/// pictures of good fits can be compared.
const RANGES: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];

/// This part of the values lies within the scale; the rest is drawn in the colors of its ends.
const COVERED: f64 = 0.98;

/// sRGB: a garment without a value; body in plain grey, so that it is not taken for one; writing.
const UNKNOWN: u32 = 0x50504c;
const BODY_COLOR: u32 = 0xb9b8b6;
const INK: u32 = 0x33332f;

/// Front and back, radians.
const AZIMUTHS: [f64; 2] = [0.0, std::f64::consts::PI];
const VIEW_NAMES: [&str; 2] = ["front", "back"];

/// Layout, pixels.
const STRIPS: Strips = Strips { header: 84, footer: 150, width: 1500 };
const MARGIN: i64 = 40;
const BAR: [i64; 2] = [760, 26];

/// The stretch of the garment as colors, from the front and from the back, as a PNG file.
///
/// The scale ends at 5 %, or at the next larger of 10, 20, 50 and 100 % that holds 98 % of the values.
pub fn strain(garment: &GarmentView, body: &BodyView, field: StrainField) -> Vec<u8> {
    let values = match field {
        StrainField::PerTriangle(values) | StrainField::PerParticle(values) => values,
    };
    let range = range(values);
    let scale = Scale::new(range);
    let unknown = color_from_srgb(UNKNOWN);
    let colors = |count: usize| -> Vec<Color> {
        let color = |index| values.get(index).and_then(|&strain| scale.color(strain)).unwrap_or(unknown);
        (0..count).map(color).collect()
    };
    let (triangles, particles);
    let coloring = match field {
        StrainField::PerTriangle(_) => {
            triangles = colors(garment.triangles.len());
            Coloring::PerTriangle(&triangles)
        }
        StrainField::PerParticle(_) => {
            particles = colors(garment.positions.len());
            Coloring::PerVertex(&particles)
        }
    };
    let scene = Scene {
        surfaces: vec![
            body.surface(color_from_srgb(BODY_COLOR)),
            Surface { positions: garment.positions, triangles: garment.triangles, coloring, lines: garment.seams },
        ],
        floor: body.floor(),
        lighting: Lighting::Even,
    };
    let (mut canvas, columns) = sheet::draw(&scene, &Focus::new(garment, body), &AZIMUTHS, STRIPS);
    let ink = color_from_srgb(INK);
    text::write(&mut canvas, "Stretch of the fabric", Style::Title, [MARGIN, MARGIN], ink);
    for (name, column) in VIEW_NAMES.iter().zip(&columns) {
        let middle = (column.x0 + column.x1) / 2;
        text::write_centered(&mut canvas, name, Style::Label, [middle, column.y1], ink);
    }
    draw_scale(&mut canvas, &scale, range);
    canvas.to_image().to_png()
}

/// End of the scale for these values.
fn range(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).filter(|size| size.is_finite()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let covered = (COVERED * sizes.len() as f64).ceil() as usize;
    let needed = covered.checked_sub(1).map_or(0.0, |index| sizes[index]);
    let last = RANGES[RANGES.len() - 1];
    RANGES.into_iter().find(|&range| range >= needed).unwrap_or(last)
}

/// A bar with the colors of the scale in the middle of the lower border, with ticks in per cent.
fn draw_scale(canvas: &mut Canvas, scale: &Scale, range: f64) {
    let ink = color_from_srgb(INK);
    let [width, height] = BAR;
    let x0 = (i64::from(canvas.width) - width) / 2;
    let y0 = i64::from(canvas.height) - 88;
    canvas.fill([x0 - 1, y0 - 1], [x0 + width + 1, y0 + height + 1], ink);
    for step in 0..width {
        let strain = range * (2.0 * (step as f64 + 0.5) / width as f64 - 1.0);
        let color = scale.color(strain).unwrap_or_default();
        canvas.fill([x0 + step, y0], [x0 + step + 1, y0 + height], color);
    }
    for tick in -2..=2 {
        let x = x0 + (width - 1) * (tick + 2) / 4;
        canvas.fill([x, y0 + height], [x + 1, y0 + height + 8], ink);
        let label = percent(range * tick as f64 / 2.0);
        text::write_centered(canvas, &label, Style::Label, [x, y0 + height + 12], ink);
    }
    let above = y0 + (height - 24) / 2;
    let left = x0 - 20 - text::width("compressed", Style::Label);
    text::write(canvas, "compressed", Style::Label, [left, above], ink);
    text::write(canvas, "stretched", Style::Label, [x0 + width + 20, above], ink);
}

/// `+2.5 %`, `0 %`, `-5 %`.
fn percent(strain: f64) -> String {
    // Ranges are written to a tenth of a per cent at most; rounding takes away 2.5000000000000004.
    let tenths = (strain * 1000.0).round() / 10.0;
    if tenths == 0.0 { "0 %".to_owned() } else { format!("{tenths:+} %") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn the_scale_holds_most_values_and_never_less_than_the_limit() {
        assert_eq!(range(&[]), 0.05);
        assert_eq!(range(&[0.001, -0.002]), 0.05);
        assert_eq!(range(&[f64::NAN, 0.07]), 0.1);
        assert_eq!(range(&[-0.3; 50]), 0.5);
        assert_eq!(range(&[1.0e9, f64::INFINITY]), 1.0);
        let mut mostly_small = vec![0.01; 99];
        mostly_small.push(0.9);
        assert_eq!(range(&mostly_small), 0.05);
    }

    #[test]
    fn ticks_read_as_written_by_hand() {
        assert_eq!(percent(0.05 / 2.0), "+2.5 %");
        assert_eq!(percent(-0.1), "-10 %");
        assert_eq!(percent(-0.0), "0 %");
    }

    #[test]
    fn stretch_is_red_and_compression_blue() {
        let positions = [[-0.5, 0.0], [0.5, 0.0], [0.5, 1.0], [-0.5, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0));
        let garment =
            GarmentView { positions: &positions, triangles: &[[0, 1, 2], [0, 2, 3]], ..GarmentView::default() };
        let picture = strain(&garment, &BodyView::default(), StrainField::PerTriangle(&[0.05, -0.05]));
        let mut reader = png::Decoder::new(std::io::Cursor::new(&picture)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let width = reader.next_frame(&mut pixels).unwrap().width as usize;
        let height = pixels.len() / width / 3;
        // The first triangle fills the lower right half of the square in the left view.
        let middle = (STRIPS.header as usize + height - STRIPS.footer as usize) / 2;
        let pixel = |x: usize, y: usize| &pixels[(y * width + x) * 3..][..3];
        let lower_right = pixel(width / 4 + 60, middle + 30);
        let upper_left = pixel(width / 4 - 60, middle - 30);
        assert!(lower_right[0] > lower_right[2] + 60, "{lower_right:?}");
        assert!(upper_left[2] > upper_left[0] + 60, "{upper_left:?}");
    }

    #[test]
    fn missing_values_give_a_picture() {
        let positions = [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
        let garment =
            GarmentView { positions: &positions, triangles: &[[0, 1, 2], [2, 1, 9]], ..GarmentView::default() };
        for field in [StrainField::PerTriangle(&[]), StrainField::PerParticle(&[f64::NAN])] {
            assert!(strain(&garment, &BodyView::default(), field).starts_with(b"\x89PNG"));
        }
    }
}
