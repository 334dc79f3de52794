//! A sleeveless dress: a bodice fitted by waist and bust darts, and an A-line skirt to the knee.
//!
//! Four panels, closed at all seams. Bodice panels are drawn with the waist at y = 0, skirt panels as sectors of a ring
//! whose center is the origin. As in the T-shirt, x is the wearer's left in front and back alike.

use super::measures::Measures;
use super::outline::{Outline, Path, Point, Stroke, rotated, solve_increasing};
use super::pattern::{Panel, Pattern, Side, side};

// Lengths in cm, angles in degrees.

/// Added to the bust girth: a close bodice that still lets breathe.
const BUST_EASE: f64 = 5.0;
/// Added to the waist girth: snug, room for a finger.
const WAIST_EASE: f64 = 3.0;
/// Added to the hip girth; what the skirt has there decides its flare.
const HIP_EASE: f64 = 12.0;
/// The front gets this much more of the half girth than a quarter of the whole. More at the bust than at the waist.
const FRONT_BUST_SURPLUS: f64 = 0.9;
const FRONT_WAIST_SURPLUS: f64 = 0.2;
/// Slack along the figure, shoulder to waist.
const LENGTH_EASE: f64 = 0.4;

/// Half the width of the neckline at the shoulders, and how far it dips below them.
const NECK_HALF_WIDTH: f64 = 10.5;
const FRONT_NECK_DROP: f64 = 12.5;
const BACK_NECK_DROP: f64 = 5.5;
/// The shoulder seam ends this far inside the shoulder point, so that the arm swings free.
const SHOULDER_INSET: f64 = 1.7;
const FRONT_SLOPE: f64 = 21.0;
const BACK_SLOPE: f64 = 18.0;
/// The underarm point lies this far below the armpit. Without sleeves it must be high, or the bodice gapes.
const UNDERARM_BELOW_ARMPIT: f64 = 0.4;
/// The waist seam rises toward the sides, so that it meets the slanted side seam squarely.
const WAIST_SIDE_RISE: f64 = 0.6;

/// Width of the darts at their open ends, and how far their tips stay from the tip of the bust.
const FRONT_WAIST_DART: f64 = 4.0;
const BACK_WAIST_DART: f64 = 2.6;
const BUST_DART: f64 = 3.0;
const TIP_TO_BUST_POINT: f64 = 2.5;
/// Height of the back dart's tip above the waist: below the shoulder blade.
const BACK_DART_HEIGHT: f64 = 15.5;
/// The bust dart leaves the side seam at this part of the way from waist to underarm.
const BUST_DART_PLACE: f64 = 0.60;

/// The hem hangs this far above the middle of the knee.
const HEM_ABOVE_KNEE: f64 = 2.0;

/// Handles of the armhole curves, at the underarm point and at the shoulder. Longer ones cut deeper toward the middle;
/// these leave 16 across the chest and 16.5 across the back, half each, which the arm needs to swing.
const FRONT_ARMHOLE_HANDLES: [f64; 2] = [6.2, 7.6];
const BACK_ARMHOLE_HANDLES: [f64; 2] = [5.2, 7.0];

/// Where flat panels hang, z. The skirt hangs inside the bodice, so that they do not meet, and below it.
const FRONT_DISTANCE: f64 = 24.0;
const BACK_DISTANCE: f64 = -22.0;
const SKIRT_FRONT_DISTANCE: f64 = 19.0;
const SKIRT_BACK_DISTANCE: f64 = -18.5;
const SKIRT_DROP: f64 = 1.5;

/// Lengths of a bodice panel's waist segments: across the middle, and from dart to side.
struct Waist {
    middle: f64,
    side: f64,
}

impl Waist {
    fn whole(&self) -> f64 {
        self.middle + 2.0 * self.side
    }
}

pub fn draft(measures: &Measures) -> Pattern {
    let front = front_bodice(measures);
    let back = back_bodice(measures, &front);
    let waists = [waist_of(&front), waist_of(&back)];
    let [front_skirt, back_skirt] = skirts(measures, &waists);

    let bodice_at = |z| [0.0, measures.waist_height, z];
    let skirt_at = |(radius, z): (f64, f64)| [0.0, measures.waist_height - SKIRT_DROP + radius, z];
    let panel = |name, part, outline, translation| Panel { name, part, outline, translation, turn: 0.0 };
    let panels = vec![
        panel("front_bodice", "body", front, bodice_at(FRONT_DISTANCE)),
        panel("back_bodice", "body", back.reversed(), bodice_at(BACK_DISTANCE)),
        panel("front_skirt", "leg", front_skirt.1, skirt_at((front_skirt.0, SKIRT_FRONT_DISTANCE))),
        panel("back_skirt", "leg", back_skirt.1.reversed(), skirt_at((back_skirt.0, SKIRT_BACK_DISTANCE))),
    ];
    Pattern { panels, seams: seams() }
}

