//! Rivals side by side: a quantity against evaluations and against processor seconds, all logarithmic.

use super::convergence::{COLORS, GRID, INK, LABEL_FONT, TITLE_FONT, decade, extent, significant};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::*;

/// A picture of several runs.
#[derive(Clone, Copy, Debug)]
pub struct RivalChart<'a> {
    pub title: &'a str,
    pub curves: &'a [Rival<'a>],
    /// Where the finish line is, in the unit of the points.
    pub line: Option<f64>,
}

/// One run.
#[derive(Clone, Copy, Debug)]
pub struct Rival<'a> {
    /// For the legend.
    pub name: &'a str,
    /// In the order of the run.
    pub points: &'a [RivalPoint],
    /// Evaluations at which it met its finish line, which is marked.
    pub finish: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RivalPoint {
    /// In evaluations of the finest level.
    pub evaluations: f64,
    /// Of all processors.
    pub seconds: f64,
    pub y: f64,
    /// On a level but the finest: drawn faint, as its energy is not that of the finest.
    pub coarse: bool,
}

/// Size of the picture, units of the SVG.
const SIZE: (u32, u32) = (2000, 1060);
/// Height of the title, and of a row of the legend, which has so many names.
const TITLE_HEIGHT: u32 = 70;
const LEGEND_ROW: u32 = 46;
const NAMES_IN_ROW: usize = 3;
const LINE_WIDTH: u32 = 4;
const MARK_RADIUS: u32 = 9;
/// How much of its color a coarse level has.
const FAINT: f64 = 0.35;
/// Decades of the y axis, at most: what is still deeper is rounding.
const MOST_DECADES: f64 = 9.0;

type DrawResult = Result<(), Box<dyn std::error::Error>>;

/// Draws the runs as an SVG file, against evaluations on the left and seconds on the right. Points that are
/// not positive and finite have no place on the scales and leave a gap. The same chart gives the same bytes.
pub fn rivals(chart: &RivalChart) -> String {
    let mut svg = String::new();
    draw(&mut svg, chart).expect("finite, non-empty ranges can be drawn, and a string takes all that is written");
    svg
}

/// Places of the curves in one diagram, logarithms of both coordinates; NaN where there is none.
struct Panel {
    x_title: &'static str,
    curves: Vec<Vec<[f64; 2]>>,
    x: Axis,
}

/// An axis of logarithms.
#[derive(Clone)]
struct Axis {
    range: [f64; 2],
    /// Where a number is written.
    keys: Vec<f64>,
}

impl Axis {
    /// Covers all values, logarithms, but at most so many decades below the highest.
    fn new(values: impl Iterator<Item = f64>, most: f64) -> Self {
        let [low, high] = extent(values.filter(|v| v.is_finite())).unwrap_or([0.0, 1.0]);
        let low = low.max(high - most);
        let room = (0.03 * (high - low)).max(0.02);
        let range = [low - room, high + room];
        // The fewer decades there are, the more numbers are written in each.
        let steps: &[f64] = match high - low {
            decades if decades > 3.0 => &[1.0],
            decades if decades > 0.8 => &[1.0, 2.0, 5.0],
            _ => &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
        };
        let decades = range[0].floor() as i32..=range[1].ceil() as i32;
        let keys = decades.flat_map(|d| steps.iter().map(move |s| f64::from(d) + s.log10()));
        Self { range, keys: keys.filter(|k| (range[0]..=range[1]).contains(k)).collect() }
    }
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let along = (value - self.range[0]) / (self.range[1] - self.range[0]);
        limit.0 + (along * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.keys.clone()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range[0]..self.range[1]
    }
}

impl Panel {
    fn new(chart: &RivalChart, x_title: &'static str, x: impl Fn(&RivalPoint) -> f64) -> Self {
        let logarithm = |v: f64| if v > 0.0 && v.is_finite() { v.log10() } else { f64::NAN };
        let place = |p: &RivalPoint| [logarithm(x(p)), logarithm(p.y)];
        let curves: Vec<Vec<_>> = chart.curves.iter().map(|c| c.points.iter().map(place).collect()).collect();
        let seen = curves.iter().flatten().filter(|p| p[1].is_finite()).map(|p| p[0]);
        Self { x_title, x: Axis::new(seen, MOST_DECADES), curves }
    }
}

fn draw(svg: &mut String, chart: &RivalChart) -> DrawResult {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let rows = chart.curves.len().div_ceil(NAMES_IN_ROW).max(1) as u32;
    let (head, below) = root.split_vertically(TITLE_HEIGHT + rows * LEGEND_ROW);
    head.draw(&Text::new(chart.title, (40, 24), TITLE_FONT.into_font().color(&INK)))?;
    draw_legend(&head, chart)?;
    let (left, right) = below.split_horizontally(SIZE.0 / 2);
    let by_evaluations = Panel::new(chart, "evaluations, in those of the finest level", |p| p.evaluations);
    let by_seconds = Panel::new(chart, "processor seconds", |p| p.seconds);
    let line = chart.line.filter(|l| *l > 0.0 && l.is_finite()).map(f64::log10);
    let heights = by_evaluations.curves.iter().flatten().map(|p| p[1]).chain(line);
    let y = Axis::new(heights, MOST_DECADES);
    draw_panel(&left, chart, &by_evaluations, &y, line)?;
    draw_panel(&right, chart, &by_seconds, &y, line)?;
    root.present()?;
    Ok(())
}

