//! Several views of one scene side by side, framed on the garment.

use super::camera::View;
use super::image::Canvas;
use super::render::Stage;
use super::scene::Scene;
use super::studio::backdrop;
use super::subject::Focus;
use crate::geometry::coverage::Rect;

/// What is to be drawn around the views, pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Strips {
    /// Free height above the views, for a title.
    pub(super) header: u32,
    /// Free height below the views, for a scale.
    pub(super) footer: u32,
    /// Width of the picture.
    pub(super) width: u32,
}

/// Height of the views, pixels: at least enough to see folds, at most a screen.
const LEAST_HEIGHT: f64 = 760.0;
const GREATEST_HEIGHT: f64 = 1300.0;

/// Space around the garment, relative to its greater extent. The body fades out in it.
const MARGIN: f64 = 0.09;

/// The eye looks down a little, rad: shows the floor under the feet, and keeps a front view a front view.
const ELEVATION: f64 = 0.09;

/// Draws the views from several azimuths (radians) in a row; returns the canvas and the part that each view fills.
pub(super) fn draw(scene: &Scene, focus: &Focus, azimuths: &[f64], strips: Strips) -> (Canvas, Vec<Rect>) {
    let layout = Layout::new(focus, azimuths, strips);
    let mut canvas = backdrop(layout.size);
    let stage = Stage::new(scene);
    for (view, &column) in layout.views.iter().zip(&layout.columns) {
        stage.draw(view, &mut canvas, column, layout.margin);
    }
    (canvas, layout.columns)
}

/// Where everything goes.
struct Layout {
    /// Of the picture, pixels.
    size: [u32; 2],
    views: Vec<View>,
    columns: Vec<Rect>,
    /// Pixels around the focus in each column.
    margin: f64,
}

impl Layout {
    /// Every view at the same scale, every column as wide as what it shows.
    fn new(focus: &Focus, azimuths: &[f64], strips: Strips) -> Self {
        let framed: Vec<_> = azimuths.iter().map(|&azimuth| View::centered(&focus.0, azimuth, ELEVATION)).collect();
        let greatest = |axis: usize| framed.iter().map(|(_, extent)| extent[axis]).fold(0.0, f64::max);
        let tallest = greatest(1);
        let margin = MARGIN * tallest.max(greatest(0));
        let width: f64 = framed.iter().map(|(_, extent)| extent[0] + 2.0 * margin).sum();
        let height = tallest + 2.0 * margin;
        let picture_width = f64::from(strips.width);
        let pixels_per_meter = (picture_width / width).min(GREATEST_HEIGHT / height);
        let pixel_height = (pixels_per_meter * height).max(LEAST_HEIGHT).round();
        // What is left over beside the views is shared by them.
        let spare = (picture_width / pixels_per_meter - width) / framed.len().max(1) as f64;
        let level = framed.iter().map(|(view, _)| view.target.y).sum::<f64>() / framed.len().max(1) as f64;

        let y0 = i64::from(strips.header);
        let y1 = y0 + pixel_height as i64;
        let mut right = 0.0;
        let mut columns = Vec::new();
        let mut views = Vec::new();
        for (mut view, extent) in framed {
            let left = right;
            right += (extent[0] + 2.0 * margin + spare) * pixels_per_meter;
            columns.push(Rect { x0: left.round() as i64, y0, x1: right.round() as i64, y1 });
            view.height = pixel_height / pixels_per_meter;
            view.target.y = level;
            views.push(view);
        }
        Self {
            size: [strips.width, strips.header + pixel_height as u32 + strips.footer],
            views,
            columns,
            margin: margin * pixels_per_meter,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn layout(points: Vec<Point3<f64>>) -> Layout {
        let strips = Strips { header: 10, footer: 20, width: 900 };
        Layout::new(&Focus(points), &[0.0, 0.7, 3.0], strips)
    }

    #[test]
    fn columns_fill_the_picture_between_the_strips() {
        let square = vec![Point3::new(-1.0, 0.0, 0.0), Point3::new(1.0, 2.0, 0.0)];
        let tower = vec![Point3::new(0.0, 0.0, 0.0), Point3::new(0.1, 2.0, 0.0)];
        let plank = vec![Point3::new(-9.0, 0.0, 0.0), Point3::new(9.0, 0.1, 0.0)];
        for points in [square, tower, plank, vec![Point3::origin()], vec![]] {
            let layout = layout(points);
            assert_eq!(layout.columns[0].x0, 0);
            assert_eq!(layout.columns[2].x1, 900);
            for pair in layout.columns.windows(2) {
                assert_eq!(pair[0].x1, pair[1].x0);
            }
            let [y0, y1] = [layout.columns[0].y0, layout.columns[0].y1];
            assert_eq!((y0, y1 + 20), (10, i64::from(layout.size[1])));
            assert!((LEAST_HEIGHT..=GREATEST_HEIGHT + 1.0).contains(&((y1 - y0) as f64)));
        }
    }

    #[test]
    fn all_views_have_one_scale() {
        let layout = layout(vec![Point3::new(-1.0, 0.0, 0.0), Point3::new(1.0, 1.5, 0.3)]);
        for pair in layout.views.windows(2) {
            assert_eq!(pair[0].height, pair[1].height);
            assert_eq!(pair[0].distance, pair[1].distance);
            assert_eq!(pair[0].target.y, pair[1].target.y);
        }
    }
}
