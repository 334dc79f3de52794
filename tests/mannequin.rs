//! What a body for dressing must be: closed, simple, well shaped, and as large as the tape measure says.

#[allow(dead_code)]
#[path = "../examples/write_mannequin.rs"]
mod write_mannequin;

use toile::body::Body;
use toile::body::mannequin::{Measurements, Mesh, sculpt, stations, tape};
use toile::geometry::{Vector3, triangles_intersect};
use toile::io::{body_obj, embedded};

/// Allowed error of a girth, as a part of it.
const GIRTH_TOLERANCE: f64 = 0.02;

fn small() -> Measurements {
    Measurements {
        height: 1.60,
        chin_height: 1.39,
        neck_height: 1.37,
        neck_base_height: 1.34,
        shoulder_height: 1.31,
        bust_height: 1.15,
        underbust_height: 1.08,
        waist_height: 1.00,
        hip_height: 0.82,
        crotch_height: 0.74,
        knee_height: 0.44,
        calf_height: 0.32,
        bust_girth: 0.82,
        underbust_girth: 0.70,
        waist_girth: 0.64,
        hip_girth: 0.88,
        thigh_girth: 0.50,
        arm_length: 0.53,
        shoulder_width: 0.35,
        ..Measurements::default()
    }
}

fn large() -> Measurements {
    Measurements {
        bust_girth: 1.06,
        underbust_girth: 0.90,
        waist_girth: 0.88,
        hip_girth: 1.12,
        thigh_girth: 0.60,
        upper_arm_girth: 0.32,
        leg_spread_degrees: 9.0,
        ..Measurements::default()
    }
}

fn figures() -> [(Measurements, Mesh); 3] {
    [Measurements::default(), small(), large()].map(|measurements| {
        let mesh = sculpt(&measurements).unwrap();
        (measurements, mesh)
    })
}

#[test]
fn the_file_holds_what_the_generator_writes() {
    /// Half of the last printed digit, and what rounding to binary adds, m.
    const PRINTED: f64 = 0.501e-6;
    let mesh = sculpt(&Measurements::default()).unwrap();
    let (body, warnings) = body_obj::parse(embedded::MANNEQUIN_OBJ).unwrap();
    assert_eq!(warnings, []);
    assert_eq!(body.positions().len(), mesh.positions.len());
    assert_eq!(body.triangles().len(), mesh.triangles.len());
    // corner by corner, since the reader numbers vertices anew
    for (k, t) in mesh.triangles.iter().enumerate() {
        let expected = corners(&mesh, t);
        for (read, written) in body.corners(k as u32).iter().zip(&expected) {
            assert!((read - written).amax() < PRINTED, "triangle {k}: {read} instead of {written}");
        }
    }
    let lines = |text: &str| text.lines().take(3).map(String::from).collect::<Vec<_>>();
    let committed = std::str::from_utf8(embedded::MANNEQUIN_OBJ).unwrap();
    assert_eq!(lines(committed), lines(&write_mannequin::obj(&mesh)), "the remarks at the head differ");
}

#[test]
fn the_readme_of_the_data_states_the_measurements() {
    let readme = include_str!("../data/README.md");
    for field in format!("{:#?}", Measurements::default()).lines() {
        if let Some((name, value)) = field.trim().trim_end_matches(',').split_once(": ") {
            assert!(readme.contains(&format!("| `{name}` | {value} |")), "{name} is {value}");
        }
    }
}

#[test]
fn every_figure_is_a_body_of_one_piece_without_handles() {
    for (measurements, mesh) in figures() {
        // Body::new checks that the surface is closed, manifold, outward and upright.
        let body = Body::mannequin(&measurements).unwrap();
        assert_eq!(body.positions().len(), mesh.positions.len());
        // Every triangle has three sides, every edge two triangles: V - E + F = V - F / 2.
        assert_eq!(mesh.positions.len(), 2 + mesh.triangles.len() / 2, "Euler characteristic is not 2");
        assert_eq!(piece_count(&mesh), 1);
    }
}

#[test]
fn the_surface_does_not_cut_itself() {
    for (measurements, mesh) in figures() {
        let body = Body::mannequin(&measurements).unwrap();
        for (index, t) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = corners(&mesh, t);
            body.for_each_meeting(a.inf(&b).inf(&c), a.sup(&b).sup(&c), |k| {
                let other = mesh.triangles[k as usize];
                let apart = k as usize <= index || t.iter().any(|v| other.contains(v));
                let cut = !apart && triangles_intersect([a, b, c], corners(&mesh, &other));
                assert!(!cut, "triangles {t:?} and {other:?} cut each other");
            });
        }
    }
}

