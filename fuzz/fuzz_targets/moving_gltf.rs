//! Any bytes are an animated body, or an error that says what to do.
#![no_main]

use libfuzzer_sys::fuzz_target;
use toile::Error;
use toile::io::moving_body::{Options, gltf::Rig};

fuzz_target!(|bytes: &[u8]| {
    let mut nothing_beside = |_: &str| Err(Error::new("There is no such file.", "Put the buffer into the file."));
    let read = Rig::read(bytes, &[], &mut nothing_beside).and_then(|rig| rig.play(&Options::default()));
    if let Err(error) = read {
        assert!(!error.problem().is_empty() && !error.remedy().is_empty(), "{error}");
    }
});
