//! `toile simulate`: fitted garments go along with a body that moves.

use super::arguments::{Progress, Simulate, Waist, threads};
use super::collide;
use super::fit::start_threads;
use super::floor::floor;
use super::inputs::tell;
use super::simulation_results::{Inputs, Results};
use super::{Failure, Status};
use crate::body::{Body, Motion};
use crate::dynamics::{
    BroadPhase, Collide, Collisions, Course, Integrator, MOVING_CLEARANCE, Settings, Simulation, Surface,
};
use crate::garment::{Garment, Level};
use crate::geometry::Vector3;
use crate::io::checkpoint::{self, Checkpoint, Description};
use crate::io::moving_body::{self, Options};
use crate::io::simulation_report::{FrameRecord, Measured, Settled, Spot};
use crate::io::state::{self, State};
use crate::io::{atomic, body_obj, process, read};
use crate::pattern::{Cut, Fabric, Pattern};
use crate::{Error, Warning};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use std::io::IsTerminal;
use std::path::Path;
use std::time::Instant;

/// What a body that stands still is given, s.
const STILL: f64 = 2.0;
/// Particles deeper in the first pose of the motion than this were fitted on another one, m.
const ANOTHER_POSE: f64 = 5e-3;
/// Share of the particles that may be so deep all the same.
const FEW: f64 = 1e-3;

/// A fitted garment.
pub struct Fitted {
    pub state: State,
    pub pattern: Pattern,
    pub garment: Garment,
    pub sha256: [u8; 32],
}

impl Fitted {
    fn open(fit: &Path) -> Result<Self, Error> {
        let file = if fit.is_dir() { fit.join("state.toile") } else { fit.to_owned() };
        let bytes = read::bytes(&file)?;
        let within = |e: Error| e.within(file.display());
        let state = state::read(&bytes).map_err(within)?;
        let (pattern, garment) = state.rebuild().map_err(within)?;
        Ok(Self { state, pattern, garment, sha256: read::sha256(&bytes) })
    }

    pub fn level(&self) -> &Level {
        self.garment.levels.last().expect("a garment has at least one level")
    }
}

