//! Bodies in other units and turned otherwise are recognized and brought back; results say so.

mod support;

use nalgebra::{Matrix3, Rotation3};
use std::path::Path;
use std::process::{Command, Output};
use toile::body::{Alignment, Body};
use toile::geometry::Vector3;
use toile::io::{body_obj, embedded};

/// Bodies that stand as they should, with their names; their crotches are moved over the origin.
fn bodies() -> Vec<(String, Body)> {
    let mut files = vec![("mannequin".to_owned(), embedded::MANNEQUIN_OBJ.to_vec())];
    if let Some(data) = support::shared_data() {
        for name in ["mean_all", "mean_all_apart", "female_apose", "male_apose"] {
            files.push((name.to_owned(), std::fs::read(data.join(format!("bodies/{name}.obj"))).unwrap()));
        }
    }
    let read = |(name, bytes): (String, Vec<u8>)| {
        let body = body_obj::parse(&bytes).unwrap().0;
        (name, body)
    };
    files.into_iter().map(read).collect()
}

/// A matrix that takes y to one of the six directions of the axes.
fn standing_along(up: Vector3) -> Matrix3<f64> {
    let upside_down = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    *Rotation3::rotation_between(&Vector3::y(), &up).unwrap_or(upside_down).matrix()
}

const UNITS: [(&str, f64); 4] = [("metres", 1.0), ("centimetres", 100.0), ("millimetres", 1000.0), ("inches", 39.37)];

#[test]
fn bodies_stand_as_they_should() {
    for (name, body) in bodies() {
        let alignment = Alignment::recognize(body.positions(), body.triangles()).unwrap();
        assert!(alignment.is_identity(), "{name}: {}", alignment.describe());
    }
}

/// All ways up, straight and crooked turns, four units, near the origin and away from it.
#[test]
fn turned_scaled_and_moved_bodies_come_back() {
    for (name, body) in bodies() {
        let mut ways = 0;
        let (mut worst_turn, mut worst_place): (f64, f64) = (0.0, 0.0);
        for up in [Vector3::y(), Vector3::z(), Vector3::x(), -Vector3::y(), -Vector3::z(), -Vector3::x()] {
            for yaw in [0.0f64, 90.0, 180.0, 270.0, 33.0, 147.0, 305.0] {
                // Every combination of unit and place comes up among these, not every one for each.
                ways += 1;
                if ways % 4 != 0 {
                    continue;
                }
                let (unit, scale) = UNITS[ways / 4 % 4];
                let away = if ways / 4 % 3 == 0 { Vector3::zeros() } else { Vector3::new(0.3, -0.2, 0.7) };
                let turn = standing_along(up) * Rotation3::from_axis_angle(&Vector3::y_axis(), yaw.to_radians());
                let moved: Vec<Vector3> = body.positions().iter().map(|p| (turn * p + away) * scale).collect();
                let found = Alignment::recognize(&moved, body.triangles())
                    .unwrap_or_else(|e| panic!("{name}, up {up}, yaw {yaw}: {e}"));
                assert_eq!(found.unit, unit, "{name}: {}", found.describe());
                let whole = found.rotation * turn;
                assert!((whole.column(1) - Vector3::y()).norm() < 1e-9, "{name}: {}", found.describe());
                worst_turn = worst_turn.max(whole[(0, 2)].atan2(whole[(0, 0)]).abs().to_degrees());
                // Where a body stands from front to back is its author's choice: the same for all of its points.
                let offsets: Vec<Vector3> =
                    moved.iter().zip(body.positions()).map(|(m, p)| found.apply(*m) - p).collect();
                let mean = offsets.iter().sum::<Vector3>() / offsets.len() as f64;
                assert!(mean.x.abs() < 0.012 && mean.y.abs() < 0.012 && mean.z.abs() < 0.05, "{name}: {mean}");
                worst_place = offsets.iter().map(|o| (o - mean).norm()).fold(worst_place, f64::max);
            }
        }
        eprintln!(
            "{name}: turned by {worst_turn:.3} degrees at most, points {:.2} mm from where they were",
            worst_place * 1e3
        );
        assert!(worst_turn < 1.0 && worst_place < 0.01, "{name}: {worst_turn} degrees, {worst_place} m");
    }
}

