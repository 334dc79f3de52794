//! Patterns of other programs, read from real files and compared with what is known of them.

mod support;

use serde_json::Value;
use std::path::PathBuf;
use support::shared_data;
use toile::io::dxf::Options;
use toile::io::{garmentcode, pattern_file, toile_pattern};
use toile::pattern::{NotchKind, Panel, Pattern};

/// Areas and perimeters of the same piece from two files differ by no more than this share.
const SAME: f64 = 0.002;

fn folder(name: &str) -> Vec<PathBuf> {
    let Some(data) = shared_data() else { return vec![] };
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(data.join("patterns").join(name)).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn all_files() -> Vec<PathBuf> {
    ["garmentcode", "dxf", "freesewing"].into_iter().flat_map(folder).collect()
}

fn stem(path: &std::path::Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

/// The pattern and its warnings in words.
fn read(path: &std::path::Path) -> (Pattern, Vec<String>) {
    let bytes = std::fs::read(path).unwrap();
    let (pattern, warnings) = pattern_file::open(&bytes, &stem(path), &Options::default())
        .unwrap_or_else(|e| panic!("{}: {e} {}", path.display(), e.remedy()));
    (pattern, warnings.iter().map(ToString::to_string).collect())
}

fn read_shared(name: &str) -> Option<(Pattern, Vec<String>)> {
    shared_data().map(|data| read(&data.join("patterns").join(name)))
}

fn panel<'p>(pattern: &'p Pattern, name: &str) -> &'p Panel {
    let names = || pattern.panels.iter().map(|p| p.name.as_str()).collect::<Vec<_>>();
    pattern.panels.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("{name} is not in {:?}", names()))
}

fn assert_same(what: &str, a: &Panel, b: &Panel) {
    let (areas, lengths) = ((a.signed_area().abs(), b.signed_area().abs()), (a.perimeter(), b.perimeter()));
    let apart = |(a, b): (f64, f64)| (a / b - 1.0).abs();
    eprintln!("{what}: area {:+.5}, perimeter {:+.5}", areas.0 / areas.1 - 1.0, lengths.0 / lengths.1 - 1.0);
    assert!(apart(areas) < SAME && apart(lengths) < SAME, "{what}: areas {areas:?}, perimeters {lengths:?}");
}

#[test]
fn every_shared_pattern_is_read_and_survives_our_own_format_to_the_last_bit() {
    for path in all_files() {
        let (pattern, _) = read(&path);
        assert!(!pattern.panels.is_empty());
        for text in [toile_pattern::write_json(&pattern), toile_pattern::write_toml(&pattern)] {
            let (again, warnings) = pattern_file::open(text.as_bytes(), "another", &Options::default()).unwrap();
            assert!(again == pattern && warnings.is_empty(), "{}", path.display());
        }
    }
}

#[test]
fn drawings_have_their_right_side_up_and_their_grainline_upright() {
    for path in folder("dxf").into_iter().chain(folder("freesewing")) {
        for panel in &read(&path).0.panels {
            assert!(panel.signed_area() > 0.0 && panel.placement.is_none());
            let Some([a, b]) = panel.markings.grainline else { continue };
            assert!((a.x - b.x).abs() < 1e-4 * (b - a).norm(), "{} {}", path.display(), panel.name);
        }
    }
}

#[test]
fn the_tee_as_dxf_is_the_tee_of_garmentcode_panel_by_panel() {
    let Some((dxf, warnings)) = read_shared("dxf/gc_tee_aama_clo_mm.dxf") else { return };
    let (tee, _) = read_shared("garmentcode/tee.json").unwrap();
    assert_eq!((dxf.panels.len(), dxf.name.as_str()), (8, "TEE"));
    assert!(warnings.iter().any(|w| w.contains("millimetres")), "{warnings:?}");
    for b in &tee.panels {
        let a = panel(&dxf, &b.name.to_uppercase());
        assert_same(&a.name, a, b);
    }
}

/// Panels of a DXF file and those of the draft that it was made of.
fn compare(dxf: &str, draft: &str, panels: &[(&str, &str)]) -> Option<(Pattern, Pattern)> {
    let (a, _) = read_shared(&format!("dxf/{dxf}.dxf"))?;
    let (b, _) = read_shared(&format!("freesewing/{draft}.json"))?;
    assert_eq!(a.panels.len(), panels.len(), "{:?}", a.panels.iter().map(|p| &p.name).collect::<Vec<_>>());
    for (of_dxf, of_draft) in panels {
        let (p, q) = (panel(&a, of_dxf), panel(&b, of_draft));
        assert_same(&format!("{dxf} {of_dxf}"), p, q);
        assert_eq!(p.markings.notches.len(), q.markings.notches.len(), "{of_dxf}");
        let kinds = |p: &Panel| p.markings.notches.iter().filter(|n| n.kind == NotchKind::Double).count();
        assert_eq!(kinds(p), kinds(q), "{of_dxf}");
    }
    Some((a, b))
}

