//! What a step of training costs, family by family, at the paper's sizes, and a filter with networks: `cargo bench --workspace --bench steps`.

use std::ops::ControlFlow;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, simulate};
use motes_proposals::{
    Backend, Family, Fcnn, FcnnConfig, Gnn, GnnConfig, Learnable, Psi, PsiConfig, Rnn, RnnConfig,
};
use motes_smc::{FilterBank, FilterSettings};
use motes_train::{TrainConfig, train};
use rayon_core::ThreadPoolBuilder;

const HORIZON: usize = 12;

/// Ten steps at a time, so that what the first one allocates counts as little as it does in a training.
const STEPS: usize = 10;

fn steps<F: Family + Learnable>(criterion: &mut Criterion, config: &F::Config) {
    let seed = Seed::from_u64(1);
    let graph = GraphDiffusionConfig::new(10);
    let system = GraphDiffusion::random(&graph, &mut seed.child("graph").stream()).expect("a usable system");
    let data = simulate(&system, HORIZON, &mut seed.child("data").stream()).expect("a stable system");
    let mut group = criterion.benchmark_group(format!("{STEPS} steps of {}", F::NAME));
    group.sample_size(10);
    for particles in [10, 50] {
        let proposal = F::create(
            config,
            &ModelShape::on_graph(&system),
            HORIZON,
            Backend::Native.into(),
            &seed.child("weights"),
        );
        let mut proposal = proposal.expect("the paper's sizes are usable");
        let config = TrainConfig { steps: STEPS, ..TrainConfig::paper(particles) };
        let mut stream = seed.child("training").stream();
        group.bench_function(BenchmarkId::from_parameter(format!("K = {particles}")), |bencher| {
            bencher.iter(|| {
                let proceed = |_, _| ControlFlow::Continue(());
                train(&mut proposal, &system, &data.measurements, &config, &mut stream, proceed)
            });
        });
    }
}

fn families(criterion: &mut Criterion) {
    steps::<Psi>(criterion, &PsiConfig::paper());
    steps::<Fcnn>(criterion, &FcnnConfig::paper());
    steps::<Rnn>(criterion, &RnnConfig::paper());
    steps::<Gnn>(criterion, &GnnConfig::paper());
}

/// Whole sequences of a filter whose proposal is a network with two hidden layers of 64.
fn learned_filter(criterion: &mut Criterion) {
    const PARTICLES: usize = 10_000;
    let seed = Seed::from_u64(1);
    let graph = GraphDiffusionConfig::new(10);
    let system = GraphDiffusion::random(&graph, &mut seed.child("graph").stream()).expect("a usable system");
    let data = simulate(&system, HORIZON, &mut seed.child("data").stream()).expect("a stable system");
    let (config, shape) =
        (FcnnConfig { widths: vec![64, 64], ridge: 1.0, ..FcnnConfig::paper() }, ModelShape::of(&system));
    let weights = seed.child("weights");
    let proposal = Fcnn::create(&config, &shape, HORIZON, Backend::Native.into(), &weights);
    let proposal = proposal.expect("usable settings");
    let mut group = criterion.benchmark_group("filter with fcnn 64, 64, K = 10000");
    group.sample_size(20).throughput(Throughput::Elements((PARTICLES * HORIZON) as u64));
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads can be had");
        group.bench_function(format!("threads: {threads}"), |bencher| {
            bencher.iter(|| {
                let settings = FilterSettings::new(PARTICLES);
                let bank = FilterBank::new(&system, proposal.clone(), settings, 1, &seed.child("filter"));
                let mut bank = bank.expect("usable settings");
                pool.install(|| bank.run(&data.measurements, |_| ()))
            });
        });
    }
}

criterion_group!(benches, families, learned_filter);
criterion_main!(benches);
