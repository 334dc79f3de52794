//! How the nearest skin is looked for: seconds, distances computed, and where the answers come from, in tables for
//! docs/broad_phases.md. Called by `broad_phases.sh`.
//!
//!     broad_phases BODY.obj WALK.glb NAME=FIT,WALK ...
//!
//! FIT is the folder of a fit on BODY, WALK that of its simulation along WALK.glb. What is asked for is what the
//! simulator asks for: the skin that is nearest to each particle, within 12 cm.

use std::path::Path;
use toile::body::Motion;
use toile::dynamics::{BroadPhase, Surface, Unsure};
use toile::geometry::Vector3;
use toile::io::moving_body::{self, Options};
use toile::io::{body_obj, export::Frames, motion_cache::MotionReader, process, state};

/// As in `dynamics/response.rs`, m.
const REACH: f64 = 0.12;
/// What the simulator follows step by step, m: particles nearer than this.
const NEAR: f64 = 0.012;
/// Frames of the walk that are looked at.
const FRAMES: [usize; 4] = [1, 8, 15, 22];
/// Rounds of which the median is told; the kinds take turns.
const ROUNDS: usize = 5;
/// Seconds that a round lasts at least.
const ROUND: f64 = 0.1;

/// The body on its way through one frame, and the particles around it.
struct Scene<'a> {
    start: Vec<Vector3>,
    end: Vec<Vector3>,
    triangles: &'a [[u32; 3]],
    points: Vec<Vector3>,
    /// Those that are nearer than [`NEAR`].
    near: Vec<Vector3>,
}

impl<'a> Scene<'a> {
    fn new(start: Vec<Vector3>, end: Vec<Vector3>, triangles: &'a [[u32; 3]], points: Vec<Vector3>) -> Self {
        let mut scene = Self { start, end, triangles, points, near: Vec::new() };
        let tree = scene.surface(BroadPhase::Tree);
        scene.near = scene.points.iter().copied().filter(|p| tree.nearest(*p, NEAR).is_some()).collect();
        scene
    }

    fn surface(&self, kind: BroadPhase) -> Surface {
        let mut surface = Surface::new(&self.start, self.triangles, kind);
        surface.move_to(&self.end, 1.0 / 24.0);
        surface.advance(0.5);
        surface
    }
}

fn main() {
    // Cargo adds arguments of its own.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let [body, walk, garments @ ..] = &arguments[..] else {
        println!("Give a body, its walk, and garments as NAME=FIT,WALK; see broad_phases.sh.");
        return;
    };
    let (body, triangles) = body_obj::mesh(&std::fs::read(body).expect("a body")).expect("a body");
    let motion = moving_body::open(Path::new(walk), &Options::default()).expect("a walk").0;
    // One thread, so that processor time is time.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    pool.install(|| tables(&body, &triangles, &motion, garments));
}

fn tables(body: &[Vector3], triangles: &[[u32; 3]], motion: &Motion, garments: &[String]) {
    let mut scenes: Vec<(String, Vec<Scene>, Vec<Scene>)> = Vec::new();
    for garment in garments {
        let (name, folders) = garment.split_once('=').expect("NAME=FIT,WALK");
        let (fit, walk) = folders.split_once(',').expect("NAME=FIT,WALK");
        let fitted = state::read(&std::fs::read(Path::new(fit).join("state.toile")).expect("a fit")).expect("a fit");
        let still = Scene::new(body.to_vec(), body.to_vec(), triangles, fitted.positions);
        let mut frames = MotionReader::open(&Path::new(walk).join("motion.toile")).expect("a simulation");
        let mut walking = Vec::new();
        for frame in FRAMES {
            let mut points = Vec::new();
            frames.read(frame, &mut points).expect("a frame");
            let (start, end) = (motion.positions(frame), motion.positions(frame + 1));
            walking.push(Scene::new(start, end, motion.triangles(), points));
        }
        scenes.push((name.to_owned(), vec![still], walking));
    }
    println!("### Made anew for a frame\n");
    println!("| | body | ms, standing | ms, walking |\n|---|---|---|---|");
    let (_, still, walking) = &scenes[0];
    for (name, kind) in BroadPhase::ALL {
        let moves = if kind == BroadPhase::Maps { "-".to_owned() } else { format!("{:.1}", 1e3 * made(walking, kind)) };
        println!("| `{name}` | {} triangles | {:.1} | {moves} |", triangles.len(), 1e3 * made(still, kind));
    }
    println!("\n### One question\n");
    let near = 1e3 * NEAR;
    println!(
        "Processor nanoseconds a particle nearer than {near:.0} mm, which the simulator asks for every 24 steps, and distances"
    );
    println!(
        "to triangles that were computed for it, before the walk to nearer neighbours that follows all of them.\n"
    );
    println!(
        "| garment | particles | | standing, ns | distances | walking, ns | distances |\n|---|---|---|---|---|---|---|"
    );
    for (garment, still, walking) in &scenes {
        let [standing, moving] = [still, walking].map(|scenes| asked(scenes));
        for (k, (name, kind)) in BroadPhase::ALL.iter().enumerate() {
            let moves = match kind {
                BroadPhase::Maps => "- | -".to_owned(),
                _ => format!("{:.0} | {:.1}", 1e9 * moving[k].0, moving[k].1),
            };
            let particles = still[0].near.len();
            println!(
                "| {garment} | {particles} | `{name}` | {:.0} | {:.1} | {moves} |",
                1e9 * standing[k].0,
                standing[k].1
            );
        }
    }
    println!("\n### What the maps know\n");
    println!(
        "Of particles nearer than {near:.0} mm, and of all within {:.0} mm. Where they are not sure they",
        1e3 * REACH
    );
    println!(
        "say why, and the tree is asked. The last columns have nanoseconds where they are sure: theirs and the tree's.\n"
    );
    let reasons: Vec<&str> = Unsure::ALL.iter().map(|(name, _)| *name).collect();
    println!(
        "| garment | | known | {} | farthest off, mm | ns | tree |\n|---|---|---|{}---|---|---|",
        reasons.join(" | "),
        "---|".repeat(reasons.len())
    );
    for (garment, still, _) in &scenes {
        known(garment, &still[0]);
    }
}

