//! Readers under attack: whatever stands in a file, they answer with a pattern or a body, or with an
//! error that tells its author what to do. They never panic, hang or fill the memory.

mod support;

use proptest::prelude::*;
use serde_json::{Value, json};
use std::time::{Duration, Instant};
use support::bodies::Mesh;
use support::patterns::{skirt, towel};
use toile::Error;
use toile::garment::Garment;
use toile::io::{body_obj, garmentcode};

/// The longest that a small file may take, on a busy machine.
const LONGEST: Duration = Duration::from_secs(20);

fn assert_told(error: &Error) {
    assert!(error.problem().ends_with('.') && error.remedy().len() > 10, "{error}: {}", error.remedy());
}

/// Reads and builds; tells whether the text was a pattern that can be sewn.
fn attack_pattern(text: &str) -> bool {
    let start = Instant::now();
    let built = garmentcode::parse(text, "attacked").and_then(|(pattern, warnings)| {
        warnings.iter().for_each(|w| assert_told(&w.0));
        Ok([Garment::build(&pattern, &[0.04])?, Garment::build(&pattern, &[0.06, 0.023])?])
    });
    match &built {
        Ok(garments) => {
            for level in garments.iter().flat_map(|g| g.levels.iter().chain([&g.open])) {
                level.sanity_check();
                assert!(level.rest.iter().all(|p| p.norm().is_finite()));
                assert!(level.rest_areas().iter().all(|area| *area > 0.0), "a triangle has no area");
            }
        }
        Err(error) => assert_told(error),
    }
    assert!(start.elapsed() < LONGEST, "it took {:?}", start.elapsed());
    built.is_ok()
}

fn attack_body(bytes: &[u8]) -> bool {
    let start = Instant::now();
    let read = body_obj::parse(bytes);
    match &read {
        Ok((body, warnings)) => {
            warnings.iter().for_each(|w| assert_told(&w.0));
            assert!(body.triangles().iter().flatten().all(|&v| (v as usize) < body.positions().len()));
        }
        Err(error) => assert_told(error),
    }
    assert!(start.elapsed() < LONGEST, "it took {:?}", start.elapsed());
    read.is_ok()
}

/// Stands for a word that JSON does not know, until the text is written.
const NOT_JSON: [&str; 3] = ["@NaN@", "@-Infinity@", "@1e999@"];

/// What an attacker writes in place of a value.
fn poison(kind: usize) -> Value {
    let values = [
        json!(1e308),
        json!(-1e308),
        json!(1e300),
        json!(1e15),
        json!(1e4),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(1e-9),
        json!(1e-40),
        json!(5e-324),
        json!(4_294_967_296u64),
        json!(i64::MIN),
        json!(u64::MAX),
        json!(0.5),
        json!(null),
        json!(true),
        json!("left"),
        json!([]),
        json!({}),
        json!([0.1, -2.0]),
        json!([[3, 4]]),
        json!(NOT_JSON[0]),
        json!(NOT_JSON[1]),
        json!(NOT_JSON[2]),
    ];
    values[kind % values.len()].clone()
}

/// JSON pointers to all values, parents first.
fn pointers(value: &Value, at: &str, found: &mut Vec<String>) {
    found.push(at.to_owned());
    match value {
        Value::Array(items) => items.iter().enumerate().for_each(|(k, v)| pointers(v, &format!("{at}/{k}"), found)),
        Value::Object(items) => items.iter().for_each(|(k, v)| pointers(v, &format!("{at}/{k}"), found)),
        _ => {}
    }
}