pub fn run(asked: &Simulate) -> Result<Status, Failure> {
    let started = Instant::now();
    let mut settings = settings(asked)?;
    start_threads(threads(asked.threads)?);
    let fitted: Vec<Fitted> = asked.fits.iter().map(|fit| Fitted::open(fit)).collect::<Result<_, _>>()?;
    settings.clearance = fitted[0].state.settings.clearance.max(MOVING_CLEARANCE);
    settings.stretch_limit = stretch_limit(asked.stretch_limit.as_deref(), &fitted)?;
    settings.collisions = collide::levels(&asked.collide, &fitted)?;
    let (motion, mut warnings) = open_motion(asked)?;
    stands_still(&settings, asked, &motion)?;
    let shot = Shot::of(asked, &motion)?;
    settings.floor = floor(asked.floor.as_deref(), &motion, &shot.at(0))?;
    settings.check().map_err(Failure::Usage)?;
    let level = Level::together(&fitted.iter().map(Fitted::level).collect::<Vec<_>>());
    let positions: Vec<Vector3> = fitted.iter().flat_map(|f| &f.state.positions).copied().collect();
    warnings.extend(in_another_pose(&shot, &positions, &settings, &level, asked)?);
    let inputs = Inputs { fitted: &fitted, motion: &motion, settings: &settings, shot: &shot, asked };
    let silent = asked.progress == Progress::None;
    let mut told = tell(&warnings.iter().collect::<Vec<_>>(), silent);

    // What the cloth is, and where it stands.
    let fabrics: Vec<&Fabric> = fitted.iter().map(|f| &f.state.fabric).collect();
    let by_panel: Vec<&Fabric> =
        fitted.iter().flat_map(|f| std::iter::repeat_n(&f.state.fabric, f.pattern.panels.len())).collect();
    let (touching, model) = (Fabric::touching(&fabrics), fitted[0].state.settings.model);
    let cut = Cut::ByPanel(&by_panel);
    let mut simulation = Simulation::new(&level, cut, &touching, model, &settings, positions);
    if asked.waist == Waist::Held {
        hold_waists(&mut simulation, &shot, &settings, &fitted);
    }
    let digest = inputs.digest()?;
    let (settled, mut frames) = match asked.resume {
        true => go_on(&asked.out, &digest, &mut simulation)?,
        false => (start(&mut simulation, &shot, &settings), Vec::new()),
    };
    let mut results = Results::open(&inputs, &level, &simulation.movement.positions, &frames)?;
    results.shoot(frames.len(), &simulation.movement.positions, &shot.at(frames.len()));

    let mut watcher = Watcher::new(asked.progress, shot.frames(), frames.len());
    let mut surface = Surface::new(&shot.at(frames.len()), motion.triangles(), settings.broad_phase);
    let (mut wall, mut cpu) = (0.0, process::cpu_seconds().map(|_| 0.0));
    while frames.len() < shot.frames() {
        let (before, cpu_before) = (Instant::now(), process::cpu_seconds());
        let frame = frames.len() + 1;
        let end = shot.at(frame);
        surface.move_to(&end, shot.duration);
        let course = simulation.frame(&mut surface, shot.duration);
        let positions = &simulation.movement.positions;
        if !positions.iter().chain(&simulation.movement.velocities).all(|v| v.iter().all(|x| x.is_finite())) {
            return Err(blown_up(frame, &settings).into());
        }
        let measured = (asked.measure_every > 0 && frame.is_multiple_of(asked.measure_every))
            .then(|| measure(&level, &simulation, &end, motion.triangles(), &surface, &settings.collisions));
        let spot = simulation.most_stretched().map(|(ends, _)| spot(&fitted, positions, ends));
        frames.push(FrameRecord { most_stretched: spot, ..record(frame, shot.duration, &course, measured) });
        results.append(frame, positions)?;
        results.shoot(frame, positions, &end);
        let description = Description { of: digest.clone(), settled: settled.clone(), frames: frames.clone() };
        let (movement, remembered) = (simulation.movement.clone(), simulation.remembered());
        let checkpoint = Checkpoint { description, movement, remembered };
        atomic::write(&asked.out.join("checkpoint.toile"), &checkpoint::write(&checkpoint))?;
        wall += before.elapsed().as_secs_f64();
        cpu = cpu.zip(process::cpu_seconds().zip(cpu_before)).map(|(sum, (now, before))| sum + now - before);
        watcher.frame(frames.last().expect("a frame was just added"));
    }
    watcher.finish();
    let not_kept = unmet(&frames, settings.stretch_limit);
    told.extend(tell(&not_kept.iter().collect::<Vec<_>>(), silent));
    let pace = (simulation.step_length(), simulation.forces().pace.added);
    let summary = results.finish(&inputs, (&settled, &frames), pace, &told, [Some(wall), cpu], started)?;
    if !silent {
        eprintln!("{summary}");
    }
    Ok(Status::Fine)
}

fn settings(asked: &Simulate) -> Result<Settings, Failure> {
    let usage = |option: &'static str| move |e: Error| Failure::Usage(e.within(option));
    let defaults = Settings::default();
    let settings = Settings {
        integrator: named("integrator", &asked.integrator, &Integrator::ALL).map_err(usage("--integrator"))?,
        broad_phase: named("broad phase", &asked.broad_phase, &BroadPhase::ALL).map_err(usage("--broad-phase"))?,
        drag: asked.drag.unwrap_or(defaults.drag),
        damping: asked.damping.unwrap_or(defaults.damping),
        wind: wind(&asked.wind).map_err(usage("--wind"))?,
        settle: asked.settle.unwrap_or(defaults.settle),
        restitution: asked.restitution.unwrap_or(defaults.restitution),
        self_collision: !asked.no_self_collision,
        ..defaults
    };
    settings.check().map_err(Failure::Usage)?;
    if !(0.0..=60.0).contains(&asked.transition) {
        let error = Error::new(format!("A transition of {} s is not possible.", asked.transition), "Give up to 60 s.");
        return Err(Failure::Usage(error.within("--transition")));
    }
    Ok(settings)
}

/// Beyond what the most elastic of the fabrics bears: single edges of a fit are, and what a limb catches will be.
const BEYOND_FABRIC: f64 = 0.03;

