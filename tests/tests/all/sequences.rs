//! Training on many sequences: what a step takes of them, its gradient, and what is refused.

use std::ops::ControlFlow;

use motes_models::{
    GraphDiffusion, GraphDiffusionConfig, MeasurementSource, Measurements, ModelError, ModelShape, Seed,
    SimulatedMeasurements, Stream, simulate,
};
use motes_proposals::{Backend, Compute, Family, Fcnn, FcnnConfig, Learnable, OverTime, Precision};
use motes_tests::{every_small_family, relative_distance, small_fcnn};
use motes_train::{
    AdamConfig, GradientFlow, Objective, TrainConfig, TrainError, Training, TrainingData, rollout, train,
};

const F64: Compute = Compute { backend: Backend::Native, precision: Precision::F64 };

/// Sequences of 3, 1, 2, 3 and 1 times.
fn problem() -> (GraphDiffusion, Vec<Measurements>) {
    let seed = Seed::from_u64(210);
    let system =
        GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut seed.child("graph").stream()).unwrap();
    let draw = |(horizon, mut stream): (usize, Stream)| {
        simulate(&system, horizon, &mut stream).unwrap().measurements
    };
    let all = [3, 1, 2, 3, 1].into_iter().zip(seed.streams(5)).map(draw).collect();
    (system, all)
}

fn families(system: &GraphDiffusion) -> Vec<(String, Box<dyn Learnable>)> {
    every_small_family(&ModelShape::on_graph(system), 3, F64, &Seed::from_u64(211))
}

fn weights(proposal: &dyn Learnable) -> Vec<f64> {
    proposal.parameters().values().host(0..proposal.parameters().values().len())
}

fn stream() -> Stream {
    Seed::from_u64(212).stream()
}

/// Minus the change of the weights in one step of an optimiser whose step is the gradient itself, to a millionth of it.
fn gradient_of_one_step<'a>(
    proposal: &mut dyn Learnable,
    system: &GraphDiffusion,
    data: impl Into<TrainingData<'a>>,
    sequences_per_step: usize,
) -> (f64, Vec<f64>) {
    let adam = AdamConfig { learning_rate: 1e9, epsilon: 1e9, ..AdamConfig::paper() };
    let config = TrainConfig {
        objective: Objective::Elbo,
        steps: 1,
        sequences_per_step,
        adam,
        ..TrainConfig::paper(4)
    };
    let before = weights(proposal);
    let proceed = |_, _| ControlFlow::Continue(());
    let history = train(proposal, system, data, &config, &mut stream(), proceed).unwrap();
    let change = before.iter().zip(weights(proposal)).map(|(before, after)| before - after).collect();
    (history.losses[0], change)
}

/// Fails if gradients are summed instead of averaged, one of them is lost, or a network that only some sequences reach gets a wrong share.
#[test]
fn the_gradient_of_a_step_is_the_mean_of_the_gradients_of_its_sequences() {
    let (system, all) = problem();
    for (name, mut proposal) in families(&system) {
        let (mut loss, mut mean, mut stream) = (0.0, vec![0.0; weights(&*proposal).len()], stream());
        for measurements in &all {
            let (objective, flow) = (Objective::Elbo, GradientFlow::Full);
            let mut found =
                rollout(&*proposal, &system, measurements, objective, flow, 4, &mut stream).unwrap();
            loss -= found.objective / 5.0;
            found.workspace.hand_over(|part| {
                let motes_proposals::Slice::F64(values) = part.values else { panic!("64 bits") };
                mean[part.range].iter_mut().zip(values).for_each(|(mean, value)| *mean += value / 5.0);
            });
        }
        let (found, gradient) = gradient_of_one_step(&mut *proposal, &system, &all, 5);
        assert!((found / loss - 1.0).abs() < 1e-12, "{name}: {found} for {loss}");
        let distance = relative_distance(&gradient, &mean);
        assert!(distance < 1e-5, "{name}: {distance:e}");
    }
}

/// Fails if something is drawn for a choice that there is not, or if one sequence is treated otherwise than alone.
#[test]
fn a_step_that_takes_all_sequences_draws_nothing_for_the_choice() {
    let (system, all) = problem();
    let trained = |data: TrainingData<'_>, sequences_per_step: usize| {
        let (_, mut proposal) = families(&system).swap_remove(0);
        let config = TrainConfig { steps: 5, sequences_per_step, ..TrainConfig::paper(4) };
        let proceed = |_, _| ControlFlow::Continue(());
        let history = train(&mut *proposal, &system, data, &config, &mut stream(), proceed).unwrap();
        (history, weights(&*proposal))
    };
    assert_eq!(trained((&all[0]).into(), 1), trained((&all[..1]).into(), 1));
    assert_eq!(trained((&all[0]).into(), 1), trained((&all[..1]).into(), 7));
    assert_eq!(trained((&all).into(), 5), trained((&all).into(), 100));
    assert_ne!(trained((&all).into(), 5), trained((&all).into(), 4));
}

