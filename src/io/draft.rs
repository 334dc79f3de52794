//! From pieces as they are drawn to panels: halves are unfolded, mirrored pairs made, the grainline turned upright,
//! notches brought onto the outline. What the readers of drawings without placement have in common.

use crate::geometry::{Vector2, cross};
use crate::pattern::{Curve, Markings, Motion, Notch, NotchKind, Panel, Path, Segment, Shape, joined};
use crate::{Error, Warning};

/// A segment whose points keep so near to the fold lies on it, m: programs draw the fold a little aside or askew.
const ON_FOLD: f64 = 1.5e-3;
/// A curve that meets the fold within this angle of a right angle runs on into its mirror image without a corner, rad.
const SMOOTH_ACROSS_FOLD: f64 = 0.2;
/// A notch on the cut line is as far from the sew line as the allowance is wide, m; what is farther is no notch of it.
const FARTHEST_NOTCH: f64 = 0.06;
/// A shorter grainline has no direction, m.
const SHORTEST_GRAINLINE: f64 = 1e-3;

/// What reaches farther than this is damage, m; readers refuse it before they draft a piece.
pub const FARTHEST: f64 = 100.0;

/// A piece as it is drawn; m, y up.
#[derive(Clone, Debug)]
pub struct Draft {
    pub name: String,
    /// A closed loop in either direction.
    pub outline: Vec<Curve>,
    pub notches: Vec<(Vector2, NotchKind)>,
    pub grainline: Option<[Vector2; 2]>,
    pub lines: Vec<Vec<Vector2>>,
    pub drill_holes: Vec<Vector2>,
    /// The line in which the piece is to be mirrored, along one of its edges.
    pub fold: Option<[Vector2; 2]>,
    pub copies: Copies,
    pub fabric: Option<String>,
}

/// How often a piece is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Copies {
    One,
    /// One as drawn, one with left and right exchanged.
    MirroredPair,
    /// Two as drawn.
    Two,
}

impl Draft {
    /// The panels of the piece, with names that no panel in `taken` has.
    pub fn panels(mut self, taken: &mut Names, warnings: &mut Vec<Warning>) -> Vec<Panel> {
        let name = taken.unique(&self.name);
        let mut warn = |problem: &str, remedy: &str| {
            warnings.push(Warning(Error::new(problem, remedy).within(format!("panel \"{name}\""))));
        };
        self.face_up();
        if let Some(fold) = self.fold
            && !self.unfold(fold)
        {
            warn(
                "Its fold line lies on no edge of the outline; the panel is taken as it is drawn.",
                "If it is a half, draw the fold line along its edge.",
            );
        }
        self.turn_upright();
        let mut lost = 0;
        let mut notches: Vec<Notch> = Vec::new();
        for &(point, kind) in &self.notches {
            match on_outline(&self.outline, point) {
                Some((segment, fraction)) => notches.push(Notch { segment, fraction, kind }),
                None => lost += 1,
            }
        }
        notches.sort_by(|a, b| a.segment.cmp(&b.segment).then(a.fraction.total_cmp(&b.fraction)));
        if lost > 0 {
            warn(
                &format!("{lost} of its notches are more than 6 cm from the outline and are left aside."),
                "Draw notches on the outline.",
            );
        }
        let markings =
            Markings { notches, grainline: self.grainline, lines: self.lines, drill_holes: self.drill_holes };
        let segments = self.outline.into_iter().map(|curve| Segment { curve, label: None }).collect();
        let panel = Panel { markings, fabric: self.fabric, ..Panel::new(name.as_str(), segments) };
        match self.copies {
            Copies::One => vec![panel],
            Copies::Two => {
                let second = Panel { name: taken.unique(&name), ..panel.clone() };
                vec![panel, second]
            }
            Copies::MirroredPair => {
                let second = mirrored(&panel, taken.unique(&format!("{name} (mirrored)")));
                vec![panel, second]
            }
        }
    }

    /// Makes the outline run counter-clockwise: drawings show the right side of the fabric.
    fn face_up(&mut self) {
        if self.outline.iter().map(Curve::signed_area).sum::<f64>() < 0.0 {
            self.outline = reversed(&self.outline);
        }
    }

