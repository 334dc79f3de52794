//! Writes the default mannequin as `data/mannequin.obj`.
//!
//! ```text
//! cargo run --release --example write_mannequin [OUT.obj]
//! ```
//!
//! Expect some 9,000 vertices and 17,500 triangles, and one line per girth: what was asked for and what the tape reads.

use std::fmt::Write as _;
use toile::body::mannequin::{Measurements, Mesh, sculpt, stations};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "data/mannequin.obj".into());
    let measurements = Measurements::default();
    let mesh = sculpt(&measurements)?;
    eprintln!("{} vertices, {} triangles", mesh.positions.len(), mesh.triangles.len());
    for station in stations(&measurements) {
        eprintln!("{:>9}: asked {:.3} m, has {:.4} m", station.name, station.girth, station.measure(&mesh));
    }
    std::fs::write(path, obj(&mesh))?;
    Ok(())
}

/// Positions to a thousandth of a millimetre: below what any tape reads, and it halves the file.
pub fn obj(mesh: &Mesh) -> String {
    let mut text = String::from(
        "# The mannequin of toile: a woman of 1.72 m in A-pose, made from a table of measurements.\n\
         # Metres, y up, facing +z, own left at +x, feet on y = 0. Closed, facing outward.\n\
         # Licence: MIT OR Apache-2.0\n",
    );
    for p in &mesh.positions {
        let [x, y, z] = [p.x, p.y, p.z].map(decimals);
        writeln!(text, "v {x} {y} {z}").expect("writing to a string cannot fail");
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("writing to a string cannot fail");
    }
    text
}

/// Six decimals, no negative zero.
fn decimals(value: f64) -> String {
    let text = format!("{value:.6}");
    if text == "-0.000000" { "0.000000".into() } else { text }
}
