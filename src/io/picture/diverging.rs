//! The strain scale: blue where the fabric is compressed, light grey at rest, red where it is stretched.
//!
//! Both arms lose lightness at the same rate in Oklab, so that equal amounts look equally strong, also in grey and to
//! people who do not tell red from green. No hue but these two occurs.

use super::color::{Color, color_from_srgb, linear_from_oklab, oklab_from_linear};

/// Stops of the two arms at 0, ½ and 1, sRGB.
const REST: u32 = 0xe7e6e4;
const COMPRESSED: [u32; 2] = [0x7fa9dc, 0x1d4f9f];
const STRETCHED: [u32; 2] = [0xe9977c, 0xa5231f];

/// The color at −1 (compressed) to 1 (stretched); beyond the ends stays at them.
pub(super) fn diverging(value: f64) -> Color {
    let arm = if value < 0.0 { COMPRESSED } else { STRETCHED };
    let stops = [REST, arm[0], arm[1]].map(|stop| oklab_from_linear(color_from_srgb(stop)));
    let along = 2.0 * value.abs().min(1.0) as f32;
    let lab = if along < 1.0 { stops[0].lerp(&stops[1], along) } else { stops[1].lerp(&stops[2], along - 1.0) };
    linear_from_oklab(lab)
}

/// Colors of the scale for many values, from a table: a color takes six cube roots.
pub(super) struct Scale {
    /// Strain at the ends.
    range: f64,
    colors: Vec<Color>,
}

impl Scale {
    /// Steps in the table, finer than eight-bit colors.
    const STEPS: usize = 1024;

    /// The scale from `-range` to `range`.
    pub(super) fn new(range: f64) -> Self {
        let color = |step: usize| diverging(2.0 * step as f64 / Self::STEPS as f64 - 1.0);
        Self { range, colors: (0..=Self::STEPS).map(color).collect() }
    }

    /// None for what is not a number.
    pub(super) fn color(&self, strain: f64) -> Option<Color> {
        let along = (strain / self.range * 0.5 + 0.5).clamp(0.0, 1.0) * Self::STEPS as f64;
        (!along.is_nan()).then(|| self.colors[along.round() as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(a: Color, b: u32) -> f32 {
        (a - color_from_srgb(b)).norm()
    }

    #[test]
    fn ends_and_middle_are_the_stops() {
        assert!(distance(diverging(-1.0), COMPRESSED[1]) < 1e-3);
        assert!(distance(diverging(0.0), REST) < 1e-3);
        assert!(distance(diverging(1.0), STRETCHED[1]) < 1e-3);
        assert_eq!(diverging(7.0), diverging(1.0));
        assert_eq!(diverging(f64::NEG_INFINITY), diverging(-1.0));
    }

    #[test]
    fn both_arms_darken_alike() {
        let lightness = |value: f64| oklab_from_linear(diverging(value)).x;
        for step in 0..20 {
            let [near, far] = [f64::from(step) / 20.0, f64::from(step + 1) / 20.0];
            assert!(lightness(far) < lightness(near) && lightness(-far) < lightness(-near));
            assert!((lightness(far) - lightness(-far)).abs() < 0.04, "{far}");
        }
    }

    #[test]
    fn the_table_agrees_with_the_formula() {
        let scale = Scale::new(0.05);
        for strain in [-1.0, -0.05, -0.02, 0.0, 0.01, 0.05, f64::INFINITY] {
            let color = scale.color(strain).unwrap();
            assert!((color - diverging(strain / 0.05)).norm() < 2e-3);
        }
        assert_eq!(scale.color(f64::NAN), None);
    }
}
