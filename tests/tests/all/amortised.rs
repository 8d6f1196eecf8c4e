//! Proposals learned once, by networks shared over time, on sequences that were never seen.

use std::ops::ControlFlow;

use faer::mat;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{
    Gaussian, LinearGaussian, Measurements, ModelShape, Seed, SimulatedMeasurements, Simulator,
    StateGradients, StateSpaceModel, Step, simulate,
};
use motes_proposals::{Backend, Family, Fcnn, FcnnConfig, OverTime};
use motes_smc::{
    Bootstrap, FilterSettings, MinDegeneracy, ParticleFilter, Proposal, SecondOpinion, Verdict, WeightReport,
};
use motes_tests::{REFUSED, score};
use motes_train::{AdamConfig, GradientFlow, Objective, TrainConfig, TrainingData, train};

/// `count` sequences of a model.
fn draw(model: &dyn Simulator, horizon: usize, count: usize, seed: &Seed) -> Vec<Measurements> {
    let draw = |mut stream| simulate(model, horizon, &mut stream).unwrap().measurements;
    seed.streams(count).into_iter().map(draw).collect()
}

fn untrained(model: &dyn StateSpaceModel) -> Fcnn {
    let config = FcnnConfig { widths: vec![16, 16], ridge: 0.01, networks: OverTime::Shared };
    let seed = Seed::from_u64(201);
    Fcnn::create(&config, &ModelShape::of(model), 0, Backend::Native.into(), &seed).unwrap()
}

fn trained<'a>(
    model: &'a dyn StateGradients,
    data: impl Into<TrainingData<'a>>,
    config: &TrainConfig,
) -> Fcnn {
    let mut proposal = untrained(model);
    let mut stream = Seed::from_u64(202).stream();
    train(&mut proposal, model, data, config, &mut stream, |_, _| ControlFlow::Continue(())).unwrap();
    proposal
}

/// What filters of some sequences say.
struct Filtered {
    /// The effective sample size as a share of the particles, over all times and sequences.
    share: f64,
    /// The share of all times at which each sign of the first coordinate has a tenth of the weight.
    both_signs: f64,
    /// The log-evidence of each sequence.
    log_evidence: Vec<f64>,
    report: WeightReport,
}

fn filtered<M: StateSpaceModel, P: Proposal<M> + Clone>(
    model: &M,
    proposal: &P,
    particles: usize,
    sequences: &[Measurements],
) -> Filtered {
    let times: usize = sequences.iter().map(|measurements| measurements.len()).sum();
    let mut found =
        Filtered { share: 0.0, both_signs: 0.0, log_evidence: vec![], report: WeightReport::default() };
    for (measurements, stream) in sequences.iter().zip(Seed::from_u64(203).streams(sequences.len())) {
        let settings = FilterSettings::new(particles);
        let mut filter = ParticleFilter::new(model, proposal.clone(), settings, stream).unwrap();
        for measurement in measurements.rows() {
            filter.step(measurement).unwrap();
            found.report.add(&filter.diagnosis());
            found.share += filter.effective_sample_size() / (particles * times) as f64;
            let states = filter.particles().chunks_exact(model.state_dim());
            let weights = filter.weights().normalised().iter().zip(states);
            let positive: f64 = weights.filter(|(_, state)| state[0] > 0.0).map(|(weight, _)| weight).sum();
            found.both_signs += if (0.1..0.9).contains(&positive) { 1.0 / times as f64 } else { 0.0 };
        }
        found.log_evidence.push(filter.log_evidence());
    }
    found
}

fn linear() -> LinearGaussian {
    let start = Gaussian::new("P_0", vec![0.0, 0.0], mat![[4.0, 0.0], [0.0, 4.0]]).unwrap();
    let moves = mat![[0.9, 0.3], [-0.3, 0.9]];
    let noise = mat![[0.3, 0.0], [0.0, 0.3]];
    LinearGaussian::new(start, moves, noise, mat![[1.0, 0.0]], mat![[0.1]]).unwrap()
}

