//! What several test programs need.
#![allow(dead_code)]

use std::path::PathBuf;

/// The folder of real patterns and bodies beside the project, if it is there; says so if not.
pub fn shared_data() -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    if folder.is_dir() {
        Some(folder)
    } else {
        eprintln!("skipped: the folder ../shared/data with real patterns is not there");
        None
    }
}

/// Name and text of every GarmentCode pattern of that folder.
pub fn shared_patterns() -> Vec<(String, String)> {
    let Some(data) = shared_data() else { return Vec::new() };
    let mut patterns: Vec<(String, String)> = std::fs::read_dir(data.join("patterns/garmentcode"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
        .map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), std::fs::read_to_string(&path).unwrap()))
        .collect();
    patterns.sort();
    patterns
}
