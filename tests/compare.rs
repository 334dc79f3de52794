//! `toile compare` as researchers see it: files, figures that are the same again, messages.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};
use toile::io::embedded;

const FILES: [&str; 5] = ["comparison.json", "comparison.md", "energy.svg", "residual.svg", "strain.svg"];

fn toile(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_toile")).current_dir(folder).args(arguments).output().unwrap()
}

fn talk(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with the embedded pattern and body in it.
fn bench() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tee.json"), embedded::TEE).unwrap();
    std::fs::write(folder.path().join("body.obj"), embedded::MANNEQUIN_OBJ).unwrap();
    folder
}

fn compare(folder: &Path, out: &str, more: &[&str]) -> Output {
    let mut arguments = vec!["compare", "tee.json", "--body", "body.obj", "--out", out, "--progress", "none"];
    arguments.extend(more);
    toile(folder, &arguments)
}

fn files(folder: &Path) -> Vec<String> {
    let entries =
        std::fs::read_dir(folder).map(|entries| entries.map(|e| e.unwrap().file_name().into_string().unwrap()));
    let mut names: Vec<String> = entries.map(|names| names.collect()).unwrap_or_default();
    names.sort();
    names
}

fn json(folder: &Path, out: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join(out).join("comparison.json")).unwrap()).unwrap()
}

