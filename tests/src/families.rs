//! A small proposal of every learned family, in every variant that a setting chooses.

use std::ops::ControlFlow;

use motes_models::{GraphModel, ModelShape, Seed, Simulator, StateGradients, simulate};
use motes_proposals::{
    Adapter, Cell, Compute, Family, Fcnn, FcnnConfig, Gnn, GnnConfig, Learnable, OverTime, Psi, PsiConfig,
    Rnn, RnnConfig,
};
use motes_train::{AdamConfig, TrainConfig, train};

/// A small fully connected proposal.
pub fn small_fcnn() -> FcnnConfig {
    FcnnConfig { widths: vec![6, 7], ridge: 1e-3, networks: OverTime::EachTime }
}

/// A small recurrent proposal of two layers.
pub fn small_rnn(cell: Cell) -> RnnConfig {
    RnnConfig { cell, hidden: 5, depth: 2, ridge: 1e-3 }
}

/// A small graph proposal, with layers that grow and layers that shrink.
pub fn small_gnn(adapter: Adapter) -> GnnConfig {
    GnnConfig { features: vec![5, 3], order: 3, adapter, ridge: 1e-3, networks: OverTime::EachTime }
}

/// A small transform.
pub fn small_psi() -> PsiConfig {
    PsiConfig { layers: 4, ridge: 1e-3, networks: OverTime::EachTime }
}

fn make<F: Family + Learnable + 'static>(
    config: &F::Config,
    shape: &ModelShape,
    horizon: usize,
    compute: Compute,
    seed: &Seed,
) -> Box<dyn Learnable> {
    Box::new(F::create(config, shape, horizon, compute, seed).unwrap())
}

/// One of each, with initial weights for `shape` and `horizon` times; a graph proposal only where there is a graph.
pub fn small_families(
    shape: &ModelShape,
    horizon: usize,
    compute: Compute,
    seed: &Seed,
) -> Vec<(String, Box<dyn Learnable>)> {
    let mut families = vec![
        ("fcnn".to_string(), make::<Fcnn>(&small_fcnn(), shape, horizon, compute, seed)),
        ("psi".to_string(), make::<Psi>(&small_psi(), shape, horizon, compute, seed)),
    ];
    for cell in [Cell::Lstm, Cell::Gru, Cell::Elman] {
        families
            .push((format!("rnn {cell:?}"), make::<Rnn>(&small_rnn(cell), shape, horizon, compute, seed)));
    }
    if shape.graph.is_some() {
        for adapter in [Adapter::Fixed, Adapter::Learned] {
            let gnn = make::<Gnn>(&small_gnn(adapter), shape, horizon, compute, seed);
            families.push((format!("gnn {adapter:?}"), gnn));
        }
    }
    families
}

/// Those of [`small_families`], and after them those whose networks are shared over time.
pub fn every_small_family(
    shape: &ModelShape,
    horizon: usize,
    compute: Compute,
    seed: &Seed,
) -> Vec<(String, Box<dyn Learnable>)> {
    let (mut families, networks) = (small_families(shape, horizon, compute, seed), OverTime::Shared);
    let fcnn = FcnnConfig { networks, ..small_fcnn() };
    families.push(("shared fcnn".into(), make::<Fcnn>(&fcnn, shape, 0, compute, seed)));
    let psi = PsiConfig { networks, ..small_psi() };
    families.push(("shared psi".into(), make::<Psi>(&psi, shape, 0, compute, seed)));
    if shape.graph.is_some() {
        let gnn = GnnConfig { networks, ..small_gnn(Adapter::Learned) };
        families.push(("shared gnn".into(), make::<Gnn>(&gnn, shape, 0, compute, seed)));
    }
    families
}

/// A proposal trained for 60 steps, by its own simulated measurements.
pub fn trained_family<F: Family + Learnable>(
    config: &F::Config,
    model: &(impl StateGradients + Simulator + GraphModel),
    horizon: usize,
    compute: Compute,
) -> F {
    let seed = Seed::from_u64(99);
    let measurements = simulate(model, horizon, &mut seed.child("data").stream()).unwrap().measurements;
    let mut proposal =
        F::create(config, &ModelShape::on_graph(model), horizon, compute, &seed.child("weights")).unwrap();
    let adam = AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() };
    let config = TrainConfig { steps: 60, adam, ..TrainConfig::paper(8) };
    let mut stream = seed.child("training").stream();
    let proceed = |_, _| ControlFlow::Continue(());
    train(&mut proposal, model, &measurements, &config, &mut stream, proceed).unwrap();
    proposal
}
