//! Any text is a pattern of toile that writes and reads back the same, or an error that says what to do.
#![no_main]

use libfuzzer_sys::fuzz_target;
use toile::io::toile_pattern;

fuzz_target!(|text: &str| {
    for read in [toile_pattern::parse_json(text, "fuzzed"), toile_pattern::parse_toml(text, "fuzzed")] {
        match read {
            Ok((pattern, _)) => {
                let (again, _) = toile_pattern::parse_json(&toile_pattern::write_json(&pattern), "again").unwrap();
                assert!(again == pattern);
            }
            Err(error) => assert!(!error.problem().is_empty() && !error.remedy().is_empty(), "{error}"),
        }
    }
});
