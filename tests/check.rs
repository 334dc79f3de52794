//! `toile check` as its users and their scripts see it: all findings in one pass, with codes.

mod support;

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::bodies::Mesh;
use toile::garment::Garment;
use toile::io::dxf::Options;
use toile::io::{body_obj, embedded, pattern_file, seams_toml};
use toile::{Code, Error};

fn toile(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_toile")).args(arguments).current_dir(folder).output().unwrap()
}

/// A folder with the embedded pattern and body in it.
fn bench() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tee.json"), embedded::TEE).unwrap();
    std::fs::write(folder.path().join("body.obj"), embedded::MANNEQUIN_OBJ).unwrap();
    folder
}

fn changed(change: impl FnOnce(&mut Value)) -> String {
    let mut file: Value = serde_json::from_str(embedded::TEE).unwrap();
    change(&mut file);
    file.to_string()
}

/// Checks with `--json`; the document and the status.
fn checked(folder: &Path, arguments: &[&str]) -> (Value, i32) {
    let output = toile(&[&["check", "--json"], arguments].concat(), folder);
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    (serde_json::from_slice(&output.stdout).unwrap(), output.status.code().unwrap())
}

fn codes(document: &Value) -> Vec<&str> {
    document["findings"].as_array().unwrap().iter().map(|f| f["code"].as_str().unwrap()).collect()
}

#[test]
fn the_document_tells_what_was_looked_at_and_found() {
    let folder = bench();
    let (document, status) = checked(folder.path(), &["tee.json", "--body", "body.obj"]);
    assert_eq!((status, &document["errors"]), (0, &json!(0)), "{document:#}");
    assert_eq!((&document["format"], &document["version"]), (&json!("toile check"), &json!(1)));
    assert_eq!(document["pattern"]["panels"], 6);
    assert_eq!(document["seams"].as_array().unwrap().len(), document["pattern"]["seams"].as_u64().unwrap() as usize);
    assert!(document["body"]["height_m"].as_f64().unwrap() > 1.5);
    assert!(document["pattern"]["levels"][0]["particles"].as_u64().unwrap() > 100);
    // Our own pattern on our own body.
    let serious = codes(&document).into_iter().filter(|code| *code != "TOILE-P012" && *code != "TOILE-A003");
    assert_eq!(serious.collect::<Vec<_>>(), Vec::<&str>::new(), "{document:#}");
}

#[test]
fn what_is_wrong_with_one_input_does_not_hide_what_is_wrong_with_another() {
    let folder = bench();
    let broken = changed(|file| {
        let stitches = file["pattern"]["stitches"].as_array_mut().unwrap();
        stitches[0][0]["panel"] = "ghost".into();
        stitches[1][1]["edge"] = 99.into();
        let third = stitches[2].clone();
        stitches.push(third);
        let panels = file["pattern"]["panels"].as_object_mut().unwrap();
        let panel = panels.values_mut().next().unwrap();
        // The first two corners change places: the outline crosses itself.
        panel["vertices"].as_array_mut().unwrap().swap(0, 1);
    });
    std::fs::write(folder.path().join("broken.json"), broken).unwrap();
    std::fs::write(folder.path().join("body.obj"), &embedded::MANNEQUIN_OBJ[..40_000]).unwrap();
    std::fs::write(folder.path().join("cloth.toml"), "based_on = \"linen\"\nfriction = \"high\"\n").unwrap();
    let arguments = ["broken.json", "--body", "body.obj", "--fabric", "cloth.toml"];
    let (document, status) = checked(folder.path(), &arguments);
    let found = codes(&document);
    assert_eq!(status, 3);
    for code in ["TOILE-S002", "TOILE-B001", "TOILE-F001"] {
        assert!(found.contains(&code), "no {code} among {found:?}");
    }
    assert!(found.iter().filter(|code| **code == "TOILE-S002").count() == 2, "{found:?}");
    assert!(found.iter().any(|code| code.starts_with("TOILE-P")), "{found:?}");
    let stitch = document["findings"].as_array().unwrap().iter().find(|f| f["code"] == "TOILE-S002").unwrap();
    assert_eq!((&stitch["place"]["file"], &stitch["place"]["seam"]), (&json!("broken.json"), &json!("0")));
    assert_eq!(stitch["page"], "docs/checks/TOILE-S002.md");
    assert!(document["pattern"].is_null() && document["body"].is_null());
    // In words, errors are on the error stream, each with its code.
    let words = toile(&[&["check"], &arguments[..]].concat(), folder.path());
    let told = String::from_utf8(words.stderr).unwrap();
    assert_eq!(words.status.code(), Some(3));
    assert_eq!(told.matches("error[TOILE-S002]: broken.json, stitch ").count(), 2, "{told}");
}