    /// Opens a half along its fold. False if no one run of edges lies on it; nothing is changed then.
    fn unfold(&mut self, fold: [Vector2; 2]) -> bool {
        let Some(along) = (fold[1] - fold[0]).try_normalize(ON_FOLD) else { return false };
        let beside = |p: Vector2| cross(along, p - fold[0]);
        let lies_on = |curve: &Curve| {
            [curve.start, curve.at_fraction(0.5), curve.end].iter().all(|&p| beside(p).abs() <= ON_FOLD)
        };
        let on: Vec<bool> = self.outline.iter().map(lies_on).collect();
        let count = on.len();
        // Where the run on the fold ends, the half begins.
        let starts: Vec<usize> = (0..count).filter(|&k| !on[k] && on[(k + count - 1) % count]).collect();
        let &[first] = starts.as_slice() else { return false };
        let mut half: Vec<Curve> =
            (0..count).map(|k| (first + k) % count).take_while(|&k| !on[k]).map(|k| self.outline[k].clone()).collect();
        let foot = |p: Vector2| fold[0] + along * along.dot(&(p - fold[0]));
        let last = half.len() - 1;
        half[0] = with_end(&half[0].reversed(), foot(half[0].start), along).reversed();
        half[last] = with_end(&half[last], foot(half[last].end), along);
        let mirror = Motion::mirror(fold);
        let mut other: Vec<Curve> = reversed(&half).iter().map(|c| c.moved(&mirror)).collect();
        let smooth = |direction: Vector2| direction.dot(&along).abs() <= SMOOTH_ACROSS_FOLD.sin();
        // `half` ends where `other` starts, and the other way round.
        if smooth(half[last].end_directions()[1]) {
            let whole = joined(&[half.pop().expect("it has a last"), other.remove(0)]);
            half.push(whole);
        }
        if smooth(half[0].end_directions()[0]) && half.len() + other.len() > 2 && !other.is_empty() {
            let whole = joined(&[other.pop().expect("it is not empty"), half[0].clone()]);
            half[0] = whole;
        }
        half.append(&mut other);
        self.outline = half;
        let both = |points: &[Vector2]| points.iter().map(|&p| mirror.apply(p)).collect::<Vec<_>>();
        let off = |p: Vector2| beside(p).abs() > ON_FOLD;
        let notches: Vec<_> =
            self.notches.iter().filter(|(p, _)| off(*p)).map(|&(p, kind)| (mirror.apply(p), kind)).collect();
        self.notches.extend(notches);
        let holes: Vec<_> = both(&self.drill_holes).into_iter().filter(|&p| off(p)).collect();
        self.drill_holes.extend(holes);
        let lines: Vec<_> =
            self.lines.iter().filter(|line| line.iter().any(|&p| off(p))).map(|line| both(line)).collect();
        self.lines.extend(lines);
        true
    }

    /// Turns the piece so that its grainline is parallel to y: by as little as that takes. A grainline along x, as some
    /// programs draw it, has its end at the top.
    fn turn_upright(&mut self) {
        let Some([a, b]) = self.grainline else { return };
        let Some(along) = (b - a).try_normalize(SHORTEST_GRAINLINE) else {
            self.grainline = None;
            return;
        };
        let steep = along.y.abs() >= std::f64::consts::FRAC_1_SQRT_2 - 1e-6;
        let up = if steep && along.y < 0.0 { -along } else { along };
        let angle = std::f64::consts::FRAC_PI_2 - up.y.atan2(up.x);
        // A drawing is not exact to a thousandth of a degree, and what is upright should stay as it is.
        const UPRIGHT: f64 = 2e-5;
        if angle.abs() < UPRIGHT {
            return;
        }
        let turn = Motion::turn(angle);
        let each = |points: &mut Vec<Vector2>| points.iter_mut().for_each(|p| *p = turn.apply(*p));
        self.outline.iter_mut().for_each(|c| *c = c.moved(&turn));
        self.notches.iter_mut().for_each(|(p, _)| *p = turn.apply(*p));
        each(&mut self.drill_holes);
        self.lines.iter_mut().for_each(each);
        self.grainline = Some([turn.apply(a), turn.apply(b)]);
    }
}

