//! The panels of a pattern side by side, with numbered edges, notches, grainlines and seams in matching colors, as SVG.

use crate::geometry::Vector2;
use crate::pattern::sewing::{SeamPlan, Stretch};
use crate::pattern::{NotchKind, Panel, Pattern};
use std::f64::consts::PI;
use std::fmt::Write as _;

/// Points of a curve.
const PER_CURVE: usize = 24;
/// Between panels, mm.
const GAP: f64 = 95.0;
const MARGIN: f64 = 75.0;

/// Draws the panels and the seams of `plans`; millimetres, as drawn, y upwards.
pub fn draw(pattern: &Pattern, plans: &[SeamPlan]) -> String {
    let boxes: Vec<[Vector2; 2]> = pattern.panels.iter().map(bounds).collect();
    let (places, [width, height]) = shelves(&boxes);
    // Text that can be read when the whole sheet is looked at on a screen.
    let size = (width.max(height) / 95.0).clamp(7.0, 26.0);
    let legend_height = if plans.is_empty() { 0.0 } else { legend_rows(plans.len(), width, size) as f64 * 1.7 * size };
    let [w, h] = [width + 2.0 * MARGIN, height + 2.0 * MARGIN + legend_height];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w:.1}mm\" height=\"{h:.1}mm\" viewBox=\"0 0 {w:.1} {h:.1}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"{size:.1}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fbfaf7\"/>\n"
    );
    let canvas = Canvas { pattern, boxes: &boxes, places: &places, size };
    for index in 0..pattern.panels.len() {
        canvas.panel(&mut svg, index);
    }
    for (number, plan) in plans.iter().enumerate() {
        for (side, stretches) in plan.sides.iter().enumerate() {
            for stretch in stretches {
                let name = if is_dart(plan, pattern) {
                    (side == 0).then(|| format!("{}", number + 1))
                } else {
                    Some(format!("{}{}", number + 1, ["a", "b"][side]))
                };
                canvas.stretch(&mut svg, stretch, number, name.as_deref());
            }
        }
    }
    for index in 0..pattern.panels.len() {
        canvas.numbers(&mut svg, index);
    }
    canvas.legend(&mut svg, plans, [width, height]);
    svg += "</svg>\n";
    svg
}

/// A seam between neighbours on one panel: its sides lie so near that one name does for both.
fn is_dart(plan: &SeamPlan, pattern: &Pattern) -> bool {
    let [[a], [b]] = [&plan.sides[0][..], &plan.sides[1][..]] else { return false };
    let count = pattern.panels[a.panel].segments.len();
    let ends = |s: &Stretch| [s.segments[0], (s.segments[s.segments.len() - 1] + 1) % count];
    a.panel == b.panel && (ends(a)[1] == ends(b)[0] || ends(b)[1] == ends(a)[0])
}

/// Colors far from each other, one after the other: hues by the golden angle, in three lightnesses.
fn color(number: usize) -> String {
    let hue = (number as f64 * 137.508) % 360.0;
    format!("hsl({hue:.0}, 72%, {}%)", [42, 55, 33][number / 3 % 3])
}

fn bounds(panel: &Panel) -> [Vector2; 2] {
    let points = panel.polygon(PER_CURVE);
    let first = points.first().copied().unwrap_or_else(Vector2::zeros);
    points.iter().fold([first, first], |[low, high], p| [low.inf(p), high.sup(p)])
}

/// Places of the boxes' lower left corners on a sheet, mm, y downwards, row by row; and the size of the sheet. Of several
/// widths the one that makes the smallest sheet of a form that fits a screen.
fn shelves(boxes: &[[Vector2; 2]]) -> (Vec<[f64; 2]>, [f64; 2]) {
    let size = |[low, high]: &[Vector2; 2]| [1e3 * (high.x - low.x), 1e3 * (high.y - low.y)];
    let area: f64 = boxes.iter().map(size).map(|[w, h]| (w + GAP) * (h + GAP)).sum();
    let widest = boxes.iter().map(|b| size(b)[0]).fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| size(&boxes[b])[1].total_cmp(&size(&boxes[a])[1]).then(a.cmp(&b)));
    let packed = |width: f64| {
        let mut places = vec![[0.0; 2]; boxes.len()];
        let (mut x, mut y, mut row, mut used) = (0.0f64, 0.0, 0.0f64, 0.0f64);
        for &index in &order {
            let [w, h] = size(&boxes[index]);
            if x > 0.0 && x + w > width {
                (x, y, row) = (0.0, y + row + GAP, 0.0);
            }
            places[index] = [x, y + h];
            (x, row) = (x + w + GAP, row.max(h));
            used = used.max(x - GAP);
        }
        (places, [used, y + row])
    };
    let badness = |[w, h]: [f64; 2]| {
        let form = if w > h { w / h } else { 1.4 * h / w };
        w * h * form.max(1.8)
    };
    (8..=24)
        .map(|k| packed((area * f64::from(k) / 8.0).sqrt().max(widest)))
        .min_by(|a, b| badness(a.1).total_cmp(&badness(b.1)))
        .expect("several widths are tried")
}

