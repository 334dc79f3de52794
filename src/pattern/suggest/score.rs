//! What speaks for and against sewing two segments together.

mod placed;

use super::symmetry::Symmetry;
use crate::geometry::{Vector2, Vector3};
use crate::pattern::names::{Part, Role, role, together};
use crate::pattern::sewing::Measured;
use crate::pattern::sewing::evidence::corner_angle;
use crate::pattern::{BodyPart, NotchKind, Pattern, SegmentId, SegmentLabel};

/// Points at which segments are compared.
const PROBES: usize = 5;

/// Lengths of which the smaller is more than this share of the larger are equal.
const EQUAL: f64 = 0.995;

/// What is known of one segment.
struct Edge {
    length: f64,
    /// Its form: how far it bulges out of its panel beyond its chord, as a share of the chord; negative inwards.
    bulge: f64,
    /// How far it leaves its chord at the most, as a share.
    curved: f64,
    /// In the world, from its start to its end; none without a placement.
    points: Option<[Vector3; PROBES]>,
    /// Out of the panel across the segment, in the world, of length one.
    outwards: Vector3,
    /// Where the right side faces.
    normal: Vector3,
    /// Interior angles of the panel at start and end, radians.
    angles: [f64; 2],
    notches: Vec<(f64, NotchKind)>,
    label: Option<SegmentLabel>,
}

/// All segments of a pattern.
pub struct Edges<'p> {
    pub(super) pattern: &'p Pattern,
    measured: Measured,
    pub ids: Vec<SegmentId>,
    edges: Vec<Edge>,
    roles: Vec<Role>,
    /// Per segment: its mirror image in the drawing.
    mirror: Vec<Option<usize>>,
    /// Per panel: index of its first segment.
    first: Vec<usize>,
    /// Per panel: is it drawn with its wrong side up? Not known before seams are.
    turned: Vec<bool>,
    /// Per panel: its middle in the world.
    middle: Vec<Vector3>,
}

/// A pair with its score.
#[derive(Clone)]
pub struct Scored {
    pub a: usize,
    pub b: usize,
    pub score: f64,
    pub reasons: Vec<String>,
    /// Both are upper edges: shoulders, or two waists, which the seams beside them tell.
    pub is_upper: bool,
}

impl<'p> Edges<'p> {
    pub fn new(pattern: &'p Pattern) -> Self {
        let measured = Measured::new(pattern);
        let symmetry = Symmetry::new(pattern, &measured);
        let mut made = Self {
            pattern,
            measured: Measured::new(pattern),
            ids: Vec::new(),
            edges: Vec::new(),
            mirror: Vec::new(),
            roles: pattern.panels.iter().map(|p| role(&p.name)).collect(),
            first: Vec::new(),
            turned: vec![false; pattern.panels.len()],
            middle: Vec::new(),
        };
        for (panel, drawn) in pattern.panels.iter().enumerate() {
            made.first.push(made.ids.len());
            let turn = drawn.signed_area().signum();
            let count = drawn.segments.len();
            let mut middle = Vector3::zeros();
            for segment in 0..count {
                let id = SegmentId { panel, segment };
                let at = |t: f64| measured.point(id, t);
                let (start, end) = (at(0.0), at(1.0));
                let chord = end - start;
                let length = measured.length_of(id);
                let size = chord.norm().max(1e-6);
                // To the right of the travel is outside where the outline runs counter-clockwise.
                let out = Vector2::new(chord.y, -chord.x) / size * turn;
                let bulges = [0.25, 0.5, 0.75].map(|t| (at(t) - start).dot(&out) / size);
                let place = |p: Vector2| drawn.placement.as_ref().map(|placement| placement.place(p));
                let points: Option<Vec<Vector3>> =
                    (0..PROBES).map(|k| place(at(k as f64 / (PROBES - 1) as f64))).collect();
                let points: Option<[Vector3; PROBES]> = points.and_then(|points| points.try_into().ok());
                let turned = |v: Vector3| drawn.placement.as_ref().map_or(v, |placement| placement.rotation * v);
                middle += points.map_or_else(Vector3::zeros, |p| p[0] / count as f64);
                let marks = drawn.markings.notches.iter().filter(|n| n.segment == segment);
                made.edges.push(Edge {
                    length,
                    bulge: bulges.iter().sum::<f64>() / 3.0,
                    curved: bulges.iter().fold(0.0, |m, b| f64::max(m, b.abs())),
                    points,
                    outwards: turned(Vector3::new(out.x, out.y, 0.0)),
                    normal: turned(Vector3::new(0.0, 0.0, turn)),
                    angles: [segment, (segment + 1) % count]
                        .map(|corner| corner_angle(pattern, &measured, panel, corner)),
                    notches: marks.map(|n| (n.fraction, n.kind)).collect(),
                    label: drawn.segments[segment].label,
                });
                made.ids.push(id);
            }
            made.middle.push(middle);
        }
        let image = |&id: &SegmentId| symmetry.image(id).map(|there| made.first[there.panel] + there.segment);
        made.mirror = made.ids.iter().map(image).collect();
        made
    }

