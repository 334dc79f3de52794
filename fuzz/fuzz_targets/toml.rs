//! Any text is a fabric, settings or a length, or an error that says what to do.
#![no_main]

use libfuzzer_sys::fuzz_target;
use toile::io::{fabric_toml, length, settings_toml};
use toile::prepositioning::Settings;

fuzz_target!(|text: &str| {
    let errors = [
        fabric_toml::parse(text, "fuzzed").err(),
        settings_toml::apply(text, &mut Settings::default()).err(),
        length::parse(text).err(),
        length::parse_list(text).err(),
    ];
    for error in errors.into_iter().flatten() {
        assert!(!error.problem().is_empty() && !error.remedy().is_empty(), "{error}");
    }
});