#[test]
fn a_fit_shows_the_same_findings_and_keeps_them() {
    let folder = bench();
    let pattern = changed(|file| file["properties"]["units_in_meter"] = Value::Null);
    std::fs::write(folder.path().join("unit.json"), pattern).unwrap();
    let fit = [
        "fit",
        "unit.json",
        "--body",
        "body.obj",
        "--out",
        "out",
        "--resolution",
        "40 mm",
        "--fabric",
        "fleece",
        "--clearance",
        "0.7 mm",
    ];
    let output = toile(&fit, folder.path());
    let told = String::from_utf8_lossy(&output.stderr);
    for code in ["warning[TOILE-P003]: ", "warning[TOILE-F003]: "] {
        assert!(told.contains(code), "{told}");
    }
    let report = std::fs::read(folder.path().join("out/report.json")).unwrap();
    let report: Value = serde_json::from_slice(&report).unwrap();
    assert!(codes(&report).contains(&"TOILE-P003") && codes(&report).contains(&"TOILE-F003"), "{}", report["findings"]);
    assert_eq!(report["findings"].as_array().unwrap().len(), report["warnings"].as_array().unwrap().len());
}

/// On the bodies that they were drawn for, real garments have gathers and short edges, and nothing worse.
#[test]
fn real_patterns_raise_no_false_alarms() {
    let Some(data) = support::shared_data() else { return };
    let bodies = |name: &str| {
        let apart = name.contains("pants") || name.contains("jumpsuit");
        data.join("bodies").join(if apart { "mean_all_apart.obj" } else { "mean_all.obj" })
    };
    let harmless = ["TOILE-P012", "TOILE-S012", "TOILE-A003", "TOILE-A004"];
    // Its fit is stretched by 7 %.
    let small = ["upstream_dress_pencil"];
    for (name, _) in support::shared_patterns() {
        let path: PathBuf = data.join("patterns/garmentcode").join(format!("{name}.json"));
        let (pattern, body) = (path.display().to_string(), bodies(&name).display().to_string());
        let (document, status) = checked(Path::new("."), &[&pattern, "--body", &body]);
        let alarms: Vec<&Value> = document["findings"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|f| !harmless.contains(&f["code"].as_str().unwrap()))
            .filter(|f| !(f["code"] == "TOILE-A007" && small.contains(&name.as_str())))
            .collect();
        assert!(status == 0 && alarms.is_empty(), "{name}: {alarms:#?}");
    }
}

/// A towel of 60 by 40 cm with one change; the codes of the errors, else of the warnings.
fn codes_of_towel(change: impl FnOnce(&mut Value)) -> Vec<&'static str> {
    let mut file = support::patterns::towel();
    change(&mut file);
    match pattern_file::open(file.to_string().as_bytes(), "towel", &Options::default()) {
        Ok((_, warnings)) => warnings.iter().filter_map(|w| w.0.code()).map(Code::id).collect(),
        Err(error) => error.each().iter().filter_map(Error::code).map(Code::id).collect(),
    }
}

fn towel_of(file: &mut Value) -> &mut Value {
    &mut file["pattern"]["panels"]["towel"]
}

