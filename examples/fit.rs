//! A fitted garment with the library alone: read, sew and relax, judge, write.
//!
//!     cargo run --release --example fit
//!     cargo run --release --example fit -- garment.obj
//!
//! Prints a line for each level, then one for each condition of the hand-off with what was measured and
//! its limit. With an argument the garment is written there. Returns an error that says what to do
//! when an input cannot be used; here pattern and body are embedded, so it never should.

use std::path::Path;
use toile::Error;
use toile::assess::hand_off;
use toile::io::{atomic, body_obj, embedded, garment_obj, garmentcode};
use toile::pattern::Fabric;
use toile::prepositioning::{Event, Observer, Settings, preposition};

/// Tells when a level is done; `&mut ()` watches nothing.
struct Levels;

impl Observer for Levels {
    fn event(&mut self, event: &Event) {
        if let Event::LevelDone { summary, .. } = event {
            let (millimetres, residual) = (summary.resolution * 1e3, summary.residual.rms);
            println!("{millimetres} mm: {} evaluations, residual {residual:.2} weights", summary.evaluations);
        }
    }
}

fn main() -> Result<(), Error> {
    // 1. Readers take what a file holds; `io::read::text` and `io::read::bytes` fetch it from a disk.
    let (pattern, pattern_warnings) = garmentcode::parse(embedded::TEE, "tee")?;
    let (body, body_warnings) = body_obj::parse(embedded::MANNEQUIN_OBJ)?;
    for warning in pattern_warnings.iter().chain(&body_warnings) {
        println!("warning: {warning}");
    }

    // 2. Sew and relax. Lengths are metres; 20 mm is coarse and takes seconds.
    let fabric = Fabric::named("cotton_shirting")?;
    let settings = Settings { clearance: 0.001, ..Settings::for_resolution(0.02) };
    let outcome = preposition(&pattern, &fabric, &body, &settings, &mut Levels)?;

    // 3. The run has measured what it made; the gate says which figures are good enough.
    for check in hand_off(&outcome.assessment) {
        let verdict = if check.passed { "ok" } else { "FAILED" };
        println!("{verdict:6} {:20} {:.6} (limit {})", check.name, check.measured, check.limit);
    }

    // 4. Positions belong to the particles of the finest level.
    if let Some(path) = std::env::args_os().nth(1) {
        let text = garment_obj::write(&pattern, outcome.finest(), &outcome.positions);
        atomic::write(Path::new(&path), text.as_bytes())?;
    }
    Ok(())
}
