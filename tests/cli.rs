//! The program as scripts see it: files, exit statuses, messages.

mod support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use toile::io::{embedded, read, state};

const FILES: [&str; 7] =
    ["convergence.svg", "garment.glb", "garment.obj", "preview.png", "report.json", "state.toile", "strain.png"];

fn toile(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_toile")).args(arguments).output().unwrap()
}

fn status(output: &Output) -> i32 {
    output.status.code().expect("the program was not killed")
}

fn talk(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with the embedded pattern and body in it.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        std::fs::write(bench.path("tee.json"), embedded::TEE).unwrap();
        std::fs::write(bench.path("body.obj"), embedded::MANNEQUIN_OBJ).unwrap();
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    /// Fits the given pattern and body quickly.
    fn fit(&self, pattern: &str, body: &str, out: &str, more: &[&str]) -> Output {
        let (pattern, body, out) = (self.text(pattern), self.text(body), self.text(out));
        let mut arguments = vec!["fit", &pattern, "--body", &body, "--out", &out];
        arguments.extend(more);
        toile(&arguments)
    }
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&path).unwrap()))
        .collect()
}

#[test]
fn a_demonstration_writes_all_its_files_and_they_belong_together() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/results");
    let output = toile(&["demo", "--out", &out.display().to_string(), "--resolution", "30 mm", "--progress", "none"]);
    assert!([0, 4].contains(&status(&output)), "{}", talk(&output));
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    let files = files(&out);
    assert_eq!(files.keys().collect::<Vec<_>>(), FILES.iter().collect::<Vec<_>>());

    let report: Value = serde_json::from_slice(&files["report.json"]).unwrap();
    assert_eq!(report["inputs"]["pattern"]["sha256"], read::sha256_hex(embedded::TEE.as_bytes()));
    assert_eq!(report["hand_off_ready"], status(&output) == 0);
    assert_eq!(report["assessment"]["intersections"]["body_pairs"], 0);
    assert_its_stages_add_up(&report["run"]);
    let state = state::read(&files["state.toile"]).unwrap();
    let (_, garment) = state.rebuild().unwrap();
    let particles = garment.levels.last().unwrap().particle_count;
    let obj = String::from_utf8(files["garment.obj"].clone()).unwrap();
    let vertices: Vec<Vec<f64>> = obj
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect())
        .collect();
    assert_eq!((vertices.len(), state.positions.len()), (particles, particles));
    // Printed so that re-reading gives the same numbers.
    assert!(vertices.iter().zip(&state.positions).all(|(v, p)| v.as_slice() == p.as_slice()));
    for picture in ["preview.png", "strain.png"] {
        assert!(files[picture].starts_with(b"\x89PNG"));
    }
    assert!(files["garment.glb"].starts_with(b"glTF"));
}