fn seams() -> Vec<[Side; 2]> {
    let same = |a: &'static str, b: &'static str, segment: &'static str| [side(a, segment), side(b, segment)];
    let dart = |panel: &'static str, one: &'static str, other: &'static str| [side(panel, one), side(panel, other)];
    vec![
        dart("front_bodice", "left_waist_dart_inner", "left_waist_dart_outer"),
        dart("front_bodice", "right_waist_dart_inner", "right_waist_dart_outer"),
        dart("front_bodice", "left_bust_dart_lower", "left_bust_dart_upper"),
        dart("front_bodice", "right_bust_dart_lower", "right_bust_dart_upper"),
        dart("back_bodice", "left_waist_dart_inner", "left_waist_dart_outer"),
        dart("back_bodice", "right_waist_dart_inner", "right_waist_dart_outer"),
        same("front_bodice", "back_bodice", "left_shoulder"),
        same("front_bodice", "back_bodice", "right_shoulder"),
        same("front_bodice", "back_bodice", "left_side_lower"),
        same("front_bodice", "back_bodice", "left_side_upper"),
        same("front_bodice", "back_bodice", "right_side_lower"),
        same("front_bodice", "back_bodice", "right_side_upper"),
        [side("front_bodice", "left_waist"), side("front_skirt", "left_lower_interface")],
        [side("front_bodice", "middle_waist"), side("front_skirt", "middle_lower_interface")],
        [side("front_bodice", "right_waist"), side("front_skirt", "right_lower_interface")],
        [side("back_bodice", "left_waist"), side("back_skirt", "left_lower_interface")],
        [side("back_bodice", "middle_waist"), side("back_skirt", "middle_lower_interface")],
        [side("back_bodice", "right_waist"), side("back_skirt", "right_lower_interface")],
        same("front_skirt", "back_skirt", "left_side"),
        same("front_skirt", "back_skirt", "right_side"),
    ]
}

/// Height of the underarm point above the waist, side seam sewn.
fn side_height(measures: &Measures) -> f64 {
    measures.armpit_height - UNDERARM_BELOW_ARMPIT - measures.waist_height
}

fn front_half_widths(measures: &Measures) -> [f64; 2] {
    let bust = (measures.bust_girth + BUST_EASE) / 4.0 + FRONT_BUST_SURPLUS;
    let waist = (measures.waist_girth + WAIST_EASE) / 4.0 + FRONT_WAIST_SURPLUS;
    [bust, waist]
}

/// Neck and shoulder ends of the shoulder seam, for a slope and the length from shoulder to waist above the bust.
fn shoulder_seam(measures: &Measures, waist_length: f64, slope: f64) -> [Point; 2] {
    let (sin, cos) = slope.to_radians().sin_cos();
    let seam_length = (measures.half_shoulder_width - SHOULDER_INSET - NECK_HALF_WIDTH)
        / (0.5 * (FRONT_SLOPE + BACK_SLOPE)).to_radians().cos();
    let drop = (NECK_HALF_WIDTH - measures.bust_point) * sin / cos;
    let neck = Point::new(NECK_HALF_WIDTH, waist_length + LENGTH_EASE - drop);
    [neck, neck + Point::new(cos, -sin) * seam_length]
}

/// Control points of a neckline that dips by `drop`, and its lowest point, in the middle.
fn neckline(neck: Point, drop: f64) -> ([Point; 2], Point) {
    /// Handles as parts of drop and half width; a little fuller than a quarter of an ellipse.
    const SHOULDER_HANDLE: f64 = 0.60;
    const MIDDLE_HANDLE: f64 = 0.62;
    /// The neckline leaves the shoulder a little inward, so that it does not stand off the neck.
    const INWARD: f64 = 0.3;
    let middle = Point::new(0.0, neck.y - drop);
    ([neck - Point::new(INWARD, SHOULDER_HANDLE * drop), middle + Point::new(MIDDLE_HANDLE * neck.x, 0.0)], middle)
}

/// Control points of an armhole that leaves the underarm point inward, turned by `turn` radians with the side seam, and
/// meets the shoulder seam squarely.
fn armhole(underarm: Point, turn: f64, shoulder: Point, slope: f64, [low, high]: [f64; 2]) -> [Point; 2] {
    let (sin, cos) = slope.to_radians().sin_cos();
    [underarm - Point::new(turn.cos(), turn.sin()) * low, shoulder - Point::new(sin, cos) * high]
}