/// One attack on a document: which values, and what is done to them.
fn mutate(document: &mut Value, [what, place, other, kind]: [usize; 4]) {
    let mut all = Vec::new();
    pointers(document, "", &mut all);
    let (at, from) = (&all[place % all.len()], &all[other % all.len()]);
    let elsewhere = document.pointer(from).cloned().unwrap_or(Value::Null);
    let Some(value) = document.pointer_mut(at) else { return };
    match (what % 7, value) {
        (0 | 1, value) => *value = poison(kind),
        (2, value) => *value = elsewhere,
        (3, Value::Array(items)) if !items.is_empty() => drop(items.remove(kind % items.len())),
        (4, Value::Array(items)) if !items.is_empty() => items.push(items[kind % items.len()].clone()),
        (5, Value::Array(items)) if !items.is_empty() => {
            let (i, j) = (kind % items.len(), other % items.len());
            items.swap(i, j);
        }
        (6, Value::Object(items)) if !items.is_empty() => {
            let key = items.keys().nth(kind % items.len()).cloned().unwrap_or_default();
            items.remove(&key);
        }
        (_, Value::Number(number)) => {
            let factor = [-1.0, 0.0, 1.001, 1e-3, 1e3, 30.0][kind % 6];
            *number = serde_json::Number::from_f64(number.as_f64().unwrap_or(0.0) * factor).unwrap_or(0.into());
        }
        (_, value) => *value = poison(kind),
    }
}

fn text_of(document: &Value) -> String {
    let text = document.to_string();
    NOT_JSON.iter().fold(text, |text, word| text.replace(&format!("\"{word}\""), word.trim_matches('@')))
}

fn attacks() -> impl Strategy<Value = Vec<[usize; 4]>> {
    prop::collection::vec(prop::array::uniform4(any::<u16>().prop_map(usize::from)), 1..5)
}

#[test]
fn the_unharmed_files_are_read() {
    assert!(attack_pattern(&skirt(60.0, 50.0).to_string()));
    assert!(attack_pattern(&towel().to_string()));
    assert!(attack_body(Mesh::figure().obj().as_bytes()));
}

proptest! {
    #![proptest_config(ProptestConfig { max_shrink_iters: 2000, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_a_pattern_or_an_error(text in "\\PC{0,200}") {
        attack_pattern(&text);
        attack_pattern(&format!("{{\"pattern\": {text}"));
    }

    #[test]
    fn any_bytes_are_a_body_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        attack_body(&bytes);
    }

    #[test]
    fn a_tampered_pattern_is_sewn_or_refused(attacks in attacks(), width in 1.0..90.0f64, height in 1.0..90.0f64) {
        let mut document = skirt(width, height);
        attacks.iter().for_each(|&attack| mutate(&mut document, attack));
        attack_pattern(&text_of(&document));
    }

    #[test]
    fn moved_corners_make_a_pattern_or_an_error(moves in prop::collection::vec((0..15usize, -30.0..60.0f64, -30.0..60.0f64), 1..4)) {
        let mut document = skirt(40.0, 40.0);
        for (k, x, y) in moves {
            let panel = ["front", "back", "belt"][k % 3];
            let vertices = document["pattern"]["panels"][panel]["vertices"].as_array_mut().unwrap();
            let count = vertices.len();
            vertices[k % count] = json!([x, y]);
        }
        attack_pattern(&document.to_string());
    }

    #[test]
    fn bent_curves_make_a_pattern_or_an_error(curves in prop::collection::vec((0..4usize, prop::array::uniform4(-3.0..3.0f64)), 1..4)) {
        let mut document = skirt(40.0, 40.0);
        for (edge, [p, q, r, s]) in curves {
            document["pattern"]["panels"]["front"]["edges"][edge]["curvature"] = match edge {
                0 => json!({"type": "circle", "params": [40.0 * p, f64::from(r > 0.0), f64::from(s > 0.0)]}),
                1 => json!({"type": "quadratic", "params": [[p, q]]}),
                _ => json!({"type": "cubic", "params": [[p, q], [r, s]]}),
            };
        }
        attack_pattern(&document.to_string());
    }

    #[test]
    fn a_tampered_text_is_a_pattern_or_an_error(cut in any::<prop::sample::Index>(), from in any::<prop::sample::Index>(), length in 1..60usize) {
        let text = skirt(50.0, 40.0).to_string();
        let (cut, from) = (cut.index(text.len()), from.index(text.len()));
        let slice = &text[from..text.len().min(from + length)];
        attack_pattern(&text[..cut]);
        attack_pattern(&format!("{}{slice}{}", &text[..cut], &text[cut..]));
        attack_pattern(&format!("{}{}", &text[..cut], &text[text.len().min(cut + length)..]));
    }

    #[test]
    fn a_tampered_body_is_dressed_or_refused(edits in prop::collection::vec((any::<prop::sample::Index>(), 0..40usize), 1..4)) {
        const LINES: [&str; 24] = [
            "", "v nan 0 0", "v 1e999 0 0", "v 1e300 1 1", "v 1 2", "v", "f", "f 1", "f 1 2", "f 1 1 1", "f 0 1 2",
            "f -1 -2 -3", "f -1 -2 -9999", "f 1/1/1/1 2 3", "f 1//1 2//1 3//1", "f 99999999999999999999 1 2",
            "f 4294967297 1 2", "f -9223372036854775808 1 2", "f 9223372036854775807 1 2", "g skin", "usemtl red",
            "mtllib none.mtl", "f 1/-9 2/-9 3/-9", "\u{0} \u{fffd}",
        ];
        let mut lines: Vec<String> = Mesh::figure().obj().lines().map(str::to_owned).collect();
        for (place, kind) in edits {
            let at = place.index(lines.len());
            match kind {
                24..30 if lines.len() == 1 => {}
                0..24 => lines[at] = LINES[kind].to_owned(),
                24..30 => drop(lines.remove(at)),
                30..36 => lines.insert(at, lines[at].clone()),
                _ => drop(lines.split_off(at.max(1))),
            }
        }
        attack_body(lines.join("\n").as_bytes());
    }
}