#[test]
fn a_training_on_many_sequences_goes_on_to_the_last_bit() {
    let (system, all) = problem();
    let source = SimulatedMeasurements::new(&system, 3, 1e6);
    for data in [(&all).into(), TrainingData::Fresh(&source)] {
        for at in 0..families(&system).len() {
            let config = TrainConfig { steps: 6, sequences_per_step: 2, ..TrainConfig::paper(4) };
            let run = |stop: Option<usize>| {
                let (name, mut proposal) = families(&system).swap_remove(at);
                let mut first = stream();
                let mut training = Training::new(&*proposal, &system, data, &config, &mut first).unwrap();
                let steps = stop.unwrap_or(6);
                (0..steps).for_each(|_| assert!(training.step(&mut *proposal).is_ok()));
                let bytes = training.checkpoint(&*proposal).unwrap();
                let (_, mut proposal) = families(&system).swap_remove(at);
                let mut second = stream();
                let mut training = Training::new(&*proposal, &system, data, &config, &mut second).unwrap();
                training.resume(&mut *proposal, &bytes).unwrap();
                while !training.is_finished() {
                    training.step(&mut *proposal).unwrap();
                }
                (name, training.into_history(), weights(&*proposal))
            };
            let expected = run(None);
            for steps in [0, 1, 4] {
                assert_eq!(run(Some(steps)), expected, "after {steps} steps");
            }
        }
    }
}

/// A source of one recorded sequence.
struct Same<'a>(&'a Measurements);

impl MeasurementSource for Same<'_> {
    fn draw(&self, _stream: &mut Stream) -> Result<Measurements, ModelError> {
        Ok(self.0.clone())
    }
}

#[test]
fn what_does_not_fit_is_refused_in_one_line_before_anything_changes() {
    let (system, all) = problem();
    let shape = ModelShape::of(&system);
    let of = |networks: OverTime, horizon: usize| {
        let config = FcnnConfig { networks, ..small_fcnn() };
        Fcnn::create(&config, &shape, horizon, Backend::Native.into(), &Seed::from_u64(213)).unwrap()
    };
    let said = |proposal: &mut Fcnn, data: TrainingData<'_>, sequences_per_step: usize| {
        let before = weights(proposal);
        let config = TrainConfig { steps: 2, sequences_per_step, ..TrainConfig::paper(4) };
        let proceed = |_, _| ControlFlow::Continue(());
        let found = train(proposal, &system, data, &config, &mut stream(), proceed);
        assert!(found.is_ok() || weights(proposal) == before);
        found.map(|_| ()).map_err(|error| error.to_string())
    };
    let refused = |line: &str| Err(line.to_string());
    let (mut shared, mut short) = (of(OverTime::Shared, 0), of(OverTime::EachTime, 2));
    let with = |other: Measurements| [all[0].clone(), other];
    assert_eq!(said(&mut shared, (&all).into(), 3), Ok(()));
    assert_eq!(
        said(&mut shared, (&[]).into(), 1),
        refused("the number of sequences of measurements is 0; it must be at least 1")
    );
    assert_eq!(
        said(&mut shared, (&all).into(), 0),
        refused("the number of sequences in a step is 0; it must be at least 1")
    );
    let empty = "the number of measurements T is 0; it must be at least 1";
    let nothing = Measurements::new(3, vec![]).unwrap();
    assert_eq!(
        said(&mut shared, (&with(nothing.clone())).into(), 1),
        refused(&format!("sequence 1, counted from 0: {empty}"))
    );
    assert_eq!(said(&mut shared, (&nothing).into(), 1), refused(empty));
    assert_eq!(said(&mut shared, TrainingData::Fresh(&Same(&nothing)), 1), refused(empty));
    let wide = Measurements::new(4, vec![0.0; 8]).unwrap();
    let error = said(&mut shared, (&with(wide.clone())).into(), 1).unwrap_err();
    assert!(error.starts_with("sequence 1, counted from 0: ") && error.contains('4'), "{error}");
    assert!(said(&mut shared, TrainingData::Fresh(&Same(&wide)), 1).is_err());
    let long = "the number of measurements T is 3; it must be at most the horizon of the unrolled proposal";
    assert_eq!(
        said(&mut short, (&all[1..]).into(), 1),
        refused(&format!("sequence 2, counted from 0: {long}"))
    );
    assert_eq!(said(&mut short, TrainingData::Fresh(&Same(&all[0])), 1), refused(long));
    let none = SimulatedMeasurements::new(&system, 0, 1e6);
    assert!(said(&mut shared, TrainingData::Fresh(&none), 1).unwrap_err().contains("horizon T"));
    let (config, mut stream) = (TrainConfig::paper(0), stream());
    let found = Training::new(&shared, &system, TrainingData::Fresh(&none), &config, &mut stream);
    assert!(matches!(found.err(), Some(TrainError::Setting { .. })));
}

/// Fails if memory that was made for one proposal is used for another.
#[test]
fn another_proposal_than_before_is_refused_and_nothing_breaks() {
    let (system, all) = problem();
    for (name, mut first) in families(&system) {
        for (other_name, mut other) in families(&system).into_iter().filter(|(other, _)| *other != name) {
            let (config, mut stream) =
                (TrainConfig { sequences_per_step: 2, ..TrainConfig::paper(4) }, stream());
            let mut training = Training::new(&*first, &system, &all, &config, &mut stream).unwrap();
            training.step(&mut *first).unwrap();
            // Once with the memory of the first, once with new memory and the moments of the first.
            for _ in 0..2 {
                let found = training.step(&mut *other);
                assert!(
                    matches!(found, Err(TrainError::Optimiser { .. })),
                    "{name}, {other_name}: {found:?}"
                );
            }
        }
    }
}