#[test]
fn the_schedule_and_its_rivals_are_measured_on_the_same_problem() {
    let bench = bench();
    let more = [
        "--levels",
        "44,26 mm",
        "--cap",
        "120",
        "--rivals",
        "conjugate-gradient,dynamic-relaxation,lbfgs,argmin-lbfgs",
    ];
    let output = compare(bench.path(), "out", &more);
    assert!([0, 4].contains(&output.status.code().unwrap()), "{}", talk(&output));
    assert_eq!(files(&bench.path().join("out")), FILES);
    let read = json(bench.path(), "out");
    let runs = read["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 5);
    for (k, run) in runs.iter().enumerate() {
        let levels = run["levels"].as_array().unwrap();
        assert_eq!((levels.len(), run["schedule"].as_bool().unwrap()), if k == 0 { (2, true) } else { (1, false) });
        let particles = |level: &Value| level["particles"].as_f64().unwrap();
        let finest = levels.last().unwrap();
        assert_eq!(particles(finest), particles(runs[0]["levels"].as_array().unwrap().last().unwrap()));
        let weighed = |part: &Value| part["evaluations"].as_f64().unwrap() * particles(part) / particles(finest);
        let sum: f64 = levels.iter().map(weighed).sum::<f64>() + weighed(&run["sewing"]);
        assert!((run["fine_equivalent"].as_f64().unwrap() / sum - 1.0).abs() < 1e-9);
        // The cap is the rivals'. The end of the level, which clears the body in rounds of 15, may go on for a few.
        assert!(k == 0 || finest["evaluations"].as_u64().unwrap() <= 120 + 360);
        assert!(run["curve"]["energy_j"].as_array().unwrap().len() > 5);
        assert!(!run["strain"]["p99"].as_array().unwrap().is_empty());
        assert!(run["end"]["energy_gap_j"].as_f64().unwrap() >= 0.0);
        let asks_for_curvatures = run["minimizer"] == "conjugate-gradient" || run["minimizer"] == "newton";
        let [evaluations, curvatures] = ["evaluations", "curvatures"].map(|key| run["sewing"][key].as_u64().unwrap());
        assert_eq!(2 * curvatures > evaluations, asks_for_curvatures);
    }
    both_lines_are_told(&read);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(table.lines().count(), 2 + 5);
    assert!(std::fs::read_to_string(bench.path().join("out/comparison.md")).unwrap().ends_with(&table));
}

/// The finish lines of the hand-off are what the curves say that they are, and ratios are those to the schedule.
fn both_lines_are_told(read: &Value) {
    let line = &read["finish_line"];
    let most = line["settled_energy_j"].as_f64().unwrap();
    assert_eq!((&line["allowance_m"], &line["residual_weights"]), (&0.0005.into(), &Value::Null));
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let runs = read["runs"].as_array().unwrap();
    let schedule = &runs[0];
    let allowed = 0.0005 * number(&read["weight_n"]);
    assert!((number(&schedule["end"]["energy_j"]) + allowed - most).abs() < 1e-12);
    assert_eq!(schedule["end"]["above_schedule_m"], 0.0);
    for (run, times) in runs.iter().zip(read["times"]["runs"].as_array().unwrap()) {
        let strain = &run["strain"];
        let column = |name: &str| strain[name].as_array().unwrap().clone();
        let within: Vec<bool> = column("within_limits").iter().map(|w| w.as_bool().unwrap()).collect();
        let low: Vec<bool> = column("energy_j").iter().map(|e| number(e) <= most).collect();
        let settled: Vec<bool> = within.iter().zip(&low).map(|(&within, &low)| within && low).collect();
        assert_eq!(column("settled"), settled.iter().map(|&s| Value::from(s)).collect::<Vec<_>>());
        for (name, met) in [("strain", &within), ("settled", &settled)] {
            let reached = &run["reached"][name];
            let first = met.iter().position(|&met| met).map(|k| strain["fine_equivalent"][k].clone());
            assert_eq!(reached["fine_equivalent"], first.unwrap_or(Value::Null));
            if !reached.is_null() && !schedule["reached"][name].is_null() {
                let ratio = number(&reached["fine_equivalent"]) / number(&schedule["reached"][name]["fine_equivalent"]);
                assert!((number(&reached["ratio"]) - ratio).abs() < 1e-9);
            }
            assert_eq!(times["reached"][name].is_null(), reached.is_null());
        }
        assert!(run["reached"]["equilibrium"].is_null());
    }
    // It ends with friction, whose energy is no longer that of sliding cloth.
    assert_eq!(schedule["strain"]["energy_j"].as_array().unwrap().last(), Some(&Value::Null));
}

#[test]
fn whoever_settles_needs_not_go_on() {
    let bench = bench();
    let run = |out: &str, more: &[&str]| {
        let usual = ["--levels", "44 mm", "--cap", "2000", "--rivals", "conjugate-gradient", "--allowance"];
        let output = compare(bench.path(), out, &[&usual[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", talk(&output));
        json(bench.path(), out)
    };
    // On one level alone the schedule is its own rival, so that both settle at the same evaluation.
    let read = run("out", &["0.5 mm"]);
    let runs = read["runs"].as_array().unwrap();
    let settled = |k: usize| &runs[k]["reached"]["settled"];
    assert_eq!(settled(0)["fine_equivalent"], settled(1)["fine_equivalent"]);
    assert_eq!(settled(1)["ratio"], 1.0);
    let looks = |run: &Value| run["strain"]["evaluations"].as_array().unwrap().len();
    assert!(looks(&runs[1]) < looks(&runs[0]));
    let generous = run("generous", &["90 mm"]);
    let sooner = &generous["runs"][1]["reached"];
    assert!(sooner["settled"]["evaluations"].as_u64() <= settled(1)["evaluations"].as_u64());
    assert_eq!(sooner["settled"]["evaluations"], sooner["strain"]["evaluations"]);
}

#[test]
fn all_but_the_times_is_the_same_on_any_number_of_threads_and_is_drawn_again_alike() {
    let bench = bench();
    let run = |out: &str, threads: &str| {
        let more = ["--levels", "44 mm", "--cap", "80", "--rivals", "lbfgs,dynamic-relaxation", "--threads", threads];
        let output = compare(bench.path(), out, &[&more[..], &["--seed", "7", "--perturb", "2 mm"]].concat());
        assert!([0, 4].contains(&output.status.code().unwrap()), "{}", talk(&output));
        let mut read = json(bench.path(), out);
        read.as_object_mut().unwrap().remove("times").expect("what varies stands in `times`");
        (read, output.stdout)
    };
    let ((one, table), (two, _)) = (run("one", "1"), run("two", "2"));
    assert_eq!(one.to_string(), two.to_string());
    assert_eq!(one["perturbation"]["amplitude_m"], 0.002);

    let read = |name: &str| std::fs::read(bench.path().join("one").join(name)).unwrap();
    let before = FILES.map(read);
    for name in &FILES[1..] {
        std::fs::write(bench.path().join("one").join(name), "old").unwrap();
    }
    let again = toile(bench.path(), &["compare", "--replot", "one"]);
    assert_eq!(again.status.code(), Some(0), "{}", talk(&again));
    assert_eq!(again.stdout, table);
    assert!(before == FILES.map(read));
}

#[test]
fn the_equilibrium_is_a_finish_line_too() {
    let bench = bench();
    let more = [
        "--levels",
        "44 mm",
        "--until",
        "equilibrium",
        "--residual",
        "5",
        "--rivals",
        "none",
        "--minimizer",
        "lbfgs,conjugate-gradient",
    ];
    let output = compare(bench.path(), "out", &more);
    assert_eq!(output.status.code(), Some(0), "{}", talk(&output));
    let read = json(bench.path(), "out");
    assert_eq!(
        (&read["finish_line"]["residual_weights"], &read["finish_line"]["strain_p99"]),
        (&5.0.into(), &Value::Null)
    );
    for run in read["runs"].as_array().unwrap() {
        assert!(run["reached"]["equilibrium"]["fine_equivalent"].as_f64().unwrap() > 100.0);
        assert!(run["reached"]["strain"].is_null() && run["reached"]["settled"].is_null());
        assert!(run["end"]["residual_weights"].as_f64().unwrap() <= 5.0);
    }
}

#[test]
fn slips_are_told_with_the_right_form_and_write_nothing() {
    let bench = bench();
    let cases: [(&[&str], &str); 9] = [
        (&["--rivals", "lbgfs"], "Did you mean `lbfgs`?"),
        (&["--rivals", "simplex"], "conjugate-gradient"),
        (&["--minimizer", "none"], "--minimizer"),
        (&["--cap", "0"], "--cap"),
        (&["--residual", "-1"], "--residual"),
        (&["--allowance", "-1 mm"], "--allowance"),
        (&["--allowance", "1 m"], "100 mm"),
        (&["--seed", "1", "--perturb", "5 cm"], "10 mm"),
        (&["--perturb", "1 mm"], "--seed"),
    ];
    for (options, word) in cases {
        let output = compare(bench.path(), "out", options);
        assert_eq!(output.status.code(), Some(2), "{options:?}: {}", talk(&output));
        assert!(talk(&output).contains(word), "{options:?}: {}", talk(&output));
        assert!(files(&bench.path().join("out")).is_empty());
    }
    assert_eq!(toile(bench.path(), &["compare", "tee.json"]).status.code(), Some(2));
}

#[test]
fn a_comparison_that_is_missing_or_corrupt_is_named() {
    let bench = bench();
    let missing = toile(bench.path(), &["compare", "--replot", "nowhere"]);
    assert_eq!(missing.status.code(), Some(3));
    assert!(talk(&missing).contains("nowhere/comparison.json"), "{}", talk(&missing));
    std::fs::create_dir(bench.path().join("bad")).unwrap();
    std::fs::write(bench.path().join("bad/comparison.json"), "{\"format\": \"toile comparison\", \"version\": 2,")
        .unwrap();
    let corrupt = toile(bench.path(), &["compare", "--replot", "bad"]);
    assert_eq!(corrupt.status.code(), Some(3));
    assert!(talk(&corrupt).contains("bad/comparison.json") && talk(&corrupt).contains("help: "), "{}", talk(&corrupt));
    assert_eq!(files(&bench.path().join("bad")), ["comparison.json"]);
}
