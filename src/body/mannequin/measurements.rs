//! What the tape measure says: the numbers a mannequin is made from.

use crate::Error;
use std::ops::RangeInclusive;

/// What a length may be, as a part of its default: beyond these it is a slip, or in another unit.
const FACTORS: RangeInclusive<f64> = 0.5..=2.0;
/// Between these the arms join the torso as drawn, degrees.
const ARM_ANGLES: RangeInclusive<f64> = 15.0..=75.0;
/// Beyond these the crotch would fold or tear, degrees.
const LEG_SPREADS: RangeInclusive<f64> = 0.0..=40.0;

/// Body dimensions of the figure to build. Metres unless the name says otherwise.
///
/// The default is a woman of 1.72 m, between sizes 38 and 40; `data/README.md` tells which values have a source and which
/// are our own round figures. They describe nobody in particular.
///
/// Girths are those of a taut tape: the convex hull of the section. Torso, neck and head are measured level; thigh,
/// knee, calf and ankle square to the axis of the leg; upper arm, forearm and wrist square to the axis of the arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurements {
    /// Floor to crown.
    pub height: f64,
    /// Floor to the underside of the chin.
    pub chin_height: f64,
    /// Floor to the middle of the neck, where its girth is taken.
    pub neck_height: f64,
    /// Floor to the base of the neck at the side, where a shoulder seam begins.
    pub neck_base_height: f64,
    /// Floor to the shoulder point, where a shoulder seam ends.
    pub shoulder_height: f64,
    /// Floor to the tips of the bust.
    pub bust_height: f64,
    /// Floor to the crease below the bust.
    pub underbust_height: f64,
    /// Floor to the waist, the narrowest part of the torso.
    pub waist_height: f64,
    /// Floor to the widest part of the seat.
    pub hip_height: f64,
    /// Floor to the crotch.
    pub crotch_height: f64,
    /// Floor to the middle of the kneecap.
    pub knee_height: f64,
    /// Floor to the fullest part of the calf.
    pub calf_height: f64,
    /// Floor to the narrowest part above the ankle.
    pub ankle_height: f64,

    /// Around the head above the brow.
    pub head_girth: f64,
    /// Around the middle of the neck.
    pub neck_girth: f64,
    /// Around the bust, over its tips.
    pub bust_girth: f64,
    /// Around the ribs, below the bust.
    pub underbust_girth: f64,
    /// Around the waist.
    pub waist_girth: f64,
    /// Around the hips at their widest.
    pub hip_girth: f64,
    /// Around the thigh, a hand's breadth below the crotch.
    pub thigh_girth: f64,
    /// Around the knee.
    pub knee_girth: f64,
    /// Around the calf at its fullest.
    pub calf_girth: f64,
    /// Around the leg above the ankle.
    pub ankle_girth: f64,
    /// Around the upper arm, halfway to the elbow.
    pub upper_arm_girth: f64,
    /// Around the forearm at its fullest.
    pub forearm_girth: f64,
    /// Around the wrist.
    pub wrist_girth: f64,

    /// From shoulder point to shoulder point, straight.
    pub shoulder_width: f64,
    /// From the shoulder point to the wrist.
    pub arm_length: f64,
    /// From the wrist to the tip of the fingers.
    pub hand_length: f64,
    /// From heel to toe.
    pub foot_length: f64,

    /// How far the arms hang below the horizontal, degrees. 45 is the usual A-pose.
    pub arm_angle_degrees: f64,
    /// Angle between the two legs, degrees. Below about 6 the thighs would touch.
    pub leg_spread_degrees: f64,
}

