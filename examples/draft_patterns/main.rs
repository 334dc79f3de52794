//! Drafts a T-shirt and a dress for the default mannequin and writes them as GarmentCode pattern files.
//!
//! ```text
//! cargo run --release --example draft_patterns [FOLDER]
//! ```
//!
//! writes `tee.json` and `dress.json` into the folder, `data` if none is named, and prints the measures taken on the
//! mannequin. Reading order: `measures` takes what a pattern maker would, `tee` and `dress` draft from that, `outline`
//! and `pattern` are the drawing tools, `garment_code` writes the file. All lengths are centimetres, as on a pattern
//! maker's table.

mod dress;
mod garment_code;
mod measures;
mod outline;
mod pattern;
mod tee;

pub use measures::Measures;
use std::path::Path;
use toile::body::mannequin::Measurements;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "data".into());
    let measures = Measures::taken(&Measurements::default())?;
    eprintln!("{measures:#.1?}");
    for (name, text) in files(&measures) {
        std::fs::write(Path::new(&folder).join(name), text)?;
    }
    Ok(())
}

/// Names and texts of the two files.
pub fn files(measures: &Measures) -> [(&'static str, String); 2] {
    [("tee.json", tee::draft(measures)), ("dress.json", dress::draft(measures))]
        .map(|(name, pattern)| (name, garment_code::json(&pattern)))
}
