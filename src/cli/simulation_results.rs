//! The folder of a simulation: motions, report, pictures.

use super::arguments::{Simulate, Waist};
use super::collide;
use super::results::prepare;
use super::simulate::{Fitted, Shot};
use crate::Error;
use crate::body::Motion;
use crate::dynamics::Settings;
use crate::garment::Level;
use crate::geometry::Vector3;
use crate::io::motion_cache::{MotionHeader, MotionWriter, Precision};
use crate::io::picture::{BodyView, Film, GarmentView};
use crate::io::report::{Host, to_json};
use crate::io::simulation_report::{FrameRecord, Run, SCHEMA, Settled, SimulationReport, Totals};
use crate::io::{atomic, process, read};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// The most pictures that are taken unless more are asked for.
const MOST_PICTURES: usize = 36;

/// What a simulation is made from.
pub struct Inputs<'a> {
    pub fitted: &'a [Fitted],
    pub motion: &'a Motion,
    pub settings: &'a Settings,
    pub shot: &'a Shot<'a>,
    pub asked: &'a Simulate,
}

impl Inputs<'_> {
    /// Names and SHA-256 of all files, as far as each is one.
    fn files(&self) -> Result<Vec<[String; 2]>, Error> {
        let states = self.fitted.iter().map(|f| [f.state.pattern_name.clone(), read::hexadecimal(&f.sha256)]);
        let asked = [Some(&self.asked.body), self.asked.motion.as_ref(), self.asked.from.as_ref()];
        let named = asked.into_iter().flatten().filter(|path| path.is_file());
        let others = named.map(|path| {
            let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            Ok([name, read::sha256_hex(&read::bytes(path)?)])
        });
        let others: Vec<_> = others.collect::<Result<_, Error>>()?;
        Ok(states.chain(others).collect())
    }

    /// A digest of all that decides the result but the number of frames: garments, the body's way, settings.
    pub fn digest(&self) -> Result<String, Error> {
        let mut text = json!({
            "toile": env!("CARGO_PKG_VERSION"),
            "files": self.files()?,
            "settings": self.settings_told(),
            "frame_rate": self.motion.frame_rate(),
            "transition": self.shot.transition_frames,
            "clip": self.asked.clip,
        })
        .to_string()
        .into_bytes();
        // A folder of frames is no file: the poses themselves tell.
        for frame in [0, self.motion.frame_count() / 2, self.motion.frame_count() - 1] {
            text.extend(
                self.motion
                    .positions(frame)
                    .iter()
                    .flat_map(|p| p.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>()),
            );
        }
        Ok(read::sha256_hex(&text))
    }

    fn settings_told(&self) -> serde_json::Value {
        let s = self.settings;
        json!({
            "integrator": s.integrator.name(),
            "broad_phase": s.broad_phase.name(),
            "clearance_mm": s.clearance * 1e3,
            "drag": s.drag,
            "damping": s.damping,
            "wind": [s.wind.x, s.wind.y, s.wind.z],
            "restitution": s.restitution,
            "stretch_limit": s.stretch_limit,
            "added_mass": s.added_mass,
            "tolerance": s.tolerance,
            "implicit_step": s.implicit_step,
            "settle_s": s.settle,
            "self_collision": s.self_collision,
            "collide": collide::told(self.fitted, &s.collisions),
            "waist": if self.asked.waist == Waist::Held { "held" } else { "free" },
            "waist_particles": self.fitted.iter().map(|f| f.state.waist.len()).collect::<Vec<_>>(),
            "floor_m": s.floor,
        })
    }
}

/// What is written while a simulation runs, and at its end.
pub struct Results {
    out: PathBuf,
    writers: Vec<MotionWriter>,
    particles: Vec<usize>,
    film: Film,
    draw_every: usize,
    triangles: Vec<[u32; 3]>,
    panels: Vec<u32>,
    seams: Vec<[u32; 2]>,
    body_triangles: Vec<[u32; 3]>,
}

impl Results {
    /// Makes the folder. Motions begin at `first`, m, of all garments; those that are gone on with keep the frames that
    /// were done.
    pub fn open(inputs: &Inputs, level: &Level, mut first: &[Vector3], done: &[FrameRecord]) -> Result<Self, Error> {
        let (out, fitted) = (&inputs.asked.out, inputs.fitted);
        prepare(out)?;
        let folders = folders(inputs);
        folders.iter().try_for_each(|folder| prepare(folder))?;
        let mut writers = Vec::new();
        for (fitted, folder) in fitted.iter().zip(&folders) {
            let (own, others) = first.split_at(fitted.level().particle_count);
            first = others;
            let header = MotionHeader {
                precision: Precision::Double,
                particle_count: fitted.level().particle_count,
                frame_rate: inputs.motion.frame_rate(),
                state_sha256: fitted.sha256,
            };
            let file = folder.join("motion.toile");
            if inputs.asked.resume {
                let writer = MotionWriter::resume(&file, &header)?;
                if writer.frame_count() <= done.len() {
                    let problem = format!(
                        "It has {} frames, the checkpoint is after frame {}.",
                        writer.frame_count(),
                        done.len()
                    );
                    return Err(Error::new(problem, "Start anew: leave out --resume.").within(file.display()));
                }
                writers.push(writer);
            } else {
                let mut writer = MotionWriter::create(&file, header)?;
                writer.append(own)?;
                writers.push(writer);
            }
        }
        let pictures = inputs.shot.frames().div_ceil(MOST_PICTURES - 1).max(1);
        Ok(Self {
            out: out.clone(),
            writers,
            particles: fitted.iter().map(|f| f.level().particle_count).collect(),
            film: Film::default(),
            draw_every: inputs.asked.draw_every.unwrap_or(pictures),
            triangles: level.particle_triangles(),
            panels: level.panel_of_triangle(),
            seams: level.seam_edges(),
            body_triangles: inputs.motion.triangles().to_vec(),
        })
    }