#[test]
fn the_surface_holds_the_volume_of_a_woman() {
    let mesh = sculpt(&Measurements::default()).unwrap();
    let volume: f64 = mesh.triangles.iter().map(|t| six_volumes(&mesh, t)).sum::<f64>() / 6.0;
    assert!((0.060..0.070).contains(&volume), "{volume} m³");
}

#[test]
fn triangles_are_of_the_promised_number_and_shape() {
    let mesh = sculpt(&Measurements::default()).unwrap();
    assert!((10_000..=20_000).contains(&mesh.triangles.len()), "{} triangles", mesh.triangles.len());
    let sharpest = mesh.triangles.iter().map(|t| smallest_angle(&mesh, t)).fold(f64::INFINITY, f64::min);
    assert!(sharpest > 10.0, "smallest angle {sharpest} degrees");
}

#[test]
fn the_figure_stands_on_the_floor_and_is_as_tall_as_stated() {
    for (measurements, mesh) in figures() {
        let heights = || mesh.positions.iter().map(|p| p.y);
        assert_eq!(heights().fold(f64::INFINITY, f64::min), 0.0);
        let highest = heights().fold(f64::NEG_INFINITY, f64::max);
        assert!((highest - measurements.height).abs() < 0.002, "{highest} m");
    }
}

#[test]
fn left_and_right_are_mirror_images_to_the_last_bit() {
    let mesh = sculpt(&Measurements::default()).unwrap();
    let key = |p: &Vector3, sign: f64| (p.y.to_bits(), p.z.to_bits(), (sign * p.x + 0.0).to_bits());
    let mut left: Vec<_> = mesh.positions.iter().filter(|p| p.x > 0.0).map(|p| key(p, 1.0)).collect();
    let mut right: Vec<_> = mesh.positions.iter().filter(|p| p.x < 0.0).map(|p| key(p, -1.0)).collect();
    left.sort_unstable();
    right.sort_unstable();
    assert_eq!(left, right);
}

#[test]
fn the_same_measurements_give_the_same_bytes() {
    let bits = |mesh: &Mesh| mesh.positions.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits).collect::<Vec<_>>();
    let [one, other] = [(); 2].map(|_| sculpt(&Measurements::default()).unwrap());
    assert_eq!(bits(&one), bits(&other));
    assert_eq!(one.triangles, other.triangles);
}

/// Measured another way than the module itself does: by Cauchy's formula, the perimeter of a convex set is the
/// integral of its width over half a turn.
#[test]
fn every_girth_comes_out_as_stated() {
    for (measurements, mesh) in figures() {
        for station in stations(&measurements) {
            let girth = girth_by_widths(&mesh, &station.origin, &station.normal, station.girth);
            let error = girth / station.girth - 1.0;
            assert!(error.abs() < GIRTH_TOLERANCE, "{}: {girth} m instead of {} m", station.name, station.girth);
            let by_tape = tape::girth(&mesh, &station.origin, &station.normal);
            assert!((by_tape / girth - 1.0).abs() < 1e-3, "{}: the two ways of measuring differ", station.name);
        }
    }
}

#[test]
fn arms_keep_clear_of_the_torso_and_legs_of_each_other() {
    /// m; a garment needs room for two layers of cloth and its clearance.
    const GAP: f64 = 0.02;
    for (measurements, mesh) in figures() {
        let upper_arm = stations(&measurements).into_iter().find(|station| station.name == "upper arm").unwrap();
        let along = |p: &Vector3| (p - upper_arm.origin).dot(&upper_arm.normal);
        let off_axis = |p: &Vector3| (p - upper_arm.origin).cross(&upper_arm.normal).norm();
        // from the middle of the upper arm to the finger tips
        let arm: Vec<_> = mesh.positions.iter().filter(|p| along(p) > 0.02 && off_axis(p) < 0.12).collect();
        let torso = mesh.positions.iter().filter(|p| p.x >= 0.0 && along(p) < -0.03 || off_axis(p) > 0.12);
        let nearest = torso.flat_map(|a| arm.iter().map(move |b| (*b - a).norm())).fold(f64::INFINITY, f64::min);
        assert!(nearest > GAP, "arm and torso come within {nearest} m");

        let below_crotch = measurements.crotch_height - 0.06;
        let legs = mesh.positions.iter().filter(|p| p.y < below_crotch).map(|p| p.x.abs());
        let gap = 2.0 * legs.fold(f64::INFINITY, f64::min);
        assert!(gap > GAP, "the legs come within {gap} m");
    }
}

