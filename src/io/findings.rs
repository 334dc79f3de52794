//! Findings as JSON: in the document of `toile check --json` and in `report.json`. `docs/formats.md` tells the form.

use crate::check::Finding;
use crate::pattern::sewing::SeamEase;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// One finding, field by field as in the files.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FindingPart {
    /// `TOILE-P012`.
    pub code: &'static str,
    pub severity: &'static str,
    /// What the code is about.
    pub title: &'static str,
    pub place: PlacePart,
    pub message: String,
    pub remedy: String,
    /// Figures by names that end with their unit.
    pub measures: BTreeMap<&'static str, f64>,
    /// The page that explains the code, within the project.
    pub page: String,
}

/// Where it is: what is not known is left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlacePart {
    /// As in messages.
    pub text: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub panel: Option<String>,
    /// Counted from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<u64>,
    /// Its name, or its number counted from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seam: Option<String>,
    /// Anything else: a part of the body, a fabric.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
}

impl PlacePart {
    /// From the places of an error, outermost first; `files` are those that were read.
    fn of(places: &[String], files: &[String]) -> Self {
        let mut part = Self { text: places.join(", "), ..Self::default() };
        for place in places {
            let (word, rest) = place.split_once(' ').unwrap_or((place, ""));
            let named = rest.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(rest).to_owned();
            match (word, rest.parse().ok()) {
                _ if files.contains(place) => part.file = Some(place.clone()),
                ("line", Some(number)) => part.line = Some(number),
                ("edge", Some(number)) => part.edge = Some(number),
                ("panel", _) => part.panel = Some(named),
                ("seam" | "stitch", _) => part.seam = Some(named),
                _ => part.part = Some(place.clone()),
            }
        }
        part
    }
}

/// A finding for a file; `files` are those that were read, as messages name them.
pub fn finding_part(finding: &Finding, files: &[String]) -> FindingPart {
    FindingPart {
        code: finding.code.id(),
        severity: finding.severity.name(),
        title: finding.code.title(),
        place: PlacePart::of(finding.error.places(), files),
        message: finding.error.problem().to_owned(),
        remedy: finding.error.remedy().to_owned(),
        measures: finding.measures.iter().copied().filter(|(_, value)| value.is_finite()).collect(),
        page: format!("docs/checks/{}.md", finding.code.id()),
    }
}

/// A row of the ease table.
pub fn seam_ease(seam: &SeamEase) -> Value {
    json!({
        "name": seam.name, "lengths_m": seam.lengths, "ease_m": seam.length(), "ease_share": seam.share(),
        "longer": seam.longer().map(|k| ["first", "second"][k]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Code, Error};

    #[test]
    fn places_are_told_apart() {
        let error = Error::new("It is bad.", "Mend it.").within("edge 3").within("panel \"a b\"").within("x y.json");
        let finding = Finding::of_error(error, Code::OutlineOpen).remove(0);
        let part = finding_part(&finding, &["x y.json".to_owned()]);
        let place = &part.place;
        assert_eq!(
            (place.file.as_deref(), place.panel.as_deref(), place.edge),
            (Some("x y.json"), Some("a b"), Some(3))
        );
        assert_eq!(
            (part.code, part.severity, part.page.as_str()),
            ("TOILE-P007", "error", "docs/checks/TOILE-P007.md")
        );
        let error = Error::new("It is bad.", "Mend it.").within("line 7").within("seam \"side\"").within("left arm");
        let place = PlacePart::of(error.places(), &[]);
        assert_eq!(
            (place.line, place.seam.as_deref(), place.part.as_deref()),
            (Some(7), Some("side"), Some("left arm"))
        );
    }
}
