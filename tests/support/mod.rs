//! What several test programs need.
#![allow(dead_code)]

pub mod bodies;
pub mod patterns;

use std::path::PathBuf;

/// The folder of real patterns and bodies, if it is there; says so if not. It lies beside the
/// project, or where the variable TOILE_TEST_DATA says.
pub fn shared_data() -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("TOILE_TEST_DATA").map_or_else(beside, PathBuf::from);
    if folder.is_dir() {
        Some(folder)
    } else {
        eprintln!("skipped: there are no real patterns and bodies in {}", folder.display());
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
