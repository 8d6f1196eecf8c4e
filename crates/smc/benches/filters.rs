//! What a step of a filter costs, by its parts and as a whole: `cargo bench --workspace --bench filters`.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use motes_models::{
    GraphDiffusion, GraphDiffusionConfig, Seed, Step, Trajectory, fill_standard_normal, simulate,
};
use motes_smc::{
    Bootstrap, FilterBank, FilterSettings, LogWeights, MinDegeneracy, Proposal, ResampleWhen, Resampling,
};
use rayon_core::{ThreadPool, ThreadPoolBuilder};

fn normals(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("normals");
    let mut stream = Seed::from_u64(1).stream();
    for count in [10, 100, 10_000] {
        let mut noise = vec![0.0; count];
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            bencher.iter(|| fill_standard_normal(&mut stream, &mut noise));
        });
    }
}

/// `K` weights as uneven as those of a filter that is about to resample.
fn weights(particles: usize) -> LogWeights {
    let mut noise = vec![0.0; particles];
    fill_standard_normal(&mut Seed::from_u64(2).stream(), &mut noise);
    let mut weights = LogWeights::uniform(particles);
    weights.update(&noise).expect("normal numbers are finite");
    weights
}

fn weighing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("weights");
    let mut weights = weights(10_000);
    let increments = vec![-0.1; 10_000];
    group.throughput(Throughput::Elements(10_000));
    group.bench_function("update", |bencher| bencher.iter(|| weights.update(&increments)));
}

fn resampling(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("resampling");
    let (weights, mut ancestors) = (weights(10_000), vec![0; 10_000]);
    let mut stream = Seed::from_u64(3).stream();
    group.throughput(Throughput::Elements(10_000));
    for scheme in
        [Resampling::Multinomial, Resampling::Systematic, Resampling::Stratified, Resampling::Residual]
    {
        group.bench_function(format!("{scheme:?}"), |bencher| {
            bencher.iter(|| scheme.draw(weights.normalised(), &mut stream, &mut ancestors));
        });
    }
}

/// A pool of so many threads.
fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads can be had")
}

fn problem() -> (GraphDiffusion, Trajectory) {
    let seed = Seed::from_u64(4);
    let config = GraphDiffusionConfig::new(10);
    let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).expect("a usable system");
    let data = simulate(&system, 50, &mut seed.child("data").stream()).expect("a stable system");
    (system, data)
}

/// Steps of filters that resample each time, on the measurements of one system over and over.
fn steps<P: Proposal<GraphDiffusion> + Clone + Send>(
    criterion: &mut Criterion,
    name: &str,
    make: impl Fn(&GraphDiffusion) -> P,
) {
    let (system, data) = problem();
    let mut group = criterion.benchmark_group(name);
    for (filters, particles, threads) in
        [(100, 10, 1), (100, 50, 1), (1, 1000, 1), (1, 10_000, 1), (1, 100_000, 1), (1, 100_000, 2)]
    {
        let settings =
            FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(particles) };
        let mut bank = FilterBank::new(&system, make(&system), settings, filters, &Seed::from_u64(5))
            .expect("usable settings");
        let mut time = 0;
        group.throughput(Throughput::Elements((filters * particles) as u64));
        group.bench_function(format!("{filters} × {particles}, threads: {threads}"), |bencher| {
            pool(threads).install(|| {
                bencher.iter(|| {
                    time = (time + 1) % data.measurements.len();
                    bank.step(data.measurements.row(time))
                });
            });
        });
    }
}

/// Whole sequences, in which threads stay awake.
fn sequences(criterion: &mut Criterion) {
    let (system, data) = problem();
    let mut group = criterion.benchmark_group("bootstrap, 50 steps in one call");
    for (filters, particles, threads) in [(100, 10, 1), (100, 10, 2), (1, 10_000, 1), (1, 10_000, 2)] {
        let settings = FilterSettings::new(particles);
        let mut bank = FilterBank::new(&system, Bootstrap, settings, filters, &Seed::from_u64(5))
            .expect("usable settings");
        group.throughput(Throughput::Elements((filters * particles * data.measurements.len()) as u64));
        group.bench_function(format!("{filters} × {particles}, threads: {threads}"), |bencher| {
            pool(threads).install(|| bencher.iter(|| bank.run(&data.measurements, |_| ())));
        });
    }
}

/// What a designed proposal is used with: a defensive mixture, and measurements of which the first entry is missing.
fn mixtures_and_gaps(criterion: &mut Criterion) {
    let (system, data) = problem();
    let mut group = criterion.benchmark_group("min-degeneracy, K = 10000");
    group.throughput(Throughput::Elements(10_000));
    for threads in [1, 2] {
        let bank = |defensive_weight| {
            let always = ResampleWhen::Always;
            let settings =
                FilterSettings { resample_when: always, defensive_weight, ..FilterSettings::new(10_000) };
            let proposal = MinDegeneracy::new(&system).expect("positive definite");
            FilterBank::new(&system, proposal, settings, 1, &Seed::from_u64(5)).expect("usable settings")
        };
        let (mut mixed, mut partial, mut time) = (bank(Some(0.1)), bank(None), 0);
        group.bench_function(format!("defensive mixture, threads: {threads}"), |bencher| {
            pool(threads).install(|| {
                bencher.iter(|| {
                    time = (time + 1) % data.measurements.len();
                    mixed.step(data.measurements.row(time))
                });
            });
        });
        group.bench_function(format!("one entry missing, threads: {threads}"), |bencher| {
            pool(threads).install(|| {
                bencher.iter(|| {
                    time = (time + 1) % data.measurements.len();
                    let mut row: Vec<_> = data.measurements.row(time).iter().copied().map(Some).collect();
                    row[0] = None;
                    partial.step_at(&Step::of_index(partial.time()), &row)
                });
            });
        });
    }
}

fn designed(criterion: &mut Criterion) {
    steps(criterion, "bootstrap", |_| Bootstrap);
    steps(criterion, "min-degeneracy", |system| MinDegeneracy::new(system).expect("positive definite"));
}

criterion_group!(benches, normals, weighing, resampling, designed, mixtures_and_gaps, sequences);
criterion_main!(benches);
