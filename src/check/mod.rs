//! Everything that is wrong or doubtful with an input, in one pass and before any solving.
//!
//! [`examine`] looks at a pattern that was read, at its seams, at where its panels start, at the fabric and at the body. What
//! the readers of files found comes as `Error` and `Warning` and becomes a [`Finding`] as well. Each family of checks has a
//! file; each finding a [`Code`], and `docs/checks` has a page for each code.
//!
//! What cannot be judged is not found fault with: without landmarks nothing is said about girths, without a placement nothing
//! about places.

mod assembly;
mod cloth;
mod edges;
mod hanging;
mod holding;
mod limbs;
mod mirror;
mod partners;
mod rings;
mod start;
mod tight;

use crate::body::{Body, DistanceField, Landmarks};
use crate::garment::Garment;
use crate::geometry::Vector3;
use crate::pattern::sewing::Measured;
use crate::pattern::{Fabric, Pattern};
use crate::{Code, Error, Severity, Warning};
use std::fmt;

/// What is looked at. The pattern has passed [`Pattern::check`].
#[derive(Clone, Copy)]
pub struct Given<'a> {
    pub pattern: &'a Pattern,
    /// Of all levels, coarsest first, m.
    pub resolutions: &'a [f64],
    /// Discretized; its coarsest level is looked at. Without it nothing is said about the sewn garment.
    pub garment: Option<&'a Garment>,
    /// Per seam: is its ease stated, so that it is meant? Empty where none is.
    pub eased: &'a [bool],
    pub fabric: &'a Fabric,
    /// Of cloth and body, m.
    pub clearance: f64,
    pub body: Option<&'a Body>,
    /// Of the body; without them nothing is said about girths, about what holds the garment, and about limbs.
    pub landmarks: Option<&'a Landmarks>,
    /// Of the body, as for a fit. With it the start of the panels is tried, which takes as long as it does in a fit.
    pub field: Option<&'a DistanceField>,
}

/// One thing that is wrong or doubtful.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    pub code: Code,
    pub severity: Severity,
    /// Where, what, and what to do.
    pub error: Error,
    /// Figures by names that end with their unit, such as `shortfall_m`.
    pub measures: Vec<(&'static str, f64)>,
}

impl Finding {
    fn new(code: Code, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        let error = Error::new(problem, remedy).coded(code);
        Self { code, severity: code.severity(), error, measures: Vec::new() }
    }

    fn within(self, place: impl fmt::Display) -> Self {
        Self { error: self.error.within(place), ..self }
    }

    fn measured(mut self, name: &'static str, value: f64) -> Self {
        self.measures.push((name, value));
        self
    }

    /// An error and all that it carries; `otherwise` is the code of those that have none.
    pub fn of_error(error: Error, otherwise: Code) -> Vec<Self> {
        let finding = |error: Error| Self::of(error, otherwise, Severity::Error);
        error.each().into_iter().map(finding).collect()
    }

    /// What a reader warned about; `otherwise` is the code of what has none.
    pub fn of_warning(warning: &Warning, otherwise: Code) -> Self {
        Self::of(warning.0.clone(), otherwise, Severity::Warning)
    }

    /// That girths are not judged, and why.
    pub fn without_landmarks(error: &Error, body: &str) -> Self {
        let problem = format!("Landmarks were not found, so that girths were not compared: {}", error.problem());
        Self::new(Code::LandmarksUnknown, problem, error.remedy()).within(format!("body \"{body}\""))
    }

    /// The same with its file, unless it names it already.
    pub fn with_file(self, file: &str) -> Self {
        match self.error.places().first() {
            Some(first) if first == file => self,
            _ => self.within(file),
        }
    }

    fn of(error: Error, otherwise: Code, severity: Severity) -> Self {
        let error = error.coded(otherwise);
        Self { code: error.code().unwrap_or(otherwise), severity, error, measures: Vec::new() }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}[{}]: {}", self.severity.name(), self.code, self.error)
    }
}

/// All that can be found without solving, in order.
pub fn examine(given: &Given) -> Vec<Finding> {
    let measured = Measured::new(given.pattern);
    let mut findings = Vec::new();
    findings.extend(edges::unit(given.pattern));
    findings.extend(edges::short(given, &measured));
    findings.extend(edges::unequal(given, &measured));
    findings.extend(assembly::findings(given.pattern));
    findings.extend(mirror::unsewn(given.pattern, &measured));
    findings.extend(cloth::findings(given));
    findings.extend(start::findings(given));
    if given.pattern.is_placed() {
        findings.extend(partners::twisted(given.pattern, &measured));
        findings.extend(partners::exchanged(given.pattern, &measured));
        findings.extend(around_the_body(given));
    }
    in_order(&mut findings);
    findings
}

/// Errors first, then by code; those of one code as they were found.
pub fn in_order(findings: &mut [Finding]) {
    findings.sort_by_key(|finding| (finding.severity, finding.code));
}

/// What the garment as it will be sewn is to the body, and the body to the garment.
fn around_the_body(given: &Given) -> Vec<Finding> {
    let (Some(garment), Some(body), Some(marks)) = (given.garment, given.body, given.landmarks) else {
        return Vec::new();
    };
    let sewn = Sewn::new(given.pattern, garment, marks);
    let mut findings = tight::findings(given, &sewn, marks);
    findings.extend(holding::nothing(given.pattern, &sewn, marks));
    findings.extend(limbs::near(given, &sewn, body, marks));
    findings
}

/// The coarsest level with its seams closed: the panels where they were placed, but for gaps between those above and those
/// below, which seams close; partners meet half-way.
struct Sewn<'a> {
    garment: &'a Garment,
    /// Of the first level, one per particle, m, world.
    positions: Vec<Vector3>,
    /// Of each triangle.
    panel_of: Vec<u32>,
}

impl<'a> Sewn<'a> {
    fn new(pattern: &Pattern, garment: &'a Garment, marks: &Landmarks) -> Self {
        let mut placed = crate::arrangement::placed(pattern, &garment.open);
        for (range, rise) in garment.open.panels.iter().zip(hanging::rises(pattern, garment, &placed, marks)) {
            placed[range.points.clone()].iter_mut().for_each(|point| point.y += rise);
        }
        let positions = garment.weld(&placed);
        Self { garment, positions, panel_of: garment.levels[0].panel_of_triangle() }
    }
}

/// Names as a message lists them, at most four.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 4;
    let names: Vec<String> = names.map(|name| format!("\"{name}\"")).collect();
    match names.len() {
        count if count > MOST => format!("{} and {} more", names[..MOST].join(", "), count - MOST),
        _ => names.join(", "),
    }
}

#[cfg(test)]
mod tests;
