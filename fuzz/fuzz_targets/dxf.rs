//! Any bytes are a drawing, or an error that says what to do.
#![no_main]

use libfuzzer_sys::fuzz_target;
use toile::io::dxf;

fuzz_target!(|bytes: &[u8]| {
    match dxf::parse(bytes, "fuzzed", &dxf::Options::default()) {
        Ok((pattern, _)) => assert!(pattern.panels.iter().all(|panel| panel.perimeter().is_finite())),
        Err(error) => assert!(!error.problem().is_empty() && !error.remedy().is_empty(), "{error}"),
    }
});