/// Median processor seconds of making what encloses the body.
fn made(scenes: &[Scene], kind: BroadPhase) -> f64 {
    let mut rounds: Vec<f64> = (0..ROUNDS)
        .map(|round| {
            let scene = &scenes[round % scenes.len()];
            let mut surface = Surface::new(&scene.start, scene.triangles, kind);
            timed(|| {
                if scene.start == scene.end {
                    surface = Surface::new(&scene.start, scene.triangles, kind);
                } else {
                    surface.move_to(&scene.start, 1.0);
                    surface.move_to(&scene.end, 1.0);
                }
            }) / if scene.start == scene.end { 1.0 } else { 2.0 }
        })
        .collect();
    median(&mut rounds)
}

/// Of each kind the median processor seconds, and the mean number of distances, of a question.
fn asked(scenes: &[Scene]) -> Vec<(f64, f64)> {
    let surfaces: Vec<Vec<Surface>> =
        BroadPhase::ALL.iter().map(|&(_, kind)| scenes.iter().map(|scene| scene.surface(kind)).collect()).collect();
    let mut rounds = vec![Vec::new(); surfaces.len()];
    let count: usize = scenes.iter().map(|scene| scene.near.len()).sum();
    for _ in 0..ROUNDS {
        for (surfaces, seconds) in surfaces.iter().zip(&mut rounds) {
            let all = || {
                for (surface, scene) in surfaces.iter().zip(scenes) {
                    for point in &scene.near {
                        std::hint::black_box(surface.look(*point, REACH).triangle);
                    }
                }
            };
            seconds.push(timed(all) / count as f64);
        }
    }
    let tests = surfaces.iter().map(|surfaces| {
        let each = surfaces.iter().zip(scenes).flat_map(|(s, scene)| scene.near.iter().map(move |p| s.look(*p, REACH)));
        each.map(|looked| looked.tests).sum::<usize>() as f64 / count as f64
    });
    rounds.iter_mut().map(|seconds| median(seconds)).zip(tests).collect()
}

/// Two rows: where the maps know the nearest skin, and how far off they are.
fn known(garment: &str, scene: &Scene) {
    let [tree, maps] = [BroadPhase::Tree, BroadPhase::Maps].map(|kind| scene.surface(kind));
    for (which, within) in [("near", NEAR), ("all", REACH)] {
        let mut counts = vec![0usize; Unsure::ALL.len() + 1];
        let (mut farthest, mut sure) = (0.0f64, Vec::new());
        for point in &scene.points {
            let Some(nearest) = tree.nearest(*point, within) else { continue };
            let looked = maps.look(*point, REACH);
            let reason = Unsure::ALL.iter().position(|(_, why)| Some(*why) == looked.unsure);
            counts[reason.map_or(0, |k| k + 1)] += 1;
            if looked.unsure.is_none() {
                sure.push(*point);
            }
            let found = maps.nearest(*point, REACH).expect("it is within reach");
            farthest = farthest.max(found.distance.abs() - nearest.distance.abs());
        }
        let all = counts.iter().sum::<usize>() as f64;
        let shares: Vec<String> = counts.iter().map(|n| format!("{:.0} %", 100.0 * *n as f64 / all)).collect();
        let seconds = [&maps, &tree].map(|surface| {
            let all = || {
                for point in &sure {
                    std::hint::black_box(surface.look(*point, REACH).triangle);
                }
            };
            median(&mut (0..ROUNDS).map(|_| timed(all) / sure.len().max(1) as f64).collect::<Vec<_>>())
        });
        let [maps, tree] = seconds.map(|s| format!("{:.0}", 1e9 * s));
        println!("| {garment} | {which} | {} | {:.3} | {maps} | {tree} |", shares.join(" | "), 1e3 * farthest);
    }
}

/// Processor seconds of some work, repeated until they are enough to be measured.
fn timed(mut work: impl FnMut()) -> f64 {
    let now = || process::cpu_seconds().expect("this system tells processor time");
    let start = now();
    let mut times = 0;
    while now() - start < ROUND {
        work();
        times += 1;
    }
    (now() - start) / f64::from(times)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