/// Fails if shared networks do not learn, learn the sequences of the training by heart, or cannot go on past their length.
#[test]
fn a_proposal_learned_on_sequences_is_near_the_optimum_on_longer_ones() {
    let (model, seed) = (linear(), Seed::from_u64(204));
    let few = draw(&model, 20, 16, &seed.child("training"));
    let held_out = draw(&model, 100, 4, &seed.child("held out"));
    // With windows of one time each draw is to be the best for its own time: that of minimum degeneracy.
    let config = TrainConfig {
        objective: Objective::Elbo,
        gradient: GradientFlow::Truncated { window: 1 },
        steps: 600,
        sequences_per_step: 4,
        adam: AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() },
        ..TrainConfig::paper(8)
    };
    let source = SimulatedMeasurements::new(&model, 20, 1e6);
    let share = |found: Filtered| found.share;
    let before = share(filtered(&model, &untrained(&model), 100, &held_out));
    let plain = share(filtered(&model, &Bootstrap, 100, &held_out));
    let best = share(filtered(&model, &MinDegeneracy::new(&model).unwrap(), 100, &held_out));
    for (name, data) in [("recorded", (&few).into()), ("fresh", TrainingData::Fresh(&source))] {
        let after = share(filtered(&model, &trained(&model, data, &config), 100, &held_out));
        println!("{name}: {after:.3}; untrained {before:.3}, bootstrap {plain:.3}, optimum {best:.3}");
        // 400 shares, each within 0.3 of their mean, have a mean that is known to about 0.015.
        assert!(before < plain - 0.1 && after > plain + 0.1 && after > best - 0.08, "{name}");
    }
}

/// The growth model of Netto, Gimeno and Mendes (1978): a measurement does not tell the sign of the state.
struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
        state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
        measurement.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

/// A Gaussian that never sees a state learns one of two modes. Its mean effective sample size looks well, and its evidence is wrong.
///
/// Fails if a single Gaussian trained without states were good enough where the posterior has two modes.
#[test]
fn a_single_gaussian_collapses_on_one_of_two_modes_and_its_mean_effective_sample_size_does_not_say_so() {
    let seed = Seed::from_u64(205);
    let held_out = draw(&Growth, 50, 8, &seed.child("held out"));
    let times = 400.0;
    let exact = filtered(&Growth, &Bootstrap, 10_000, &held_out);
    let of_each = |found: &Filtered| found.log_evidence.iter().sum::<f64>() / times;
    println!("bootstrap: {:.2}, {:.2}, {:.2}", exact.share, exact.both_signs, of_each(&exact));
    assert!(exact.both_signs > 0.2);
    let source = SimulatedMeasurements::new(&Growth, 20, 1e6);
    for (objective, least_share) in [(Objective::LogLikelihood, 0.2), (Objective::Elbo, exact.share)] {
        let config = TrainConfig {
            objective,
            steps: 300,
            sequences_per_step: 4,
            adam: AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() },
            ..TrainConfig::paper(8)
        };
        let found =
            filtered(&Growth, &trained(&Growth, TrainingData::Fresh(&source), &config), 100, &held_out);
        println!("{objective:?}: {:.2}, {:.2}, {:.2}", found.share, found.both_signs, of_each(&found));
        let missing: Vec<f64> =
            exact.log_evidence.iter().zip(&found.log_evidence).map(|(exact, found)| exact - found).collect();
        println!("    {}", found.report);
        println!("    missing by sequence {missing:.1?}, {:.1} standard errors", score(&missing, 0.0));
        assert!(found.share > least_share, "the weights look well");
        assert!(found.both_signs < 0.5 * exact.both_signs, "it has one mode");
        // More than a nat of every measurement, whichever sequences were drawn.
        assert!(score(&missing, times / 8.0) > REFUSED, "the evidence is wrong");
    }
}

/// A bootstrap filter beside such a filter says so, in nearly every sequence.
#[test]
fn a_second_opinion_catches_a_gaussian_that_collapsed_on_one_of_two_modes() {
    let seed = Seed::from_u64(206);
    let held_out = draw(&Growth, 60, 8, &seed.child("held out"));
    let source = SimulatedMeasurements::new(&Growth, 20, 1e6);
    let config = TrainConfig {
        objective: Objective::LogLikelihood,
        steps: 300,
        sequences_per_step: 4,
        adam: AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() },
        ..TrainConfig::paper(8)
    };
    let learned = trained(&Growth, TrainingData::Fresh(&source), &config);
    let settings = FilterSettings::new(1000);
    let warned = held_out.iter().enumerate().filter(|(number, measurements)| {
        let stream = |label: &str| seed.child(label).nth(*number as u64).stream();
        let mut filter = ParticleFilter::new(&Growth, learned.clone(), settings, stream("filter")).unwrap();
        let mut bootstrap = ParticleFilter::new(&Growth, Bootstrap, settings, stream("bootstrap")).unwrap();
        let mut opinion = SecondOpinion::new();
        for row in measurements.rows() {
            if filter.step(row).is_err() {
                break;
            }
            let _ = bootstrap.step(row);
            opinion.step(&filter, &bootstrap).unwrap();
        }
        matches!(opinion.verdict(), Verdict::Warns { .. })
    });
    let warned = warned.count();
    assert!(warned >= 7, "{warned} of 8 are warned of");
}
