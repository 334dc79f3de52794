//! What a fit spends its time on, each alone, and bounds to compare the kernel with.
//!
//!     cargo bench --bench hot_paths
//!     cargo bench --bench hot_paths -- energy
//!
//! Takes about a minute. *Elements* are springs: edges of the mesh and hinges. Everything runs on the
//! embedded tee, at 5 mm unless the name says otherwise; contact on positions that were prolonged from a
//! fit at 20 mm, so that cloth touches where it touches in earnest.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Duration;
use toile::body::{Body, DistanceField};
use toile::contact::{BodyContact, BodyContactSettings, SelfContact, SelfContactSettings};
use toile::energy::{Bending, Energy, Membrane, Model};
use toile::garment::{Correspondence, Garment, Level};
use toile::geometry::Vector3;
use toile::io::{body_obj, embedded, garmentcode};
use toile::minimize::{ConjugateGradient, Problem, Settings as Steps};
use toile::pattern::{Fabric, Pattern};
use toile::prepositioning::{Settings, preposition};

/// m.
const FINE: f64 = 0.005;
const COARSE: f64 = 0.02;
/// Numbers of each array of the triad: three of them are more than caches hold.
const TRIAD: usize = 1 << 22;

struct Tee {
    pattern: Pattern,
    body: Body,
    garment: Garment,
    /// Of the finest level, m.
    positions: Vec<Vector3>,
}

impl Tee {
    fn new() -> Self {
        let pattern = garmentcode::parse(embedded::TEE, "tee").expect("it is embedded").0;
        let body = body_obj::parse(embedded::MANNEQUIN_OBJ).expect("it is embedded").0;
        let settings = Settings::for_resolution(COARSE);
        let outcome = preposition(&pattern, &Fabric::default(), &body, &settings, &mut ()).expect("the tee fits");
        let garment = Garment::build(&pattern, &[COARSE, 0.5 * COARSE, FINE]).expect("the tee is sound");
        let [_, middle, fine] = &garment.levels[..] else { unreachable!("three levels were asked for") };
        // The fit has levels of its own.
        let onto_middle = Correspondence::new(outcome.finest(), middle);
        let between = onto_middle.prolong(outcome.finest(), middle, &outcome.positions);
        let positions = garment.correspondences[1].prolong(middle, fine, &between);
        Self { pattern, body, garment, positions }
    }

    fn level(&self) -> &Level {
        &self.garment.levels[2]
    }

    fn springs(&self) -> u64 {
        let triangles = (0..self.level().triangles.len()).map(|t| self.level().particles(t));
        let mut edges: Vec<[u32; 2]> = triangles.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        edges.dedup();
        (edges.len() + self.level().hinges.len()) as u64
    }
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool").install(work)
}

fn kernel(criterion: &mut Criterion, tee: &Tee) {
    let mut group = criterion.benchmark_group("energy");
    group.throughput(Throughput::Elements(tee.springs()));
    let paper = Model { membrane: Membrane::Springs, bending: Bending::Springs };
    let direction: Vec<Vector3> =
        (0..tee.positions.len()).map(|k| Vector3::new((k as f64).sin(), (k as f64 * 0.7).cos(), 0.5)).collect();
    for (name, model) in [("", Model::default()), (" of the paper's springs", paper)] {
        let mut energy = Energy::new(tee.level(), &Fabric::default(), model);
        let mut gradient = tee.positions.clone();
        for threads in [1, 2] {
            group.bench_function(BenchmarkId::new(format!("energy and gradient{name}"), threads), |b| {
                b.iter_custom(|count| {
                    on_threads(threads, || {
                        timed(count, || black_box(energy.evaluate(&tee.positions, &mut gradient).total()))
                    })
                });
            });
            group.bench_function(BenchmarkId::new(format!("curvature{name}"), threads), |b| {
                b.iter_custom(|count| {
                    on_threads(threads, || timed(count, || black_box(energy.curvature(&tee.positions, &direction))))
                });
            });
        }
    }
    // What no kernel can beat: a root and a quotient for each edge of each triangle, out of registers.
    let edges = 3 * tee.level().triangles.len();
    group.bench_function("bound: root and quotient", |b| b.iter(|| Arch::new().dispatch(Roots(black_box(edges)))));
    group.bench_function("set-up", |b| b.iter(|| Energy::new(tee.level(), &Fabric::default(), Model::default())));
    group.finish();

    let mut group = criterion.benchmark_group("memory");
    group.throughput(Throughput::Bytes(3 * 8 * TRIAD as u64));
    let (mut a, b, c) = (vec![0.0; TRIAD], vec![1.0; TRIAD], vec![2.0; TRIAD]);
    for threads in [1, 2] {
        group.bench_function(BenchmarkId::new("triad", threads), |bencher| {
            bencher.iter_custom(|count| on_threads(threads, || timed(count, || triad(&mut a, &b, &c))));
        });
    }
    group.finish();
}

