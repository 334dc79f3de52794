//! Evaluates the energy of the embedded tee so many times, for `instructions.sh` to count instructions.
//! Prints the number of springs: edges of the mesh and hinges.

use toile::energy::{Energy, Model};
use toile::garment::Garment;
use toile::geometry::Vector3;
use toile::io::{embedded, garmentcode};
use toile::pattern::Fabric;

/// Coarse enough for an emulated processor, fine enough for many patches, m.
const RESOLUTION: f64 = 0.01;

fn main() {
    // Cargo adds arguments of its own.
    let count = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(1_usize);
    let pattern = garmentcode::parse(embedded::TEE, "tee").expect("it is embedded").0;
    let level = Garment::build(&pattern, &[RESOLUTION]).expect("the tee is sound").levels.remove(0);
    let mut positions = vec![Vector3::zeros(); level.particle_count];
    for (rest, &p) in level.rest.iter().zip(&level.particle_of) {
        positions[p as usize] = Vector3::new(1.01 * rest.x, rest.y, 0.01 * (40.0 * rest.x).sin());
    }
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for [a, b, c] in (0..level.triangles.len()).map(|t| level.particles(t)) {
        edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
    }
    edges.sort_unstable();
    edges.dedup();
    println!("{}", edges.len() + level.hinges.len());
    // One thread, which never waits for another.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    pool.install(|| {
        let mut energy = Energy::new(&level, &Fabric::default(), Model::default());
        let mut gradient = positions.clone();
        for _ in 0..count {
            std::hint::black_box(energy.evaluate(&positions, &mut gradient));
            std::hint::black_box(energy.curvature(&positions, &gradient));
        }
    });
}