#[test]
fn sew_lines_of_the_t_shirt_are_those_of_its_draft() {
    let panels = [
        ("TEAGAN FRONT", "front"),
        ("TEAGAN BACK", "back"),
        ("TEAGAN SLEEVE", "sleeve"),
        ("TEAGAN SLEEVE (mirrored)", "sleeve (mirrored)"),
    ];
    let Some((dxf, draft)) = compare("teagan_aama_accumark_mm", "teagan_cisFemaleAdult34", &panels) else { return };
    // Unfolded: hem, two sides, two armholes, two shoulders, neck.
    assert_eq!(panel(&draft, "front").segments.len(), 8);
    assert_eq!(panel(&dxf, "TEAGAN FRONT").segments.len(), 8);
    // A sleeve: hem, two seams, cap.
    assert_eq!(panel(&draft, "sleeve").segments.len(), 4);
    assert_eq!(panel(&dxf, "TEAGAN SLEEVE").segments.len(), 4);
}

#[test]
fn sew_lines_of_the_body_block_are_those_of_its_draft() {
    let panels = [
        ("BRIAN BACK", "back"),
        ("BRIAN FRONT", "front"),
        ("BRIAN SLEEVE", "sleeve"),
        ("BRIAN SLEEVE (mirrored)", "sleeve (mirrored)"),
    ];
    compare("brian_aama_accumark_mm", "brian_cisMaleAdult40", &panels);
}

#[test]
fn sew_lines_of_the_skirt_in_inches_are_those_of_its_draft() {
    let panels = [
        ("PENELOPE BACK", "back"),
        ("PENELOPE BACK (mirrored)", "back (mirrored)"),
        ("PENELOPE FRONT", "front"),
        ("PENELOPE WAISTBAND", "waistband"),
    ];
    compare("penelope_astm_accumark_inch", "penelope_cisFemaleAdult34", &panels);
}

#[test]
fn sew_lines_of_the_trousers_are_those_of_their_draft() {
    let panels = [
        ("BACK", "back"),
        ("BACK (mirrored)", "back (mirrored)"),
        ("FRONT", "front"),
        ("FRONT (mirrored)", "front (mirrored)"),
    ];
    compare("titan_aama_clo_mm", "titan_cisMaleAdult40", &panels);
}

#[test]
fn the_svg_of_a_draft_gives_the_panels_of_its_dump() {
    for path in folder("freesewing").iter().filter(|path| path.extension().is_some_and(|e| e == "json")) {
        let ((dump, _), (svg, _)) = (read(path), read(&path.with_extension("svg")));
        let names = |p: &Pattern| p.panels.iter().map(|p| p.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&dump), names(&svg), "{}", path.display());
        for (a, b) in svg.panels.iter().zip(&dump.panels) {
            let at = format!("{} {}", stem(path), a.name);
            assert_same(&at, a, b);
            assert_eq!(a.segments.len(), b.segments.len(), "{at}");
            assert_eq!(a.markings.notches.len(), b.markings.notches.len(), "{at}");
            for (n, m) in a.markings.notches.iter().zip(&b.markings.notches) {
                assert!(n.segment == m.segment && n.kind == m.kind && (n.fraction - m.fraction).abs() < 1e-3, "{at}");
            }
            assert_eq!(a.fabric, b.fabric, "{at}");
            assert_eq!(a.markings.grainline.is_some(), b.markings.grainline.is_some(), "{at}");
        }
    }
}

#[test]
fn drafts_have_the_lengths_that_the_program_measured() {
    for path in folder("freesewing").iter().filter(|path| path.extension().is_some_and(|e| e == "json")) {
        let dump: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let (pattern, _) = read(path);
        for part in dump["parts"].as_array().unwrap() {
            let name = part["name"].as_str().unwrap().rsplit('.').next().unwrap();
            let seam = part["paths"]
                .as_array()
                .unwrap()
                .iter()
                .find(|p| ["seam", "pocket", "outline"].contains(&p["name"].as_str().unwrap()));
            let length = seam.unwrap()["length_mm"].as_f64().unwrap() / 1000.0;
            let measured = panel(&pattern, name).perimeter();
            // Of a half the whole is more than its outline and less than twice that.
            let half = part["cut"]["cutOnFold"].is_array();
            let fits =
                if half { (1.0..2.0).contains(&(measured / length)) } else { (measured / length - 1.0).abs() < 1e-3 };
            assert!(fits, "{name}: {measured} m, not {length}");
        }
    }
}

#[test]
fn a_unit_that_is_given_is_taken() {
    let Some(data) = shared_data() else { return };
    let bytes = std::fs::read(data.join("patterns/dxf/clo-box.dxf")).unwrap();
    let open = |unit: Option<&str>| {
        let unit = unit.map(|u| toile::io::length::Unit::named(u).unwrap());
        let options = Options { unit, ..Options::default() };
        pattern_file::open(&bytes, "box", &options)
    };
    // The box of CLO is 3 m by 2 m, in inches.
    let (guessed, warnings) = open(None).unwrap();
    assert!((guessed.panels[0].signed_area() - 6.0).abs() < 1e-3);
    assert!(warnings[0].0.problem().contains("inches"), "{}", warnings[0]);
    let (given, _) = open(Some("cm")).unwrap();
    assert!((given.panels[0].signed_area() * 2.54 * 2.54 - 6.0).abs() < 1e-3);
    assert!(open(Some("m")).is_err(), "a panel of a hundred metres is refused");
}

#[test]
fn garmentcode_through_the_door_is_what_its_reader_reads() {
    for (name, text) in support::shared_patterns() {
        let through = pattern_file::open(text.as_bytes(), &name, &Options::default()).unwrap();
        assert!(through == garmentcode::parse(&text, &name).unwrap());
    }
}
