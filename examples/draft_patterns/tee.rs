//! A T-shirt: whole front and back, crew neck, short set-in sleeves in two halves each.
//!
//! Drawn with the underarm line at y = 0. The front is drawn as seen by a viewer before the body, the back as seen
//! through the body from the same place, so x is the wearer's left in both.

use super::measures::Measures;
use super::outline::{Outline, Path, Point, Stroke, solve_increasing};
use super::pattern::{Panel, Pattern, Side, side};

// Lengths in cm, angles in degrees.

/// Added to the bust girth: an easy, not a loose T-shirt.
const BUST_EASE: f64 = 9.0;
/// The front gets this much more of every half girth than the back, since the bust is in front.
const FRONT_SURPLUS: f64 = 0.5;
/// Added to the hip girth at the hem, for sitting down.
const HEM_EASE: f64 = 7.0;
/// The hem hangs this far above the widest part of the hips.
const HEM_ABOVE_HIP: f64 = 1.0;
/// The underarm point lies this far below the armpit, for reach.
const UNDERARM_BELOW_ARMPIT: f64 = 1.8;
/// Half the width of the neckline at the shoulders: 1.7 outside the base of the neck.
const NECK_HALF_WIDTH: f64 = 8.6;
/// How far the neckline dips below its shoulder end. A crew neck clears the pit of the neck by a finger.
const FRONT_NECK_DROP: f64 = 9.7;
const BACK_NECK_DROP: f64 = 3.2;
/// Handle of the neckline in the middle, as a part of its half width.
const MIDDLE_NECK_HANDLE: f64 = 0.6;
/// Shoulder slopes. The ridge of the shoulder falls by 19; the front seam line, before it, falls a little more.
const FRONT_SLOPE: f64 = 20.5;
const BACK_SLOPE: f64 = 18.5;
/// The shoulder seam ends this far outside the shoulder point.
const SHOULDER_EXTENSION: f64 = 0.5;
/// The front is this much longer above the underarm line, for the bust. A fitted garment without darts would want
/// twice as much; the rest comes out of the ease.
const FRONT_BALANCE: f64 = 2.2;

/// Sleeve length along its top.
const SLEEVE_LENGTH: f64 = 21.0;
/// Width of the sleeve around the upper arm beyond the arm's girth.
const SLEEVE_EASE: f64 = 8.0;
/// The sleeve cap is longer than its armhole by this part, to round over the joint.
const CAP_EASE: f64 = 0.015;
/// Each half of the sleeve is narrower at its hem by this much.
const SLEEVE_TAPER: f64 = 1.2;
/// The cap starts this far beyond the shoulder point before sewing.
const SLEEVE_GAP: f64 = 1.5;

/// Where flat panels hang, z. Nearer they would touch bust or seat, farther away sewing takes longer.
const FRONT_DISTANCE: f64 = 24.0;
const BACK_DISTANCE: f64 = -22.0;
/// Sleeves hang closer, an arm being thinner than a torso.
const SLEEVE_FRONT_DISTANCE: f64 = 13.0;
const SLEEVE_BACK_DISTANCE: f64 = -16.0;

/// What front and back differ in.
struct Half {
    half_width: f64,
    neck_height: f64,
    neck_drop: f64,
    slope: f64,
    /// Lengths of the armhole's two handles: at the underarm point and at the shoulder.
    armhole_handles: [f64; 2],
    /// Handle of the neckline at the shoulder, as a part of its drop.
    neck_handle: f64,
}

pub fn draft(measures: &Measures) -> Pattern {
    let underarm_height = measures.armpit_height - UNDERARM_BELOW_ARMPIT;
    let neck_height = measures.back_waist_length - (underarm_height - measures.waist_height);
    let quarter = (measures.bust_girth + BUST_EASE) / 4.0;
    let front = Half {
        half_width: quarter + 0.5 * FRONT_SURPLUS,
        neck_height: neck_height + FRONT_BALANCE,
        neck_drop: FRONT_NECK_DROP,
        slope: FRONT_SLOPE,
        armhole_handles: [7.2, 9.2],
        neck_handle: 0.60,
    };
    let back = Half {
        half_width: quarter - 0.5 * FRONT_SURPLUS,
        neck_height,
        neck_drop: BACK_NECK_DROP,
        slope: BACK_SLOPE,
        armhole_handles: [6.2, 8.4],
        neck_handle: 0.45,
    };
    let front_outline = front.outline(measures, underarm_height);
    let back_outline = back.outline(measures, underarm_height).reversed();
    let [front_sleeve, back_sleeve] = sleeves(measures, &front_outline, &back_outline);

    let at = |z| [0.0, underarm_height, z];
    let mut panels = vec![
        Panel { name: "front", part: "body", outline: front_outline, translation: at(FRONT_DISTANCE), turn: 0.0 },
        Panel { name: "back", part: "body", outline: back_outline, translation: at(BACK_DISTANCE), turn: 0.0 },
    ];
    panels.extend(sleeve_pair(
        measures,
        ["left_sleeve_front", "right_sleeve_front"],
        front_sleeve,
        SLEEVE_FRONT_DISTANCE,
    ));
    let back_sleeve = back_sleeve.reversed();
    panels.extend(sleeve_pair(measures, ["left_sleeve_back", "right_sleeve_back"], back_sleeve, SLEEVE_BACK_DISTANCE));
    Pattern { panels, seams: seams() }
}