/// Strain beyond which edges do not lengthen.
fn stretch_limit(asked: Option<&str>, fitted: &[Fitted]) -> Result<Option<f64>, Failure> {
    let Some(text) = asked else {
        let most = fitted.iter().map(|f| f.state.fabric.stretch_limit).fold(0.0, f64::max);
        return Ok(Some(most + BEYOND_FABRIC));
    };
    if text == "none" {
        return Ok(None);
    }
    let percent = text.trim().trim_end_matches('%').trim_end().parse::<f64>();
    percent.map(|percent| Some(percent / 100.0)).map_err(|_| {
        let problem = format!("\"{text}\" is no stretch.");
        Failure::Usage(Error::new(problem, "Give per cent, such as 8, or \"none\".").within("--stretch-limit"))
    })
}

/// What goes by a name.
pub fn named<T: Copy>(what: &str, name: &str, all: &[(&'static str, T)]) -> Result<T, Error> {
    all.iter().find(|(known, _)| *known == name).map(|(_, one)| *one).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(known, _)| *known).collect();
        let near = names.iter().max_by(|a, b| strsim::jaro(a, name).total_cmp(&strsim::jaro(b, name)));
        let near = near.map_or_else(String::new, |near| format!("Did you mean \"{near}\"? "));
        Error::new(format!("There is no {what} \"{name}\"."), format!("{near}There are {}.", names.join(", ")))
    })
}

fn wind(text: &str) -> Result<Vector3, Error> {
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if text.split(',').count() == 3 => Ok(Vector3::new(x, y, z)),
        _ => Err(Error::new(
            format!("\"{text}\" is no velocity."),
            "Give three numbers, metres a second along x, y and z, such as \"0,0,-3\".",
        )),
    }
}

fn open_motion(asked: &Simulate) -> Result<(Motion, Vec<Warning>), Error> {
    let options = Options {
        body: asked.motion.as_ref().map(|_| asked.body.clone()),
        clip: asked.clip.clone(),
        frame_rate: asked.fps,
        ..Options::default()
    };
    moving_body::open(asked.motion.as_ref().unwrap_or(&asked.body), &options)
}

/// Where the body is at each frame of the simulation: on its way from the pose of the fit, then in motion.
pub struct Shot<'a> {
    motion: &'a Motion,
    /// The pose of the fit.
    from: Option<Vec<Vector3>>,
    pub transition_frames: usize,
    frames: usize,
    /// Of a frame, s.
    pub duration: f64,
}

impl<'a> Shot<'a> {
    fn of(asked: &Simulate, motion: &'a Motion) -> Result<Self, Error> {
        let rate = motion.frame_rate();
        let from = asked.from.as_deref().map(|file| pose(file, motion)).transpose()?;
        let transition_frames = if from.is_some() { (asked.transition * rate).ceil() as usize } else { 0 };
        let moving = motion.frame_count() - 1;
        let own = if moving == 0 { (STILL * rate).ceil() as usize } else { moving };
        let frames = asked.frames.unwrap_or(transition_frames + own);
        if moving > 0 && frames > transition_frames + moving {
            let problem = format!("{frames} frames are asked for, but the motion has {}.", transition_frames + moving);
            return Err(Error::new(problem, "Ask for fewer, or leave --frames out.").within("--frames"));
        }
        Ok(Self { motion, from, transition_frames, frames, duration: 1.0 / rate })
    }

    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Positions at a frame, m; 0 is where the simulation starts.
    pub fn at(&self, frame: usize) -> Vec<Vector3> {
        if frame >= self.transition_frames {
            return self.motion.positions((frame - self.transition_frames).min(self.motion.frame_count() - 1));
        }
        let from = self.from.as_ref().expect("a transition starts from somewhere");
        let share = frame as f64 / self.transition_frames as f64;
        // Slowly off and slowly to a stand: 3s² - 2s³.
        let share = share * share * (3.0 - 2.0 * share);
        from.iter().zip(self.motion.positions(0)).map(|(a, b)| a + (b - a) * share).collect()
    }
}

