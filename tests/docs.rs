//! What the documentation says about the code is in the code, and the other way round.

use std::path::{Path, PathBuf};

const THEORY: &str = include_str!("../docs/theory.md");

fn sources() -> Vec<PathBuf> {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files
}

#[test]
fn the_guide_shows_the_example_that_runs() {
    assert!(include_str!("../docs/guide.md").contains(include_str!("../examples/fit.rs")));
}

#[test]
fn every_equation_that_the_code_cites_stands_in_the_theory() {
    let mut cited = 0;
    for file in sources() {
        let text = std::fs::read_to_string(&file).unwrap();
        for (at, found) in text.match_indices("theory, equation ") {
            let number: String = text[at + found.len()..].chars().take_while(char::is_ascii_alphanumeric).collect();
            let stands = THEORY.lines().any(|line| line.ends_with(&format!("  ({number})")));
            assert!(stands, "{} cites equation {number}", file.display());
            cited += 1;
        }
    }
    assert!(cited >= 5, "{cited} citations are too few to be all");
}

/// The theory names tests as witnesses; they must exist.
#[test]
fn every_test_that_the_documents_name_exists() {
    let tests = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")).unwrap();
    let tests = tests.map(|entry| entry.unwrap().path()).filter(|path| path.is_file());
    let code: String = sources().into_iter().chain(tests).map(|file| std::fs::read_to_string(file).unwrap()).collect();
    for text in [THEORY, include_str!("../docs/architecture.md")] {
        for word in text.split('`').skip(1).step_by(2) {
            // Sentences for names are what tests have.
            let sentence =
                word.matches('_').count() >= 3 && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            assert!(!sentence || code.contains(&format!("fn {word}(")), "there is no test {word}");
        }
    }
}
