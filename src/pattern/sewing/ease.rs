//! How much longer one side of a seam is than the other.

use super::SeamPlan;
use crate::pattern::Pattern;
use crate::{Code, Error, Warning};

/// A stated ease: how much longer the longer side is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ease {
    /// m.
    Length(f64),
    /// Of the shorter side: 5 % are 0.05.
    Share(f64),
}

/// The lengths of the sides of one seam.
#[derive(Clone, Debug, PartialEq)]
pub struct SeamEase {
    pub name: String,
    /// m.
    pub lengths: [f64; 2],
}

impl SeamEase {
    /// How much longer the longer side is, m.
    pub fn length(&self) -> f64 {
        (self.lengths[0] - self.lengths[1]).abs()
    }

    /// The same as a share of the shorter side.
    pub fn share(&self) -> f64 {
        self.length() / self.lengths[0].min(self.lengths[1]).max(f64::MIN_POSITIVE)
    }

    /// Which side is longer; none where they are equal to a tenth of a millimetre, which is how exactly cloth is cut.
    pub fn longer(&self) -> Option<usize> {
        const EQUAL: f64 = 1e-4;
        (self.length() > EQUAL).then(|| usize::from(self.lengths[1] > self.lengths[0]))
    }
}

/// The lengths of the sides of every seam, in the order of the plans.
pub fn ease_of(pattern: &Pattern, plans: &[SeamPlan]) -> Vec<SeamEase> {
    plans.iter().map(|plan| SeamEase { name: plan.name.clone(), lengths: plan.lengths(pattern) }).collect()
}

/// Seams whose stated ease is not what the lengths give.
pub(super) fn doubts(pattern: &Pattern, plans: &[SeamPlan]) -> Vec<Warning> {
    /// A stated length is meant to a millimetre, m.
    const LENGTH_SLACK: f64 = 1.5e-3;
    /// A stated share is meant to half a per cent.
    const SHARE_SLACK: f64 = 0.0075;
    let doubt = |(plan, ease): (&SeamPlan, SeamEase)| -> Option<Warning> {
        let (stated, wrong) = match plan.ease? {
            Ease::Length(l) => (format!("{:.1} mm", 1e3 * l), (l - ease.length()).abs() > LENGTH_SLACK),
            Ease::Share(s) => (format!("{:.1} %", 1e2 * s), (s - ease.share()).abs() > SHARE_SLACK),
        };
        let remedy = "Sew the right edges, change the drawing, or state what is meant.";
        wrong.then(|| {
            let error: Error = plan.complain(
                format!(
                    "Its ease is said to be {stated}, but the sides are {:.1} mm and {:.1} mm long: {:.1} mm or {:.1} %.",
                    1e3 * ease.lengths[0], 1e3 * ease.lengths[1], 1e3 * ease.length(), 1e2 * ease.share()
                ),
                remedy,
            );
            Warning(error.coded(Code::EaseNotAsStated))
        })
    };
    plans.iter().zip(ease_of(pattern, plans)).filter_map(doubt).collect()
}