/// The body of the fit, which has to have the vertices of the one that moves.
fn pose(file: &Path, motion: &Motion) -> Result<Vec<Vector3>, Error> {
    let within = |e: Error| e.within(file.display());
    let (positions, _) = body_obj::mesh(&read::bytes(file)?).map_err(within)?;
    if positions.len() != motion.vertex_count() {
        return Err(within(Error::new(
            format!("It has {} vertices, the body that moves has {}.", positions.len(), motion.vertex_count()),
            "Export the first frame of the motion as an OBJ, and fit the garment on that.",
        )));
    }
    Ok(positions)
}

/// Maps are for bodies that stand still.
fn stands_still(settings: &Settings, asked: &Simulate, motion: &Motion) -> Result<(), Failure> {
    if settings.broad_phase != BroadPhase::Maps || (motion.frame_count() == 1 && asked.from.is_none()) {
        return Ok(());
    }
    let problem = "Maps show the body at one moment, and this one moves all through a frame.";
    let remedy = "Look for the nearest skin with tree, which is the default, or give a body that stands still.";
    Err(Failure::Usage(Error::new(problem, remedy).within("--broad-phase maps")))
}

/// Is the garment where the body begins?
fn in_another_pose(
    shot: &Shot,
    positions: &[Vector3],
    settings: &Settings,
    level: &Level,
    asked: &Simulate,
) -> Result<Option<Warning>, Error> {
    let surface = Surface::new(&shot.at(0), shot.motion.triangles(), settings.broad_phase);
    let free = settings.collisions.free_of_body(level);
    let deep = |p: &Vector3| surface.nearest(*p, 0.1).is_some_and(|place| place.distance < -ANOTHER_POSE);
    let held = |k: usize| !free.get(k).is_some_and(|free| *free);
    let inside = positions.iter().enumerate().filter(|(k, p)| held(*k) && deep(p)).count();
    if inside == 0 {
        return Ok(None);
    }
    let problem = format!("{inside} of {} particles start more than 5 mm inside the body.", positions.len());
    let error = Error::new(
        problem,
        "Fit the garment on the first frame of the motion, or give the body that it was fitted on with --from: the body then \
         moves from that pose to the first one.",
    )
    .within(asked.body.display());
    match inside as f64 > FEW * positions.len() as f64 {
        true => Err(error),
        false => Ok(Some(Warning(error))),
    }
}

fn blown_up(frame: usize, settings: &Settings) -> Error {
    let remedy = match settings.integrator {
        Integrator::Implicit => "Use another integrator, or report it with the files: it should not happen.",
        _ => "Use more damping, or report it with the files: it should not happen.",
    };
    Error::new("The cloth flew apart: positions are no numbers any more.", remedy).within(format!("frame {frame}"))
}

/// Has garments hang from their waists on the body in its first pose, where their fits left them.
fn hold_waists(simulation: &mut Simulation, shot: &Shot, settings: &Settings, fitted: &[Fitted]) {
    let surface = Surface::new(&shot.at(0), shot.motion.triangles(), settings.broad_phase);
    let mut first = 0;
    for fitted in fitted {
        let waist: Vec<u32> = fitted.state.waist.iter().map(|p| first + p).collect();
        simulation.hold_waist(&surface, &waist);
        first += fitted.level().particle_count as u32;
    }
}

/// Takes the garments over from their fits, and lets them find their balance on the body in its first pose.
fn start(simulation: &mut Simulation, shot: &Shot, settings: &Settings) -> Settled {
    let mut surface = Surface::new(&shot.at(0), shot.motion.triangles(), settings.broad_phase);
    simulation.take_over(&surface);
    if settings.settle == 0.0 {
        return Settled::default();
    }
    let course = simulation.settle(&mut surface, settings.settle);
    Settled { time: course.elapsed, steps: course.steps, largest_speed: course.largest_speed }
}

/// Where a simulation stopped.
fn go_on(out: &Path, digest: &str, simulation: &mut Simulation) -> Result<(Settled, Vec<FrameRecord>), Error> {
    let file = out.join("checkpoint.toile");
    let within = |e: Error| e.within(file.display());
    let checkpoint = checkpoint::read(&read::bytes(&file)?, simulation.movement.positions.len()).map_err(within)?;
    if checkpoint.description.of != digest {
        return Err(within(Error::new(
            "It is the checkpoint of another simulation: garments, body, motion or settings differ.",
            "Give what it was started with, or start anew without --resume.",
        )));
    }
    simulation.remember(&checkpoint.remembered);
    simulation.movement = checkpoint.movement;
    Ok((checkpoint.description.settled, checkpoint.description.frames))
}

