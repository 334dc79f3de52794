//! `convergence.svg`: energy and residual against evaluations, level by level.

use plotters::prelude::*;

/// One level of a run, or one run to be compared with others, borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve<'a> {
    /// For the legend, for instance `20 mm`.
    pub name: &'a str,
    /// In the order of the run.
    pub points: &'a [CurvePoint],
}

/// The state of a minimization at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Evaluations of the energy since the start of the run, all levels together.
    pub evaluations: u64,
    /// J.
    pub energy: f64,
    /// Root mean square over the free particles, in particle weights. Shown on a logarithmic scale, where values that
    /// are not positive have no place and leave a gap.
    pub residual: f64,
}

/// Size of the picture, units of the SVG. Twice what a page shows, because places are rounded to whole units.
const SIZE: (u32, u32) = (1800, 1360);

/// Writing, units of the SVG.
pub(super) const TITLE_FONT: (&str, u32) = ("sans-serif", 38);
pub(super) const LABEL_FONT: (&str, u32) = ("sans-serif", 31);

/// Width of a curve and of the mark at its end, units of the SVG.
const LINE_WIDTH: u32 = 4;
const DOT_RADIUS: u32 = 7;

/// One color per level in turn: the palette of M. Okabe and K. Ito (2008), which the color-blind can tell apart.
pub(super) const COLORS: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
];

pub(super) const INK: RGBColor = RGBColor(0x33, 0x33, 0x2f);
pub(super) const GRID: RGBColor = RGBColor(0xe4, 0xe4, 0xe2);
const LEVEL_CHANGE: RGBColor = RGBColor(0xa0, 0xa0, 0x9c);

/// A curve of more points is thinned: two points for each pixel across look the same and keep the file small.
const MOST_POINTS: usize = 1600;

/// The energy axis ends at this multiple of the part that 95 % of the points fill, if the highest is beyond even the
/// double: the first evaluations of a run can be so high that all else would look like a flat line.
const HEADROOM: f64 = 1.5;

/// Energy (J) above and residual (particle weights, logarithmic) below, against evaluations, as an SVG file.
///
/// Any curves give a picture; points that are not finite are left out. The same curves give the same bytes.
pub fn convergence(curves: &[Curve]) -> String {
    let panels = [Panel::energy(curves), Panel::residual(curves)];
    let mut svg = String::new();
    draw(&mut svg, curves, &panels)
        .expect("finite, non-empty ranges can be drawn, and a string takes all that is written");
    svg
}

/// One of the two diagrams.
struct Panel {
    title: String,
    /// One per curve: places in the diagram, NaN where there is none.
    curves: Vec<Vec<[f64; 2]>>,
    y_range: [f64; 2],
    y_label: fn(&f64) -> String,
    /// At most so many.
    y_label_count: usize,
}

impl Panel {
    fn energy(curves: &[Curve]) -> Self {
        let curves = places(curves, |point| point.energy);
        let (y_range, is_cut) = energy_range(&curves);
        let note = if is_cut { " (the highest at the start are off the scale)" } else { "" };
        Self { title: format!("Energy, J{note}"), curves, y_range, y_label: |y| significant(*y), y_label_count: 8 }
    }

    fn residual(curves: &[Curve]) -> Self {
        let curves = places(curves, |point| if point.residual > 0.0 { point.residual.log10() } else { f64::NAN });
        let [low, high] = extent(heights(&curves)).unwrap_or([-3.0, 0.0]);
        // Whole decades, at least one.
        let y_range = [low.floor(), high.ceil().max(low.floor() + 1.0)];
        let decades = (y_range[1] - y_range[0]) as usize;
        Self {
            title: "Residual, particle weights (rms)".to_owned(),
            curves,
            y_range,
            y_label: decade,
            y_label_count: decades.min(8) + 1,
        }
    }
}