/// The text must be refused, with these words in place, problem and remedy.
fn assert_refused(read: Result<(), Error>, [place, problem, remedy]: [&str; 3]) {
    let error = read.expect_err("it was taken");
    assert_told(&error);
    for (text, words) in [(error.place().as_str(), place), (error.problem(), problem), (error.remedy(), remedy)] {
        assert!(
            text.contains(words),
            "\"{words}\" is missing in: {} | {} | {}",
            error.place(),
            error.problem(),
            error.remedy()
        );
    }
}

fn assert_pattern_refused(text: &str, words: [&str; 3]) {
    assert_refused(garmentcode::parse(text, "bad").map(drop), words);
}

/// The towel with one value changed.
fn assert_towel_refused(pointer: &str, value: Value, words: [&str; 3]) {
    let mut document = towel();
    *document.pointer_mut(pointer).expect("the towel has such a value") = value;
    assert_pattern_refused(&text_of(&document), words);
}

const TOWEL: &str = "/pattern/panels/towel";

#[test]
fn a_truncated_file_is_said_to_end_early() {
    let text = towel().to_string();
    assert_pattern_refused(&text[..text.len() / 2], ["", "cannot be read", "ends too early"]);
    assert_pattern_refused("", ["", "cannot be read", "ends too early"]);
}

#[test]
fn not_a_number_is_said_to_be_no_json() {
    assert_towel_refused(
        &format!("{TOWEL}/vertices/1/0"),
        json!("@NaN@"),
        ["", "line 1 column", "NaN and Infinity are not JSON"],
    );
}

#[test]
fn an_edge_to_a_missing_vertex_is_named() {
    let place = "panel \"towel\", edge 2";
    assert_towel_refused(
        &format!("{TOWEL}/edges/2/endpoints/1"),
        json!(9),
        [place, "vertex 9", "4 vertices, counted from 0"],
    );
    assert_towel_refused(&format!("{TOWEL}/edges/2/endpoints/1"), json!(-1), [place, "vertex -1", "counted from 0"]);
}