#[test]
fn the_wrist_lies_an_arm_length_from_the_shoulder_point() {
    for (measurements, _) in figures() {
        let wrist = stations(&measurements).into_iter().find(|station| station.name == "wrist").unwrap().origin;
        let shoulder = Vector3::new(0.5 * measurements.shoulder_width, measurements.shoulder_height, wrist.z);
        assert!(((wrist - shoulder).norm() - measurements.arm_length).abs() < 0.002);
    }
}

#[test]
fn impossible_measurements_are_named() {
    let problem = |measurements: &Measurements| match Body::mannequin(measurements) {
        Err(error) => error.problem().to_owned(),
        Ok(_) => panic!("{measurements:?} were accepted"),
    };
    let default = Measurements::default;
    assert!(problem(&Measurements { waist_height: 0.5, ..default() }).contains("waist_height"));
    assert!(problem(&Measurements { wrist_girth: f64::NAN, ..default() }).contains("wrist_girth"));
    assert!(problem(&Measurements { arm_angle_degrees: 90.0, ..default() }).contains("arm_angle_degrees"));
    assert!(problem(&Measurements { foot_length: 1e300, ..default() }).contains("foot_length"));
    assert!(problem(&Measurements { height: 172.0, ..default() }).contains("height"));
    assert_eq!(default().check(), Ok(()));
}

fn corners(mesh: &Mesh, t: &[u32; 3]) -> [Vector3; 3] {
    t.map(|vertex| mesh.positions[vertex as usize])
}

fn six_volumes(mesh: &Mesh, t: &[u32; 3]) -> f64 {
    let [a, b, c] = corners(mesh, t);
    a.dot(&b.cross(&c))
}

fn smallest_angle(mesh: &Mesh, t: &[u32; 3]) -> f64 {
    let [a, b, c] = corners(mesh, t);
    let angle = |p: Vector3, q: Vector3, r: Vector3| (q - p).angle(&(r - p)).to_degrees();
    angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b))
}

fn piece_count(mesh: &Mesh) -> usize {
    let mut sets = toile::geometry::UnionFind::new(mesh.positions.len());
    for &[a, b, c] in &mesh.triangles {
        sets.union(a, b);
        sets.union(b, c);
    }
    (0..mesh.positions.len() as u32).filter(|&v| sets.find(v) == v).count()
}

fn girth_by_widths(mesh: &Mesh, origin: &Vector3, normal: &Vector3, expected: f64) -> f64 {
    const DIRECTION_COUNT: usize = 720;
    /// The section reaches at most this many times the radius of a circle of that girth; other limbs lie beyond.
    const REACH: f64 = 1.25;
    /// m; shins and wrists lie this far off the straight axis of their limb, at most, and the neck off its plumb line.
    const LIMB_BEND: f64 = 0.025;
    const NECK_BEND: f64 = 0.012;
    let u = normal.cross(&Vector3::z()).normalize();
    let v = normal.cross(&u);
    let on_limb = origin.x > 0.0;
    let reach = REACH * expected / std::f64::consts::TAU + if on_limb { LIMB_BEND } else { NECK_BEND };
    let mut points: Vec<[f64; 2]> = Vec::new();
    for t in &mesh.triangles {
        let [a, b, c] = corners(mesh, t);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (hp, hq) = ((p - origin).dot(normal), (q - origin).dot(normal));
            if (hp >= 0.0) != (hq >= 0.0) {
                let crossing = p + (q - p) * (hp / (hp - hq)) - origin;
                if crossing.norm() < reach && (!on_limb || (origin + crossing).x > 0.0) {
                    points.push([crossing.dot(&u), crossing.dot(&v)]);
                }
            }
        }
    }
    let width = |k: usize| {
        let (sin, cos) = (std::f64::consts::PI * k as f64 / DIRECTION_COUNT as f64).sin_cos();
        let shadow = points.iter().map(|p| p[0] * cos + p[1] * sin);
        let (low, high) = shadow.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| (l.min(s), h.max(s)));
        high - low
    };
    (0..DIRECTION_COUNT).map(width).sum::<f64>() * std::f64::consts::PI / DIRECTION_COUNT as f64
}
