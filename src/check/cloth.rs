//! The fabric: whether the pattern asks for another, and whether it is too thick for what is asked.

use super::{Finding, Given, listed};
use crate::Code;
use std::collections::BTreeMap;

pub fn findings(given: &Given) -> Vec<Finding> {
    let fabric = given.fabric;
    let mut wanted: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for panel in &given.pattern.panels {
        if let Some(name) = panel.fabric.as_deref().filter(|name| *name != fabric.name) {
            wanted.entry(name).or_default().push(&panel.name);
        }
    }
    let other = |(name, panels): (&str, Vec<&str>)| {
        let panel = panels[0].to_owned();
        Finding::new(
            Code::OtherFabric,
            format!("\"{name}\" is asked for by {}; all is fitted with {}.", listed(panels.into_iter()), fabric.name),
            "A garment is fitted with one fabric: give with --fabric the one that most of it is cut from.",
        )
        .within(format!("panel \"{panel}\""))
    };
    let mut findings: Vec<Finding> = wanted.into_iter().map(other).collect();
    if 0.5 * fabric.thickness > given.clearance {
        findings.push(
            Finding::new(
                Code::ThickerThanClearance,
                format!(
                    "Half of the fabric's thickness, {:.2} mm, is more than the clearance of {:.2} mm: its inner face would lie in the body.",
                    500.0 * fabric.thickness,
                    1e3 * given.clearance
                ),
                format!("Ask for a clearance of at least {:.2} mm, or take a thinner fabric.", 500.0 * fabric.thickness),
            )
            .within(format!("fabric \"{}\"", fabric.name))
            .measured("thickness_m", fabric.thickness)
            .measured("clearance_m", given.clearance),
        );
    }
    let finest = given.resolutions.last().copied().unwrap_or(f64::INFINITY);
    if fabric.thickness > finest {
        findings.push(
            Finding::new(
                Code::ThickerThanClearance,
                format!(
                    "It is {:.2} mm thick, more than the finest resolution of {:.2} mm: folds of such cloth are rounder than that.",
                    1e3 * fabric.thickness,
                    1e3 * finest
                ),
                "Ask for a coarser resolution; neighbouring particles would push each other apart.",
            )
            .within(format!("fabric \"{}\"", fabric.name))
            .measured("thickness_m", fabric.thickness)
            .measured("resolution_m", finest),
        );
    }
    findings
}