#[test]
fn every_fault_of_a_pattern_has_its_code() {
    type Change = fn(&mut Value);
    let cases: [(&str, Change); 12] = [
        ("TOILE-P001", |f| f["pattern"] = Value::Null),
        ("TOILE-P002", |f| towel_of(f)["label"] = "tail".into()),
        ("TOILE-P003", |f| f["properties"]["units_in_meter"] = Value::Null),
        ("TOILE-P004", |f| towel_of(f)["vertices"][2] = json!([60_000.0, 40_000.0])),
        ("TOILE-P005", |f| f["pattern"]["panels"] = json!({" ": towel_of(f).clone()})),
        ("TOILE-P007", |f| towel_of(f)["edges"][1]["endpoints"] = json!([1, 3])),
        ("TOILE-P008", |f| towel_of(f)["vertices"].as_array_mut().unwrap().swap(0, 1)),
        ("TOILE-P010", |f| towel_of(f)["vertices"] = json!([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]])),
        ("TOILE-P015", |f| f["pattern"]["panels"] = json!({})),
        ("TOILE-S001", |f| f["pattern"]["stitches"] = json!([["right_wrong", "right_wrong"]])),
        ("TOILE-S002", |f| f["pattern"]["stitches"] = json!([[side(1), side(7)]])),
        ("TOILE-S004", |f| f["pattern"]["stitches"] = json!([[side(1)]])),
    ];
    for (code, change) in cases {
        let found = codes_of_towel(change);
        assert!(!found.is_empty() && found.iter().all(|id| *id == code), "{code}: {found:?}");
    }
    let twice = codes_of_towel(|f| f["pattern"]["stitches"] = json!([[side(0), side(1)], [side(1), side(2)]]));
    assert_eq!(twice, ["TOILE-S003"]);
    let without_length = codes_of_towel(|f| {
        let vertices = towel_of(f)["vertices"].as_array_mut().unwrap();
        vertices[1] = vertices[0].clone();
    });
    assert_eq!(without_length, ["TOILE-P009"]);
}

fn side(edge: usize) -> Value {
    json!({"panel": "towel", "edge": edge})
}

#[test]
fn what_json_cannot_say_has_its_code_as_well() {
    let (pattern, _) =
        pattern_file::open(support::patterns::towel().to_string().as_bytes(), "towel", &Options::default()).unwrap();
    let mut twin = pattern.clone();
    twin.panels.push(twin.panels[0].clone());
    assert_eq!(twin.check().unwrap_err().code(), Some(Code::NameTwice));
    let mut unusable = pattern.clone();
    unusable.panels[0].segments[0].curve.start.x = f64::NAN;
    assert_eq!(unusable.check().unwrap_err().code(), Some(Code::NumberUnusable));
    let mut large = pattern.clone();
    for segment in &mut large.panels[0].segments {
        for point in [&mut segment.curve.start, &mut segment.curve.end] {
            *point *= 10.0;
        }
    }
    assert_eq!(Garment::build(&large, &[0.0005]).unwrap_err().code(), Some(Code::TooManyParticles));
}

#[test]
fn every_fault_of_a_body_has_its_code() {
    let ball = Mesh::ball([0.0, 0.5, 0.0], 0.5, 12);
    let code = |mesh: &Mesh| match body_obj::parse(mesh.obj().as_bytes()) {
        Ok((_, warnings)) => warnings.first().and_then(|w| w.0.code()),
        Err(error) => error.code(),
    };
    assert_eq!(code(&ball), None);
    assert_eq!(code(&ball.clone().mapped(|p| p.map(|c| 100.0 * c))), Some(Code::BodyWrongSize));
    assert_eq!(code(&ball.clone().mapped(|[x, y, z]| [x, y + 1.0, z])), Some(Code::BodyOffFloor));
    assert_eq!(code(&ball.clone().mapped(|[x, y, z]| [-x, y, z])), Some(Code::BodyInsideOut));
    assert_eq!(code(&ball.clone().mapped(|[x, y, z]| [0.4 * x, 0.3 * z, -y])), Some(Code::BodyNotUpright));
    assert_eq!(code(&ball.clone().mapped(|[x, y, _]| [x, y, 0.0])), Some(Code::BodyWithoutVolume));
    let mut open = ball.clone();
    open.faces.pop();
    assert_eq!(code(&open), Some(Code::BodyOpen));
    // In centimetres and open: both are told.
    let both = body_obj::parse(open.mapped(|p| p.map(|c| 100.0 * c)).obj().as_bytes()).err().unwrap().each();
    assert_eq!(both.iter().map(Error::code).collect::<Vec<_>>(), [Some(Code::BodyWrongSize), Some(Code::BodyOpen)]);
    let mut double = ball;
    double.faces.push(double.faces[0].clone());
    assert_eq!(code(&double), Some(Code::BodyNotManifold));
}

