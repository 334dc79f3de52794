//! Any text is a draft, as JSON or SVG, or an error that says what to do.
#![no_main]

use libfuzzer_sys::fuzz_target;
use toile::io::freesewing;

fuzz_target!(|text: &str| {
    for read in [freesewing::parse_dump(text, "fuzzed"), freesewing::parse_svg(text, "fuzzed")] {
        match read {
            Ok((pattern, _)) => assert!(pattern.panels.iter().all(|panel| panel.perimeter().is_finite())),
            Err(error) => assert!(!error.problem().is_empty() && !error.remedy().is_empty(), "{error}"),
        }
    }
});
