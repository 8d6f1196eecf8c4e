//! The fully connected proposal against the paper's formulas written out by hand.

use std::ops::ControlFlow;

use faer::Mat;
use motes_models::{
    Gaussian, GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, StateSpaceModel, Step, simulate,
};
use motes_proposals::{
    Backend, Compute, Family, Fcnn, FcnnConfig, Hidden, OverTime, Parameters, Parametric, Precision,
};
use motes_smc::{Conditional, Context, Proposal, ProposalError};
use motes_train::{AdamConfig, TrainConfig, train};

fn system() -> GraphDiffusion {
    GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut Seed::from_u64(80).stream()).unwrap()
}

fn fcnn(precision: Precision) -> Fcnn {
    let compute = Compute { backend: Backend::Native, precision };
    let config = FcnnConfig { widths: vec![4, 6], ..FcnnConfig::paper() };
    Fcnn::create(&config, &ModelShape::of(&system()), 3, compute, &Seed::from_u64(81)).unwrap()
}

fn initial_memory(proposal: &Fcnn, particles: usize) -> Hidden {
    Proposal::<GraphDiffusion>::initial_memory(proposal, particles)
}

/// The matrix of that name, row-major.
fn named(parameters: &Parameters, name: &str) -> Vec<f64> {
    let index = parameters.names().iter().position(|found| found == name).unwrap();
    parameters.host(index)
}

/// `W₃ᵀ tanh(W₂ᵀ tanh(W₁ᵀ x + b₁) + b₂) + b₃` for one input, with plain loops.
fn network(parameters: &Parameters, name: &str, input: &[f64]) -> Vec<f64> {
    let mut values = input.to_vec();
    for layer in 0..3 {
        let weight = named(parameters, &format!("{name}.{layer}.weight"));
        let bias = named(parameters, &format!("{name}.{layer}.bias"));
        let outputs = bias.len();
        values = (0..outputs)
            .map(|o| {
                bias[o] + values.iter().enumerate().map(|(i, v)| v * weight[i * outputs + o]).sum::<f64>()
            })
            .map(|value| if layer < 2 { value.tanh() } else { value })
            .collect();
    }
    values
}

/// The names of mean network, covariance network and `C` at a time.
fn names(networks: OverTime, time: usize) -> [String; 3] {
    match (networks, time) {
        (OverTime::EachTime, _) => {
            [&format!("mean.{time}"), "covariance", "covariance.mixing"].map(Into::into)
        }
        (OverTime::Shared, 0) => {
            ["first.mean", "first.covariance", "first.covariance.mixing"].map(Into::into)
        }
        (OverTime::Shared, _) => ["mean", "covariance", "covariance.mixing"].map(Into::into),
    }
}

/// The paper's `q(x_t | x_{t−1}, y_t)` as one dense Gaussian.
fn by_hand(parameters: &Parameters, names: [String; 3], input: &[f64], n: usize) -> Gaussian {
    let [of_mean, of_covariance, of_mixing] = names;
    let mean = network(parameters, &of_mean, input);
    let z = network(parameters, &of_covariance, input);
    let c = named(parameters, &of_mixing);
    let entry = |i: usize, j: usize| {
        let sum: f64 = (0..n)
            .flat_map(|a| (0..n).map(move |b| (a, b)))
            .map(|(a, b)| c[i * n + a] * (-(z[a] - z[b]).powi(2)).exp() * c[j * n + b])
            .sum();
        sum + if i == j { 1e-6 } else { 0.0 }
    };
    let covariance = Mat::from_fn(n, n, |i, j| 0.5 * (entry(i, j) + entry(j, i)));
    Gaussian::new("Σ", mean, covariance).unwrap()
}

#[test]
fn log_q_of_an_untrained_proposal_is_that_of_the_formulas() {
    check_log_q(fcnn(Precision::F64));
}

#[test]
fn log_q_of_a_trained_and_collapsed_proposal_is_that_of_the_formulas() {
    let (system, mut proposal) = (system(), fcnn(Precision::F64));
    let measurements = simulate(&system, 3, &mut Seed::from_u64(83).stream()).unwrap().measurements;
    let adam = AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() };
    let config = TrainConfig { steps: 300, adam, ..TrainConfig::paper(8) };
    let mut stream = Seed::from_u64(84).stream();
    train(&mut proposal, &system, &measurements, &config, &mut stream, |_, _| ControlFlow::Continue(()))
        .unwrap();
    let input: Vec<f64> = [&[0.0; 5], measurements.row(0)].concat();
    let trained = by_hand(proposal.parameters(), names(OverTime::EachTime, 0), &input, 5);
    let variance: f64 = (0..5).map(|i| trained.covariance()[(i, i)]).sum();
    println!("total variance {variance:.1e}");
    assert!(variance < 1e-2, "training did not collapse the covariance: total variance {variance}");
    check_log_q(proposal);
}

