//! `toile export` as scripts see it: sets of files, manifests, messages. What other programs make of the files is for
//! `tests/other_programs/run`.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use toile::geometry::Vector3;
use toile::io::export::{Frames, Target};
use toile::io::motion_cache::{MotionHeader, MotionReader, MotionWriter, Precision};
use toile::io::{read, state};

fn toile(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_toile")).args(arguments).output().unwrap()
}

fn status(output: &Output) -> i32 {
    output.status.code().expect("the program was not killed")
}

fn talk(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The state of a coarse fit, made once.
fn fitted() -> &'static [u8] {
    static STATE: OnceLock<Vec<u8>> = OnceLock::new();
    STATE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("fit").display().to_string();
        let output = toile(&["demo", "--out", &out, "--resolution", "40 mm", "--progress", "none"]);
        assert!([0, 4].contains(&status(&output)), "{}", talk(&output));
        std::fs::read(folder.path().join("fit/state.toile")).unwrap()
    })
}

/// A folder with a fit in it.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        std::fs::create_dir(bench.path("fit")).unwrap();
        std::fs::write(bench.path("fit/state.toile"), fitted()).unwrap();
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn export(&self, to: &str, out: &str, more: &[&str]) -> Output {
        let (fit, out) = (self.path("fit").display().to_string(), self.path(out).display().to_string());
        toile(&[&["export", &fit, "--to", to, "--out", &out], more].concat())
    }

    /// Puts a motion of so many frames beside the state, and returns its frames.
    fn move_by(&self, frames: usize) -> Vec<Vec<Vector3>> {
        let state = state::read(fitted()).unwrap();
        let header = MotionHeader {
            precision: Precision::Double,
            particle_count: state.positions.len(),
            frame_rate: 24.0,
            state_sha256: read::sha256(fitted()),
        };
        let mut writer = MotionWriter::create(&self.path("fit/motion.toile"), header).unwrap();
        let moved = |k: usize| state.positions.iter().map(|p| p + Vector3::new(0.01, 0.0, 0.1) * k as f64).collect();
        let frames: Vec<Vec<Vector3>> = (0..frames).map(moved).collect();
        frames.iter().for_each(|frame| writer.append(frame).unwrap());
        writer.finish().unwrap();
        frames
    }
}