fn draw_legend(head: &DrawingArea<SVGBackend, Shift>, chart: &RivalChart) -> DrawResult {
    let width = (SIZE.0 as usize - 80) / NAMES_IN_ROW;
    for (k, (curve, color)) in chart.curves.iter().zip(COLORS.iter().cycle()).enumerate() {
        let x = (40 + (k % NAMES_IN_ROW) * width) as i32;
        let y = (TITLE_HEIGHT + (k / NAMES_IN_ROW) as u32 * LEGEND_ROW) as i32 + 18;
        head.draw(&PathElement::new([(x, y), (x + 50, y)], color.stroke_width(LINE_WIDTH)))?;
        head.draw(&Text::new(curve.name, (x + 64, y - 15), LABEL_FONT.into_font().color(&INK)))?;
    }
    Ok(())
}

fn draw_panel(
    area: &DrawingArea<SVGBackend, Shift>,
    chart: &RivalChart,
    panel: &Panel,
    y: &Axis,
    line: Option<f64>,
) -> DrawResult {
    let mut plot = ChartBuilder::on(area)
        .margin(24)
        .x_label_area_size(90)
        .y_label_area_size(110)
        .build_cartesian_2d(panel.x.clone(), y.clone())?;
    plot.configure_mesh()
        .bold_line_style(GRID.stroke_width(2))
        .light_line_style(TRANSPARENT)
        .axis_style(INK.stroke_width(2))
        .label_style(LABEL_FONT.into_font().color(&INK))
        .x_desc(panel.x_title)
        .x_labels(panel.x.keys.len().max(1))
        .y_labels(y.keys.len().max(1))
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .draw()?;
    if let Some(line) = line {
        let [from, to] = panel.x.range;
        plot.draw_series(DashedLineSeries::new([(from, line), (to, line)], 14, 10, INK.stroke_width(2)))?;
    }
    let inside = |[px, py]: [f64; 2]| px.is_finite() && py.is_finite() && py >= y.range[0];
    for ((curve, places), color) in chart.curves.iter().zip(&panel.curves).zip(COLORS.iter().cycle()) {
        for coarse in [true, false] {
            let style = if coarse { color.mix(FAINT) } else { color.to_rgba() };
            let shown = |k: &usize| curve.points[*k].coarse == coarse && inside(places[*k]);
            for piece in pieces((0..places.len()).collect(), shown) {
                let points = piece.iter().map(|&k| (places[k][0], places[k][1]));
                plot.draw_series(LineSeries::new(points, style.stroke_width(LINE_WIDTH)))?;
            }
        }
        // The mark is at the last point that is no further than the finish.
        let finish = curve.finish.and_then(|finish| {
            // A count came through a text.
            let before = |k: &usize| curve.points[*k].evaluations <= finish * (1.0 + 1e-9) && inside(places[*k]);
            (0..places.len()).filter(|k| !curve.points[*k].coarse).rfind(before)
        });
        let mark = finish.map(|k| Circle::new((places[k][0], places[k][1]), MARK_RADIUS, color.filled()));
        plot.draw_series(mark)?;
    }
    Ok(())
}

/// Stretches of neighbours that are all shown.
fn pieces(all: Vec<usize>, shown: impl Fn(&usize) -> bool) -> Vec<Vec<usize>> {
    all.chunk_by(|a, b| shown(a) == shown(b)).filter(|piece| shown(&piece[0])).map(<[usize]>::to_vec).collect()
}

/// The number whose logarithm this is: in full where that is short.
fn label(logarithm: &f64) -> String {
    let value = 10f64.powf(*logarithm);
    if (-3.0..6.0).contains(&(logarithm + 1e-9)) {
        // Rounding of the logarithm must not show.
        significant((value * 1e4).round() / 1e4)
    } else {
        let written = decade(logarithm);
        if written.is_empty() { format!("{value:.0e}") } else { written }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(evaluations: f64, seconds: f64, y: f64) -> RivalPoint {
        RivalPoint { evaluations, seconds, y, coarse: evaluations < 10.0 }
    }

    #[test]
    fn odd_curves_give_a_picture() {
        let odd = [
            point(0.0, 0.0, f64::NAN),
            point(1.0, f64::NAN, 2.0),
            point(f64::INFINITY, 1.0, -1.0),
            point(20.0, 2.0, 1e-300),
            point(1e300, 3.0, 1e300),
        ];
        for points in [&odd[..], &odd[..1], &odd[3..4], &[]] {
            for line in [None, Some(0.0), Some(5.0), Some(f64::NAN)] {
                let curves = [Rival { name: "a < b", points, finish: Some(25.0) }; 7];
                let svg = rivals(&RivalChart { title: "Odd & ends", curves: &curves, line });
                assert!(svg.contains("</svg>") && svg.contains("a &lt; b") && !svg.contains("NaN"));
            }
        }
        assert!(rivals(&RivalChart { title: "", curves: &[], line: None }).contains("</svg>"));
    }

    #[test]
    fn the_finish_is_marked_where_it_was_met_and_coarse_levels_are_faint() {
        let points: Vec<_> = (1..60).map(|k| point(f64::from(k), 0.1 * f64::from(k), 1.0 / f64::from(k))).collect();
        let curve = |finish| [Rival { name: "one", points: &points, finish }];
        let draw = |finish| rivals(&RivalChart { title: "One", curves: &curve(finish), line: Some(0.05) });
        let (marked, bare) = (draw(Some(40.0)), draw(None));
        assert_eq!((marked.matches("<circle").count(), bare.matches("<circle").count()), (2, 0));
        assert!(bare.contains("opacity=\"0.35\""));
        assert_eq!(marked, draw(Some(40.0)));
    }

    #[test]
    fn numbers_on_the_axes_read_well() {
        let texts = [0.0, 2f64.log10(), 5f64.log10() - 2.0, 3.0, -5.0, 8.0].map(|l| label(&l));
        assert_eq!(texts, ["1", "2", "0.05", "1000", "10⁻⁵", "10⁸"]);
    }
}