fn legend_columns(width: f64, size: f64) -> usize {
    ((width / (26.0 * size)) as usize).max(1)
}

fn legend_rows(count: usize, width: f64, size: f64) -> usize {
    count.div_ceil(legend_columns(width, size))
}

struct Canvas<'a> {
    pattern: &'a Pattern,
    boxes: &'a [[Vector2; 2]],
    places: &'a [[f64; 2]],
    size: f64,
}

impl Canvas<'_> {
    fn at(&self, panel: usize, p: Vector2) -> [f64; 2] {
        let low = self.boxes[panel][0];
        [MARGIN + self.places[panel][0] + 1e3 * (p.x - low.x), MARGIN + self.places[panel][1] - 1e3 * (p.y - low.y)]
    }

    fn path(&self, panel: usize, points: &[Vector2]) -> String {
        let mut d = String::new();
        for (k, p) in points.iter().enumerate() {
            let [x, y] = self.at(panel, *p);
            let _ = write!(d, "{}{x:.2} {y:.2}", if k == 0 { "M" } else { " L" });
        }
        d
    }

    /// Unit vector into the panel across a segment, at a fraction.
    fn inwards(&self, panel: usize, segment: usize, fraction: f64) -> Vector2 {
        let drawn = &self.pattern.panels[panel];
        let curve = &drawn.segments[segment].curve;
        let along = curve.at_fraction((fraction + 0.01).min(1.0)) - curve.at_fraction((fraction - 0.01).max(0.0));
        let left = Vector2::new(-along.y, along.x).try_normalize(1e-12).unwrap_or_else(Vector2::zeros);
        left * drawn.signed_area().signum()
    }

    fn panel(&self, svg: &mut String, index: usize) {
        let panel = &self.pattern.panels[index];
        let outline = self.path(index, &panel.polygon(PER_CURVE));
        let _ = writeln!(
            svg,
            "<path d=\"{outline} Z\" fill=\"#ffffff\" stroke=\"#555\" stroke-width=\"{:.2}\"/>",
            0.09 * self.size
        );
        for line in &panel.markings.lines {
            let _ = writeln!(
                svg,
                "<path d=\"{}\" fill=\"none\" stroke=\"#bbb\" stroke-width=\"{:.2}\" stroke-dasharray=\"6 4\"/>",
                self.path(index, line),
                0.06 * self.size
            );
        }
        for hole in &panel.markings.drill_holes {
            let [x, y] = self.at(index, *hole);
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{:.2}\" fill=\"none\" stroke=\"#888\"/>",
                0.3 * self.size
            );
        }
        if let Some(grain) = panel.markings.grainline {
            let _ = writeln!(
                svg,
                "<path d=\"{}\" stroke=\"#999\" stroke-width=\"{:.2}\" stroke-dasharray=\"12 3 3 3\"/>",
                self.path(index, &grain),
                0.08 * self.size
            );
            let along = (grain[1] - grain[0]).try_normalize(1e-12).unwrap_or_else(Vector2::zeros);
            let (barb, across) = (along * (0.6e-3 * self.size), Vector2::new(-along.y, along.x) * (0.3e-3 * self.size));
            for (tip, back) in [(grain[1], -barb), (grain[0], barb)] {
                let _ = writeln!(
                    svg,
                    "<path d=\"{}\" fill=\"none\" stroke=\"#999\"/>",
                    self.path(index, &[tip + back + across, tip, tip + back - across])
                );
            }
        }
        let [low, high] = self.boxes[index];
        let [x, y] = self.at(index, middle(panel).unwrap_or((low + high) / 2.0));
        let _ = writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\" font-size=\"{:.1}\" font-weight=\"bold\" fill=\"#333\">{}</text>",
            // Letters are about six tenths as wide as high.
            (1.25 * self.size).min(0.65e3 * (high.x - low.x) / (0.6 * panel.name.chars().count().max(1) as f64)),
            escaped(&panel.name)
        );
    }

    /// A sewn stretch, with its seam's number and an arrow along the outline.
    fn stretch(&self, svg: &mut String, stretch: &Stretch, number: usize, name: Option<&str>) {
        let color = color(number);
        for part in stretch.parts() {
            let curve = &self.pattern.panels[part.id.panel].segments[part.id.segment].curve;
            let points: Vec<Vector2> = (0..=PER_CURVE)
                .map(|k| curve.at_fraction(part.from + (part.to - part.from) * k as f64 / PER_CURVE as f64))
                .collect();
            let _ = writeln!(
                svg,
                "<path d=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{:.2}\" stroke-linecap=\"butt\"/>",
                self.path(part.id.panel, &points),
                0.32 * self.size
            );
        }
        let Some(name) = name else { return };
        let parts = stretch.parts();
        let part = parts[parts.len() / 2];
        let fraction = 0.5 * (part.from + part.to);
        let curve = &self.pattern.panels[part.id.panel].segments[part.id.segment].curve;
        let out = -self.inwards(part.id.panel, part.id.segment, fraction);
        let [x, y] =
            self.at(part.id.panel, curve.at_fraction(fraction) + out * ((0.95 + 0.4 * out.x.abs()) * 1e-3 * self.size));
        let _ = writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{color}\" font-weight=\"bold\" font-size=\"{:.1}\">{name}</text>",
            y + 0.3 * self.size,
            0.85 * self.size
        );
    }

    /// Numbers of edges with the direction they are drawn in, corners, notches.
    fn numbers(&self, svg: &mut String, index: usize) {
        let panel = &self.pattern.panels[index];
        for (k, segment) in panel.segments.iter().enumerate() {
            let curve = &segment.curve;
            let inwards = self.inwards(index, k, 0.5);
            let along = Vector2::new(inwards.y, -inwards.x) * panel.signed_area().signum();
            let middle = curve.at_fraction(0.5);
            // Of short edges the number moves into the panel, where there is room.
            let depth = if curve.length() < 1.5e-3 * self.size { 1.6e-3 } else { 0.85e-3 } * self.size;
            let [x, y] = self.at(index, middle + inwards * depth);
            let _ = writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#111\" font-size=\"{:.1}\">{k}</text>",
                y + 0.27 * self.size,
                0.75 * self.size
            );
            if curve.length() > 3e-3 * self.size {
                let at = curve.at_fraction(0.5) + inwards * (0.2e-3 * self.size);
                let (tip, wing) = (along * (0.3e-3 * self.size), inwards * (0.22e-3 * self.size));
                let _ = writeln!(
                    svg,
                    "<path d=\"{}\" fill=\"none\" stroke=\"#333\" stroke-width=\"{:.2}\"/>",
                    self.path(index, &[at - tip + wing, at + tip, at - tip - wing]),
                    0.07 * self.size
                );
            }
            let [x, y] = self.at(index, curve.start);
            let _ = writeln!(svg, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{:.2}\" fill=\"#222\"/>", 0.17 * self.size);
        }
        for (k, notch) in panel.markings.notches.iter().enumerate() {
            let Some(segment) = panel.segments.get(notch.segment) else { continue };
            let at = segment.curve.at_fraction(notch.fraction);
            let inwards = self.inwards(index, notch.segment, notch.fraction);
            let across = Vector2::new(-inwards.y, inwards.x) * (0.14e-3 * self.size);
            let depth = inwards * (0.6e-3 * self.size);
            let shifts = if notch.kind == NotchKind::Double { vec![across, -across] } else { vec![Vector2::zeros()] };
            for shift in shifts {
                let _ = writeln!(
                    svg,
                    "<path d=\"{}\" stroke=\"#c22\" stroke-width=\"{:.2}\"/>",
                    self.path(index, &[at + shift, at + shift + depth]),
                    0.1 * self.size
                );
            }
            let [x, y] = self.at(index, at + inwards * (1.1e-3 * self.size));
            let _ = writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#c22\" font-size=\"{:.1}\">n{k}</text>",
                y + 0.2 * self.size,
                0.6 * self.size
            );
        }
    }

    fn legend(&self, svg: &mut String, plans: &[SeamPlan], [width, height]: [f64; 2]) {
        let columns = legend_columns(width, self.size);
        for (number, plan) in plans.iter().enumerate() {
            let (column, row) = (number % columns, number / columns);
            let x = MARGIN + column as f64 * width / columns as f64;
            let y = height + 2.0 * MARGIN + (row as f64 + 0.3) * 1.7 * self.size;
            let color = color(number);
            let _ = writeln!(
                svg,
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{color}\"/><text x=\"{:.1}\" y=\"{y:.1}\" fill=\"#222\" font-size=\"{:.1}\">{} {}</text>",
                y - 0.6 * self.size,
                1.2 * self.size,
                0.6 * self.size,
                x + 1.6 * self.size,
                0.8 * self.size,
                number + 1,
                escaped(&plan.name)
            );
        }
    }
}

/// A point well inside the panel, for its name: the middle of the widest stretch on a line through the panel's middle height.
fn middle(panel: &Panel) -> Option<Vector2> {
    let points = panel.polygon(PER_CURVE);
    let [low, high] = bounds(panel);
    let y = 0.5 * (low.y + high.y) + PI * 1e-7;
    let mut crossings: Vec<f64> = (0..points.len())
        .filter_map(|k| {
            let (a, b) = (points[k], points[(k + 1) % points.len()]);
            ((a.y > y) != (b.y > y)).then(|| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x))
        })
        .collect();
    crossings.sort_by(f64::total_cmp);
    let widest = crossings.chunks_exact(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    Some(Vector2::new(0.5 * (widest[0] + widest[1]), y))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