fn front_bodice(measures: &Measures) -> Outline {
    let [half_bust, half_waist] = front_half_widths(measures);
    let bust_point = Point::new(measures.bust_point, measures.bust_to_waist);
    let dart_middle = measures.bust_point;
    let inner = Point::new(dart_middle - 0.5 * FRONT_WAIST_DART, 0.0);
    let waist_tip = Point::new(dart_middle, bust_point.y - TIP_TO_BUST_POINT);
    let outer = Point::new(dart_middle + 0.5 * FRONT_WAIST_DART, 0.0);
    let waist_side = Point::new(half_waist + FRONT_WAIST_DART, WAIST_SIDE_RISE);

    // The side as it will be when the bust dart is sewn; opening the dart turns all above it about the dart's tip.
    let sewn_underarm = Point::new(half_bust, side_height(measures));
    let lower = waist_side.lerp(&sewn_underarm, BUST_DART_PLACE);
    let bust_tip = bust_point + (lower - bust_point).normalize() * TIP_TO_BUST_POINT;
    let opening = 2.0 * (0.5 * BUST_DART / (lower - bust_tip).norm()).asin();
    let upper = rotated(lower, bust_tip, opening);
    let underarm = rotated(sewn_underarm, bust_tip, opening);

    let [neck, shoulder] = shoulder_seam(measures, measures.front_waist_length, FRONT_SLOPE);
    let armhole = armhole(underarm, opening, shoulder, FRONT_SLOPE, FRONT_ARMHOLE_HANDLES);
    let (collar, middle) = neckline(neck, FRONT_NECK_DROP);
    Path::from(inner)
        .line("left_waist_dart_inner", waist_tip)
        .line("left_waist_dart_outer", outer)
        .line("left_waist", waist_side)
        .line("left_side_lower", lower)
        .line("left_bust_dart_lower", bust_tip)
        .line("left_bust_dart_upper", upper)
        .line("left_side_upper", underarm)
        .cubic("left_armhole", armhole, shoulder)
        .line("left_shoulder", neck)
        .cubic("left_collar", collar, middle)
        .with_mirror_image(("middle_waist", Stroke::Straight), None)
}

fn back_bodice(measures: &Measures, front: &Outline) -> Outline {
    let [front_bust, front_waist] = front_half_widths(measures);
    let half_bust = 0.5 * (measures.bust_girth + BUST_EASE) - front_bust;
    let half_waist = 0.5 * (measures.waist_girth + WAIST_EASE) - front_waist;
    let dart_middle = measures.bust_point;
    let inner = Point::new(dart_middle - 0.5 * BACK_WAIST_DART, 0.0);
    let tip = Point::new(dart_middle, BACK_DART_HEIGHT);
    let outer = Point::new(dart_middle + 0.5 * BACK_WAIST_DART, 0.0);
    let waist_side = Point::new(half_waist + BACK_WAIST_DART, WAIST_SIDE_RISE);

    // the side seam has the front's two lengths
    let (lower_length, upper_length) = (front.length_of("left_side_lower"), front.length_of("left_side_upper"));
    let side_length = lower_length + upper_length;
    let height = solve_increasing([5.0, 40.0], side_length, |y| (Point::new(half_bust, y) - waist_side).norm());
    let underarm = Point::new(half_bust, height);
    let split = waist_side.lerp(&underarm, lower_length / side_length);

    let [neck, shoulder] = shoulder_seam(measures, measures.back_waist_length, BACK_SLOPE);
    let armhole = armhole(underarm, 0.0, shoulder, BACK_SLOPE, BACK_ARMHOLE_HANDLES);
    let (collar, middle) = neckline(neck, BACK_NECK_DROP);
    Path::from(inner)
        .line("left_waist_dart_inner", tip)
        .line("left_waist_dart_outer", outer)
        .line("left_waist", waist_side)
        .line("left_side_lower", split)
        .line("left_side_upper", underarm)
        .cubic("left_armhole", armhole, shoulder)
        .line("left_shoulder", neck)
        .cubic("left_collar", collar, middle)
        .with_mirror_image(("middle_waist", Stroke::Straight), None)
}

fn waist_of(bodice: &Outline) -> Waist {
    Waist { middle: bodice.length_of("middle_waist"), side: bodice.length_of("left_waist") }
}

/// Front and back skirt, each with its waist radius. Around the whole body the skirt is a ring sector whose inner arc
/// is the waist and whose arc at hip depth is the hip girth with ease:
///
/// ```text
///     waist = angle * radius          hip = angle * (radius + depth)
/// ```
fn skirts(measures: &Measures, waists: &[Waist; 2]) -> [(f64, Outline); 2] {
    let waist = waists[0].whole() + waists[1].whole();
    let depth = measures.waist_height - measures.hip_height;
    let radius = waist * depth / (measures.hip_girth + HIP_EASE - waist);
    let hem_radius = radius + measures.waist_height - measures.knee_height - HEM_ABOVE_KNEE;
    [0, 1].map(|i| {
        let at = |arc_from_middle: f64, from_center: f64| -> Point {
            let (sin, cos) = (arc_from_middle / radius).sin_cos();
            Point::new(sin, -cos) * from_center
        };
        let half = 0.5 * waists[i].whole();
        let outline = Path::from(at(half, hem_radius))
            .line("left_side", at(half, radius))
            .arc("left_lower_interface", radius, false, at(0.5 * waists[i].middle, radius))
            .with_mirror_image(
                ("hem", Stroke::Arc { radius: hem_radius, bulges_right: true }),
                Some(("middle_lower_interface", Stroke::Arc { radius, bulges_right: false })),
            );
        (radius, outline)
    })
}
