//! Sewing by dynamics alone, from panels as they are placed: what a fit is compared with.
//!
//! As simulators do it (Vassilev and Spanlang 2001, section 4): without gravity, stitches are springs that draw sewn
//! particles together at one pace, body and cloth in the way are met as ever. Once all are closed the seams are welded,
//! gravity acts, and the garment comes to rest.

use super::{Settings, Simulation, Surface};
use crate::energy::Model;
use crate::garment::Garment;
use crate::geometry::Vector3;
use crate::pattern::Fabric;

/// Seams that are no farther open than this are closed, m.
const CLOSED: f64 = 2e-3;
/// At which stitches shorten, m/s.
const PACE: f64 = 0.5;
/// N/m, of each stitch.
const STIFFNESS: f64 = 50.0;
/// Stitches are shortened once in so long, s.
const INTERVAL: f64 = 0.01;

/// How the seams closed.
#[derive(Clone, Debug)]
pub struct Sewing {
    pub steps: usize,
    /// Simulated, s.
    pub time: f64,
    pub closed: bool,
    /// m.
    pub largest_gap: f64,
    /// Of the sewn garment, one per particle of its only level, m.
    pub positions: Vec<Vector3>,
}

/// Sews a garment of one level from where the panels are placed, for `most` seconds at most.
pub fn sew(
    garment: &Garment,
    fabric: &Fabric,
    model: Model,
    settings: &Settings,
    surface: &mut Surface,
    placed: Vec<Vector3>,
    most: f64,
) -> Sewing {
    // Seams pull harder than cloth is to be stretched by.
    let settings = Settings { stretch_limit: None, ..settings.clone() };
    let mut simulation = Simulation::new(&garment.open, fabric, fabric, model, &settings, placed);
    // Particles that will be sewn to one are neighbours already.
    simulation.forces.take_for_one(&garment.open, garment.levels[0].particle_of.clone(), fabric);
    simulation.look_afresh();
    let energy = &mut simulation.forces.energy;
    energy.gravity = 0.0;
    energy.stitches.stiffness = STIFFNESS;
    energy.stitches.lengths = energy.stitches.gaps(&simulation.movement.positions);
    let largest = |gaps: &[f64]| gaps.iter().copied().fold(0.0, f64::max);
    let (mut steps, mut time) = (0, 0.0);
    let mut largest_gap = largest(&simulation.forces.energy.stitches.lengths);
    while time < most && largest_gap > CLOSED {
        let stitches = &mut simulation.forces.energy.stitches;
        stitches.lengths.iter_mut().for_each(|length| *length = (*length - PACE * INTERVAL).max(0.0));
        steps += simulation.run(surface, INTERVAL, |_| false).steps;
        time += INTERVAL;
        largest_gap = largest(&simulation.forces.energy.stitches.gaps(&simulation.movement.positions));
    }
    let positions = garment.weld(&simulation.movement.positions);
    Sewing { steps, time, closed: largest_gap <= CLOSED, largest_gap, positions }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::BroadPhase;
    use crate::pattern::shapes;

    #[test]
    fn an_open_tube_closes() {
        let garment = Garment::build(&shapes::tube(0.3, 0.1), &[0.02]).unwrap();
        let rolled = |p: &crate::geometry::Vector2| {
            let (sin, cos) = (p.x / 0.06).sin_cos();
            Vector3::new(0.06 * sin, p.y, 0.06 * cos)
        };
        let placed: Vec<Vector3> = garment.open.rest.iter().map(rolled).collect();
        let mut nobody = Surface::new(&[], &[], BroadPhase::Tree);
        let (fabric, settings) = (Fabric::default(), Settings::default());
        let sewn = sew(&garment, &fabric, Model::default(), &settings, &mut nobody, placed, 2.0);
        assert!(sewn.closed && sewn.steps > 10, "{} m after {} s", sewn.largest_gap, sewn.time);
        assert_eq!(sewn.positions.len(), garment.levels[0].particle_count);
    }
}