fn record(frame: usize, duration: f64, course: &Course, measured: Option<Measured>) -> FrameRecord {
    FrameRecord {
        frame,
        time: frame as f64 * duration,
        steps: course.steps,
        evaluations: course.evaluations,
        largest_speed: course.largest_speed,
        rms_speed: course.rms_speed,
        largest_stretch: course.largest_strain,
        most_stretched: None,
        particles_pinched: course.met.pinched,
        measured,
    }
}

/// The middle of an edge of all garments' cloth, and the panel that it is of.
fn spot(fitted: &[Fitted], positions: &[Vector3], ends: [u32; 2]) -> Spot {
    let [a, b] = ends.map(|p| positions[p as usize]);
    let (mut garment, mut first) = (&fitted[0], 0);
    for next in fitted {
        if first + next.level().particle_count as u32 > ends[0] {
            garment = next;
            break;
        }
        first += next.level().particle_count as u32;
    }
    let level = garment.level();
    let has_both = |t: &usize| ends.iter().all(|p| level.particles(*t).contains(&(p - first)));
    let triangle = (0..level.triangles.len()).find(has_both).expect("an edge is of a triangle");
    let panel = level.panel_of_triangle()[triangle] as usize;
    Spot { panel: garment.pattern.panels[panel].name.clone(), at: ((a + b) * 0.5).into() }
}

/// Stretch beyond the limit by this much is told, as a share of the length.
const BEYOND_LIMIT: f64 = 0.02;

/// What could not be met in some frame: the limit of stretch, and a clear place for all cloth.
fn unmet(frames: &[FrameRecord], limit: Option<f64>) -> Vec<Warning> {
    let mut unmet = Vec::new();
    let most = frames.iter().max_by(|a, b| a.largest_stretch.total_cmp(&b.largest_stretch));
    if let (Some(frame), Some(limit)) = (most, limit)
        && let Some(Spot { panel, at: [x, y, z] }) = &frame.most_stretched
        && frame.largest_stretch > limit + BEYOND_LIMIT
    {
        let (stretch, limit) = (100.0 * frame.largest_stretch, 100.0 * limit);
        let problem = format!(
            "The limit of {limit:.0} % could not be kept: by up to {stretch:.0} % was the cloth of `{panel}` stretched."
        );
        let remedy = "The body is wider there than the cloth may become, as in a stride longer than a skirt is wide: give the \
                      garment more ease, or take a fabric that bears more.";
        let place = format!("frame {}, around ({x:.2}, {y:.2}, {z:.2}) m", frame.frame);
        unmet.push(Warning(Error::new(problem, remedy).within(place)));
    }
    if let Some(frame) = frames.iter().max_by_key(|f| f.particles_pinched).filter(|f| f.particles_pinched > 0) {
        let problem = format!(
            "Up to {} particles lay where skin leaves no room for cloth: they were let be between it.",
            frame.particles_pinched
        );
        let remedy = "Where limbs press each other, or the body passes through itself, as behind a bent knee, no place is \
                      clear. Only a body that does neither helps.";
        unmet.push(Warning(Error::new(problem, remedy).within(format!("frame {}", frame.frame))));
    }
    unmet
}

