//! What the documentation says about the code is in the code, and the other way round.

use std::path::{Path, PathBuf};
use toile::Code;

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

/// Pages and registry agree: names, titles, severities, and the index that lists them in order.
#[test]
fn every_code_has_a_page_and_every_page_a_code() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/checks");
    let index = include_str!("../docs/checks.md");
    let mut listed = index.lines().filter(|line| line.starts_with("| [TOILE-"));
    for code in Code::ALL {
        let page = std::fs::read_to_string(folder.join(format!("{code}.md"))).unwrap_or_else(|e| panic!("{code}: {e}"));
        let severity = code.severity().name();
        assert_eq!(page.lines().next(), Some(format!("# {code}: {}", code.title()).as_str()));
        assert!(page.to_lowercase().contains(&format!("*{severity}.*")), "{code} is a {severity}");
        for heading in ["## How it looks", "## What to do"] {
            assert!(page.contains(heading), "{code} lacks {heading}");
        }
        assert!(
            page.split("## How it looks").nth(1).unwrap().contains(code.id()),
            "the example of {code} is of another"
        );
        let row = format!("| [{code}](checks/{code}.md) | {severity} | {} |", code.title());
        assert_eq!(listed.next(), Some(row.as_str()));
    }
    assert_eq!(listed.next(), None);
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), Code::ALL.len());
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