/// Where a quantity of each curve's points lies; thinned.
fn places(curves: &[Curve], quantity: impl Fn(&CurvePoint) -> f64) -> Vec<Vec<[f64; 2]>> {
    let place = |point: &CurvePoint| [point.evaluations as f64, quantity(point)];
    curves.iter().map(|curve| thin(&curve.points.iter().map(place).collect::<Vec<_>>())).collect()
}

/// Every stretch of points reduced to its lowest and highest, in their order, so that no peak is lost.
fn thin(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let mut kept = Vec::new();
    for stretch in points.chunks(points.len().div_ceil(MOST_POINTS / 2)) {
        let by_height = |a: &usize, b: &usize| stretch[*a][1].total_cmp(&stretch[*b][1]);
        let lowest = (0..stretch.len()).min_by(by_height).unwrap_or(0);
        let highest = (0..stretch.len()).max_by(by_height).unwrap_or(0);
        kept.push(stretch[lowest.min(highest)]);
        kept.push(stretch[lowest.max(highest)]);
    }
    kept.extend(points.last());
    kept
}

fn heights(curves: &[Vec<[f64; 2]>]) -> impl Iterator<Item = f64> {
    curves.iter().flatten().map(|point| point[1]).filter(|y| y.is_finite())
}

/// Least and greatest value.
pub(super) fn extent(mut values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let first = values.next()?;
    Some(values.fold([first; 2], |[low, high], value| [low.min(value), high.max(value)]))
}

/// The energy axis, and whether some points lie above it.
fn energy_range(curves: &[Vec<[f64; 2]>]) -> ([f64; 2], bool) {
    let mut sorted: Vec<f64> = heights(curves).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
        return ([0.0, 1.0], false);
    };
    let common = sorted[(sorted.len() - 1) * 95 / 100];
    let limit = low + HEADROOM * (common - low);
    let is_cut = common > low && high > low + 2.0 * HEADROOM * (common - low);
    let top = if is_cut { limit } else { high };
    (widened([low, top]), is_cut)
}

/// A little room at both ends, and more where both are the same.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    // The halves keep the difference of two huge numbers finite.
    let half = 0.5 * high - 0.5 * low;
    let room = (0.08 * half).max(1.0e-3 * low.abs().max(high.abs())).max(1.0e-12);
    let limit = 0.25 * f64::MAX;
    [(low - room).clamp(-limit, limit), (high + room).clamp(-limit, limit)]
}

/// The pieces of a curve that lie below the top of the diagram; each a line of one point or more.
fn visible_pieces(points: &[[f64; 2]], top: f64) -> Vec<Vec<(f64, f64)>> {
    let mut pieces = vec![Vec::new()];
    let mut before: Option<[f64; 2]> = None;
    for &[x, y] in points {
        let crossing = before.filter(|last| (last[1] > top) != (y > top)).map(|last| {
            let along = (top - last[1]) / (y - last[1]);
            (last[0] + along * (x - last[0]), top)
        });
        pieces.last_mut().into_iter().for_each(|piece| piece.extend(crossing));
        if y.is_finite() && y <= top {
            pieces.last_mut().into_iter().for_each(|piece| piece.push((x, y)));
        } else {
            pieces.push(Vec::new());
        }
        before = y.is_finite().then_some([x, y]);
    }
    pieces.retain(|piece| !piece.is_empty());
    pieces
}

type DrawResult = Result<(), Box<dyn std::error::Error>>;

fn draw(svg: &mut String, curves: &[Curve], panels: &[Panel; 2]) -> DrawResult {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let x_range = x_range(curves);
    let (upper, lower) = root.split_vertically(SIZE.1 / 2 - 20);
    draw_panel(&upper, curves, &panels[0], x_range, true)?;
    draw_panel(&lower, curves, &panels[1], x_range, false)?;
    root.present()?;
    Ok(())
}

/// From 0, so that the cost of the first level is seen, to the last evaluation.
fn x_range(curves: &[Curve]) -> [f64; 2] {
    let evaluations = curves.iter().flat_map(|curve| curve.points).map(|point| point.evaluations);
    [0.0, evaluations.max().unwrap_or(0).max(1) as f64]
}