impl Measurements {
    /// The figure the tables of this module were drawn for.
    pub const DEFAULT: Self = Self {
        height: 1.72,
        chin_height: 1.50,
        neck_height: 1.478,
        neck_base_height: 1.445,
        shoulder_height: 1.41,
        bust_height: 1.24,
        underbust_height: 1.165,
        waist_height: 1.08,
        hip_height: 0.88,
        crotch_height: 0.80,
        knee_height: 0.475,
        calf_height: 0.345,
        ankle_height: 0.115,
        head_girth: 0.56,
        neck_girth: 0.335,
        bust_girth: 0.92,
        underbust_girth: 0.78,
        waist_girth: 0.74,
        hip_girth: 0.98,
        thigh_girth: 0.56,
        knee_girth: 0.37,
        calf_girth: 0.36,
        ankle_girth: 0.22,
        upper_arm_girth: 0.275,
        forearm_girth: 0.245,
        wrist_girth: 0.158,
        shoulder_width: 0.38,
        arm_length: 0.58,
        hand_length: 0.18,
        foot_length: 0.25,
        arm_angle_degrees: 45.0,
        leg_spread_degrees: 7.0,
    };

    /// Finds what no figure can have: lengths far from any grown-up's, heights out of order, limbs at impossible angles.
    pub fn check(&self) -> Result<(), Error> {
        let (heights, lengths) = (self.heights(), self.lengths());
        let (default_heights, default_lengths) = (Self::DEFAULT.heights(), Self::DEFAULT.lengths());
        let defaults = default_heights.iter().chain(&default_lengths);
        for ((name, length), (_, default)) in heights.iter().chain(&lengths).zip(defaults) {
            if !FACTORS.contains(&(length / default)) {
                let (least, most) = (FACTORS.start() * default, FACTORS.end() * default);
                return Err(Error::new(
                    format!("`{name}` is {length} m."),
                    format!("Give a length from {least} to {most} m."),
                ));
            }
        }
        for pair in heights.windows(2) {
            let ((lower_name, lower), (upper_name, upper)) = (pair[0], pair[1]);
            if lower >= upper {
                return Err(Error::new(
                    format!("`{upper_name}`, {upper} m, does not lie above `{lower_name}`, {lower} m."),
                    "Heights are measured from the floor, in metres.",
                ));
            }
        }
        let angles = [
            ("arm_angle_degrees", self.arm_angle_degrees, ARM_ANGLES),
            ("leg_spread_degrees", self.leg_spread_degrees, LEG_SPREADS),
        ];
        for (name, angle, allowed) in angles {
            if !allowed.contains(&angle) {
                return Err(Error::new(
                    format!("`{name}` is {angle}."),
                    format!("Give an angle from {} to {} degrees.", allowed.start(), allowed.end()),
                ));
            }
        }
        Ok(())
    }

    /// Names and values of all heights, which must ascend, m.
    pub(super) fn heights(&self) -> [(&'static str, f64); 13] {
        [
            ("ankle_height", self.ankle_height),
            ("calf_height", self.calf_height),
            ("knee_height", self.knee_height),
            ("crotch_height", self.crotch_height),
            ("hip_height", self.hip_height),
            ("waist_height", self.waist_height),
            ("underbust_height", self.underbust_height),
            ("bust_height", self.bust_height),
            ("shoulder_height", self.shoulder_height),
            ("neck_base_height", self.neck_base_height),
            ("neck_height", self.neck_height),
            ("chin_height", self.chin_height),
            ("height", self.height),
        ]
    }

    /// Names and values of all girths and of the lengths that are no heights, m.
    fn lengths(&self) -> [(&'static str, f64); 17] {
        [
            ("head_girth", self.head_girth),
            ("neck_girth", self.neck_girth),
            ("bust_girth", self.bust_girth),
            ("underbust_girth", self.underbust_girth),
            ("waist_girth", self.waist_girth),
            ("hip_girth", self.hip_girth),
            ("thigh_girth", self.thigh_girth),
            ("knee_girth", self.knee_girth),
            ("calf_girth", self.calf_girth),
            ("ankle_girth", self.ankle_girth),
            ("upper_arm_girth", self.upper_arm_girth),
            ("forearm_girth", self.forearm_girth),
            ("wrist_girth", self.wrist_girth),
            ("shoulder_width", self.shoulder_width),
            ("arm_length", self.arm_length),
            ("hand_length", self.hand_length),
            ("foot_length", self.foot_length),
        ]
    }
}

impl Default for Measurements {
    fn default() -> Self {
        Self::DEFAULT
    }
}