/// The curve with its end brought to `end` on the fold, its last handle square to the fold if it nearly is.
fn with_end(curve: &Curve, end: Vector2, along: Vector2) -> Curve {
    if curve.is_straight() {
        // A line square to the fold but for a slip of the pen stays as it is drawn: its other end is a corner.
        return Curve::line(curve.start, end);
    }
    let mut points = curve.cubics();
    let last = points.len() - 1;
    let shift = end - points[last];
    points[last] = end;
    points[last - 1] += shift;
    let handle = end - points[last - 1];
    let square = handle - along * along.dot(&handle);
    if along.dot(&handle).abs() <= SMOOTH_ACROSS_FOLD.sin() * handle.norm() && square.norm() > 0.0 {
        points[last - 1] = end - square * (handle.norm() / square.norm());
    }
    Path::new(points).map_or_else(|| curve.clone(), Curve::along)
}

fn reversed(outline: &[Curve]) -> Vec<Curve> {
    outline.iter().rev().map(Curve::reversed).collect()
}

/// The mirror image of a panel, its right side up as well: segment `k` of `n` becomes segment `n - 1 - k`.
pub fn mirrored(panel: &Panel, name: String) -> Panel {
    let mirror = Motion::mirror([Vector2::zeros(), Vector2::y()]);
    let count = panel.segments.len();
    let image = |s: &Segment| Segment { curve: s.curve.reversed().moved(&mirror), label: s.label };
    let all = |points: &[Vector2]| points.iter().map(|&p| mirror.apply(p)).collect::<Vec<_>>();
    let Markings { notches, grainline, lines, drill_holes } = &panel.markings;
    let notch = |n: &Notch| Notch { segment: count - 1 - n.segment, fraction: 1.0 - n.fraction, kind: n.kind };
    let markings = Markings {
        notches: notches.iter().rev().map(notch).collect(),
        grainline: grainline.map(|ends| ends.map(|p| mirror.apply(p))),
        lines: lines.iter().map(|line| all(line)).collect(),
        drill_holes: all(drill_holes),
    };
    let segments = panel.segments.iter().rev().map(image).collect();
    Panel { name, segments, markings, ..panel.clone() }
}

/// Segment and fraction of the outline nearest to a point, if it is near enough to mean it.
fn on_outline(outline: &[Curve], point: Vector2) -> Option<(usize, f64)> {
    let mut best = (FARTHEST_NOTCH, None);
    for (k, curve) in outline.iter().enumerate() {
        // Measuring is slow, and most curves are far away.
        let reach = curve.control_points().iter().map(|p| (p - curve.start).norm()).fold(0.0, f64::max);
        let reach = if let Shape::Arc(arc) = &curve.shape { reach.max(2.0 * arc.radius) } else { reach };
        if (point - curve.start).norm() > reach + best.0 {
            continue;
        }
        let (fraction, distance) = curve.nearest(point);
        if distance < best.0 {
            best = (distance, Some((k, fraction)));
        }
    }
    best.1
}

/// Names of panels, each given once.
#[derive(Default)]
pub struct Names(std::collections::HashSet<String>);

