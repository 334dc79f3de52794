//! Seams proposed.
use crate::pattern::sewing::SeamPlan;
/// A seam that is proposed.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    pub plan: SeamPlan,
    /// From 0 to 1.
    pub confidence: f64,
    /// Why, in a few words.
    pub reason: String,
}