fn manifest(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap()
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Positions of a PC2 file, frame by frame.
fn pc2(path: &Path) -> Vec<Vec<[f32; 3]>> {
    let bytes = std::fs::read(path).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let floats: Vec<f32> = bytes[32..].as_chunks::<4>().0.iter().map(|&four| f32::from_le_bytes(four)).collect();
    let frames: Vec<Vec<[f32; 3]>> = floats.chunks(3 * word(16)).map(|frame| frame.as_chunks().0.to_vec()).collect();
    assert_eq!(frames.len(), word(28));
    frames
}

#[test]
fn every_target_at_rest_writes_what_its_manifest_says() {
    let bench = Bench::new();
    // What follows a skin needs a body: `a_garment_follows_what_it_lies_on`.
    let own = Target::ALL.into_iter().filter(|target| *target != Target::GlbSkinned);
    let all = own.map(Target::name).collect::<Vec<_>>().join(",");
    let output = bench.export(&all, "out/deep", &[]);
    assert_eq!(status(&output), 0, "{}", talk(&output));
    let out = bench.path("out/deep");
    let manifest = manifest(&out);
    let mut listed = vec!["manifest.json".to_owned()];
    for file in manifest["files"].as_array().unwrap() {
        let name = file["name"].as_str().unwrap();
        let bytes = std::fs::read(out.join(name)).unwrap();
        assert_eq!(file["sha256"], read::sha256_hex(&bytes), "{name}");
        assert_eq!(file["bytes"], bytes.len());
        listed.push(name.to_owned());
    }
    listed.sort();
    assert_eq!(listed, files(&out));
    for name in ["garment.obj", "rest.npz", "garment.pc2", "garment.usda", "newton.npz", "garment.glb", "rest.ply"] {
        assert!(listed.iter().any(|file| file == name), "{name}");
    }
    let state = state::read(fitted()).unwrap();
    assert_eq!(manifest["vertices"]["sewn"], state.positions.len());
    assert_eq!(manifest["from"]["state_sha256"], read::sha256_hex(fitted()));
    assert_eq!(manifest["from"]["pattern"]["sha256"], state.pattern_sha256);
    assert_eq!(manifest["frames"], serde_json::json!({"count": 1, "rate": null}));
    assert_eq!(manifest["clearance_m"], state.settings.clearance);
    let [frame] = &pc2(&out.join("garment.pc2"))[..] else { panic!("a garment at rest has one frame") };
    assert!(frame.iter().zip(&state.positions).all(|(a, b)| *a == <[f32; 3]>::from(b.map(|x| x as f32))));
    // The same input gives the same bytes, and an earlier set is replaced.
    let before: Vec<Vec<u8>> = listed.iter().map(|name| std::fs::read(out.join(name)).unwrap()).collect();
    assert_eq!(status(&bench.export(&all, "out/deep", &[])), 0);
    let after: Vec<Vec<u8>> = listed.iter().map(|name| std::fs::read(out.join(name)).unwrap()).collect();
    assert!(before == after);
}

#[test]
fn a_motion_is_exported_whole_or_the_frames_that_were_chosen() {
    let bench = Bench::new();
    let frames = bench.move_by(7);
    let output = bench.export("pc2, obj", "whole", &[]);
    assert_eq!(status(&output), 0, "{}", talk(&output));
    let written = pc2(&bench.path("whole/garment.pc2"));
    assert_eq!(written.len(), 7);
    for (a, b) in written.iter().flatten().zip(frames.iter().flatten()) {
        assert_eq!(*a, <[f32; 3]>::from(b.map(|x| x as f32)));
    }
    assert_eq!(files(&bench.path("whole/frames")).len(), 7);
    let last = std::fs::read_to_string(bench.path("whole/frames/garment.00006.obj")).unwrap();
    let first_vertex = last.lines().find_map(|line| line.strip_prefix("v ")).unwrap();
    assert_eq!(first_vertex, format!("{} {} {}", frames[6][0].x, frames[6][0].y, frames[6][0].z));

    assert_eq!(status(&bench.export("mdd,pc2", "some", &["--frames", "1..6/2"])), 0);
    let manifest = manifest(&bench.path("some"));
    assert_eq!(manifest["frames"], serde_json::json!({"count": 3, "rate": 12.0}));
    assert_eq!(
        (&manifest["from"]["motion"]["first_frame"], &manifest["from"]["motion"]["step"]),
        (&1.into(), &2.into())
    );
    let [_, second, _] = &pc2(&bench.path("some/garment.pc2"))[..] else { panic!("three frames were asked for") };
    assert_eq!(second[0][2], frames[3][0].z as f32);

    assert_eq!(status(&bench.export("pc2", "still", &["--still"])), 0);
    assert_eq!(pc2(&bench.path("still/garment.pc2")).len(), 1);
}

#[test]
fn a_motion_that_was_cut_off_gives_its_whole_frames_and_a_warning() {
    let bench = Bench::new();
    bench.move_by(3);
    let path = bench.path("fit/motion.toile");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    let output = bench.export("pc2", "out", &[]);
    assert_eq!(status(&output), 0);
    assert!(talk(&output).contains("not whole"), "{}", talk(&output));
    assert_eq!(pc2(&bench.path("out/garment.pc2")).len(), 2);
}

#[test]
fn what_is_damaged_or_does_not_belong_ends_in_a_message_and_no_manifest() {
    let bench = Bench::new();
    bench.move_by(3);
    let path = bench.path("fit/motion.toile");
    let sound = std::fs::read(&path).unwrap();
    let particles = MotionReader::open(&path).unwrap().header().particle_count;
    let mut damaged = sound.clone();
    let at = damaged.len() - 24 * particles;
    damaged[at] ^= 1;
    std::fs::write(&path, damaged).unwrap();
    for to in ["pc2", "usd", "npz", "glb", "obj"] {
        let output = bench.export(to, "out", &[]);
        assert_eq!(status(&output), 3, "{to}");
        assert!(talk(&output).contains("frame 2: The checksum"), "{}", talk(&output));
        assert!(!bench.path("out/manifest.json").exists());
    }
    let mut other = MotionReader::open(&path).unwrap().header().to_owned();
    other.state_sha256[0] ^= 1;
    MotionWriter::create(&path, other).unwrap();
    assert!(talk(&bench.export("pc2", "out", &[])).contains("another fit"));
    std::fs::write(&path, &sound[..3]).unwrap();
    let output = bench.export("pc2", "out", &[]);
    assert_eq!((status(&output), talk(&output).contains("not a motion")), (3, true));
    assert_eq!(status(&bench.export("pc2", "out", &["--still"])), 0);
}

#[test]
fn what_cannot_be_asked_for_is_told_with_what_can() {
    let bench = Bench::new();
    for (to, more, expected) in [
        ("blendr", &[][..], "Did you mean `blender`?"),
        ("usd,maya", &[], "Known are blender"),
        ("", &[], "There is no target named \"\""),
        ("pc2", &["--frames", "0..3"], "There is no motion"),
        ("pc2", &["--frames", "3..0"], "no range of frames"),
    ] {
        let output = bench.export(to, "out", more);
        assert_eq!(status(&output), 2, "{to} {}", talk(&output));
        assert!(talk(&output).contains(expected), "{}", talk(&output));
        assert!(!bench.path("out").exists());
    }
    bench.move_by(3);
    let output = bench.export("pc2", "out", &["--frames", "1..3"]);
    assert_eq!((status(&output), talk(&output).contains("its last is 2")), (3, true), "{}", talk(&output));
    // The files of the fit are not to be replaced.
    let output = bench.export("glb", "fit", &[]);
    assert_eq!((status(&output), talk(&output).contains("replace those of the fit")), (2, true));
    std::fs::create_dir(bench.path("outfit")).unwrap();
    std::fs::write(bench.path("outfit/outfit.json"), "{}").unwrap();
    let outfit = bench.path("outfit").display().to_string();
    let output = toile(&["export", &outfit, "--to", "usd", "--out", &bench.path("x").display().to_string()]);
    assert_eq!((status(&output), talk(&output).contains("several garments")), (3, true));
    assert_eq!(MotionReader::open(&bench.path("fit/motion.toile")).unwrap().frame_count(), 3);
}

/// The garment's own mesh in a node is a body without joints: what lies on it follows that node.
#[test]
fn a_garment_follows_what_it_lies_on() {
    let bench = Bench::new();
    let output = bench.export("glb-skinned", "out", &[]);
    assert_eq!((status(&output), talk(&output).contains("--skin")), (3, true), "{}", talk(&output));
    assert_eq!(status(&bench.export("glb", "body", &[])), 0);
    let body = bench.path("body/garment.glb").display().to_string();
    let output = bench.export("glb", "out", &["--skin", &body]);
    assert_eq!((status(&output), talk(&output).contains("No target")), (2, true), "{}", talk(&output));
    let output = bench.export("glb-skinned", "out", &["--skin", &body, "--skin-frame", "1"]);
    assert_eq!((status(&output), talk(&output).contains("no frame 1")), (3, true), "{}", talk(&output));
    let output = bench.export("glb-skinned", "out", &["--skin", &body]);
    assert_eq!(status(&output), 0, "{}", talk(&output));
    assert_eq!(manifest(&bench.path("out"))["from"]["skin"]["name"], "garment.glb");
    let skinned = bench.path("out/garment_skinned.glb");
    let (motion, _) = toile::io::moving_body::open(&skinned, &Default::default()).unwrap();
    let state = state::read(fitted()).unwrap();
    let low = |of: &[Vector3]| of.iter().fold(Vector3::repeat(f64::INFINITY), |low, p| low.inf(p));
    let (found, expected) = (low(&motion.positions(0)), low(&state.positions));
    assert!((found - expected).norm() < 1e-6, "{found} instead of {expected}");
}
