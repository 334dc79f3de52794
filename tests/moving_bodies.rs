//! Animated bodies: what is read from real files, and what is said of damaged ones.

mod support;

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use support::shared_data;
use toile::Error;
use toile::body::Motion;
use toile::geometry::Vector3;
use toile::io::moving_body::gltf::Rig;
use toile::io::moving_body::{Options, open};

fn animation(name: &str) -> Option<PathBuf> {
    shared_data().map(|data| data.join("animation").join(name))
}

fn size(motion: &Motion, k: usize) -> Vector3 {
    let (low, high) = motion.bounds(k);
    high - low
}

#[test]
fn the_walking_woman_begins_as_the_standing_one_and_stays_a_body() {
    let Some(path) = animation("walking_female.glb") else { return };
    let (motion, warnings) = open(&path, &Options::default()).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!((motion.frame_count(), motion.frame_rate(), motion.vertex_count()), (72, 24.0, 13_348));
    assert_eq!(motion.triangles().len(), 26_692);
    let (standing, _) = open(&shared_data().unwrap().join("bodies/female_apose.obj"), &Options::default()).unwrap();
    let first = motion.positions(0);
    let farthest = first.iter().zip(standing.positions(0)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(farthest < 1e-3, "{farthest}");
    let mut last = first;
    for k in 0..72 {
        let size = size(&motion, k);
        assert!((1.5..1.7).contains(&size.y) && size.x < 1.4 && size.z < 1.5, "frame {k}: {size}");
        let now = motion.positions(k);
        // Nothing of a walk is faster than 8 m/s.
        let step = now.iter().zip(&last).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(step < 8.0 / 24.0, "frame {k}: {step}");
        last = now;
    }
    assert!(motion.parts().names.iter().any(|n| n == "head") && motion.parts().of_vertex.len() == 13_348);
    for k in [0, 12, 24, 47, 71] {
        motion.body(k).unwrap();
    }
}

#[test]
fn cesium_man_is_welded_closed_and_as_tall_as_he_is() {
    let Some(path) = animation("CesiumMan.glb") else { return };
    let (motion, warnings) = open(&path, &Options::default()).unwrap();
    assert_eq!((motion.vertex_count(), motion.triangles().len()), (2338, 4672));
    assert_eq!((motion.frame_count(), motion.frame_rate()), (49, 24.0));
    assert!(warnings.len() == 1 && warnings[0].to_string().contains("do not sum to one"), "{warnings:?}");
    assert!((size(&motion, 0).y - 1.5).abs() < 0.07, "{}", size(&motion, 0));
    for k in 0..49 {
        motion.body(k).unwrap();
    }
    // The same man as text with his buffer beside him.
    let (text, _) = open(&path.with_extension("gltf"), &Options::default()).unwrap();
    for k in [0, 20, 48] {
        assert_eq!(text.positions(k), motion.positions(k));
    }
    let slow = Options { frame_rate: Some(10.0), ..Options::default() };
    assert_eq!(open(&path, &slow).unwrap().0.frame_count(), 21);
}

/// How the capture's joints are called in the woman's skeleton.
const CMU_ON_ANNY: [(&str, &str); 16] = [
    ("Hips", "root"),
    ("LeftHip", "upperleg01.L"),
    ("LeftKnee", "lowerleg01.L"),
    ("LeftAnkle", "foot.L"),
    ("RightHip", "upperleg01.R"),
    ("RightKnee", "lowerleg01.R"),
    ("RightAnkle", "foot.R"),
    ("Chest2", "spine01"),
    ("Neck", "neck01"),
    ("Head", "head"),
    ("LeftShoulder", "upperarm01.L"),
    ("LeftElbow", "lowerarm01.L"),
    ("LeftWrist", "wrist.L"),
    ("RightShoulder", "upperarm01.R"),
    ("RightElbow", "lowerarm01.R"),
    ("RightWrist", "wrist.R"),
];

#[test]
fn a_captured_walk_moves_another_body_forwards_on_the_floor() {
    let Some(path) = animation("cmu_131_02_walk_metres.bvh") else { return };
    let body = Some(animation("walking_female.glb").unwrap());
    let joints = CMU_ON_ANNY.map(|(a, b)| (a.to_owned(), b.to_owned())).to_vec();
    let options = Options { body: body.clone(), joints, frame_rate: Some(12.0), ..Options::default() };
    let (motion, warnings) = open(&path, &options).unwrap();
    assert!(warnings.len() == 1 && warnings[0].to_string().contains("LThumb"), "{warnings:?}");
    assert_eq!(motion.frame_count(), 125);
    let middle = |k: usize| (motion.bounds(k).0 + motion.bounds(k).1) * 0.5;
    let went = middle(124) - middle(0);
    let horizontal = went.x.hypot(went.z);
    assert!((1.0..8.0).contains(&horizontal), "{went}");
    for k in (0..125).step_by(4) {
        let (low, high) = motion.bounds(k);
        assert!(low.y.abs() < 0.15 && (1.4..1.75).contains(&(high.y - low.y)), "frame {k}: {low} {high}");
        motion.body(k).unwrap();
    }
    // Without the table the two skeletons have hardly a name in common.
    let alone = open(&path, &Options { body, ..Options::default() }).unwrap_err();
    assert!(alone.to_string().contains("Hips") && alone.remedy().contains("upperleg01.L"), "{alone}");
    let nobody = open(&path, &Options::default()).unwrap_err();
    assert!(nobody.remedy().contains("Name the body"), "{nobody}");
}

/// A GLB file in the making.
struct Glb {
    json: Value,
    binary: Vec<u8>,
}

impl Glb {
    fn add(&mut self, shape: &str, component: u32, count: usize, bytes: Vec<u8>) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let (offset, length) = (self.binary.len(), bytes.len());
        self.binary.extend(bytes);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        let view = views.len() - 1;
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": shape}));
        accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, shape: &str, values: &[[f32; N]]) -> usize {
        self.add(shape, 5126, values.len(), values.iter().flatten().flat_map(|f| f.to_le_bytes()).collect())
    }

    /// Two joints, one in the other, and a box of 1 m around them with corners of their own for each side; the second
    /// joint carries the top and turns about z by 90° in a second, while a morph target moves the bottom in z.
    fn bent_box() -> Self {
        let mut glb =
            Self { json: json!({"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}), binary: Vec::new() };
        let corner = |k: u8| [f32::from(k & 1), f32::from(k >> 1 & 1), f32::from(k >> 2 & 1)];
        let sides: [[u8; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let corners: Vec<[f32; 3]> = sides.iter().flatten().map(|&k| corner(k)).collect();
        let positions = glb.floats("VEC3", &corners);
        let joints = glb.add("VEC4", 5121, 24, corners.iter().flat_map(|p| [u8::from(p[1] > 0.5), 0, 0, 0]).collect());
        let weights = glb.add("VEC4", 5121, 24, corners.iter().flat_map(|_| [255, 0, 0, 0]).collect());
        glb.json["accessors"][weights]["normalized"] = json!(true);
        let indices = (0..24u16).step_by(4).flat_map(|k| [k, k + 1, k + 2, k, k + 2, k + 3]);
        let indices = glb.add("SCALAR", 5123, 36, indices.flat_map(u16::to_le_bytes).collect());
        let below: Vec<[f32; 3]> = corners.iter().map(|p| [0.0, 0.0, if p[1] < 0.5 { -0.5 } else { 0.0 }]).collect();
        let morph = glb.floats("VEC3", &below);
        let unit = |y: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., y, 0., 1.];
        let binds = glb.floats("MAT4", &[unit(0.0), unit(-1.0)]);
        let times = glb.floats("SCALAR", &[[0.0], [1.0]]);
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let turns = glb.floats("VEC4", &[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, -half, -half]]);
        let swell = glb.floats("SCALAR", &[[0.0], [1.0]]);
        glb.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights},
            "indices": indices, "targets": [{"POSITION": morph}]}]}]);
        glb.json["skins"] = json!([{"joints": [0, 1], "inverseBindMatrices": binds}]);
        glb.json["nodes"] = json!([{"name": "foot", "children": [1]}, {"name": "top", "translation": [0, 1, 0]},
            {"name": "box", "mesh": 0, "skin": 0, "translation": [9, 9, 9]}]);
        glb.json["scenes"] = json!([{"nodes": [0, 2]}]);
        glb.json["scene"] = json!(0);
        glb.json["animations"] = json!([{"name": "bend", "samplers": [{"input": times, "output": turns}, {"input": times, "output": swell}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}, {"sampler": 1, "target": {"node": 2, "path": "weights"}}]}]);
        glb
    }

    fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        self.wrapped(json.to_string().into_bytes())
    }

    fn wrapped(&self, mut json: Vec<u8>) -> Vec<u8> {
        json.resize(json.len().next_multiple_of(4), b' ');
        let length = 28 + json.len() + self.binary.len();
        let mut bytes = b"glTF".to_vec();
        [2, length, json.len()].iter().for_each(|&n| bytes.extend((n as u32).to_le_bytes()));
        bytes.extend(b"JSON");
        bytes.extend(json);
        bytes.extend((self.binary.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(&self.binary);
        bytes
    }
}

fn play(bytes: &[u8], options: &Options) -> Result<Motion, Error> {
    let mut none = |name: &str| Err(Error::new(format!("{name} is not there."), "Put it there for the test."));
    Rig::read(bytes, &options.meshes, &mut none).and_then(|rig| rig.play(options)).map(|(motion, _)| motion)
}

#[test]
fn skins_clips_and_morph_targets_move_a_box() {
    let options = Options { frame_rate: Some(2.0), ..Options::default() };
    let motion = play(&Glb::bent_box().bytes(), &options).unwrap();
    // Three copies of each corner became one.
    assert_eq!((motion.vertex_count(), motion.triangles().len(), motion.frame_count()), (8, 12, 3));
    motion.body(0).unwrap();
    let at = |k: usize, corner: [f64; 3]| {
        let v = motion.positions(0).iter().position(|p| (p - Vector3::from(corner)).norm() < 1e-6).unwrap();
        motion.positions(k)[v]
    };
    // Halfway on the shorter arc the top is turned by 45°; the bottom is moved by half the morph target.
    let half = 0.5f64.sqrt();
    assert!((at(1, [1.0, 1.0, 0.0]) - Vector3::new(half, 1.0 + half, 0.0)).norm() < 1e-6);
    assert!((at(2, [1.0, 1.0, 0.0]) - Vector3::new(0.0, 2.0, 0.0)).norm() < 1e-6);
    assert!((at(1, [1.0, 0.0, 1.0]) - Vector3::new(1.0, 0.0, 0.75)).norm() < 1e-6);
    assert_eq!(motion.parts().names, ["foot", "top"]);
}

#[test]
fn a_mesh_without_a_skin_follows_its_node() {
    let mut glb = Glb::bent_box();
    glb.json["nodes"][2] = json!({"mesh": 0, "scale": [-1, 1, 1]});
    glb.json["nodes"][1]["children"] = json!([2]);
    glb.json["scenes"] = json!([{"nodes": [0]}]);
    glb.json["animations"][0]["channels"].as_array_mut().unwrap().pop();
    let motion = play(&glb.bytes(), &Options::default()).unwrap();
    // Mirrored, one metre up; its triangles face outwards all the same.
    assert_eq!(motion.bounds(0), (Vector3::new(-1.0, 1.0, 0.0), Vector3::new(0.0, 2.0, 1.0)));
    motion.body(0).unwrap();
    assert!((motion.bounds(1).0 - Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-6, "{:?}", motion.bounds(1));
}

#[test]
fn sparse_values_replace_elements() {
    let mut glb = Glb::bent_box();
    let indices = glb.add("SCALAR", 5121, 1, vec![1]);
    let values = glb.floats("SCALAR", &[[2.0]]);
    let view = |glb: &Glb, accessor: usize| glb.json["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({"count": 1, "indices": {"bufferView": view(&glb, indices), "componentType": 5121}, "values": {"bufferView": view(&glb, values)}});
    let times = glb.json["animations"][0]["samplers"][0]["input"].as_u64().unwrap() as usize;
    glb.json["accessors"][times]["sparse"] = sparse;
    let motion = play(&glb.bytes(), &Options { frame_rate: Some(2.0), ..Options::default() }).unwrap();
    assert_eq!(motion.duration(), 2.0);
}

#[test]
fn clips_and_meshes_are_chosen_by_name_or_number() {
    let mut glb = Glb::bent_box();
    let mut again = glb.json["animations"][0].clone();
    again["name"] = json!("still");
    again["channels"].as_array_mut().unwrap().remove(0);
    glb.json["animations"].as_array_mut().unwrap().push(again);
    let chosen = |clip: &str| play(&glb.bytes(), &Options { clip: Some(clip.into()), ..Options::default() });
    let height = |motion: Motion| motion.bounds(motion.frame_count() - 1).1.y;
    assert!(height(chosen("bend").unwrap()) > 1.5 && height(chosen("0").unwrap()) > 1.5);
    assert!(height(chosen("still").unwrap()) < 1.1 && height(chosen("1").unwrap()) < 1.1);
    let error = chosen("walk").unwrap_err();
    assert!(error.problem().contains("\"walk\"") && error.remedy().contains("animation 1 \"still\""), "{error}");
    let mesh = |name: &str| play(&glb.bytes(), &Options { meshes: vec![name.into()], ..Options::default() });
    assert!(mesh("box").is_ok() && mesh("hat").unwrap_err().remedy().contains("box"));
}

/// The box with one thing changed is refused, and the message has these words.
fn refused(change: impl FnOnce(&mut Glb), words: &[&str]) {
    let mut glb = Glb::bent_box();
    change(&mut glb);
    let error = match play(&glb.bytes(), &Options::default()) {
        Ok(_) => panic!("it was taken: {words:?}"),
        Err(error) => error,
    };
    let told = format!("{error} {}", error.remedy());
    words.iter().for_each(|word| assert!(told.contains(word), "{told}"));
}

/// Overwrites element `element` of an accessor's numbers with `number`, an f32.
fn poke(glb: &mut Glb, accessor: &Value, element: usize, number: f32) {
    let view = glb.json["accessors"][accessor.as_u64().unwrap() as usize]["bufferView"].as_u64().unwrap() as usize;
    let at = glb.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize + 4 * element;
    glb.binary[at..at + 4].copy_from_slice(&number.to_le_bytes());
}

#[test]
fn damaged_animations_are_told_with_their_place() {
    let sampler = |glb: &Glb, end: &str| glb.json["animations"][0]["samplers"][0][end].clone();
    let attribute = |glb: &Glb, name: &str| glb.json["meshes"][0]["primitives"][0]["attributes"][name].clone();
    refused(
        |g| g.json["animations"][0]["samplers"][0]["output"] = json!(99),
        &["animation 0 \"bend\"", "channel 0", "accessor 99"],
    );
    refused(|g| poke(g, &sampler(g, "output"), 5, f32::NAN), &["channel 0", "element 1", "NaN"]);
    refused(|g| (4..8).for_each(|k| poke(g, &sampler(g, "output"), k, 0.0)), &["channel 0", "element 1", "zero"]);
    refused(|g| poke(g, &sampler(g, "input"), 1, -1.0), &["channel 0", "key 1", "do not ascend"]);
    refused(|g| poke(g, &sampler(g, "input"), 1, 1e30), &["frames a second"]);
    refused(
        |g| g.json["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE"),
        &["2 keys and 2 values; 6"],
    );
    refused(|g| g.json["animations"][0]["samplers"][0]["interpolation"] = json!("WAVY"), &["channel 0", "LINEAR"]);
    refused(|g| g.json["animations"][0]["channels"][0]["target"]["node"] = json!(7), &["channel 0", "node 7"]);
    refused(|g| g.json["animations"][0]["channels"][0]["sampler"] = json!(7), &["channel 0", "sampler 7"]);
    refused(|g| g.json["nodes"][1] = json!({"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,1,0,1]}), &["node 1", "matrix"]);
    refused(|g| g.json["nodes"][1]["rotation"] = json!([0, 0, 0, 0]), &["node 1 \"top\"", "quaternion"]);
    refused(
        |g| g.json["nodes"][1]["children"] = json!([0]),
        &["node 1", "ancestor"].map(|w| if w == "node 1" { "node" } else { w }),
    );
    refused(|g| g.json["nodes"][2]["children"] = json!([1]), &["node 2 \"box\"", "child of node 0"]);
    refused(|g| g.json["nodes"][2]["skin"] = json!(3), &["node 2 \"box\"", "skin 3"]);
    refused(|g| g.json["skins"][0]["joints"] = json!([0]), &["primitive 0", "joint 1", "1 joints"]);
    refused(|g| g.json["skins"][0]["joints"] = json!([0, 1, 1]), &["skin 0", "2 of them for 3 joints"]);
    refused(|g| g.json["skins"][0]["joints"] = json!([]), &["skin 0", "no joints"]);
    let zero = |g: &mut Glb| {
        let accessor = attribute(g, "WEIGHTS_0").as_u64().unwrap() as usize;
        let at =
            g.json["bufferViews"][g.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize]["byteOffset"]
                .as_u64()
                .unwrap();
        g.binary[at as usize + 20] = 0;
    };
    refused(zero, &["mesh 0, primitive 0", "Vertex 5", "sum to 0.000"]);
    refused(|g| g.json["accessors"][0]["count"] = json!(23), &["JOINTS_0", "24 vertices", "23"]);
    refused(|g| g.json["accessors"][0]["count"] = json!(u64::MAX), &["accessor 0", "more numbers"]);
    refused(|g| g.json["accessors"][0]["count"] = json!(0), &["accessor 0", "no elements"]);
    refused(|g| g.json["accessors"][0]["count"] = json!(25), &["accessor 0", "is cut"]);
    refused(|g| g.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX), &["buffer view 0", "is cut"]);
    refused(|g| g.json["bufferViews"][0]["byteStride"] = json!(8), &["buffer view 0", "8 bytes apart"]);
    refused(|g| poke(g, &attribute(g, "POSITION"), 7, f32::INFINITY), &["accessor 0", "element 2", "inf"]);
    refused(|g| poke(g, &attribute(g, "POSITION"), 7, 1e20), &["rest shape", "Vertex"]);
    refused(|g| g.json["scenes"] = json!([]), &["scene"]);
    refused(
        |g| g.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
        &["draco", "without compression"],
    );
    refused(|g| g.json["asset"]["version"] = json!("1.0"), &["glTF 1.0"]);
    refused(|g| drop(g.json.as_object_mut().unwrap().remove("meshes")), &["node 2 \"box\"", "mesh 0"]);
}

#[test]
fn containers_that_are_cut_are_told_so() {
    let glb = Glb::bent_box();
    let whole = glb.bytes();
    for length in 0..whole.len() {
        let error = play(&whole[..length], &Options::default()).unwrap_err();
        assert!(!error.remedy().is_empty());
    }
    let mut lies = whole.clone();
    lies[8..12].copy_from_slice(&3u32.to_le_bytes());
    assert!(play(&lies, &Options::default()).unwrap_err().to_string().contains("JSON"));
    let mut json = glb.json.clone();
    json["buffers"] = json!([{"byteLength": 4, "uri": "data:application/octet-stream;base64,AAA"}]);
    let text = |json: &Value| play(json.to_string().as_bytes(), &Options::default()).unwrap_err().to_string();
    assert!(text(&json).contains("buffer 0: Its data URI is damaged"));
    json["buffers"][0]["uri"] = json!("http://example.org/a.bin");
    assert!(text(&json).contains("http://example.org"));
    json["buffers"][0]["uri"] = json!("my%20body.bin");
    assert!(text(&json).contains("buffer 0: my body.bin is not there"));
}

/// Numbers that look random and are the same every time (Steele, Lea and Flood 2014).
struct Mix(u64);

impl Mix {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) % limit as u64) as usize
    }
}

/// Changes bytes of a file many times and reads it.
fn attack(bytes: &[u8], rounds: usize, read: impl Fn(&[u8]) -> Result<Motion, Error>) {
    let mut mix = Mix(1);
    let started = Instant::now();
    for _ in 0..rounds {
        let mut bytes = bytes.to_vec();
        for _ in 0..1 + mix.below(4) {
            let at = mix.below(bytes.len());
            match mix.below(5) {
                0 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][mix.below(5)],
                1 => bytes[at] ^= 1 << mix.below(8),
                2 => bytes[at] = b"0123456789-.{}[]\",e\n"[mix.below(20)],
                3 => bytes.truncate(at + 1),
                _ => {
                    let from = mix.below(bytes.len());
                    let length = mix.below(16).min(bytes.len() - from);
                    let piece = bytes[from..from + length].to_vec();
                    bytes.splice(at..at, piece);
                }
            }
        }
        match read(&bytes) {
            Ok(motion) => {
                let last = motion.positions(motion.frame_count() - 1);
                assert!(last.iter().all(|p| p.iter().all(|c| c.is_finite())));
                assert!(motion.triangles().iter().flatten().all(|&v| (v as usize) < last.len()));
            }
            Err(error) => {
                assert!(error.problem().ends_with('.') && error.remedy().len() > 10, "{error}: {}", error.remedy())
            }
        }
    }
    assert!(started.elapsed() < Duration::from_secs(60), "it took {:?}", started.elapsed());
}

#[test]
fn no_damage_to_a_gltf_file_stops_the_reader() {
    attack(&Glb::bent_box().bytes(), 4000, |bytes| play(bytes, &Options::default()));
}

#[test]
fn no_damage_to_caches_and_captures_stops_their_readers() {
    let folder = tempfile::tempdir().unwrap();
    let obj = folder.path().join("body.obj");
    std::fs::write(&obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").unwrap();
    let glb = folder.path().join("body.glb");
    std::fs::write(&glb, Glb::bent_box().bytes()).unwrap();
    let through = |name: &str, body: &Path, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        open(&path, &Options { body: Some(body.to_owned()), ..Options::default() }).map(|(motion, _)| motion)
    };
    let mut pc2 = b"POINTCACHE2\0".to_vec();
    [1i32, 4].iter().for_each(|n| pc2.extend(n.to_le_bytes()));
    [0.0f32, 1.0].iter().for_each(|n| pc2.extend(n.to_le_bytes()));
    pc2.extend(2i32.to_le_bytes());
    pc2.extend((0..24).flat_map(|k| (k as f32).to_le_bytes()));
    attack(&pc2, 700, |bytes| through("a.pc2", &obj, bytes));
    let mut mdd: Vec<u8> = [2i32, 4].iter().flat_map(|n| n.to_be_bytes()).collect();
    mdd.extend((0..26).flat_map(|k| (k as f32).to_be_bytes()));
    attack(&mdd, 700, |bytes| through("a.mdd", &obj, bytes));
    let joint = |name: &str, inner: &str| {
        format!("{name}\n{{\nOFFSET 0 -1 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n{inner}}}\n")
    };
    let foot = joint("ROOT foot", &joint("JOINT top", "End Site\n{\nOFFSET 0 -1 0\n}\n"));
    let bvh = format!("HIERARCHY\n{foot}MOTION\nFrames: 2\nFrame Time: 0.04\n0 0 0 0 0 0\n90 0 0 10 20 30\n");
    attack(bvh.as_bytes(), 700, |bytes| through("a.bvh", &glb, bytes));
}

/// A garment on the skeleton of the box, taken over in a pose that is not its bind pose, is where it was put in that pose
/// and goes along in the others.
#[test]
fn a_skinned_garment_is_where_the_fit_put_it_and_follows_the_clip() {
    use toile::io::{embedded, garmentcode, glb};
    let (pattern, _) = garmentcode::parse(embedded::TEE, "tee").unwrap();
    let garment = toile::garment::Garment::build(&pattern, &[0.04]).unwrap();
    let level = garment.levels.last().unwrap();
    let body = Glb::bent_box().bytes();
    let options = Options { frame_rate: Some(2.0), ..Options::default() };
    let read = |bytes: &[u8]| Rig::read(bytes, &[], &mut |_| unreachable!()).unwrap();
    let (skin, warnings) = read(&body).skin(&options, 1).unwrap();
    assert!(warnings.is_empty() && skin.clips.len() == 1 && skin.clips[0].channels.len() == 1);
    // A centimetre above the skin of the box, all over it.
    let on = |k: usize| {
        let t = skin.triangles[k % skin.triangles.len()].map(|v| skin.positions[v as usize]);
        let (a, b) = ((k as f64 * 0.618).fract(), (k as f64 * 0.7548).fract());
        let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
        let normal = (t[1] - t[0]).cross(&(t[2] - t[0])).normalize();
        t[0] + (t[1] - t[0]) * a + (t[2] - t[0]) * b + normal * 0.01
    };
    let positions: Vec<Vector3> = (0..level.particle_count).map(on).collect();
    let file = glb::write_skinned(&pattern, level, &positions, &skin).unwrap();
    gltf::Gltf::from_slice(&file).unwrap();
    let (motion, _) = read(&file).play(&options).unwrap();
    assert_eq!(motion.frame_count(), 3);
    assert_eq!(motion.vertex_count(), level.particle_count, "seams are welded by the reader");
    let moved: Vec<Vec<Vector3>> = (0..3).map(|k| motion.positions(k)).collect();
    let (later, _) = read(&body).skin(&options, 2).unwrap();
    let mut carried = 0;
    for (k, position) in positions.iter().enumerate() {
        let distance = |v: &usize| (moved[1][*v] - position).norm();
        let v = (0..moved[1].len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        assert!(distance(&v) < 1e-6, "{} m away", distance(&v));
        // What lies on the lid follows the second joint alone.
        let corners = skin.triangles[k % skin.triangles.len()];
        if corners.iter().all(|&v| skin.influences[v as usize] == [(1, 1.0)]) {
            let (now, then) = (&skin.carriers[1].world_from_rest, &later.carriers[1].world_from_rest);
            let rest = now.fixed_view::<3, 3>(0, 0).try_inverse().unwrap() * (position - now.column(3));
            let expected = then.fixed_view::<3, 3>(0, 0) * rest + then.column(3);
            assert!((moved[2][v] - expected).norm() < 1e-6, "{} instead of {expected}", moved[2][v]);
            carried += 1;
        }
    }
    assert!(carried > 20, "only {carried} particles lie on the lid");
    // A joint without size, and a garment elsewhere.
    let mut flat = skin.clone();
    flat.carriers.iter_mut().for_each(|c| c.world_from_rest.column_mut(1).fill(0.0));
    let error = glb::write_skinned(&pattern, level, &positions, &flat).unwrap_err();
    assert!(error.problem().contains("flatten") && error.problem().contains("\"foot\""), "{error}");
    let away: Vec<Vector3> = positions.iter().map(|p| p + Vector3::x() * 9.0).collect();
    assert!(glb::write_skinned(&pattern, level, &away, &skin).unwrap_err().problem().contains("nowhere near"));
    assert!(read(&body).skin(&options, 3).unwrap_err().problem().contains("no frame 3"));
}
