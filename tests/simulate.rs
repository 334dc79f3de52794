//! `toile simulate` as scripts see it: the same bytes on any number of threads and after a pause, messages, statuses.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn toile(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_toile")).args(arguments).output().unwrap()
}

fn talk(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with a coarse fit in it.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        let fit = bench.path("fit").display().to_string();
        let output = toile(&["demo", "--out", &fit, "--resolution", "40 mm", "--progress", "none"]);
        assert!([Some(0), Some(4)].contains(&output.status.code()), "{}", talk(&output));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn simulate(&self, body: &Path, out: &str, more: &[&str]) -> Output {
        let [fit, body, out] = [&self.path("fit"), body, &self.path(out)].map(|p| p.display().to_string());
        let quiet = ["--progress", "none", "--draw-every", "0"];
        toile(&[&["simulate", &fit, "--body", &body, "--out", &out], &quiet[..], more].concat())
    }

    fn motion(&self, out: &str) -> Vec<u8> {
        std::fs::read(self.path(out).join("motion.toile")).unwrap()
    }
}

fn mannequin() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/mannequin.obj")
}

#[test]
fn threads_and_pauses_change_no_byte_of_a_motion() {
    let bench = Bench::new();
    let body = mannequin();
    let fine = |output: Output| assert_eq!(output.status.code(), Some(0), "{}", talk(&output));
    fine(bench.simulate(&body, "one", &["--frames", "4", "--threads", "1"]));
    fine(bench.simulate(&body, "two", &["--frames", "4", "--threads", "2"]));
    fine(bench.simulate(&body, "paused", &["--frames", "2"]));
    fine(bench.simulate(&body, "paused", &["--frames", "4", "--resume"]));
    assert!(bench.motion("one") == bench.motion("two"), "threads changed the motion");
    assert!(bench.motion("one") == bench.motion("paused"), "a pause changed the motion");
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(bench.path("one/simulation.json")).unwrap()).unwrap();
    assert_eq!(report["schema"], "toile-simulation/1");
    // The mannequin stands, and a T-shirt does not hang from a waist.
    assert!(report["settings"]["floor_m"].as_f64().unwrap().abs() < 0.01, "{report}");
    assert_eq!(report["settings"]["waist_particles"], serde_json::json!([0]));
    let frames = report["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 4);
    for frame in frames {
        assert!(frame["steps"].as_u64().unwrap() > 10, "{frame}");
        assert!(frame["measured"]["deepest_mm"].as_f64().unwrap() < 1.0, "{frame}");
        assert!(frame["largest_speed"].as_f64().unwrap() < 3.0, "{frame}");
    }
    // Another simulation is not gone on with.
    let output = bench.simulate(&body, "paused", &["--frames", "5", "--resume", "--drag", "7"]);
    assert_eq!(output.status.code(), Some(3), "{}", talk(&output));
    assert!(talk(&output).contains("another simulation"), "{}", talk(&output));
}

/// Maps and collision levels: the same bytes on any number of threads, and no pause without the same levels.
#[test]
fn panels_run_into_what_they_are_to() {
    let bench = Bench::new();
    let body = mannequin();
    let fine = |output: Output| assert_eq!(output.status.code(), Some(0), "{}", talk(&output));
    let levels = ["--frames", "5", "--collide", "*=others", "--collide", "*sleeve*=none"];
    let maps = [&levels[..], &["--broad-phase", "maps"]].concat();
    fine(bench.simulate(&body, "one", &[&maps[..], &["--threads", "1"]].concat()));
    fine(bench.simulate(&body, "two", &[&maps[..], &["--threads", "2"]].concat()));
    assert!(bench.motion("one") == bench.motion("two"), "threads changed the motion");
    fine(bench.simulate(&body, "all", &["--frames", "5"]));
    let report = |out: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(bench.path(out).join("simulation.json")).unwrap()).unwrap()
    };
    let told = report("one")["settings"]["collide"].as_array().unwrap().clone();
    assert_eq!(told.len(), 6);
    assert!(told.contains(&serde_json::json!(["left_sleeve_front", "none"])), "{told:?}");
    assert!(told.contains(&serde_json::json!(["front", "others"])), "{told:?}");
    assert_eq!(report("all")["settings"]["collide"], serde_json::json!([]));
    // Sleeves fall through the arms; what else there is still keeps clear of the body.
    assert!(bench.motion("one") != bench.motion("all"));
    for frame in report("one")["frames"].as_array().unwrap() {
        assert!(frame["measured"]["deepest_mm"].as_f64().unwrap() < 1.0, "{frame}");
    }
    // Other levels are another simulation.
    let other = ["--frames", "6", "--broad-phase", "maps", "--collide", "*=others", "--resume"];
    let output = bench.simulate(&body, "one", &other);
    assert_eq!(output.status.code(), Some(3), "{}", talk(&output));
    assert!(talk(&output).contains("another simulation"), "{}", talk(&output));
}

#[test]
fn what_cannot_be_simulated_ends_in_a_message_that_names_the_place() {
    let bench = Bench::new();
    let body = mannequin();
    let broken = bench.path("broken.glb");
    std::fs::write(&broken, b"glTF\x02\0\0\0\x05\0\0\0").unwrap();
    let nobody = bench.path("nobody.glb");
    let from = body.to_str().unwrap();
    let cases: [(&Path, &[&str], i32, &str); 13] = [
        (&broken, &[], 3, "broken.glb"),
        (&nobody, &[], 3, "nobody.glb"),
        (&body, &["--integrator", "simplectic-euler"], 2, "symplectic-euler"),
        (&body, &["--wind", "1,2"], 2, "three numbers"),
        (&body, &["--damping", "7"], 2, "damping"),
        (&body, &["--collide", "front"], 2, "names no level"),
        (&body, &["--collide", "front=sometimes"], 2, "none, body, others, all"),
        (&body, &["--collide", "frnt=none"], 2, "\"front\""),
        (&body, &["--broad-phase", "spherse"], 2, "spheres"),
        (&body, &["--broad-phase", "maps", "--from", from], 2, "stands still"),
        (&body, &["--resume"], 3, "checkpoint.toile"),
        (&body, &["--floor", "ground"], 2, "no height of a floor"),
        (&body, &["--waist", "tied"], 2, "held, free"),
    ];
    for (body, more, status, word) in cases {
        let output = bench.simulate(body, "out", more);
        assert_eq!(output.status.code(), Some(status), "{more:?}: {}", talk(&output));
        assert!(talk(&output).contains(word), "{more:?}: {}", talk(&output));
    }
}
