use super::shading::{material, smooth_normals};
use super::*;
use crate::io::sample::two_panels;

#[test]
fn another_reader_finds_the_garment() {
    let (pattern, garment, positions) = two_panels();
    let level = &garment.levels[1];
    let file = write(&pattern, level, &positions);
    assert_eq!(file.len() % 4, 0);
    // Reading validates the document against the specification.
    let gltf = gltf::Gltf::from_slice(&file).unwrap();
    let blob = gltf.blob.as_deref().unwrap();
    assert_eq!(gltf.nodes().count(), 2);
    for (k, node) in gltf.nodes().enumerate() {
        let (panel, range) = (&pattern.panels[k], &level.panels[k]);
        assert_eq!(node.name(), Some(panel.name.as_str()));
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        assert!(primitive.material().double_sided());
        let reader = primitive.reader(|_| Some(blob));
        let read: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
        let points: Vec<usize> = range.points.clone().collect();
        assert_eq!(read.len(), points.len());
        for (place, &point) in read.iter().zip(&points) {
            assert_eq!(*place, <[f32; 3]>::from(positions[level.particle_of[point] as usize].map(narrow)));
        }
        for (rest, &point) in reader.read_tex_coords(0).unwrap().into_f32().zip(&points) {
            assert_eq!(rest, <[f32; 2]>::from(level.rest[point].map(narrow)));
        }
        let outward = panel.outward_normal();
        for normal in reader.read_normals().unwrap() {
            assert!((Vector3::from(normal.map(f64::from)) - outward).norm() < 1e-6);
        }
        let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(corners.len(), 3 * range.triangles.len());
        assert!(corners.iter().all(|&c| (c as usize) < points.len()));
        let bounds = primitive.bounding_box();
        assert!(read.iter().all(|p| (0..3).all(|k| bounds.min[k] <= p[k] && p[k] <= bounds.max[k])));
    }
}

#[test]
fn normals_are_smooth_across_a_seam() {
    let (_, garment, mut positions) = two_panels();
    let level = &garment.levels[1];
    // Folded along the seam at x = 0.2 m by a right angle.
    for p in &mut positions {
        if p.x > 0.2 + 1e-9 {
            *p = Vector3::new(0.2, p.y, p.z - (p.x - 0.2));
        }
    }
    let normals = smooth_normals(level, &positions);
    let inside = level.seams[0][0][1..level.seams[0][0].len() - 1].iter();
    for &point in inside {
        let normal = normals[level.particle_of[point as usize] as usize];
        assert!((normal - Vector3::new(-1.0, 0.0, -1.0).normalize()).norm() < 1e-12, "{normal}");
    }
}

#[test]
fn what_is_not_finite_does_not_spoil_the_file() {
    let (pattern, garment, mut positions) = two_panels();
    positions[3] = Vector3::new(f64::NAN, f64::INFINITY, 1e300);
    gltf::Gltf::from_slice(&write(&pattern, &garment.levels[1], &positions)).unwrap();
}

#[test]
fn another_reader_finds_every_frame_at_its_time() {
    let (pattern, garment, positions) = two_panels();
    let level = &garment.levels[1];
    let moved = |k: usize| positions.iter().map(|p| p + Vector3::new(0.1, p.x, 0.0) * (k * k) as f64).collect();
    let mut motion = Sequence { frame_rate: 24.0, frames: (0..4).map(moved).collect() };
    let file = write_frames(&pattern, level, &mut motion).unwrap();
    let gltf = gltf::Gltf::from_slice(&file).unwrap();
    let blob = gltf.blob.as_deref().unwrap();
    let animation = gltf.animations().next().unwrap();
    assert_eq!(animation.channels().count(), 2);
    for channel in animation.channels() {
        let reader = channel.reader(|_| Some(blob));
        let times: Vec<f32> = reader.read_inputs().unwrap().collect();
        assert_eq!(times, [0.0, 1.0 / 24.0, 2.0 / 24.0, 3.0 / 24.0]);
        let gltf::animation::util::ReadOutputs::MorphTargetWeights(weights) = reader.read_outputs().unwrap() else {
            panic!("the animation is not of morph targets")
        };
        let weights: Vec<f32> = weights.into_f32().collect();
        let node = channel.target().node();
        let range = &level.panels[node.index()];
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(blob));
        let base: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
        let targets: Vec<Vec<[f32; 3]>> =
            reader.read_morph_targets().map(|(positions, ..)| positions.unwrap().collect()).collect();
        for (frame, weights) in weights.chunks(3).enumerate() {
            for (k, point) in range.points.clone().enumerate() {
                let mut place = Vector3::from(base[k].map(f64::from));
                for (target, &weight) in targets.iter().zip(weights) {
                    place += Vector3::from(target[k].map(f64::from)) * f64::from(weight);
                }
                let expected = motion.frames[frame][level.particle_of[point] as usize];
                assert!((place - expected).norm() < 2e-7, "frame {frame}: {place} {expected}");
            }
        }
    }
}

#[test]
fn a_motion_too_long_for_a_viewer_is_refused_before_it_is_read() {
    struct Endless;
    impl Frames for Endless {
        fn frame_rate(&self) -> f64 {
            24.0
        }
        fn frame_count(&self) -> usize {
            usize::MAX
        }
        fn read(&mut self, _: usize, _: &mut Vec<Vector3>) -> Result<(), Error> {
            panic!("it is read")
        }
    }
    let (pattern, garment, _) = two_panels();
    let error = write_frames(&pattern, &garment.levels[1], &mut Endless).unwrap_err();
    assert!(error.remedy().contains("--frames"));
}

#[test]
fn a_garment_without_triangles_is_an_empty_file_that_reads() {
    let (pattern, mut garment, positions) = two_panels();
    garment.levels[1].panels.iter_mut().for_each(|panel| panel.triangles = 0..0);
    let gltf = gltf::Gltf::from_slice(&write(&pattern, &garment.levels[1], &positions)).unwrap();
    assert_eq!(gltf.nodes().count(), 0);
    assert!(gltf.blob.is_none());
}

#[test]
fn colors_of_many_panels_differ() {
    let colors: Vec<_> = (0..36).map(|k| material("", k).pbr_metallic_roughness.base_color_factor.0).collect();
    for (k, color) in colors.iter().enumerate() {
        assert!(!colors[..k].contains(color));
    }
}
