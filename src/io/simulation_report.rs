//! `simulation.json`: what a simulation was like, frame by frame. Anything that varies from run to run sits in `run`.

use super::report::Host;
use serde::{Deserialize, Serialize};

/// Name and version of the format.
pub const SCHEMA: &str = "toile-simulation/1";

/// One frame of a simulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameRecord {
    /// Of the simulation, counted from 1: 0 is where it starts.
    pub frame: usize,
    /// s, at its end.
    pub time: f64,
    pub steps: usize,
    pub evaluations: usize,
    /// m/s, of any particle in any step.
    pub largest_speed: f64,
    /// m/s, of all particles at the end.
    pub rms_speed: f64,
    /// Of any edge, as a share of its length.
    pub largest_stretch: f64,
    /// Where that edge is, at the end.
    #[serde(default)]
    pub most_stretched: Option<Spot>,
    /// Particles between two skins of the body that leave them no room, at the end.
    #[serde(default)]
    pub particles_pinched: usize,
    /// What follows was measured exactly at the end of the frame, if it was asked for.
    pub measured: Option<Measured>,
}

/// A place on a garment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spot {
    pub panel: String,
    /// m, world.
    pub at: [f64; 3],
}

/// How the cloth found its balance before the body moved.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// Simulated, s.
    pub time: f64,
    pub steps: usize,
    /// m/s, of any particle in any step.
    pub largest_speed: f64,
}

/// What exact tests say of the end of a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    pub particles_inside: usize,
    /// Of the deepest particle inside the body, mm.
    pub deepest_mm: f64,
    /// The same without those that are pinched.
    #[serde(default)]
    pub deepest_with_room_mm: f64,
    pub body_intersections: usize,
    pub cloth_intersections: usize,
}

#[derive(Serialize)]
pub struct SimulationReport<'a> {
    pub schema: &'static str,
    pub toile: &'static str,
    /// Names and SHA-256 of the states, the body and its motion.
    pub inputs: Vec<[String; 2]>,
    pub settings: serde_json::Value,
    pub frame_rate: f64,
    /// Frames before the motion begins, in which the body comes from the pose of the fit.
    pub transition_frames: usize,
    pub step_seconds: f64,
    pub added_mass_share: f64,
    pub settled: &'a Settled,
    pub totals: Totals,
    pub frames: &'a [FrameRecord],
    pub warnings: &'a [String],
    pub run: Run,
}

/// Over all frames.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Totals {
    pub frames: usize,
    pub steps: usize,
    pub evaluations: usize,
    pub largest_speed: f64,
    pub largest_stretch: f64,
    pub most_particles_pinched: usize,
    pub deepest_mm: Option<f64>,
    pub deepest_with_room_mm: Option<f64>,
    pub most_body_intersections: Option<usize>,
    pub most_cloth_intersections: Option<usize>,
}

impl Totals {
    pub fn of(frames: &[FrameRecord]) -> Self {
        let measured = || frames.iter().filter_map(|f| f.measured.as_ref());
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        Self {
            frames: frames.len(),
            steps: frames.iter().map(|f| f.steps).sum(),
            evaluations: frames.iter().map(|f| f.evaluations).sum(),
            largest_speed: largest(&mut frames.iter().map(|f| f.largest_speed)),
            largest_stretch: largest(&mut frames.iter().map(|f| f.largest_stretch)),
            most_particles_pinched: frames.iter().map(|f| f.particles_pinched).max().unwrap_or(0),
            deepest_mm: measured().map(|m| m.deepest_mm).reduce(f64::max),
            deepest_with_room_mm: measured().map(|m| m.deepest_with_room_mm).reduce(f64::max),
            most_body_intersections: measured().map(|m| m.body_intersections).max(),
            most_cloth_intersections: measured().map(|m| m.cloth_intersections).max(),
        }
    }
}

#[derive(Serialize)]
pub struct Run {
    pub wall_seconds: f64,
    pub cpu_seconds: Option<f64>,
    /// Of the simulation alone, without reading, pictures and report; s of all threads.
    pub cpu_seconds_per_frame: Option<f64>,
    pub wall_seconds_per_frame: f64,
    pub peak_memory_bytes: Option<u64>,
    pub threads: usize,
    pub cpu: Option<String>,
    pub system: String,
}

impl Run {
    /// `simulated` are wall and CPU seconds of so many frames.
    pub fn new(host: Host, simulated: [Option<f64>; 2], frames: usize) -> Self {
        let per_frame = |seconds: f64| seconds / frames.max(1) as f64;
        Self {
            wall_seconds: host.wall_seconds,
            cpu_seconds: host.cpu_seconds,
            cpu_seconds_per_frame: simulated[1].map(per_frame),
            wall_seconds_per_frame: per_frame(simulated[0].unwrap_or(0.0)),
            peak_memory_bytes: host.peak_memory_bytes,
            threads: host.threads,
            cpu: host.cpu,
            system: host.system,
        }
    }
}