/// Time of all calls together.
fn timed<T>(count: u64, mut work: impl FnMut() -> T) -> Duration {
    let start = std::time::Instant::now();
    (0..count).for_each(|_| {
        work();
    });
    start.elapsed()
}

fn triad(a: &mut [f64], b: &[f64], c: &[f64]) {
    let chunks = a.par_chunks_mut(1 << 16).zip(b.par_chunks(1 << 16)).zip(c.par_chunks(1 << 16));
    chunks.for_each(|((a, b), c)| a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 3.0 * c));
}

/// So many roots and quotients, with the instructions that the kernel uses.
struct Roots(usize);

impl NullaryFnOnce for Roots {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let mut lanes = [1.0_f64; 64];
        for _ in 0..self.0 / lanes.len() {
            lanes.iter_mut().for_each(|x| *x = 1.0 / (*x + 0.5).sqrt());
        }
        lanes.iter().sum()
    }
}

/// A bowl, so cheap that only the minimizer's own vectors cost.
struct Bowl(Vec<f64>);

impl Problem for Bowl {
    fn evaluate(&mut self, points: &[Vector3], gradient: &mut [Vector3]) -> f64 {
        gradient.copy_from_slice(points);
        self.0[0] -= 1e-9;
        self.0[0]
    }

    fn curvature(&mut self, _: &[Vector3], _: &[Vector3]) -> f64 {
        1e9
    }

    fn diagonal(&self) -> &[f64] {
        &self.0
    }
}

fn minimizer(criterion: &mut Criterion, tee: &Tee) {
    let mut points = tee.positions.clone();
    let mut bowl = Bowl(vec![1.0; points.len()]);
    let mut minimizer = ConjugateGradient::new(points.len());
    let steps = Steps { evaluations: 11, largest_move: 1.0, restart_after: 100 };
    criterion.bench_function("minimizer/vectors of ten steps", |b| {
        b.iter(|| minimizer.run(&mut bowl, &mut points, &steps, |_| false));
    });
}

fn garment(criterion: &mut Criterion, tee: &Tee) {
    let mut group = criterion.benchmark_group("garment");
    let resolutions = Settings::for_resolution(FINE).resolutions;
    group.bench_function("build all levels", |b| b.iter(|| Garment::build(&tee.pattern, &resolutions)));
    let [_, middle, fine] = &tee.garment.levels[..] else { unreachable!("three levels were asked for") };
    group.bench_function("correspondence", |b| b.iter(|| Correspondence::new(middle, fine)));
    group.finish();
}

fn contact(criterion: &mut Criterion, tee: &Tee) {
    let mut group = criterion.benchmark_group("contact");
    let field = DistanceField::new(&tee.body, 0.006, 0.03);
    let settings = BodyContactSettings { clearance: 0.002, stiffness: 500.0, friction: 0.3 };
    let mut body = BodyContact::new(&tee.body, &field, tee.level(), settings);
    let mut gradient = vec![Vector3::zeros(); tee.positions.len()];
    group.bench_function("with the body", |b| b.iter(|| body.evaluate(&tee.positions, &mut gradient)));
    let settings = SelfContactSettings { clearance: 0.0005, stiffness: 200.0, reach: 0.7 * FINE };
    let mut cloth = SelfContact::new(tee.level(), (0..tee.positions.len() as u32).collect(), settings);
    group.bench_function("of the cloth with itself: rebuild", |b| b.iter(|| cloth.rebuild(&tee.positions)));
    group.bench_function("of the cloth with itself", |b| b.iter(|| cloth.evaluate(&tee.positions, &mut gradient)));
    group.finish();
}

fn fits(criterion: &mut Criterion, tee: &Tee) {
    let mut group = criterion.benchmark_group("fit");
    group.sample_size(10).sampling_mode(criterion::SamplingMode::Flat);
    for millimetres in [40, 20] {
        let settings = Settings::for_resolution(f64::from(millimetres) * 1e-3);
        group.bench_function(BenchmarkId::new("tee, mm", millimetres), |b| {
            b.iter(|| preposition(&tee.pattern, &Fabric::default(), &tee.body, &settings, &mut ()));
        });
    }
    group.finish();
}

fn all(criterion: &mut Criterion) {
    let tee = Tee::new();
    kernel(criterion, &tee);
    minimizer(criterion, &tee);
    garment(criterion, &tee);
    contact(criterion, &tee);
    fits(criterion, &tee);
}

criterion_group! {
    name = hot_paths;
    config = Criterion::default()
        .sample_size(15)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = all
}
criterion_main!(hot_paths);
