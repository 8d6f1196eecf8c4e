//! What a step of training costs, family by family, at the paper's sizes: `cargo bench --workspace --bench steps`.

use std::ops::ControlFlow;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, simulate};
use motes_proposals::{Backend, Family, Fcnn, FcnnConfig, Gnn, GnnConfig, Psi, PsiConfig, Rnn, RnnConfig};
use motes_train::{TrainConfig, train};

const HORIZON: usize = 12;

/// Ten steps at a time, so that what the first one allocates counts as little as it does in a training.
const STEPS: usize = 10;

fn steps<F: Family>(criterion: &mut Criterion, config: &F::Config) {
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

criterion_group!(benches, families);
criterion_main!(benches);