/// Of a run with one level.
fn assert_its_stages_add_up(run: &Value) {
    let stages = run["stages"].as_array().unwrap();
    let names: Vec<&str> = stages.iter().map(|stage| stage["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["body", "start-up", "sewing", "level 1", "assessment"]);
    for [whole, solve, part] in
        [["wall_seconds", "solve_wall_seconds", "wall_seconds"], ["cpu_seconds", "solve_cpu_seconds", "cpu_seconds"]]
    {
        // A system that tells no processor time tells none at all.
        let Some(whole) = run[whole].as_f64() else { continue };
        let parts: f64 = stages.iter().map(|stage| stage[part].as_f64().unwrap()).sum();
        assert!((parts - run[solve].as_f64().unwrap()).abs() < 1e-9 && parts < whole, "{run}");
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let bench = Bench::new();
    let run = |threads: &str| {
        let output = bench.fit("tee.json", "body.obj", threads, &["--levels", "36,18 mm", "--threads", threads]);
        assert!([0, 4].contains(&status(&output)), "{}", talk(&output));
        let mut files = files(&bench.path(threads));
        let mut report: Value = serde_json::from_slice(&files["report.json"]).unwrap();
        let host = report.as_object_mut().unwrap().remove("run").expect("what varies stands in `run`");
        assert_eq!(host["threads"].to_string(), threads);
        files.insert("report.json".to_owned(), report.to_string().into_bytes());
        files
    };
    let (one, two) = (run("1"), run("2"));
    for (name, bytes) in &one {
        assert!(bytes == &two[name], "{name} differs");
    }
}

#[test]
fn progress_is_a_line_a_level_or_json_as_asked() {
    let bench = Bench::new();
    let lines = bench.fit("tee.json", "body.obj", "out", &["--resolution", "40 mm"]);
    assert!(talk(&lines).contains("level 1: 40 mm"), "{}", talk(&lines));
    let json = bench.fit("tee.json", "body.obj", "out", &["--resolution", "40 mm", "--progress", "json"]);
    let events: Vec<Value> =
        talk(&json).lines().filter(|l| l.starts_with('{')).map(|l| serde_json::from_str(l).unwrap()).collect();
    for name in ["arranged", "sewing", "level_started", "step", "level_done"] {
        assert!(events.iter().any(|e| e["event"] == name), "no event {name}");
    }
}

#[test]
fn an_exhausted_budget_has_its_own_status_and_results_all_the_same() {
    let bench = Bench::new();
    std::fs::write(bench.path("settings.toml"), "equilibrium_evaluations = 20\ncoarse_evaluations = 50\n").unwrap();
    let settings = bench.text("settings.toml");
    let more = ["--resolution", "40 mm", "--until", "equilibrium", "--settings", &settings];
    let output = bench.fit("tee.json", "body.obj", "out", &more);
    assert_eq!(status(&output), 5, "{}", talk(&output));
    assert_eq!(files(&bench.path("out")).len(), FILES.len());
}

#[test]
fn a_garment_that_is_too_tight_is_written_with_status_4() {
    let bench = Bench::new();
    // The same outlines in a smaller unit: a tee for a child.
    let mut pattern: Value = serde_json::from_str(embedded::TEE).unwrap();
    for panel in pattern["pattern"]["panels"].as_object_mut().unwrap().values_mut() {
        for vertex in panel["vertices"].as_array_mut().unwrap() {
            vertex[0] = (vertex[0].as_f64().unwrap() * 0.8).into();
        }
    }
    std::fs::write(bench.path("small.json"), pattern.to_string()).unwrap();
    let output = bench.fit("small.json", "body.obj", "out", &["--resolution", "40 mm"]);
    assert_eq!(status(&output), 4, "{}", talk(&output));
    assert!(talk(&output).contains("Not ready for hand-off"));
    // What is too tight is named, with its place.
    let told = talk(&output);
    let place = told.lines().find(|line| line.starts_with("warning: panel")).expect("a panel is too tight");
    assert!(place.contains("bears, 5.0 %") && place.contains("above the floor"), "{place}");
    // And what crosses, if anything does, is in a picture.
    let written = files(&bench.path("out"));
    let report: Value = serde_json::from_slice(&written["report.json"]).unwrap();
    let crossings = &report["assessment"]["intersections"];
    let clean = crossings["body_pairs"] == 0 && crossings["cloth_pairs"] == 0;
    assert_eq!(written.contains_key("crossings.png"), !clean, "{crossings}");
    assert!(FILES.iter().all(|file| written.contains_key(*file)));
    assert!(!report["tight"].as_array().unwrap().is_empty());
}

#[test]
fn several_garments_have_a_folder_each_and_one_can_be_worn_over_what_was_fitted_before() {
    let bench = Bench::new();
    std::fs::write(bench.path("dress.json"), embedded::DRESS).unwrap();
    let [tee, dress, body, out] = ["tee.json", "dress.json", "body.obj", "out"].map(|name| bench.text(name));
    let fit = |more: &[&str]| toile(&[&["fit"], more, &["--body", &body, "--resolution", "40 mm"]].concat());
    let output = fit(&[&tee, &tee, "--out", &out, "--fabric", "cotton_jersey, wool_suiting"]);
    assert!([0, 4].contains(&status(&output)), "{}", talk(&output));
    assert!(talk(&output).contains("All together: no crossings between garments"), "{}", talk(&output));
    for folder in ["tee", "tee-2"] {
        let written = files(&bench.path("out").join(folder));
        assert!(FILES.iter().all(|file| written.contains_key(*file)), "{folder}: {:?}", written.keys());
    }
    let json = |file: &str| serde_json::from_slice::<Value>(&std::fs::read(bench.path(file)).unwrap()).unwrap();
    let outfit = json("out/outfit.json");
    assert_eq!((&outfit["format"], &outfit["garments"][1]["folder"]), (&"toile outfit".into(), &"tee-2".into()));
    assert!(bench.path("out/preview.png").exists());
    assert_eq!(json("out/tee-2/report.json")["fabric"]["name"], "wool_suiting");

    let (alone, over) = (bench.text("alone"), bench.text("over"));
    assert!([0, 4].contains(&status(&fit(&[&tee, "--out", &alone]))));
    // The same shape in another file: that it was fitted on another body is told, and no more.
    let twin = bench.text("twin.obj");
    std::fs::write(&twin, [embedded::MANNEQUIN_OBJ, &b"# again\n"[..]].concat()).unwrap();
    let output = toile(&["fit", &dress, "--over", &alone, "--out", &over, "--body", &twin, "--resolution", "40 mm"]);
    assert!([0, 4].contains(&status(&output)), "{}", talk(&output));
    assert!(talk(&output).contains("warning[TOILE-B012]: "), "{}", talk(&output));
    let report = json("over/report.json");
    let findings = report["findings"].as_array().unwrap();
    assert!(findings.iter().any(|finding| finding["code"] == "TOILE-B012"), "{findings:#?}");
    assert_eq!(report["inputs"]["body"]["wears"][0]["name"], "tee");
    assert_eq!(report["assessment"]["intersections"]["body_pairs"], 0);

    let output = fit(&[&tee, &dress, "--out", &out, "--fabric", "neutral,denim_11oz,linen"]);
    assert_eq!(status(&output), 2, "{}", talk(&output));
    assert!(talk(&output).contains("3 fabrics are listed for 2 garments"), "{}", talk(&output));
    let output = fit(&[&tee, "--over", &tee, "--out", &out]);
    assert_eq!(status(&output), 3, "{}", talk(&output));
}

/// One way to give bad input.
struct Bad {
    name: &'static str,
    pattern: String,
    body: Vec<u8>,
    status: i32,
    /// What the message must say: the place, and the remedy.
    says: &'static [&'static str],
}

fn scaled_body(scale: f64, map: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<u8> {
    let text = std::str::from_utf8(embedded::MANNEQUIN_OBJ).unwrap();
    let line = |line: &str| match line.strip_prefix("v ") {
        Some(rest) => {
            let v: Vec<f64> = rest.split_whitespace().map(|n| n.parse().unwrap()).collect();
            let [x, y, z] = map([v[0] * scale, v[1] * scale, v[2] * scale]);
            format!("v {x} {y} {z}\n")
        }
        None => format!("{line}\n"),
    };
    text.lines().map(line).collect::<String>().into_bytes()
}

fn changed(change: impl FnOnce(&mut Value)) -> String {
    let mut pattern: Value = serde_json::from_str(embedded::TEE).unwrap();
    change(&mut pattern["pattern"]);
    pattern.to_string()
}

fn first_panel(pattern: &mut Value) -> &mut Value {
    pattern["panels"].as_object_mut().unwrap().values_mut().next().unwrap()
}

fn bad_inputs() -> Vec<Bad> {
    let body = || embedded::MANNEQUIN_OBJ.to_vec();
    let bad = |name, pattern: String, body: Vec<u8>, says| Bad { name, pattern, body, status: 3, says };
    let tee = || embedded::TEE.to_owned();
    vec![
        bad("truncated JSON", embedded::TEE[..700].to_owned(), body(), &["bad.json", "line"]),
        bad(
            "NaN",
            embedded::TEE.replacen("\"translation\": [", "\"translation\": [NaN, ", 1),
            body(),
            &["bad.json", "line"],
        ),
        bad(
            "an edge to no vertex",
            changed(|p| first_panel(p)["edges"][0]["endpoints"] = serde_json::json!([0, 99])),
            body(),
            &["bad.json", "panel", "99"],
        ),
        bad(
            "a stitch to a missing panel",
            changed(|p| p["stitches"][0][0]["panel"] = "ghost".into()),
            body(),
            &["bad.json", "stitch", "ghost"],
        ),
        bad(
            "an open loop",
            changed(|p| {
                first_panel(p)["edges"].as_array_mut().unwrap().pop();
                p["stitches"] = serde_json::json!([]);
            }),
            body(),
            &["bad.json", "panel", "loop"],
        ),
        bad("an empty body", tee(), Vec::new(), &["body.obj", "empty"]),
        bad("a body in centimetres", tee(), scaled_body(100.0, |v| v), &["body.obj", "centimetres"]),
        bad(
            "an upside-down body",
            tee(),
            scaled_body(1.0, |[x, y, z]| [x, 1.7 - y, -z]),
            &["body.obj", "stands on its head"],
        ),
        bad("a body in pieces", tee(), body()[..body().len() - 400].to_vec(), &["body.obj", "closed"]),
        bad(
            "a pattern a metre away",
            changed(|p| {
                for panel in p["panels"].as_object_mut().unwrap().values_mut() {
                    panel["translation"][0] = (panel["translation"][0].as_f64().unwrap() + 100.0).into();
                }
            }),
            body(),
            &["beside the body", "place the panels"],
        ),
    ]
}

#[test]
fn bad_input_ends_in_a_message_that_names_the_place_and_the_remedy() {
    for bad in bad_inputs() {
        let bench = Bench::new();
        std::fs::write(bench.path("bad.json"), &bad.pattern).unwrap();
        std::fs::write(bench.path("body.obj"), &bad.body).unwrap();
        let output = bench.fit("bad.json", "body.obj", "out", &["--resolution", "40 mm"]);
        let talk = talk(&output);
        assert_eq!(status(&output), bad.status, "{}: {talk}", bad.name);
        assert!(!talk.contains("panicked") && talk.contains("help: "), "{}: {talk}", bad.name);
        for word in bad.says {
            assert!(talk.contains(word), "{}: the message does not say {word:?}: {talk}", bad.name);
        }
        let written = std::fs::read_dir(bench.path("out")).map_or(0, |entries| entries.count());
        assert_eq!(written, 0, "{}: files were written", bad.name);
    }
}

#[test]
fn misunderstood_options_end_with_status_2_and_show_the_right_form() {
    let bench = Bench::new();
    let cases: [(&[&str], &str); 8] = [
        (&["--resolution", "5"], "5 mm"),
        (&["--resolution", "0 mm"], "--resolution"),
        (&["--resolution", "-5 mm"], "--resolution"),
        (&["--resolution", "2 m"], "--resolution"),
        (&["--levels", "5,10 mm"], "--levels"),
        (&["--fabric", "unobtainium"], "cotton_jersey"),
        (&["--threads", "0"], "--threads"),
        (&["--until", "sunrise"], "equilibrium"),
    ];
    for (options, word) in cases {
        let output = bench.fit("tee.json", "body.obj", "out", options);
        assert_eq!(status(&output), 2, "{options:?}: {}", talk(&output));
        assert!(talk(&output).contains(word), "{options:?}: {}", talk(&output));
    }
    assert_eq!(status(&toile(&["fit"])), 2);
    assert_eq!(status(&toile(&["--help"])), 0);
}

#[test]
fn missing_files_are_named() {
    let bench = Bench::new();
    for (pattern, body, missing) in [("none.json", "body.obj", "none.json"), ("tee.json", "none.obj", "none.obj")] {
        let output = bench.fit(pattern, body, "out", &[]);
        assert_eq!(status(&output), 3);
        assert!(talk(&output).contains(missing), "{}", talk(&output));
    }
}

#[test]
fn a_check_tells_what_is_sewn_and_what_is_doubtful() {
    let bench = Bench::new();
    let output = toile(&["check", &bench.text("tee.json"), "--body", &bench.text("body.obj")]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(status(&output), 0, "{}", talk(&output));
    assert!(text.contains("6 panels") && text.contains("nothing wrong"), "{text}");
    let broken = changed(|p| p["stitches"][0][0]["panel"] = "ghost".into());
    std::fs::write(bench.path("broken.json"), broken).unwrap();
    assert_eq!(status(&toile(&["check", &bench.text("broken.json")])), 3);
}

#[test]
fn killed_at_any_moment_it_leaves_old_files_or_whole_new_ones() {
    let bench = Bench::new();
    let whole = bench.fit("tee.json", "body.obj", "out", &["--resolution", "40 mm"]);
    assert!([0, 4].contains(&status(&whole)));
    let old = files(&bench.path("out"));
    let fresh = bench.fit("tee.json", "body.obj", "other", &["--resolution", "36 mm"]);
    assert!([0, 4].contains(&status(&fresh)));
    let new = files(&bench.path("other"));
    for wait in [50, 400, 800, 1200, 1600, 2000] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_toile"))
            .args(["fit", &bench.text("tee.json"), "--body", &bench.text("body.obj")])
            .args(["--out", &bench.text("out"), "--resolution", "36 mm"])
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(wait));
        child.kill().unwrap();
        child.wait().unwrap();
        for (name, bytes) in files(&bench.path("out")).into_iter().filter(|(name, _)| FILES.contains(&name.as_str())) {
            if name == "report.json" {
                serde_json::from_slice::<Value>(&bytes).expect("a report is whole");
            } else {
                assert!(bytes == old[&name] || bytes == new[&name], "{name} is neither the old nor the new one");
            }
        }
    }
}
