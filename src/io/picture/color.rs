//! Colors: linear light for arithmetic, sRGB bytes for files, Oklab for choosing them.
//!
//! Light adds up in linear RGB, so every sum and mean of the renderer is taken there (IEC 61966-2-1 for the way to
//! sRGB and back). Equal steps to the eye are equal steps in Oklab (B. Ottosson, "A perceptual color space for image
//! processing", 2020), so tints and the strain scale are made there.

use nalgebra::{Matrix3, Vector3};

/// Red, green and blue in linear light; 0 is black, 1 the white of the screen.
pub type Color = Vector3<f32>;

/// The color of three sRGB bytes, written as in a style sheet: `0xRRGGBB`.
pub fn color_from_srgb(hex: u32) -> Color {
    let channel = |shift: u32| linear_from_srgb(((hex >> shift) & 0xff) as f32 / 255.0);
    Color::new(channel(16), channel(8), channel(0))
}

/// One channel, sRGB to linear light.
fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// One channel, linear light to sRGB.
fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear light to sRGB bytes by table, because a picture has millions of channels and `powf` is slow.
pub(super) struct SrgbTable(Vec<u16>);

impl SrgbTable {
    /// So many steps that the steepest part of the curve (12.92 × 255 bytes per unit of light) has twenty a byte.
    const STEPS: usize = 1 << 16;

    /// Table entries count in this part of a byte.
    const PART: f32 = 256.0;

    pub(super) fn new() -> Self {
        let entry = |step| (srgb_from_linear(step as f32 / Self::STEPS as f32) * 255.0 * Self::PART).round() as u16;
        Self((0..=Self::STEPS).map(entry).collect())
    }

    /// The bytes of a color in a pixel; what is out of range, NaN included, goes to the nearest end.
    ///
    /// Neighbouring pixels round at different places (ordered dither, B. Bayer 1973), so that the slow gradient of a
    /// background does not fall into bands. Colors that are exact in bytes stay as they are.
    pub(super) fn bytes(&self, color: Color, x: u32, y: u32) -> [u8; 3] {
        let threshold = BAYER[(y % 4) as usize][(x % 4) as usize] * 16 + 8;
        let byte = |channel: f32| {
            let entry = self.0[(channel.clamp(0.0, 1.0) * Self::STEPS as f32 + 0.5) as usize];
            (entry.saturating_add(threshold) >> 8) as u8
        };
        [byte(color.x), byte(color.y), byte(color.z)]
    }
}

/// The order in which the pixels of a 4 × 4 block are rounded up.
const BAYER: [[u16; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// A color in Oklab: lightness 0 to 1, then green to red, then blue to yellow.
pub(super) type Oklab = Vector3<f32>;

const LMS_FROM_LINEAR: Matrix3<f32> = Matrix3::new(
    0.412_221_46,
    0.536_332_55,
    0.051_445_995,
    0.211_903_5,
    0.680_699_5,
    0.107_396_96,
    0.088_302_46,
    0.281_718_85,
    0.629_978_7,
);

const OKLAB_FROM_LMS_ROOTS: Matrix3<f32> = Matrix3::new(
    0.210_454_26,
    0.793_617_8,
    -0.004_072_047,
    1.977_998_5,
    -2.428_592_2,
    0.450_593_7,
    0.025_904_037,
    0.782_771_77,
    -0.808_675_77,
);

const LMS_ROOTS_FROM_OKLAB: Matrix3<f32> =
    Matrix3::new(1.0, 0.396_337_78, 0.215_803_76, 1.0, -0.105_561_346, -0.063_854_17, 1.0, -0.089_484_18, -1.291_485_5);

const LINEAR_FROM_LMS: Matrix3<f32> = Matrix3::new(
    4.076_741_7,
    -3.307_711_6,
    0.230_969_94,
    -1.268_438,
    2.609_757_4,
    -0.341_319_4,
    -0.004_196_086_3,
    -0.703_418_6,
    1.707_614_7,
);

pub(super) fn oklab_from_linear(color: Color) -> Oklab {
    OKLAB_FROM_LMS_ROOTS * (LMS_FROM_LINEAR * color).map(f32::cbrt)
}

/// Back to linear light; colors that no screen shows are clipped.
pub(super) fn linear_from_oklab(lab: Oklab) -> Color {
    let lms = (LMS_ROOTS_FROM_OKLAB * lab).map(|root| root * root * root);
    (LINEAR_FROM_LMS * lms).map(|channel| channel.clamp(0.0, 1.0))
}

/// How bright a linear color looks, 0 to 1 (Rec. 709 weights).
pub(super) fn luminance(color: Color) -> f32 {
    color.dot(&Vector3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_bytes_survive_linear_light_and_back() {
        let table = SrgbTable::new();
        for byte in 0..=255_u32 {
            let color = color_from_srgb(byte << 16 | byte << 8 | byte);
            for pixel in 0..16 {
                assert_eq!(table.bytes(color, pixel % 4, pixel / 4), [byte as u8; 3]);
            }
        }
    }

    #[test]
    fn between_two_bytes_half_of_the_pixels_round_up() {
        let [low, high] = [0x808080, 0x818181].map(color_from_srgb);
        let between = low.lerp(&high, 0.5);
        let table = SrgbTable::new();
        let sum: u32 = (0..16).map(|pixel| u32::from(table.bytes(between, pixel % 4, pixel / 4)[0])).sum();
        assert!(sum.abs_diff(16 * 0x80 + 8) <= 1, "{sum}");
    }

    #[test]
    fn bytes_of_any_number_are_in_range() {
        let wild = Color::new(f32::NAN, f32::INFINITY, -1.0);
        assert_eq!(SrgbTable::new().bytes(wild, 0, 0), [0, 255, 0]);
    }

    #[test]
    fn oklab_inverts_and_calls_white_white() {
        let white = oklab_from_linear(Color::new(1.0, 1.0, 1.0));
        assert!((white - Oklab::new(1.0, 0.0, 0.0)).norm() < 1e-4);
        let teal = color_from_srgb(0x2a7f86);
        assert!((linear_from_oklab(oklab_from_linear(teal)) - teal).norm() < 1e-4);
    }
}