#[test]
fn a_stitch_to_nothing_is_named() {
    let side = |panel: &str, edge: i64| json!({"panel": panel, "edge": edge});
    let stitches = |b: Value| json!([[side("towel", 0), b]]);
    assert_towel_refused(
        "/pattern/stitches",
        stitches(side("sleeve", 0)),
        ["stitch 0", "panel \"sleeve\"", "spelling"],
    );
    assert_towel_refused("/pattern/stitches", stitches(side("towel", 4)), ["stitch 0", "edge 4", "4 edges"]);
    assert_towel_refused("/pattern/stitches", stitches(side("towel", 0)), ["stitch 0", "already sewn", "once"]);
    assert_towel_refused("/pattern/stitches", json!([[side("towel", 0)]]), ["stitch 0", "1 sides", "two edges"]);
}

#[test]
fn an_open_outline_is_named_by_its_gap() {
    assert_towel_refused(
        &format!("{TOWEL}/edges/2/endpoints"),
        json!([1, 3]),
        ["panel \"towel\"", "edge 1 ends at vertex 2", "order of the loop"],
    );
}

#[test]
fn an_outline_that_crosses_itself_is_named_by_its_edges() {
    assert_towel_refused(
        &format!("{TOWEL}/vertices"),
        json!([[0, 0], [60, 0], [0, 40], [60, 40]]),
        ["panel \"towel\"", "Edges 1 and 3 cross", "without crossing itself"],
    );
}

#[test]
fn a_pattern_in_another_unit_is_told_so() {
    assert_towel_refused(
        "/properties/units_in_meter",
        json!(1),
        ["panel \"towel\"", "m from the origin", "units_in_meter"],
    );
    assert_towel_refused("/properties/units_in_meter", json!(0), ["", "`units_in_meter` is 0", "100 for centimetres"]);
    assert_towel_refused("/properties/units_in_meter", json!(1e7), ["panel \"towel\"", "no length", ""]);
}

/// Measuring such a curve to a nanometre went on for ever.
#[test]
fn a_curve_of_a_light_year_is_refused_at_once() {
    for size in [1e4, 1e9, 1e17, 1e150, 1e300, 1e308] {
        let start = Instant::now();
        let curve = json!({"type": "cubic", "params": [[0.3, size], [-size, 0.7]]});
        assert_towel_refused(
            &format!("{TOWEL}/edges/0"),
            json!({"endpoints": [0, 1], "curvature": curve}),
            ["panel \"towel\"", "", ""],
        );
        assert!(start.elapsed() < Duration::from_secs(1));
    }
}