/// Exact tests at the end of a frame, of what is to keep clear. What the body's own skin hides, where a limb lies in
/// another, is inside the body, but not deep in what can be seen of it.
fn measure(
    level: &Level,
    simulation: &Simulation,
    body: &[Vector3],
    triangles: &[[u32; 3]],
    surface: &Surface,
    collisions: &Collisions,
) -> Measured {
    use rayon::prelude::*;
    let (positions, pinched) = (&simulation.movement.positions, simulation.pinched());
    let panel_of = level.panel_of_triangle();
    let panel = |triangle: u32| panel_of[triangle as usize] as usize;
    let mut crossings = crate::assess::cloth_intersections(level, positions);
    crossings.retain(|&[t, u]| collisions.meet(panel(t), panel(u)));
    let cloth_intersections = crossings.len();
    let free = collisions.free_of_body(level);
    let held = |&(k, _): &(usize, &Vector3)| !free.get(k).is_some_and(|free| *free);
    let held: Vec<(usize, Vector3)> = positions.iter().enumerate().filter(held).map(|(k, p)| (k, *p)).collect();
    let of_depths = |depths: Vec<(usize, f64)>| {
        let deepest = |depths: &mut dyn Iterator<Item = &(usize, f64)>| depths.map(|d| d.1).fold(0.0, f64::max) * 1e3;
        Measured {
            particles_inside: depths.iter().filter(|d| d.1 > 0.0).count(),
            deepest_mm: deepest(&mut depths.iter()),
            deepest_with_room_mm: deepest(&mut depths.iter().filter(|d| !pinched[d.0])),
            body_intersections: 0,
            cloth_intersections,
        }
    };
    let near =
        |(_, p): &&(usize, Vector3)| surface.nearest(*p, NEAR_SKIN).is_some_and(|place| place.distance < NEAR_SKIN);
    let Ok((body, _)) = Body::new(body.to_vec(), triangles.to_vec()) else {
        // A frame may be no proper body; the surface that the cloth felt is then all there is to measure against.
        let depth = |p: &Vector3| surface.nearest(*p, 0.1).map_or(0.0, |place| (-place.distance).max(0.0));
        return of_depths(held.par_iter().map(|(k, p)| (*k, depth(p))).collect());
    };
    let depth = |p: &Vector3| match body.contains(*p) {
        true => body.nearest(*p, 0.2).map_or(0.2, |nearest| nearest.distance),
        false => 0.0,
    };
    let depths = held.par_iter().filter(near).map(|(k, p)| (*k, depth(p))).collect();
    let mut pierced = crate::assess::body_intersections(level, positions, &body);
    pierced.retain(|&[t, _]| collisions.of(panel(t)) != Collide::Nothing);
    Measured { body_intersections: pierced.len(), ..of_depths(depths) }
}

/// Only particles nearer to the skin than this are asked whether they are inside, m.
const NEAR_SKIN: f64 = 0.05;

/// Tells of the frames as they are done.
enum Watcher {
    Bar(ProgressBar),
    Lines {
        last: Instant,
        started: Instant,
        /// Frames before it started, and in all.
        done: usize,
        frames: usize,
    },
    Json,
    Silent,
}

/// Seconds between two lines where no terminal shows a bar.
const BETWEEN_LINES: f64 = 5.0;

impl Watcher {
    fn new(progress: Progress, frames: usize, done: usize) -> Self {
        match progress {
            Progress::Auto if std::io::stderr().is_terminal() => {
                let bar = ProgressBar::with_draw_target(Some(frames as u64), ProgressDrawTarget::stderr());
                let template = "frame {pos}/{len} {bar:30} {msg}, {eta} left";
                bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
                bar.set_position(done as u64);
                bar.reset_eta();
                Self::Bar(bar)
            }
            Progress::Auto => Self::Lines { last: Instant::now(), started: Instant::now(), done, frames },
            Progress::Json => Self::Json,
            Progress::None => Self::Silent,
        }
    }

    fn frame(&mut self, record: &FrameRecord) {
        let speed = format!("{} steps, up to {:.2} m/s", record.steps, record.largest_speed);
        match self {
            Self::Bar(bar) => {
                bar.set_message(speed);
                bar.inc(1);
            }
            Self::Lines { last, started, done, frames } if last.elapsed().as_secs_f64() > BETWEEN_LINES => {
                let pace = started.elapsed().as_secs_f64() / (record.frame - *done) as f64;
                let left = pace * (*frames - record.frame) as f64;
                eprintln!("frame {} of {frames}: {speed}; about {left:.0} s left", record.frame);
                *last = Instant::now();
            }
            Self::Json => eprintln!("{}", json!({ "event": "frame", "record": record })),
            Self::Lines { .. } | Self::Silent => {}
        }
    }

    fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
