//! Words on a picture, in a bitmap font that comes with the program, so that they look the same everywhere.
//!
//! The font is Noto Sans Mono (SIL Open Font License). Basic Latin only; anything else is shown as a question mark.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::color::Color;
use super::image::Canvas;

/// A kind of writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// 32 pixels high, bold.
    Title,
    /// 24 pixels high.
    Label,
}

impl Style {
    fn font(self) -> (FontWeight, RasterHeight) {
        match self {
            Self::Title => (FontWeight::Bold, RasterHeight::Size32),
            Self::Label => (FontWeight::Regular, RasterHeight::Size24),
        }
    }
}

/// Pixels that a text is wide.
pub(super) fn width(text: &str, style: Style) -> i64 {
    let (weight, height) = style.font();
    (text.chars().count() * get_raster_width(weight, height)) as i64
}

/// Writes a text whose upper left corner is at `x`, `y`, pixels.
pub(super) fn write(canvas: &mut Canvas, text: &str, style: Style, [mut x, y]: [i64; 2], color: Color) {
    let (weight, height) = style.font();
    for character in text.chars() {
        let raster = get_raster(character, weight, height).or_else(|| get_raster('?', weight, height));
        for (row, opacities) in (y..).zip(raster.iter().flat_map(|raster| raster.rows())) {
            for (column, &opacity) in (x..).zip(opacities) {
                canvas.blend(column, row, color, f32::from(opacity) / 255.0);
            }
        }
        x += get_raster_width(weight, height) as i64;
    }
}

/// As [`write()`], with the middle of the upper border at `x`, `y`.
pub(super) fn write_centered(canvas: &mut Canvas, text: &str, style: Style, [x, y]: [i64; 2], color: Color) {
    write(canvas, text, style, [x - width(text, style) / 2, y], color);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ink(text: &str, style: Style, place: [i64; 2]) -> f32 {
        let mut canvas = Canvas::new([200, 50]);
        write(&mut canvas, text, style, place, Color::new(1.0, 1.0, 1.0));
        canvas.pixels.iter().map(|pixel| pixel.x).sum()
    }

    #[test]
    fn letters_leave_ink_and_spaces_do_not() {
        assert_eq!(ink("   ", Style::Label, [0, 0]), 0.0);
        assert!(ink("I", Style::Label, [0, 0]) > 20.0);
        assert!(ink("MM", Style::Label, [0, 0]) > 1.5 * ink("M", Style::Label, [0, 0]));
        assert!(ink("M", Style::Title, [0, 0]) > ink("M", Style::Label, [0, 0]));
    }

    #[test]
    fn unknown_letters_are_question_marks() {
        assert_eq!(ink("\u{4e00}", Style::Title, [0, 0]), ink("?", Style::Title, [0, 0]));
        assert!(ink("?", Style::Title, [0, 0]) > 0.0);
    }

    #[test]
    fn text_beside_the_canvas_is_cut_off() {
        assert_eq!(ink("M", Style::Title, [-500, 0]), 0.0);
        assert_eq!(ink("M", Style::Title, [0, 500]), 0.0);
        let cut = ink("M", Style::Title, [-8, 0]);
        assert!(cut > 0.0 && cut < ink("M", Style::Title, [0, 0]));
    }
}