#[test]
fn an_outline_of_a_million_edges_is_refused() {
    let count = 1_000_000;
    let mut document = towel();
    let edge = |k: usize| json!({"endpoints": [k, (k + 1) % count]});
    let turn = |k: usize| (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
    document["pattern"]["panels"]["towel"]["vertices"] =
        (0..count).map(|k| json!([30.0 * turn(k).0, 30.0 * turn(k).1])).collect();
    document["pattern"]["panels"]["towel"]["edges"] = (0..count).map(edge).collect();
    assert_pattern_refused(&document.to_string(), ["", "1000000 edges", "damaged"]);
}

#[test]
fn a_panel_of_too_many_particles_is_refused_by_name() {
    let mut document = towel();
    document["pattern"]["panels"]["towel"]["vertices"] = json!([[0, 0], [1500, 0], [1500, 900], [0, 900]]);
    let (pattern, _) = garmentcode::parse(&document.to_string(), "tent").unwrap();
    let built = Garment::build(&pattern, &[0.04, 0.002]);
    assert_refused(built.map(drop), ["panel \"towel\"", "million particles", "coarser resolution"]);
}

/// The bins that once told how near a lattice point is to the rim filled the whole box of the panel.
#[test]
fn a_narrow_panel_drawn_aslant_takes_no_memory_for_its_empty_box() {
    let mut document = towel();
    document["pattern"]["panels"]["towel"]["vertices"] = json!([[0, 0], [1000, 1000], [999, 1001], [-1, 1]]);
    let (pattern, _) = garmentcode::parse(&document.to_string(), "ribbon").unwrap();
    let start = Instant::now();
    let garment = Garment::build(&pattern, &[0.002]).unwrap();
    assert!(garment.levels[0].particle_count > 50_000);
    assert!(start.elapsed() < LONGEST);
}

fn assert_body_refused(text: &str, words: [&str; 3]) {
    assert_refused(body_obj::parse(text.as_bytes()).map(drop), words);
}

#[test]
fn an_empty_body_file_is_told_so() {
    assert_body_refused("", ["", "empty", "OBJ file"]);
    assert_body_refused(" \r\n\n", ["", "empty", "OBJ file"]);
    assert_body_refused("# nothing\no body\n", ["", "no triangles", "closed triangle mesh"]);
}

#[test]
fn a_body_in_another_unit_is_told_which() {
    let scaled = |by: f64| Mesh::figure().mapped(|v| v.map(|c| c * by)).obj();
    assert_body_refused(&scaled(100.0), ["", "m tall", "centimetres"]);
    assert_body_refused(&scaled(1000.0), ["", "m tall", "millimetres"]);
    assert_body_refused(&scaled(1.0 / 0.0254), ["", "m tall", "inches"]);
}

#[test]
fn a_body_that_is_turned_is_told_how() {
    let upside_down = Mesh::figure().mapped(|[x, y, z]| [x, 1.75 - y, -z]);
    assert_body_refused(&upside_down.obj(), ["", "on its head", "feet are at y = 0"]);
    let z_up = Mesh::figure().mapped(|[x, y, z]| [0.5 * x, -0.5 * z, y]);
    assert_body_refused(&z_up.obj(), ["", "along z", "y is up"]);
}

#[test]
fn a_body_that_is_inside_out_or_open_is_told_so() {
    let mut body = Mesh::figure();
    body.faces.iter_mut().for_each(|f| f.reverse());
    assert_body_refused(&body.obj(), ["", "inside out", "Flip the normals"]);
    let mut body = Mesh::figure();
    body.faces.pop();
    assert_body_refused(&body.obj(), ["", "not closed", "Close the holes"]);
}

#[test]
fn a_bad_line_of_a_body_is_named() {
    let text = Mesh::figure().obj();
    assert_body_refused(&text.replacen("v ", "v nan ", 1), ["line 3", "has nan", "plain numbers"]);
    assert_body_refused(&format!("{text}f 0 1 2"), ["line", "\"0\"", "counted from 1"]);
    assert_body_refused(&format!("{text}f 1 2 99999"), ["line", "vertex 99999", "counted from 1"]);
}

/// All edges overlap in x, so that the sweep that looks for crossings can rule out none of them early.
#[test]
fn a_comb_of_a_thousand_bent_teeth_does_not_hang() {
    let mut document = towel();
    let teeth = 499;
    let mut vertices: Vec<Value> =
        (0..=2 * teeth).map(|k| json!([if k % 2 == 0 { 0.0 } else { 50.0 }, 0.2 * f64::from(k)])).collect();
    vertices.push(json!([-10.0, 0.1 * f64::from(teeth)]));
    let count = vertices.len();
    let curve = json!({"type": "cubic", "params": [[0.3, 0.0005], [0.6, -0.0005]]});
    let edge = |k: usize| match k + 2 < count {
        true => json!({"endpoints": [k, k + 1], "curvature": curve}),
        false => json!({"endpoints": [k, (k + 1) % count]}),
    };
    document["pattern"]["panels"]["towel"]["edges"] = (0..count).map(edge).collect();
    document["pattern"]["panels"]["towel"]["vertices"] = vertices.into();
    let panel = document["pattern"]["panels"]["towel"].clone();
    for k in 1..5 {
        document["pattern"]["panels"][format!("comb {k}")] = panel.clone();
    }
    assert!(attack_pattern(&document.to_string()));
}
