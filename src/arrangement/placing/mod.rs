//! Placing by itself: first positions of panels that were drawn without any.
//!
//! The sewn garment is one surface with openings, and the openings tell where on the body it belongs (`rims`). A smooth map of
//! that surface with its openings where head, arms and legs come out (`map`, `facing`) tells of each panel whether it lies in
//! front or behind and which way is up. Panels then stand flat outside the body, as Le Thanh and Gagalowicz (2005) have them, or
//! bent around a limb, as on the bounding surfaces of Gross, Fuhrmann and Luckas (2003) (`stance`), where their seams are
//! shortest (`puzzle`). Names are asked for what is front and left (`names`); they are not needed.
//!
//! Not promised: that it is right. Garments with openings besides those of the body, with pieces sewn to nothing, or wrapped twice
//! around it are placed by their names alone, and an [`Override`] moves any panel. What is left is up to the search of
//! [`super::arrange`].

mod apart;
mod facing;
mod figure;
mod map;
mod names;
mod narrow;
mod puzzle;
mod rims;
mod stance;
mod surface;
mod waist;

pub use names::{Hints, Zone};

use crate::body::{Body, Landmarks};
use crate::geometry::Vector3;
use crate::pattern::{Pattern, Placement};
use crate::{Error, Warning};
use facing::{Draft, draft};
use figure::Figure;
use puzzle::{Row, ties, translations};
use rims::{Opening, openings};
use stance::{Stance, Standing};
use surface::Surface;

/// What a panel is placed on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limb {
    Torso,
    Head,
    /// 0 at the body's left, +x.
    Arm(usize),
    Leg(usize),
}

impl Limb {
    pub fn name(self) -> &'static str {
        match self {
            Self::Torso => "torso",
            Self::Head => "head",
            Self::Arm(0) => "left arm",
            Self::Arm(_) => "right arm",
            Self::Leg(0) => "left leg",
            Self::Leg(_) => "right leg",
        }
    }
}

/// What is asked of one panel; all else is found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Override {
    pub limb: Option<Limb>,
    /// Of the panel's middle above the floor, m.
    pub height: Option<f64>,
    /// Of its middle, towards the body's left, m.
    pub aside: Option<f64>,
    /// Which way it faces, rad: 0 to the front; a quarter to the body's left, on arms and legs to their outside; a half to the back.
    pub angle: Option<f64>,
    /// In its own plane, rad, counter-clockwise seen from outside; 0 has the panel's y up the limb.
    pub turn: Option<f64>,
    /// How far its middle is from the limb's axis, in the direction that it faces, m.
    pub distance: Option<f64>,
    /// Radius of the cylinder around which it is bent, m; infinite for a flat panel.
    pub bend: Option<f64>,
}

/// Where a panel was placed.
#[derive(Clone, Debug)]
pub struct Placed {
    pub panel: usize,
    pub limb: Limb,
    /// Unit outward normal of its middle, world.
    pub face: Vector3,
    /// Of its outline, m, world.
    pub middle: Vector3,
    /// As an override would ask for it, none of its fields open but `bend` of a flat panel.
    pub stands: Override,
}

/// What placing did.
#[derive(Clone, Debug)]
pub struct Report {
    /// One per panel.
    pub panels: Vec<Placed>,
    pub warnings: Vec<Warning>,
    /// Mean length of the lines along which seams close, m.
    pub mean_gap: f64,
}

/// The shoulder seam begins this far above the side of the neck, m.
const SHOULDER_EASE: f64 = 0.01;
/// Panels smaller than this share of the largest say nothing of where shoulders are: collars.
const SMALL: f64 = 0.15;
/// A strapless top ends this far below the armpits, m.
const BELOW_ARMPIT: f64 = 0.01;
/// Weights of rows against metres of seam: what settles a height, what keeps legs and arms in their places.
const FIRM: f64 = 50.0;
const SOFT: f64 = 0.2;

