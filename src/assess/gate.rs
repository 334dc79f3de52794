//! Is a garment ready for a simulator? The limits of the hand-off, each with its measure.
//!
//! What needs the simulator itself, that released cloth stays slow, is not judged here.

use super::Assessment;
use serde::Serialize;

/// One condition: the measure is at most the limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Of the measure, with its unit if it has one.
    pub name: &'static str,
    pub limit: f64,
    pub measured: f64,
    /// False too where the measure is not a number.
    pub passed: bool,
}

/// Points to be sewn together may be this far apart, m: a millimetre does not show and a simulator
/// closes it without a jerk.
pub const LARGEST_SEAM_GAP: f64 = 1e-3;
/// The share of strain that 99 % of the cloth may not exceed, gathers aside.
pub const LARGEST_STRAIN_P99: f64 = 0.05;
/// The mean strain, gathers aside.
pub const LARGEST_STRAIN_MEAN: f64 = 0.01;

/// The conditions of the hand-off. The garment is ready when all have passed.
pub fn hand_off(assessment: &Assessment) -> Vec<Check> {
    let Assessment { strain: _, strain_less_gathers: strain, seams, clearance, intersections } = assessment;
    let check = |name, measured: f64, limit: f64| Check { name, limit, measured, passed: measured <= limit };
    vec![
        check("seam_gap_m", seams.largest, LARGEST_SEAM_GAP),
        check("body_intersections", intersections.body_pairs as f64, 0.0),
        check("cloth_intersections", intersections.cloth_pairs as f64, 0.0),
        check("particles_inside", clearance.inside as f64, 0.0),
        check("triangles_too_near", clearance.triangles_too_near as f64, 0.0),
        check("strain_p99", strain.p99, LARGEST_STRAIN_P99),
        check("strain_mean", strain.mean, LARGEST_STRAIN_MEAN),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::{Clearance, Intersections, SeamGaps, Strain};

    fn good() -> Assessment {
        Assessment {
            strain: Strain { p99: 0.3, ..Strain::default() },
            strain_less_gathers: Strain { mean: 0.01, p99: 0.05, ..Strain::default() },
            seams: SeamGaps { pairs: 10, largest: 1e-3, mean: 1e-4 },
            clearance: Clearance { least: 0.001, inside: 0, too_near: 0, least_of_cloth: 0.001, triangles_too_near: 0 },
            intersections: Intersections::default(),
        }
    }

    fn failed(change: impl FnOnce(&mut Assessment)) -> Vec<&'static str> {
        let mut assessment = good();
        change(&mut assessment);
        hand_off(&assessment).into_iter().filter(|c| !c.passed).map(|c| c.name).collect()
    }

    #[test]
    fn the_limits_themselves_pass() {
        assert!(failed(|_| ()).is_empty());
    }

    #[test]
    fn each_fault_fails_its_own_check() {
        assert_eq!(failed(|a| a.seams.largest = 1.1e-3), ["seam_gap_m"]);
        assert_eq!(failed(|a| a.intersections.body_pairs = 1), ["body_intersections"]);
        assert_eq!(failed(|a| a.intersections.cloth_pairs = 1), ["cloth_intersections"]);
        assert_eq!(failed(|a| a.clearance.inside = 1), ["particles_inside"]);
        assert_eq!(failed(|a| a.clearance.triangles_too_near = 1), ["triangles_too_near"]);
        assert_eq!(failed(|a| a.strain_less_gathers.p99 = 0.051), ["strain_p99"]);
        assert_eq!(failed(|a| a.strain_less_gathers.mean = f64::NAN), ["strain_mean"]);
    }
}