fn draw_panel(
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
    curves: &[Curve],
    panel: &Panel,
    [x0, x1]: [f64; 2],
    is_upper: bool,
) -> DrawResult {
    let [y0, y1] = panel.y_range;
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, TITLE_FONT.into_font().color(&INK))
        .margin(24)
        .x_label_area_size(if is_upper { 50 } else { 90 })
        .y_label_area_size(130)
        .build_cartesian_2d(x0..x1, y0..y1)?;
    chart
        .configure_mesh()
        .bold_line_style(GRID.stroke_width(2))
        .light_line_style(TRANSPARENT)
        .axis_style(INK.stroke_width(2))
        .label_style(LABEL_FONT.into_font().color(&INK))
        .x_desc(if is_upper { "" } else { "evaluations" })
        .y_labels(panel.y_label_count)
        .x_label_formatter(&|x| significant(*x))
        .y_label_formatter(&panel.y_label)
        .draw()?;
    for curve in curves.iter().skip(1) {
        if let Some(start) = curve.points.first().map(|point| point.evaluations as f64) {
            chart.draw_series(LineSeries::new([(start, y0), (start, y1)], LEVEL_CHANGE.stroke_width(2)))?;
        }
    }
    for ((curve, points), color) in curves.iter().zip(&panel.curves).zip(COLORS.iter().cycle()) {
        let pieces = visible_pieces(points, y1);
        // The end of each level is marked; so a level of a single point is seen as well.
        let end = pieces.last().and_then(|piece| piece.last().copied());
        let dot = end.map(|place| Circle::new(place, DOT_RADIUS, color.filled()));
        let dots = chart.draw_series(dot)?;
        if is_upper {
            // Without font files plotters guesses the width of a name a little short; the spaces make up for it.
            dots.label(format!("{}  ", curve.name))
                .legend(|(x, y)| PathElement::new([(x, y), (x + 40, y)], color.stroke_width(LINE_WIDTH)));
        }
        for piece in pieces {
            chart.draw_series(LineSeries::new(piece, color.stroke_width(LINE_WIDTH)))?;
        }
    }
    if is_upper && !curves.is_empty() {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .label_font(LABEL_FONT.into_font().color(&INK))
            .background_style(WHITE.mix(0.85))
            .border_style(GRID.stroke_width(2))
            .legend_area_size(56)
            .margin(16)
            .draw()?;
    }
    Ok(())
}

/// A number in as few characters as show four digits.
pub(super) fn significant(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1.0e-3..1.0e7).contains(&size) {
        return format!("{value:.1e}");
    }
    let decimals = if size >= 100.0 || size == 0.0 { 0 } else { 4 };
    let text = format!("{value:.decimals$}");
    if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// `10⁻³` at whole decades, nothing between.