    /// Adds a frame to the motions, unless a run that was killed after it wrote it and before its checkpoint has.
    pub fn append(&mut self, frame: usize, mut positions: &[Vector3]) -> Result<(), Error> {
        for (writer, &count) in self.writers.iter_mut().zip(&self.particles) {
            let (own, others) = positions.split_at(count);
            if writer.frame_count() <= frame {
                writer.append(own)?;
            }
            positions = others;
        }
        Ok(())
    }

    /// Takes a picture, if this frame has one.
    pub fn shoot(&mut self, frame: usize, positions: &[Vector3], body: &[Vector3]) {
        if self.draw_every == 0 || !frame.is_multiple_of(self.draw_every) {
            return;
        }
        let garment = GarmentView {
            positions: bytemuck::cast_slice(positions),
            triangles: &self.triangles,
            panels: &self.panels,
            seams: &self.seams,
            colors: &[],
        };
        let body = BodyView { positions: bytemuck::cast_slice(body), triangles: &self.body_triangles };
        self.film.shoot(&garment, &body);
    }

    /// Writes pictures and report; returns what to tell.
    pub fn finish(
        self,
        inputs: &Inputs,
        (settled, frames): (&Settled, &[FrameRecord]),
        (step_seconds, added_mass_share): (f64, f64),
        warnings: &[String],
        simulated: [Option<f64>; 2],
        started: Instant,
    ) -> Result<String, Error> {
        self.writers.into_iter().try_for_each(MotionWriter::finish)?;
        if !self.film.is_empty() {
            atomic::write(&self.out.join("frames.png"), &self.film.contact_sheet())?;
            let rate = inputs.motion.frame_rate() / self.draw_every.max(1) as f64;
            atomic::write(&self.out.join("preview.png"), &self.film.animation(rate))?;
        }
        let host = Host {
            wall_seconds: started.elapsed().as_secs_f64(),
            cpu_seconds: process::cpu_seconds(),
            peak_memory_bytes: process::peak_memory_bytes(),
            threads: rayon::current_num_threads(),
            cpu: process::cpu_name(),
            system: process::system_name(),
        };
        let totals = Totals::of(frames);
        let run = Run::new(host, simulated, frames.len());
        let summary = summary(&totals, &run, settled, frames, &self.out);
        let report = SimulationReport {
            schema: SCHEMA,
            toile: env!("CARGO_PKG_VERSION"),
            inputs: inputs.files()?,
            settings: inputs.settings_told(),
            frame_rate: inputs.motion.frame_rate(),
            transition_frames: inputs.shot.transition_frames,
            step_seconds,
            added_mass_share,
            settled,
            totals,
            frames,
            warnings,
            run,
        };
        atomic::write(&self.out.join("simulation.json"), to_json(&report).as_bytes())?;
        Ok(summary)
    }
}

/// The folder of each garment's motion: that of all results for one alone.
fn folders(inputs: &Inputs) -> Vec<PathBuf> {
    let out = &inputs.asked.out;
    let [_, _, ..] = inputs.fitted else { return vec![out.clone()] };
    let mut names: Vec<String> = Vec::new();
    for fitted in inputs.fitted {
        let name = &fitted.pattern.name;
        let numbered = |n: usize| if n == 1 { name.clone() } else { format!("{name}-{n}") };
        let free = (1..).map(numbered).find(|name| !names.contains(name));
        names.push(free.expect("there are more numbers than garments"));
    }
    names.iter().map(|name| out.join(name)).collect()
}

fn summary(totals: &Totals, run: &Run, settled: &Settled, frames: &[FrameRecord], out: &std::path::Path) -> String {
    let seconds = frames.last().map_or(0.0, |last| last.time);
    let mut lines = vec![format!(
        "{} frames, {seconds:.2} s, in {} steps; stretch at most {:.1} %, speed at most {:.2} m/s",
        totals.frames,
        totals.steps,
        totals.largest_stretch * 100.0,
        totals.largest_speed,
    )];
    if settled.steps > 0 {
        lines.push(format!(
            "  settled before in {:.2} s, {} steps, at {:.2} m/s at most",
            settled.time, settled.steps, settled.largest_speed
        ));
    }
    if let (Some(deepest), Some(body), Some(cloth)) =
        (totals.deepest_mm, totals.most_body_intersections, totals.most_cloth_intersections)
    {
        lines.push(format!(
            "  in any frame at most: {deepest:.2} mm inside the body, crossings {body} with the body, {cloth} of the cloth"
        ));
    }
    let cpu = run.cpu_seconds_per_frame.map_or_else(String::new, |s| format!(", {s:.2} s of processor time"));
    lines.push(format!("  {:.2} s a frame{cpu}; results in {}", run.wall_seconds_per_frame, out.display()));
    lines.join("\n")
}