/// Places all panels of a pattern around a body, whether or not they had a placement. `overrides` has one entry per panel.
pub fn place(
    pattern: &mut Pattern,
    body: &Body,
    marks: &Landmarks,
    overrides: &[Option<Override>],
) -> Result<Report, Error> {
    assert_eq!(overrides.len(), pattern.panels.len(), "each panel may have an override");
    let surface = Surface::new(pattern)?;
    let hints: Vec<Hints> = pattern.panels.iter().map(Hints::of).collect();
    let figure = Figure::new(body, marks);
    let mut warnings = Vec::new();
    let mut stances: Vec<Option<Stance>> = vec![None; pattern.panels.len()];
    let mut rows = Vec::new();
    let mut drafts: Vec<(Vec<usize>, Draft)> = Vec::new();
    for piece in 0..surface.pieces {
        let panels: Vec<usize> = (0..pattern.panels.len())
            .filter(|&p| {
                let first = surface.level.panels[p].points.start;
                surface.piece_of[surface.level.particle_of[first] as usize] == piece
            })
            .collect();
        let found = openings(&surface, &hints, piece);
        if found.is_empty() {
            warnings.push(puzzled(pattern, &panels));
        }
        let draft = draft(&surface, &hints, &figure, piece, found);
        let standing = Standing { pattern, surface: &surface, hints: &hints, figure: &figure };
        for (&panel, stance) in panels.iter().zip(standing.stances(&panels, &draft, overrides)) {
            stances[panel] = Some(stance);
        }
        drafts.push((panels, draft));
    }
    let stances: Vec<Stance> = stances.into_iter().map(|s| s.expect("each panel belongs to a piece")).collect();
    let ties = ties(pattern, &stances);
    rows.extend(asked_rows(&stances, overrides, marks));
    for (panels, draft) in &drafts {
        rows.extend(limb_rows(&surface, &figure, &stances, panels, draft));
    }
    let loose = translations(&stances, &ties, &rows);
    for (panels, draft) in &drafts {
        rows.extend(height_rows(pattern, &surface, &hints, &figure, &stances, &loose, panels, draft));
    }
    let mut moves = translations(&stances, &ties, &rows);
    let mut raised = vec![0.0; stances.len()];
    for (panels, draft) in &drafts {
        let lift =
            narrow::free_hands_and_feet(&surface, &figure, body, &stances, overrides, (panels, draft), &mut moves);
        panels.iter().for_each(|&panel| raised[panel] = lift);
        waist::label(pattern, &surface, panels, draft);
    }
    apart::part_legs(pattern, &stances, &mut moves);
    apart::stagger(pattern, &stances, &mut moves);
    apart::clear_body(&surface, &stances, &mut moves, body);
    for (k, asked) in overrides.iter().enumerate() {
        if let Some(distance) = asked.and_then(|asked| asked.distance) {
            // The nearest point of an axis that leans moves along: a few rounds.
            for _ in 0..8 {
                let at = stances[k].turned(stances[k].middle) + moves[k];
                let axis = axis_point(&figure, stances[k].limb, at);
                moves[k] += stances[k].face * (distance - (at - axis).dot(&stances[k].face));
            }
        }
    }
    for (panel, (stance, translation)) in pattern.panels.iter_mut().zip(stances.iter().zip(&moves)) {
        panel.placement = Some(stance.placement(*translation));
    }
    for (panel, raised) in pattern.panels.iter_mut().zip(raised) {
        panel.placement.iter_mut().for_each(|placement| placement.raised = raised);
    }
    let panels = (0..stances.len()).map(|k| placed(pattern, &figure, &stances[k], k)).collect();
    let total: f64 = ties.iter().map(|tie| tie.weight).sum();
    let gap = |tie: &puzzle::Tie| {
        let [a, b] = [0, 1].map(|k| tie.ends[k] + moves[tie.panels[k]]);
        (a - b).norm() * tie.weight
    };
    let mean_gap = ties.iter().map(gap).sum::<f64>() / total.max(1e-12);
    Ok(Report { panels, warnings, mean_gap })
}

fn puzzled(pattern: &Pattern, panels: &[usize]) -> Warning {
    let names: Vec<String> = panels.iter().take(4).map(|&p| format!("\"{}\"", pattern.panels[p].name)).collect();
    let more = if panels.len() > 4 { " and others" } else { "" };
    Warning(
        Error::new(
            format!("What these panels are to enclose cannot be told from their openings: {}{more}.", names.join(", ")),
            "Check their seams, and tell where they belong in an arrangement file.",
        )
        .coded(crate::Code::PlacingDoubtful)
        .within("placing"),
    )
}

/// Heights and places aside that were asked for.
fn asked_rows(stances: &[Stance], overrides: &[Option<Override>], marks: &Landmarks) -> Vec<Row> {
    let mut rows = Vec::new();
    for (panel, asked) in overrides.iter().enumerate() {
        let Some(asked) = asked else { continue };
        let point = stances[panel].turned(stances[panel].middle);
        let height = asked.height.map(|height| (Vector3::y(), height + marks.floor));
        let aside = asked.aside.map(|aside| (Vector3::x(), aside));
        for (normal, value) in height.into_iter().chain(aside) {
            rows.push(Row { panel, point, normal, value, weight: 20.0 * FIRM });
        }
    }
    rows
}

/// The axis of a limb at the height, or the length, of a point.
fn axis_point(figure: &Figure, limb: Limb, at: Vector3) -> Vector3 {
    match limb {
        Limb::Torso | Limb::Head => Vector3::new(figure.middle, at.y, 0.5 * (figure.front + figure.back)),
        Limb::Leg(side) => figure.leg_at(side, at.y),
        Limb::Arm(side) => {
            let arm = &figure.marks.arms[side];
            let (root, end) = (arm.axis[0], *arm.axis.last().expect("an arm has sections"));
            let way = (end - root).normalize();
            root + way * way.dot(&(at - root))
        }
    }
}