fn seams() -> Vec<[Side; 2]> {
    vec![
        [side("front", "left_shoulder"), side("back", "left_shoulder")],
        [side("front", "right_shoulder"), side("back", "right_shoulder")],
        [side("front", "left_side"), side("back", "left_side")],
        [side("front", "right_side"), side("back", "right_side")],
        [side("front", "left_armhole"), side("left_sleeve_front", "left_cap")],
        [side("back", "left_armhole"), side("left_sleeve_back", "left_cap")],
        [side("front", "right_armhole"), side("right_sleeve_front", "right_cap")],
        [side("back", "right_armhole"), side("right_sleeve_back", "right_cap")],
        [side("left_sleeve_front", "left_top"), side("left_sleeve_back", "left_top")],
        [side("right_sleeve_front", "right_top"), side("right_sleeve_back", "right_top")],
        [side("left_sleeve_front", "left_underarm"), side("left_sleeve_back", "left_underarm")],
        [side("right_sleeve_front", "right_underarm"), side("right_sleeve_back", "right_underarm")],
    ]
}

impl Half {
    fn outline(&self, measures: &Measures, underarm_height: f64) -> Outline {
        let hem_y = measures.hip_height + HEM_ABOVE_HIP - underarm_height;
        let flare = (measures.hip_girth + HEM_EASE - measures.bust_girth - BUST_EASE) / 4.0;
        let (sin, cos) = self.slope.to_radians().sin_cos();

        let hem = Point::new(self.half_width + flare, hem_y);
        let underarm = Point::new(self.half_width, 0.0);
        let neck = Point::new(NECK_HALF_WIDTH, self.neck_height);
        // both halves have the same shoulder length, so that of the steeper one ends a little nearer to the middle
        let shoulder_length = (measures.half_shoulder_width + SHOULDER_EXTENSION - NECK_HALF_WIDTH)
            / (0.5 * (FRONT_SLOPE + BACK_SLOPE)).to_radians().cos();
        let shoulder = neck + Point::new(cos, -sin) * shoulder_length;
        let middle = Point::new(0.0, neck.y - self.neck_drop);

        let [low_handle, high_handle] = self.armhole_handles;
        let armhole = [underarm - Point::new(low_handle, 0.0), shoulder - Point::new(sin, cos) * high_handle];
        let collar = [
            neck - Point::new(0.0, self.neck_handle * self.neck_drop),
            Point::new(MIDDLE_NECK_HANDLE * NECK_HALF_WIDTH, middle.y),
        ];
        Path::from(hem)
            .line("left_side", underarm)
            .cubic("left_armhole", armhole, shoulder)
            .line("left_shoulder", neck)
            .cubic("left_collar", collar, middle)
            .with_mirror_image(("hem", Stroke::Straight), None)
    }
}

/// Front and back half of the left sleeve, both drawn counter-clockwise, the arm pointing to +x, the hem's top at the
/// origin. The cap is as high as the wanted width allows; then each half takes the width its own armhole needs.
fn sleeves(measures: &Measures, front: &Outline, back: &Outline) -> [Outline; 2] {
    let lengths = [front, back].map(|outline| outline.length_of("left_armhole") * (1.0 + CAP_EASE));
    let half_width = 0.5 * (measures.upper_arm_girth + SLEEVE_EASE);
    let mean_length = 0.5 * (lengths[0] + lengths[1]);
    let cap_height = solve_increasing([1.0, 20.0], mean_length, |height| cap_length(height, half_width));
    lengths.map(|length| {
        let width = solve_increasing([5.0, 40.0], length, |width| cap_length(cap_height, width));
        sleeve_half(cap_height, width)
    })
}

fn cap_length(height: f64, width: f64) -> f64 {
    sleeve_half(height, width).length_of("left_cap")
}

fn sleeve_half(cap_height: f64, width: f64) -> Outline {
    /// Handles of the cap's S-curve, as parts of the width: fuller over the joint than it is hollow at the armpit.
    const TOP_HANDLE: f64 = 0.52;
    const UNDERARM_HANDLE: f64 = 0.42;
    let top = Point::new(-SLEEVE_LENGTH, 0.0);
    let underarm = Point::new(cap_height - SLEEVE_LENGTH, -width);
    let cap = [top - Point::new(0.0, TOP_HANDLE * width), underarm + Point::new(0.0, UNDERARM_HANDLE * width)];
    Path::from(Point::zeros())
        .line("left_top", top)
        .cubic("left_cap", cap, underarm)
        .line("left_underarm", Point::new(0.0, SLEEVE_TAPER - width))
        .closed("left_hem")
}

/// A sleeve half beside each arm, its middle line on the arm's axis.
fn sleeve_pair(measures: &Measures, names: [&'static str; 2], left: Outline, z: f64) -> [Panel; 2] {
    let (sin, cos) = measures.arm_angle.to_radians().sin_cos();
    let (along, above) = (Point::new(cos, -sin), Point::new(sin, cos));
    let shoulder = Point::new(measures.half_shoulder_width, measures.shoulder_height);
    let hem = (shoulder - measures.upper_arm).dot(&along) + SLEEVE_GAP + SLEEVE_LENGTH;
    let rise = 0.25 * (measures.upper_arm_girth + SLEEVE_EASE);
    let at = measures.upper_arm + along * hem + above * rise;
    let right = left.mirrored();
    [
        Panel { name: names[0], part: "arm", outline: left, translation: [at.x, at.y, z], turn: -measures.arm_angle },
        Panel { name: names[1], part: "arm", outline: right, translation: [-at.x, at.y, z], turn: measures.arm_angle },
    ]
}