pub(super) fn decade(exponent: &f64) -> String {
    let whole = exponent.round();
    if (exponent - whole).abs() > 1.0e-6 {
        return String::new();
    }
    let superscript = |character| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => digit.to_digit(10).and_then(|digit| char::from_u32('⁰' as u32 + digit)).unwrap_or(digit),
    };
    let power: String = format!("{whole}").chars().map(superscript).collect();
    format!("10{power}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(evaluations: u64, energy: f64, residual: f64) -> CurvePoint {
        CurvePoint { evaluations, energy, residual }
    }

    /// Tags opened and closed in turn, attributes quoted, nothing left open.
    fn assert_well_formed(svg: &str) {
        let mut open = Vec::new();
        for part in svg.split('<').skip(1) {
            let (tag, text) = part.split_once('>').expect("every tag ends");
            assert!(tag.matches('"').count() % 2 == 0 && !text.contains('>'), "{part}");
            let name = tag.trim_end_matches('/').split_whitespace().next().unwrap();
            if let Some(closed) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(closed));
            } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
                open.push(name);
            }
        }
        assert!(open.is_empty() && svg.contains("</svg>"), "{open:?}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn odd_curves_give_a_well_formed_picture() {
        let one = [point(7, 1.0, 0.5)];
        let constant = [point(0, 2.0, 1.0), point(10, 2.0, 1.0)];
        let odd = [
            point(0, f64::NAN, 0.0),
            point(1, f64::INFINITY, -1.0),
            point(2, 3.0, f64::NAN),
            point(2, -3.0, 1e-300),
            point(u64::MAX, 0.0, f64::INFINITY),
        ];
        let huge = [point(0, f64::MAX, f64::MAX), point(1, f64::MIN, f64::MIN_POSITIVE)];
        for points in [&[][..], &one, &constant, &odd, &odd[..1], &odd[2..3], &huge] {
            assert_well_formed(&convergence(&[Curve { name: "20 mm", points }]));
            let twice = [Curve { name: "a < b & \"c\"", points }, Curve { name: "", points }];
            assert_well_formed(&convergence(&twice));
        }
        assert_well_formed(&convergence(&[]));
    }

    #[test]
    fn every_level_is_named_and_the_bytes_are_the_same_again() {
        let points: Vec<_> = (0..5000).map(|i| point(i, 1.0 / (i + 1) as f64, 1.0 / (i + 1) as f64)).collect();
        let curves =
            [Curve { name: "20 mm", points: &points[..2000] }, Curve { name: "10 mm", points: &points[2000..] }];
        let svg = convergence(&curves);
        assert!(svg.contains("20 mm") && svg.contains("10 mm") && svg.contains("evaluations"));
        assert!(svg.contains("10⁻³"));
        assert_eq!(svg, convergence(&curves));
        assert!(svg.len() < 200_000, "{}", svg.len());
    }

    #[test]
    fn a_high_start_does_not_flatten_the_rest() {
        let mut points = vec![[0.0, 1000.0]];
        points.extend((1..100).map(|i| [f64::from(i), 1.0 + 1.0 / f64::from(i)]));
        let ([low, high], is_cut) = energy_range(&[points]);
        assert!(is_cut && low < 1.1 && high < 3.0, "{low} {high}");
        let ([_, high], is_cut) = energy_range(&[vec![[0.0, 3.0], [1.0, 2.0], [2.0, 1.0]]]);
        assert!(!is_cut && high > 3.0);
    }

    #[test]
    fn curves_are_cut_where_they_cross_the_top_and_broken_at_gaps() {
        let points = [[0.0, 4.0], [1.0, 2.0], [2.0, f64::NAN], [3.0, 1.0], [4.0, 5.0]];
        let pieces = visible_pieces(&points, 3.0);
        assert_eq!(pieces, [vec![(0.5, 3.0), (1.0, 2.0)], vec![(3.0, 1.0), (3.5, 3.0)]]);
        assert!(visible_pieces(&[], 1.0).is_empty());
    }

    #[test]
    fn thinning_keeps_the_peaks_and_the_end() {
        let mut points: Vec<_> = (0..20_000).map(|i| [f64::from(i), 1.0]).collect();
        points[7777][1] = 9.0;
        points[8888][1] = -9.0;
        let kept = thin(&points);
        assert!(kept.len() <= MOST_POINTS + 1);
        assert!(kept.contains(&[7777.0, 9.0]) && kept.contains(&[8888.0, -9.0]));
        assert_eq!(kept.last(), points.last());
        assert!(kept.is_sorted_by(|a, b| a[0] <= b[0]));
    }

    #[test]
    fn numbers_on_the_axes_read_well() {
        let texts = [0.0, 1500.0, 2.5, 0.125, 1.0e9, -3.0e-5].map(significant);
        assert_eq!(texts, ["0", "1500", "2.5", "0.125", "1.0e9", "-3.0e-5"]);
        assert_eq!([-12.0, 0.0, 3.0, 0.5].map(|exponent| decade(&exponent)), ["10⁻¹²", "10⁰", "10³", ""]);
    }
}