impl Names {
    /// The name, or the name with the first number from 2 that makes it new; on one line and not empty.
    pub fn unique(&mut self, name: &str) -> String {
        const MOST_CHARACTERS: usize = 100;
        let breaks = |c: char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}');
        let clean: String = name.chars().map(|c| if breaks(c) { ' ' } else { c }).take(MOST_CHARACTERS).collect();
        let clean = clean.split_whitespace().collect::<Vec<_>>().join(" ");
        let clean = if clean.is_empty() { "panel".to_owned() } else { clean };
        let mut unique = clean.clone();
        let mut number = 1;
        while !self.0.insert(unique.clone()) {
            number += 1;
            unique = format!("{clean} {number}");
        }
        unique
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64) -> Vector2 {
        Vector2::new(x, y)
    }

    fn draft(outline: Vec<Curve>) -> Draft {
        Draft {
            name: "piece".into(),
            outline,
            notches: vec![],
            grainline: None,
            lines: vec![],
            drill_holes: vec![],
            fold: None,
            copies: Copies::One,
            fabric: None,
        }
    }

    /// Half of a front: fold at x = 0, hem, side, shoulder, and a neck that meets the fold at a right angle.
    fn half_front() -> Draft {
        let corners = [v(0.0, 0.0), v(0.3, 0.0), v(0.25, 0.6), v(0.1, 0.62), v(0.0, 0.5)];
        let mut outline: Vec<Curve> = (0..5).map(|k| Curve::line(corners[k], corners[(k + 1) % 5])).collect();
        outline[3].shape = Shape::Cubic(v(0.1, 0.55), v(0.05, 0.5));
        Draft {
            fold: Some([v(1e-4, -0.01), v(0.0, 0.51)]),
            notches: vec![(v(0.28, 0.3), NotchKind::Single)],
            ..draft(outline)
        }
    }

    #[test]
    fn a_half_is_unfolded_with_hem_and_neck_in_one() {
        let mut half = half_front();
        let area: f64 = half.outline.iter().map(Curve::signed_area).sum();
        half.outline = reversed(&half.outline);
        let panels = half.panels(&mut Names::default(), &mut vec![]);
        let [whole] = panels.as_slice() else { panic!() };
        assert!((whole.signed_area() - 2.0 * area).abs() < 2e-3 * area, "{}", whole.signed_area());
        // Hem, side, shoulder, neck, shoulder, side.
        assert_eq!(whole.segments.len(), 6);
        assert_eq!(whole.segments.iter().filter(|s| !s.curve.is_straight()).count(), 1);
        assert_eq!(whole.markings.notches.len(), 2);
        let closed = |k: usize| whole.segments[k].curve.end - whole.segments[(k + 1) % 6].curve.start;
        assert!((0..6).all(|k| closed(k).norm() == 0.0));
        let pattern = crate::pattern::Pattern { name: "half".into(), panels: vec![whole.clone()], seams: vec![] };
        pattern.check().unwrap();
    }

    #[test]
    fn a_point_on_the_fold_stays_a_corner() {
        let mut half = half_front();
        half.outline[3] = Curve::line(v(0.1, 0.62), v(0.0, 0.5));
        let panels = half.panels(&mut Names::default(), &mut vec![]);
        assert_eq!(panels[0].segments.len(), 7);
    }

    #[test]
    fn a_fold_beside_the_outline_is_told() {
        let mut warnings = vec![];
        let half = Draft { fold: Some([v(0.1, 0.0), v(0.1, 1.0)]), ..half_front() };
        assert_eq!(half.panels(&mut Names::default(), &mut warnings)[0].segments.len(), 5);
        assert!(warnings[0].0.problem().contains("fold line"));
    }

    #[test]
    fn pairs_are_mirror_images_with_their_right_sides_up() {
        let pair = Draft { fold: None, copies: Copies::MirroredPair, ..half_front() };
        let panels = pair.panels(&mut Names::default(), &mut vec![]);
        let [a, b] = panels.as_slice() else { panic!() };
        assert_eq!((a.name.as_str(), b.name.as_str()), ("piece", "piece (mirrored)"));
        assert!((a.signed_area() - b.signed_area()).abs() < 1e-12 && a.signed_area() > 0.0);
        for (n, m) in a.markings.notches.iter().zip(&b.markings.notches) {
            let (p, q) = (
                a.segments[n.segment].curve.at_fraction(n.fraction),
                b.segments[m.segment].curve.at_fraction(m.fraction),
            );
            assert!((p - v(-q.x, q.y)).norm() < 1e-7);
        }
    }

    #[test]
    fn the_grainline_is_turned_upright() {
        for (grain, height) in [([v(0.0, 0.0), v(0.2, 0.0)], 0.3), ([v(0.0, 0.4), v(0.0, 0.1)], 0.62)] {
            let turned = Draft { fold: None, grainline: Some(grain), ..half_front() };
            let panels = turned.panels(&mut Names::default(), &mut vec![]);
            let [a, b] = panels[0].markings.grainline.unwrap();
            assert!((a.x - b.x).abs() < 1e-12);
            let ys = panels[0].corners().map(|p| p.y);
            let (low, high) = ys.fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(y), h.max(y)));
            assert!((high - low - height).abs() < 1e-9, "{low} {high}");
        }
    }

    #[test]
    fn names_are_made_unique_and_clean() {
        let mut names = Names::default();
        let given = ["DETAIL", "DETAIL", "a\nb", " ", "DETAIL 2"].map(|n| names.unique(n));
        assert_eq!(given, ["DETAIL", "DETAIL 2", "a b", "panel", "DETAIL 2 2"]);
    }
}
