//! Any bytes are a body, or an error that says what to do.
#![no_main]

use libfuzzer_sys::fuzz_target;
use toile::io::body_obj;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = body_obj::parse(bytes) {
        assert!(!error.problem().is_empty() && !error.remedy().is_empty(), "{error}");
    }
});
