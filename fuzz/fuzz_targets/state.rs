//! Any bytes are a state that can be rebuilt, or an error that says what to do.
#![no_main]

use libfuzzer_sys::fuzz_target;
use toile::io::state;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = state::read(bytes).and_then(|state| state.rebuild()) {
        assert!(!error.problem().is_empty() && !error.remedy().is_empty(), "{error}");
    }
});
