//! The picture itself: a canvas in linear light while it is made, then bytes.

use super::color::{Color, SrgbTable};

/// Longest side of a picture, pixels. Beyond most screens; keeps a slip in a size from eating the memory.
pub const MAX_SIDE: u32 = 4096;

/// A finished picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// sRGB, row by row from the top left; `width × height` of them.
    pub pixels: Vec<[u8; 3]>,
}

impl Image {
    /// The picture as a PNG file, with the sRGB chunk.
    pub fn to_png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header().expect("a picture has at least one pixel and memory takes every byte");
        writer
            .write_image_data(self.pixels.as_flattened())
            .expect("there are width × height pixels and memory takes every byte");
        writer.finish().expect("all rows are written and memory takes every byte");
        bytes
    }
}

/// A picture in the making, in linear light.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    pub(super) width: u32,
    pub(super) height: u32,
    /// Row by row from the top left; `width × height` of them.
    pub(super) pixels: Vec<Color>,
}

impl Canvas {
    /// A black canvas; each side is brought into 1 to [`MAX_SIDE`].
    pub(super) fn new(size: [u32; 2]) -> Self {
        let [width, height] = size.map(|side| side.clamp(1, MAX_SIDE));
        let pixels = vec![Color::zeros(); width as usize * height as usize];
        Self { width, height, pixels }
    }

    /// Lays `color` over one pixel with `opacity` 0 to 1; beside the canvas nothing happens.
    pub(super) fn blend(&mut self, x: i64, y: i64, color: Color, opacity: f32) {
        let inside = (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        if inside {
            let pixel = &mut self.pixels[y as usize * self.width as usize + x as usize];
            *pixel = pixel.lerp(&color, opacity);
        }
    }

    /// Fills the pixels `x0..x1` × `y0..y1`.
    pub(super) fn fill(&mut self, [x0, y0]: [i64; 2], [x1, y1]: [i64; 2], color: Color) {
        for y in y0..y1 {
            for x in x0..x1 {
                self.blend(x, y, color, 1.0);
            }
        }
    }

    pub(super) fn to_image(&self) -> Image {
        let table = SrgbTable::new();
        let pixel = |(index, &color): (usize, &Color)| {
            let index = index as u32;
            table.bytes(color, index % self.width, index / self.width)
        };
        Image { width: self.width, height: self.height, pixels: self.pixels.iter().enumerate().map(pixel).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_can_be_read_back() {
        let mut canvas = Canvas::new([5, 3]);
        canvas.fill([1, 1], [3, 2], Color::new(1.0, 0.0, 0.0));
        let image = canvas.to_image();
        let bytes = image.to_png();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, image.pixels.as_flattened());
        assert_eq!(image.pixels[6], [255, 0, 0]);
    }

    #[test]
    fn sizes_are_brought_into_range() {
        let canvas = Canvas::new([0, 1]);
        assert_eq!((canvas.width, canvas.height), (1, 1));
        assert_eq!(canvas.to_image().pixels.len(), 1);
    }
}
