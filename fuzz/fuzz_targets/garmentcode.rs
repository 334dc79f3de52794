//! Any text is a pattern that can be sewn, or an error that says what to do.
#![no_main]

use libfuzzer_sys::fuzz_target;
use toile::garment::Garment;
use toile::io::garmentcode;

fuzz_target!(|text: &str| {
    let built = garmentcode::parse(text, "fuzzed").and_then(|(pattern, _)| Garment::build(&pattern, &[0.04]));
    match built {
        Ok(garment) => garment.levels.iter().chain([&garment.open]).for_each(|level| level.sanity_check()),
        Err(error) => assert!(!error.problem().is_empty() && !error.remedy().is_empty(), "{error}"),
    }
});