/// Sleeves lie over their arms, trouser legs over their legs, and what is around the body has its middle there.
fn limb_rows(surface: &Surface, figure: &Figure, stances: &[Stance], panels: &[usize], draft: &Draft) -> Vec<Row> {
    let mut rows = Vec::new();
    for &panel in panels {
        let stance = &stances[panel];
        let at_rim = |wanted: &dyn Fn(Opening) -> bool| rim_middle(surface, draft, stance, panel, wanted);
        match stance.limb {
            Limb::Arm(_) if stance.bend.is_none() => {
                let point = stance.turned(stance.middle);
                let axis = axis_point(figure, stance.limb, stance.drafted);
                let normal = stance.free[1];
                rows.push(Row { panel, point, normal, value: normal.dot(&axis), weight: SOFT });
            }
            Limb::Leg(side) if stance.bend.is_none() => {
                if let Some(point) = at_rim(&|o| o == Opening::Leg(side)) {
                    let value = figure.leg_at(side, figure.marks.ankles[side].y).x;
                    rows.push(Row { panel, point, normal: Vector3::x(), value, weight: SOFT });
                }
            }
            Limb::Torso if draft.is_tube && stance.face.x.abs() < 0.3 && panels.len() <= 8 => {
                let point = stance.turned(stance.middle);
                rows.push(Row { panel, point, normal: Vector3::x(), value: stance.drafted.x, weight: 0.1 * SOFT });
            }
            _ => {}
        }
    }
    rows
}

/// The middle of a panel's part of an opening, turned as the panel is, m.
fn rim_middle(
    surface: &Surface,
    draft: &Draft,
    stance: &Stance,
    panel: usize,
    wanted: &dyn Fn(Opening) -> bool,
) -> Option<Vector3> {
    let points = surface.level.panels[panel].points.clone();
    let mut on_rim = vec![false; surface.level.particle_count];
    for (rim, _) in draft.openings.iter().filter(|(_, o)| wanted(*o)) {
        surface.rims[*rim].indices().for_each(|p| on_rim[p as usize] = true);
    }
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    for p in points.filter(|&p| on_rim[surface.level.particle_of[p] as usize]) {
        sum += stance.turned(surface.level.rest[p]);
        count += 1.0;
    }
    // Two points are the ends of neighbors.
    (count > 2.0).then(|| sum / count)
}

/// Shoulders belong on shoulders, waists on waists: what settles how high a piece hangs.
#[allow(clippy::too_many_arguments)]
fn height_rows(
    pattern: &Pattern,
    surface: &Surface,
    hints: &[Hints],
    figure: &Figure,
    stances: &[Stance],
    loose: &[Vector3],
    panels: &[usize],
    draft: &Draft,
) -> Vec<Row> {
    let top = draft.openings.iter().find(|(_, o)| *o == Opening::Top);
    if let Some(&(rim, _)) = top {
        let value = match waist::is_strapless(pattern, hints, panels, draft) {
            true => 0.5 * (figure.marks.armpits[0].y + figure.marks.armpits[1].y) - BELOW_ARMPIT,
            false => waist::height(surface, figure, draft, rim),
        };
        let row = |&panel: &usize| {
            let point = rim_middle(surface, draft, &stances[panel], panel, &|o| o == Opening::Top)?;
            Some(Row { panel, point, normal: Vector3::y(), value, weight: FIRM })
        };
        return panels.iter().filter_map(row).collect();
    }
    // The highest point of what is large and lies in front or behind is where the shoulder meets the neck.
    let area = |panel: usize| pattern.panels[panel].signed_area().abs();
    let largest = panels.iter().map(|&p| area(p)).fold(0.0, f64::max);
    let is_shoulder = |&&panel: &&usize| {
        stances[panel].limb == Limb::Torso
            && stances[panel].face.z.abs() > 0.5
            && area(panel) > SMALL * largest
            && !matches!(hints[panel].zone, Some(Zone::Neck | Zone::Skirt | Zone::Waistband))
    };
    let mut best: Option<(f64, Row)> = None;
    for &panel in panels.iter().filter(is_shoulder) {
        for corner in pattern.panels[panel].corners() {
            let point = stances[panel].turned(corner);
            let height = (point + loose[panel]).y;
            if best.as_ref().is_none_or(|(other, _)| height > *other) {
                let value = 0.5 * (figure.marks.neck_sides[0].y + figure.marks.neck_sides[1].y) + SHOULDER_EASE;
                best = Some((height, Row { panel, point, normal: Vector3::y(), value, weight: FIRM }));
            }
        }
    }
    best.map(|(_, row)| row).into_iter().collect()
}

fn placed(pattern: &Pattern, figure: &Figure, stance: &Stance, panel: usize) -> Placed {
    let placement: &Placement = pattern.panels[panel].placement.as_ref().expect("it was just placed");
    let middle = placement.place(stance.middle);
    let axis = axis_point(figure, stance.limb, middle);
    Placed {
        panel,
        limb: stance.limb,
        face: stance.face,
        middle,
        stands: Override {
            limb: Some(stance.limb),
            height: Some(middle.y - figure.marks.floor),
            aside: Some(middle.x),
            angle: Some(stance.angle),
            turn: Some(stance.turn),
            distance: Some((middle - axis).dot(&stance.face)),
            bend: stance.bend.map(|bend| bend.radius.abs()),
        },
    }
}
