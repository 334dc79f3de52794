//! Pictures of a result: what the garment looks like, where it is stretched, how the minimization went.
//!
//! * [`preview()`]: garment and body from three sides;
//! * [`strain()`]: the stretch in colors, with a scale;
//! * [`measured()`]: a body with what was measured on it;
//! * [`convergence()`]: energy and residual against evaluations, as SVG;
//! * [`Film`]: frames of a simulation;
//! * [`rivals()`]: several runs against evaluations and seconds, as SVG;
//! * [`render()`]: any [`Scene`] of [`Surface`]s in a [`View`], for everything else.
//!
//! The renderer needs no graphics card: `raster` decides what each of sixteen samples in a pixel sees, `shade` colors
//! it under a `key_light` with soft shadow and an `ambient` light that tells how open each vertex is to sky and
//! ground, `studio` is the room around. All light is added up linear and written as sRGB.
//!
//! Promised: functions return bytes and touch neither file nor screen; the same input gives the same bytes on any
//! number of threads; no input panics, and no value that is not finite gets into a picture (vertices that are not
//! finite are left out with their triangles, colors are clamped). Not promised: the same bytes on another machine,
//! whose sine and cube root may round differently; physically exact light.
//!
//! ```
//! use nalgebra::Point3;
//! use toile::io::picture::{BodyView, GarmentView, preview};
//!
//! let positions = [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
//! let garment = GarmentView { positions: &positions, triangles: &[[0, 1, 2]], ..GarmentView::default() };
//! let png = preview(&garment, &BodyView::default());
//! assert!(png.starts_with(b"\x89PNG"));
//! ```

mod ambient;
mod camera;
mod color;
mod convergence;
mod crossings;
mod depth_map;
mod diverging;
mod film;
mod image;
mod key_light;
mod measured;
mod preview;
mod raster;
mod render;
mod rivals;
mod scene;
mod shade;
mod sheet;
mod strain;
mod studio;
mod subject;
mod text;

pub use camera::View;
pub use color::{Color, color_from_srgb};
pub use convergence::{Curve, CurvePoint, convergence};
pub use crossings::crossings;
pub use film::Film;
pub use image::{Image, MAX_SIDE};
pub use measured::{Marks, measured};
pub use preview::preview;
pub use render::render;
pub use rivals::{Rival, RivalChart, RivalPoint, rivals};
pub use scene::{Coloring, Lighting, MISSING_COLOR, Scene, Surface};
pub use strain::{StrainField, strain};
pub use subject::{BodyView, GarmentView};