#[test]
fn the_matrix_of_an_alignment_does_what_it_does() {
    let body = body_obj::parse(embedded::MANNEQUIN_OBJ).unwrap().0;
    let moved: Vec<Vector3> =
        body.positions().iter().map(|p| Vector3::new(p.z, p.x, p.y).add_scalar(0.4) * 100.0).collect();
    let found = Alignment::recognize(&moved, body.triangles()).unwrap();
    let matrix = found.world_from_file();
    for point in moved.iter().step_by(101) {
        let by_matrix: Vec<f64> =
            matrix.iter().map(|row| row[0] * point.x + row[1] * point.y + row[2] * point.z + row[3]).collect();
        assert!((found.apply(*point) - Vector3::from_column_slice(&by_matrix[..3])).norm() < 1e-12);
    }
    assert_eq!(matrix[3], [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn what_cannot_be_recognized_is_an_error_with_a_remedy() {
    let figure = support::bodies::Mesh::figure().body();
    let error = Alignment::recognize(figure.positions(), figure.triangles()).unwrap_err();
    assert!(error.remedy().contains("yourself"), "{error}");
    for (positions, triangles) in [
        (vec![], vec![]),
        (vec![Vector3::zeros()], vec![[0, 1, 2]]),
        (vec![Vector3::repeat(f64::NAN); 3], vec![[0, 1, 2]]),
        (vec![Vector3::repeat(1e308), Vector3::zeros(), Vector3::x()], vec![[0, 1, 2]]),
    ] {
        assert!(Alignment::recognize(&positions, &triangles).is_err());
    }
}

fn toile(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_toile")).args(arguments).current_dir(folder).output().unwrap()
}

/// The embedded body in centimetres, z up, facing -y, half a metre beside the origin.
fn elsewhere() -> String {
    let body = body_obj::parse(embedded::MANNEQUIN_OBJ).unwrap().0;
    let turned: Vec<Vector3> = body.positions().iter().map(|p| Vector3::new(p.x + 0.5, -p.z, p.y) * 100.0).collect();
    body_obj::write(&turned, body.triangles())
}

#[test]
fn a_body_from_elsewhere_is_refused_with_a_hint_and_taken_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("body.obj"), elsewhere()).unwrap();
    std::fs::write(folder.path().join("tee.json"), embedded::TEE).unwrap();
    let refused = toile(&["check", "tee.json", "--body", "body.obj"], folder.path());
    let told = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(3), "{told}");
    assert!(told.contains("--align auto") && told.contains("centimetres, +z up, facing -y"), "{told}");
    let taken = toile(&["check", "tee.json", "--body", "body.obj", "--align", "auto"], folder.path());
    let told = String::from_utf8(taken.stdout).unwrap();
    assert_eq!(taken.status.code(), Some(0), "{told}");
    assert!(told.contains("aligned: it is in centimetres, +z up, facing -y: scaled by 0.01"), "{told}");
}

/// The garment is where it would be on the body as it should stand, and the report has the way back.
#[test]
fn a_fit_on_an_aligned_body_is_the_fit_on_the_body() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("body.obj"), elsewhere()).unwrap();
    std::fs::write(folder.path().join("mannequin.obj"), embedded::MANNEQUIN_OBJ).unwrap();
    std::fs::write(folder.path().join("tee.json"), embedded::TEE).unwrap();
    let fit = |body: &str, out: &str, more: &[&str]| {
        let all = [&["fit", "tee.json", "--body", body, "--out", out, "--levels", "40 mm"], more].concat();
        let output = toile(&all, folder.path());
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(matches!(output.status.code(), Some(0 | 4)), "{told}");
        let report = std::fs::read_to_string(folder.path().join(out).join("report.json")).unwrap();
        (told, serde_json::from_str::<serde_json::Value>(&report).unwrap())
    };
    let (told, report) = fit("body.obj", "aligned", &["--align", "auto"]);
    assert!(told.contains("aligned: it is in centimetres"), "{told}");
    let alignment = &report["inputs"]["body"]["alignment"];
    assert_eq!((&alignment["unit"], &alignment["scale"]), (&"centimetres".into(), &0.01.into()));
    assert!((alignment["world_from_file"][0][3].as_f64().unwrap() + 0.5).abs() < 0.01, "{alignment}");
    let written = std::fs::read(folder.path().join("aligned/body_aligned.obj")).unwrap();
    let (low, high) = body_obj::parse(&written).unwrap().0.bounds();
    assert!(low.y.abs() < 1e-6 && (high.y - 1.72).abs() < 1e-3);

    let (_, plain) = fit("mannequin.obj", "plain", &[]);
    assert!(plain["inputs"]["body"].get("alignment").is_none());
    assert!(!folder.path().join("plain/body_aligned.obj").exists());
    // Stretch would be too much to ask: at 40 mm it is that of the four worst triangles.
    let [aligned, plain] = ["aligned", "plain"].map(|out| {
        let garment = std::fs::read_to_string(folder.path().join(out).join("garment.obj")).unwrap();
        let vertices = garment.lines().filter_map(|line| line.strip_prefix("v "));
        vertices.map(|v| Vector3::from_iterator(v.split(' ').map(|x| x.parse().unwrap()))).collect::<Vec<_>>()
    });
    assert_eq!(aligned.len(), plain.len());
    let apart = aligned.iter().zip(&plain).map(|(a, b)| (a - b).norm()).sum::<f64>() / plain.len() as f64;
    assert!(apart < 0.01, "{apart} m");
}

#[test]
fn what_is_seen_in_a_body_is_told_in_words_and_in_json() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("body.obj"), elsewhere()).unwrap();
    let words = String::from_utf8(toile(&["body", "body.obj"], folder.path()).stdout).unwrap();
    assert!(words.contains("waist") && words.contains("girths of a taut tape"), "{words}");
    let json = toile(&["body", "body.obj", "--json"], folder.path()).stdout;
    let told: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert!((told["girths_m"]["bust"].as_f64().unwrap() - 0.92).abs() < 0.02, "{told}");
    assert_eq!(told["alignment"]["up"], "+z");
    assert_eq!(told["points_m"]["shoulders"].as_array().unwrap().len(), 2);
}