    /// Is any panel without a place around the body?
    pub fn are_drawn(&self) -> bool {
        self.edges.iter().any(|edge| edge.points.is_none())
    }

    pub fn mirror(&self, edge: usize) -> Option<usize> {
        self.mirror[edge]
    }

    pub fn role(&self, edge: usize) -> Role {
        self.roles[self.ids[edge].panel]
    }

    pub fn length(&self, edge: usize) -> f64 {
        self.edges[edge].length
    }

    /// Are they as long as each other, as far as that is drawn?
    pub fn are_as_long(&self, a: usize, b: usize) -> bool {
        let lengths = [self.length(a), self.length(b)];
        lengths[0].min(lengths[1]) > EQUAL * lengths[0].max(lengths[1])
    }

    pub fn bulge(&self, edge: usize) -> f64 {
        self.edges[edge].bulge
    }

    /// The height in the drawing at a fraction of a segment, m.
    pub fn height(&self, edge: usize, fraction: f64) -> f64 {
        self.measured.point(self.ids[edge], fraction).y
    }

    pub fn notches_of(&self, edge: usize) -> &[(f64, NotchKind)] {
        &self.edges[edge].notches
    }

    /// Turns those panels over, of all, whose wrong side is drawn.
    pub fn turn_over(&mut self, turned: Vec<bool>) {
        self.turned = turned;
    }

    /// Does the outline of its panel run clockwise, seen with the right side up?
    pub fn is_clockwise(&self, edge: usize) -> bool {
        self.turned[self.ids[edge].panel]
    }

    /// Out of the panel across a segment, as drawn, seen with the right side up: what is left then is left.
    pub fn outwards(&self, edge: usize) -> Vector2 {
        let edge = &self.edges[edge];
        Vector2::new(edge.outwards.x * edge.normal.z.signum(), edge.outwards.y)
    }

    /// The segments beside one along its outline: the one before and the one after.
    pub fn beside(&self, edge: usize) -> [usize; 2] {
        let id = self.ids[edge];
        let (first, count) = (self.first[id.panel], self.pattern.panels[id.panel].segments.len());
        [first + (id.segment + count - 1) % count, first + (id.segment + 1) % count]
    }

    /// Are these of one part of the garment, as far as names tell?
    pub fn same_part(&self, a: usize, b: usize) -> bool {
        self.part(a) == self.part(b)
    }

    /// The corners that a seam would join, by the index of the segment that starts there.
    pub fn ends(&self, pair: &Scored) -> [[u32; 2]; 2] {
        let corner = |edge: usize, end: usize| {
            let id = self.ids[edge];
            let count = self.pattern.panels[id.panel].segments.len();
            (self.first[id.panel] + (id.segment + end) % count) as u32
        };
        [[corner(pair.a, 0), corner(pair.b, 1)], [corner(pair.a, 1), corner(pair.b, 0)]]
    }

    pub fn score(&self, a: usize, b: usize) -> Scored {
        let mut made = Scored { a, b, score: 0.0, reasons: Vec::new(), is_upper: false };
        let (ea, eb) = (&self.edges[a], &self.edges[b]);
        let (panel_a, panel_b) = (self.ids[a].panel, self.ids[b].panel);
        let ratio = ea.length.min(eb.length) / ea.length.max(eb.length);
        if panel_a == panel_b {
            self.within_panel(&mut made, ratio);
            return made;
        }
        made.score += match ratio {
            r if r > EQUAL => 2.0,
            r if r > 0.97 => 1.3,
            r if r > 0.9 => 0.5,
            r if r > 0.6 => -0.2,
            r if r > 0.35 => -0.8,
            _ => -4.0,
        };
        made.reasons.push(match ratio {
            r if r > EQUAL => "equal lengths".to_owned(),
            r => format!("{:.0} % longer on one side", 100.0 * (1.0 / r - 1.0)),
        });
        let named = together(&self.roles[panel_a], &self.roles[panel_b]);
        made.score += 0.8 * named;
        if named > 0.5 {
            made.reasons.push("names".to_owned());
        }
        let form = (ea.bulge - eb.bulge).abs().min((ea.bulge + eb.bulge).abs());
        made.score += 0.5 - 6.0 * form.min(0.3);
        if form < 0.01 && ea.curved > 0.03 {
            made.reasons.push("equal curves".to_owned());
        }
        self.notches(&mut made);
        match (&ea.points, &eb.points) {
            (Some(p), Some(q)) => self.placed(&mut made, p, q),
            _ => self.unplaced(&mut made),
        }
        made
    }

    /// What part of the garment the panel of a segment is.
    pub(super) fn part(&self, edge: usize) -> Option<Part> {
        let panel = self.ids[edge].panel;
        let labelled = self.pattern.panels[panel].part.and_then(|part| match part {
            BodyPart::Arm => Some(Part::Sleeve),
            BodyPart::Body => Some(Part::Torso),
            BodyPart::Leg => None,
        });
        self.roles[panel].part.or(labelled)
    }