/// A wrong network, or the `C` of another time, shows at the first or at a late time.
#[test]
fn log_q_of_shared_networks_is_that_of_the_formulas_at_any_time() {
    let compute = Compute { backend: Backend::Native, precision: Precision::F64 };
    let config = FcnnConfig { widths: vec![4, 6], networks: OverTime::Shared, ..FcnnConfig::paper() };
    let shared = Fcnn::create(&config, &ModelShape::of(&system()), 0, compute, &Seed::from_u64(81)).unwrap();
    assert_eq!(Parametric::horizon(&shared), None);
    assert_eq!(Fcnn::count(&config, &ModelShape::of(&system()), 0), Some(shared.parameters().values().len()));
    check_log_q(shared);
}

/// Compares `log q` with a dense Gaussian, at samples and beside them, to 1e-9.
fn check_log_q(mut proposal: Fcnn) {
    let system = system();
    let (parameters, networks) = (proposal.parameters().clone(), proposal.config().networks);
    let (n, particles) = (5, 4);
    let measurement = [0.4, -1.0, 2.0];
    let previous: Vec<f64> = (0..n * particles).map(|i| (i as f64 * 0.7).sin() * 2.0).collect();
    let later = if networks == OverTime::Shared { 1000 } else { 2 };
    for (time, past) in [(0, None), (1, Some(previous.as_slice())), (later, Some(previous.as_slice()))] {
        let context = Context::new(Step::of_index(time), past, particles);
        let mut memory = initial_memory(&proposal, particles);
        let mut scratch = Default::default();
        let conditional =
            proposal.condition_batch(&system, context, &measurement, &mut memory, &mut scratch).unwrap();
        let mut streams = Seed::from_u64(82).streams(2);
        let (mut states, mut along) = (vec![0.0; n * particles], vec![0.0; particles]);
        conditional.sample(&mut streams, &mut states, &mut along);
        let elsewhere: Vec<f64> = states.iter().map(|x| x + 0.01).collect();
        let mut there = vec![0.0; particles];
        conditional.log_density(&elsewhere, &mut there);
        for row in 0..particles {
            let at = row * n..(row + 1) * n;
            let mut input = context.previous.map_or(vec![0.0; n], |previous| previous.row(row).to_vec());
            input.extend(measurement);
            let dense = by_hand(&parameters, names(networks, time), &input, n);
            for (found, at) in [(along[row], &states[at.clone()]), (there[row], &elsewhere[at])] {
                let expected = dense.log_density(at);
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} for {expected}");
            }
        }
    }
}

#[test]
fn weights_come_from_the_seed_alone() {
    let values = |seed| {
        let config = FcnnConfig { widths: vec![4, 6], ..FcnnConfig::paper() };
        let drawn = Fcnn::create(
            &config,
            &ModelShape::of(&system()),
            3,
            Backend::Native.into(),
            &Seed::from_u64(seed),
        )
        .unwrap();
        let parameters = drawn.parameters();
        (0..parameters.len()).flat_map(|index| parameters.host(index)).collect::<Vec<f64>>()
    };
    assert_eq!(values(1), values(1));
    assert_ne!(values(1), values(2));
    // The first layer has fan-in 5 + 3, C is uniform on ±1/5.
    let drawn = fcnn(Precision::F64);
    let first = named(drawn.parameters(), "mean.1.0.weight");
    let bound = 1.0 / 8.0_f64.sqrt();
    assert!(first.iter().all(|w| w.abs() <= bound) && first.iter().any(|w| w.abs() > 0.8 * bound));
    let mixing = named(drawn.parameters(), "covariance.mixing");
    assert!(mixing.iter().all(|w| w.abs() <= 0.2) && mixing.iter().any(|w| w.abs() > 0.1));
}

#[test]
fn misuse_is_a_typed_error() {
    let (system, mut proposal) = (system(), fcnn(Precision::F32));
    let mut memory = initial_memory(&proposal, 1);
    let context = Context::new(Step::of_index(3), Some(&[0.0; 5]), 1);
    let error = proposal
        .condition_batch(&system, context, &[0.0; 3], &mut memory, &mut Default::default())
        .err()
        .unwrap();
    assert_eq!(error, ProposalError::PastHorizon { horizon: 3, time: 3 });
    assert_eq!(error.to_string(), "this proposal is unrolled over 3 times and was asked for time 3");
    let other =
        GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut Seed::from_u64(1).stream()).unwrap();
    let context = Context::new(Step::of_index(0), None, 1);
    assert!(
        proposal.condition_batch(&other, context, &[0.0; 4], &mut memory, &mut Default::default()).is_err()
    );
    assert_eq!((other.state_dim(), Parametric::state_dim(&proposal)), (6, 5));

    let new = |widths: Vec<usize>, ridge, horizon| {
        Fcnn::create(
            &FcnnConfig { widths, ridge, ..FcnnConfig::paper() },
            &ModelShape::of(&system),
            horizon,
            Backend::Native.into(),
            &Seed::from_u64(1),
        )
        .err()
    };
    assert!(new(vec![4], 1e-6, 0).unwrap().to_string().contains("horizon"));
    assert!(new(vec![4, 0], 1e-6, 3).unwrap().to_string().contains("[4, 0]"));
    assert!(new(vec![4], -1.0, 3).unwrap().to_string().contains("-1"));
    assert!(new(vec![4], f64::NAN, 3).unwrap().to_string().contains("NaN"));
}
