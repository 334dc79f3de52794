//! Processor seconds of what comes before the first relaxation: body, distance field, garment, arrangement.
//!
//!     cargo run --release --example startup -- PATTERN.json BODY.obj RESOLUTION_MM [ROUNDS]
//!
//! Prints the least of some rounds for each, and the seconds a particle that the garment takes: they should
//! be the same at every resolution. `RAYON_NUM_THREADS=1` makes them comparable between machines.

use std::time::Instant;
use toile::arrangement::{Care, arrange};
use toile::body::Body;
use toile::garment::Garment;
use toile::io::{body_obj, garmentcode, process};
use toile::prepositioning::{Settings, distance_field, worn_heights};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let [_, pattern, body, millimetres, rounds @ ..] = args.as_slice() else {
        return println!("startup PATTERN.json BODY.obj RESOLUTION_MM [ROUNDS]");
    };
    let (pattern, _) = garmentcode::parse(&std::fs::read_to_string(pattern).unwrap(), "pattern").unwrap();
    let (read, _) = body_obj::parse(&std::fs::read(body).unwrap()).unwrap();
    let settings = Settings::for_resolution(millimetres.parse::<f64>().unwrap() * 1e-3);
    let mut least = [[f64::INFINITY; 2]; 4];
    let mut particles = 0;
    for _ in 0..rounds.first().map_or(5, |r| r.parse().unwrap()) {
        let mut stage = 0;
        let mut timed = |since: (f64, Instant)| {
            let spent = [cpu() - since.0, since.1.elapsed().as_secs_f64()];
            (0..2).for_each(|k| least[stage][k] = least[stage][k].min(spent[k]));
            stage += 1;
        };
        let (positions, triangles) = (read.positions().to_vec(), read.triangles().to_vec());
        let start = now();
        let body = Body::new(positions, triangles).unwrap().0;
        timed(start);
        let start = now();
        let field = distance_field(&body, settings.clearance, worn_heights([&pattern]));
        timed(start);
        let start = now();
        let garment = Garment::build(&pattern, &settings.resolutions).unwrap();
        timed(start);
        let start = now();
        let arrangement = arrange(&pattern, &garment.open, &body, &field, Care::Seams);
        timed(start);
        particles = garment.levels[garment.levels.len() - 1].particle_count;
        std::hint::black_box(arrangement.positions);
    }
    for (name, [cpu, wall]) in ["body", "field", "garment", "arrange"].iter().zip(least) {
        println!("{name:8} {:8.1} ms of processor time, {:8.1} ms", cpu * 1e3, wall * 1e3);
    }
    println!("{particles} particles, {:.2} us each for the garment", least[2][0] / particles as f64 * 1e6);
}

fn now() -> (f64, Instant) {
    (cpu(), Instant::now())
}

fn cpu() -> f64 {
    process::cpu_seconds().unwrap_or(f64::NAN)
}