    /// Darts, and tubes of one panel.
    fn within_panel(&self, made: &mut Scored, ratio: f64) {
        /// A dart turns the outline back into the panel by more than this, radians.
        const DART: f64 = 1.25 * std::f64::consts::PI;
        /// In a drawing, where pockets and vents are notched as well.
        const DRAWN_DART: f64 = 1.6 * std::f64::consts::PI;
        let count = self.pattern.panels[self.ids[made.a].panel].segments.len();
        let (i, j) = (self.ids[made.a].segment, self.ids[made.b].segment);
        let (ea, eb) = (&self.edges[made.a], &self.edges[made.b]);
        let straight = ea.curved.max(eb.curved) < 0.1;
        let drawn = ea.points.is_none();
        let dart = if drawn { DRAWN_DART } else { DART };
        let tip = if j == i + 1 { Some(ea.angles[1]) } else { (i == 0 && j == count - 1).then_some(ea.angles[0]) };
        match tip {
            Some(angle) if angle > dart && ratio > 0.95 && straight && count > 3 => {
                made.score = 6.0;
                made.reasons.push("a dart: equal legs".to_owned());
            }
            Some(_) => made.score = -9.0,
            None => {
                // A sleeve in one piece closes under the arm.
                let panel = self.ids[made.a].panel;
                let band = drawn && self.is_band(panel);
                let part = self.part(made.a);
                let sleeve = part == Some(Part::Sleeve) || part == Some(Part::Cuff) && !band;
                let alike = ratio > 0.97 && (ea.bulge - eb.bulge).abs() < 0.02 && ea.bulge.abs() < 0.08;
                let one_piece = self.roles[self.ids[made.a].panel].face.is_none();
                let ends = ea.length.max(eb.length) < 0.3 * 0.5 * self.pattern.panels[panel].perimeter();
                if sleeve && alike && one_piece && count <= 8 {
                    made.score = 2.5 + self.corners(ea, eb);
                    made.reasons.push("equal lengths on one sleeve, which closes to a tube".to_owned());
                } else if band && ends && matches!(part, Some(Part::Waistband | Part::Cuff)) {
                    made.score = 2.5;
                    made.reasons.push("the ends of a band".to_owned());
                } else {
                    made.score = -9.0;
                }
            }
        }
    }

    fn notches(&self, made: &mut Scored) {
        let (a, b) = (&self.edges[made.a].notches, &self.edges[made.b].notches);
        if a.is_empty() && b.is_empty() {
            return;
        }
        let fits = |flip: bool| {
            a.len() == b.len()
                && a.iter().all(|(f, kind)| {
                    let f = if flip { 1.0 - f } else { *f };
                    b.iter().any(|(g, other)| kind == other && (f - g).abs() < 0.06)
                })
        };
        if fits(true) || fits(false) {
            made.score += 2.0;
            made.reasons.push("notches".to_owned());
        } else {
            made.score -= 0.7;
        }
    }

    /// How well corners fit: where two segments meet, outlines go on straight or the angles are alike; at most 0.6.
    fn corners(&self, a: &Edge, b: &Edge) -> f64 {
        let at = |x: f64, y: f64| (x + y - std::f64::consts::PI).abs().min(1.0);
        let opposed = at(a.angles[0], b.angles[1]) + at(a.angles[1], b.angles[0]);
        let aligned = at(a.angles[0], b.angles[0]) + at(a.angles[1], b.angles[1]);
        0.6 - 0.8 * opposed.min(aligned)
    }

    fn unplaced(&self, made: &mut Scored) {
        let (ea, eb) = (&self.edges[made.a], &self.edges[made.b]);
        made.score += self.corners(ea, eb);
        let same = self.part(made.a).is_some() && self.part(made.a) == self.part(made.b);
        // Curves that both bend inwards on front and back are armholes and necklines.
        if same && ea.bulge < -0.04 && eb.bulge < -0.04 && self.faces_differ(made) {
            made.score -= 2.5;
        }
        self.labels(made);
        self.drawn(made);
    }

    pub(super) fn faces_differ(&self, made: &Scored) -> bool {
        let face = |edge: usize| self.roles[self.ids[edge].panel].face;
        matches!((face(made.a), face(made.b)), (Some(f), Some(g)) if f != g)
    }

    fn labels(&self, made: &mut Scored) {
        let labels = [made.a, made.b].map(|edge| self.edges[edge].label);
        let same_part = self.part(made.a) == self.part(made.b);
        for label in labels.into_iter().flatten() {
            if same_part
                && matches!(label, SegmentLabel::Armhole | SegmentLabel::LowerInterface | SegmentLabel::StraplessTop)
            {
                made.score -= 3.0;
            }
        }
    }
}
