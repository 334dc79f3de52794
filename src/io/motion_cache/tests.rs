use super::header::*;
use super::*;
use crate::geometry::Vector3;
use crate::io::export::Frames;
use proptest::prelude::*;
use std::path::{Path, PathBuf};

const PARTICLES: usize = 3;

fn header(precision: Precision) -> MotionHeader {
    MotionHeader { precision, particle_count: PARTICLES, frame_rate: 23.976, state_sha256: [7; 32] }
}

fn frame(k: usize) -> Vec<Vector3> {
    (0..PARTICLES).map(|i| Vector3::new(0.1 * k as f64, i as f64 / 3.0, -1e-9)).collect()
}

/// A file of some frames, and where it is.
fn written(precision: Precision, frames: usize) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motion.toile");
    let mut writer = MotionWriter::create(&path, header(precision)).unwrap();
    (0..frames).for_each(|k| writer.append(&frame(k)).unwrap());
    writer.finish().unwrap();
    (folder, path)
}

fn read_all(path: &Path) -> Vec<Vec<Vector3>> {
    let mut reader = MotionReader::open(path).unwrap();
    let mut read = |k| {
        let mut positions = Vec::new();
        reader.read(k, &mut positions).map(|()| positions).unwrap()
    };
    (0..MotionReader::open(path).unwrap().frame_count()).map(&mut read).collect()
}

#[test]
fn frames_read_back_the_same_in_any_order() {
    let (_folder, path) = written(Precision::Double, 5);
    assert_eq!(read_all(&path), (0..5).map(frame).collect::<Vec<_>>());
    let mut reader = MotionReader::open(&path).unwrap();
    let mut positions = Vec::new();
    for k in [4, 0, 2] {
        reader.read(k, &mut positions).unwrap();
        assert_eq!(positions, frame(k));
    }
    assert_eq!((reader.frame_rate(), reader.header()), (23.976, &header(Precision::Double)));
    let (_folder, path) = written(Precision::Single, 2);
    assert!(read_all(&path)[1].iter().zip(frame(1)).all(|(a, b)| (a - b).norm() < 1e-7));
}

#[test]
fn a_killed_run_leaves_its_whole_frames_and_goes_on_after_them_to_the_same_bytes() {
    let (_folder, whole) = written(Precision::Double, 6);
    let expected = std::fs::read(&whole).unwrap();
    let record = header(Precision::Double).record_bytes();
    for kept in [HEADER_BYTES, HEADER_BYTES + 1, HEADER_BYTES + 3 * record, HEADER_BYTES + 4 * record - 1] {
        let (_folder, path) = written(Precision::Double, 0);
        std::fs::write(&path, &expected[..kept]).unwrap();
        let reader = MotionReader::open(&path).unwrap();
        let frames = (kept - HEADER_BYTES) / record;
        assert_eq!(reader.frame_count(), frames);
        assert_eq!(reader.unfinished_bytes() as usize, kept - HEADER_BYTES - frames * record);
        let mut writer = MotionWriter::resume(&path, &header(Precision::Double)).unwrap();
        (writer.frame_count()..6).for_each(|k| writer.append(&frame(k)).unwrap());
        assert!(std::fs::read(&path).unwrap() == expected, "after {kept} bytes");
    }
}

#[test]
fn a_run_goes_on_before_a_frame_that_never_reached_the_disk() {
    let (_folder, path) = written(Precision::Double, 4);
    let mut bytes = std::fs::read(&path).unwrap();
    let record = header(Precision::Double).record_bytes();
    bytes[HEADER_BYTES + 2 * record..HEADER_BYTES + 3 * record].fill(0);
    std::fs::write(&path, &bytes).unwrap();
    let error = MotionReader::open(&path).unwrap().read(2, &mut Vec::new()).unwrap_err();
    assert!(error.place().contains("frame 2") && error.problem().contains("checksum"), "{error}");
    assert_eq!(MotionWriter::resume(&path, &header(Precision::Double)).unwrap().frame_count(), 2);
}

#[test]
fn another_garment_is_not_gone_on_with() {
    let (_folder, path) = written(Precision::Double, 1);
    let other = MotionHeader { state_sha256: [8; 32], ..header(Precision::Double) };
    assert!(MotionWriter::resume(&path, &other).unwrap_err().problem().contains("another state"));
    assert!(MotionWriter::resume(&path, &header(Precision::Single)).is_err());
    assert_eq!(read_all(&path).len(), 1);
}

#[test]
fn errors_tell_what_is_wrong_with_the_file() {
    let (folder, path) = written(Precision::Double, 1);
    let bytes = std::fs::read(&path).unwrap();
    let problem = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        MotionReader::open(&path).unwrap_err().problem().to_owned()
    };
    assert!(problem(b"").contains("not a motion"));
    assert!(problem(b"TOILE\0\r\n").contains("not a motion"));
    assert!(problem(&bytes[..20]).contains("header"));
    let changed = |at: usize, value: u8| {
        let mut changed = bytes.clone();
        changed[at] = value;
        changed
    };
    assert!(problem(&changed(8, 2)).contains("version 2"));
    assert!(problem(&changed(40, 2)).contains("checksum"));
    // Forged, with checksums that fit: sizes that no memory holds, rates that are no numbers.
    let forged = |header: MotionHeader| header.bytes();
    let sound = header(Precision::Double);
    assert!(problem(&forged(MotionHeader { particle_count: usize::MAX, ..sound })).contains("particles"));
    assert!(problem(&forged(MotionHeader { frame_rate: f64::NAN, ..sound })).contains("frames a second"));
    let mut nan = frame(0);
    nan[1].z = f64::NAN;
    std::fs::write(&path, [&sound.bytes()[..], &sound.record(0, &nan)].concat()).unwrap();
    let error = MotionReader::open(&path).unwrap().read(0, &mut Vec::new()).unwrap_err();
    assert!(error.problem().contains("not finite"));
    assert!(MotionReader::open(folder.path()).is_err());
    assert!(MotionReader::open(&folder.path().join("none")).unwrap_err().problem().contains("no such file"));
}

proptest! {
    #[test]
    fn any_damage_is_told_or_leaves_the_frames_as_they_were(at in any::<prop::sample::Index>(), change in 1u8..) {
        let (_folder, path) = written(Precision::Single, 3);
        let frames = read_all(&path);
        let mut bytes = std::fs::read(&path).unwrap();
        let at = at.index(bytes.len());
        bytes[at] ^= change;
        std::fs::write(&path, &bytes).unwrap();
        let Ok(mut reader) = MotionReader::open(&path) else { return Ok(()) };
        let mut wrong = 0;
        for (k, frame) in frames.iter().enumerate() {
            let mut positions = Vec::new();
            match reader.read(k, &mut positions) {
                Ok(()) => prop_assert_eq!(&positions, frame),
                Err(_) => wrong += 1,
            }
        }
        prop_assert_eq!(wrong, 1);
    }
}