#[test]
fn what_only_the_whole_shows_has_its_code() {
    let folder = bench();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let beside: String = std::str::from_utf8(embedded::MANNEQUIN_OBJ)
        .unwrap()
        .lines()
        .map(|line| match line.strip_prefix("v ").and_then(|rest| rest.split_once(' ')) {
            Some((x, rest)) => format!("v {} {rest}\n", x.parse::<f64>().unwrap() + 0.7),
            None => format!("{line}\n"),
        })
        .collect();
    write("beside.obj", &beside);
    write("ball.obj", &Mesh::ball([0.0, 0.5, 0.0], 0.5, 12).obj());
    write("seams.toml", "[[seam]]\nsides = [\"left_sleeve_front:0\", \"left_sleeve_back:0\"]\n");
    let found = |arguments: &[&str]| {
        let (document, _) = checked(folder.path(), &[&["tee.json"], arguments].concat());
        codes(&document).into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let cases: [(&str, &[&str]); 4] = [
        ("TOILE-B009", &["--body", "beside.obj"]),
        ("TOILE-B011", &["--body", "ball.obj"]),
        ("TOILE-S014", &["--seams", "seams.toml"]),
        ("TOILE-A006", &["--body", "body.obj", "--arrangement", "missing.toml"]),
    ];
    for (code, arguments) in cases {
        let codes = found(arguments);
        assert!(codes.iter().any(|one| one == code), "no {code} among {codes:?}");
    }
    // Both sleeves' halves sewn all around: what is told is that they are bags, once each, not at which resolution they are narrow.
    let bag = |side: &str| {
        let seam = |k| format!("[[seam]]\nsides = [\"{side}_sleeve_front:{k}\", \"{side}_sleeve_back:{}\"]\n", 3 - k);
        (0..4).map(seam).collect::<String>()
    };
    write("bags.toml", &[bag("left"), bag("right")].concat());
    let (document, status) = checked(folder.path(), &["tee.json", "--seams", "bags.toml", "--body", "body.obj"]);
    let wrong = document["findings"].as_array().unwrap().iter().filter(|f| f["severity"] == "error");
    assert_eq!((wrong.map(|f| f["code"].as_str().unwrap()).collect::<Vec<_>>(), status), (vec!["TOILE-S015"; 2], 3));
    // A towel has one edge around it: nobody can tell what it is to be worn on.
    write("towel.json", &support::patterns::towel().to_string());
    let (document, status) = checked(folder.path(), &["towel.json", "--body", "body.obj", "--place", "auto"]);
    assert_eq!((codes(&document), status), (vec!["TOILE-A005"], 0), "{document:#}");
}

#[test]
fn files_of_seams_have_codes_and_tell_all_their_faults() {
    let (pattern, _) = pattern_file::open(embedded::TEE.as_bytes(), "tee", &Options::default()).unwrap();
    let name = &pattern.panels[0].name;
    let text = format!(
        "[[seam]]\nsides = [\"ghost:1\", \"{name}:0\"]\n[[seam]]\nsides = [\"{name}:1\"]\n\
         [[seam]]\nsides = [\"{name}:2\", \"{name}:99\"]\n[[seam]]\nsides = [\"{name}:2\", \"{name}:3\"]\ndirection = \"up\"\n"
    );
    let errors = seams_toml::sew(&pattern, &text).unwrap_err().each();
    let found: Vec<_> = errors.iter().filter_map(Error::code).collect();
    assert_eq!(found, [Code::SeamUnknownEdge, Code::SeamWithoutPartner, Code::SeamUnknownEdge, Code::SeamUnusable]);
}
