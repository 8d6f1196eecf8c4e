//! A training goes on from a checkpoint to the last bit, and nothing else is taken for a checkpoint.

use motes_models::{GraphDiffusion, GraphDiffusionConfig, Measurements, ModelShape, Seed, Stream, simulate};
use motes_proposals::{Backend, Compute, Learnable, Precision};
use motes_tests::every_small_family;
use motes_train::{Schedule, TrainConfig, TrainError, Training};

const STEPS: usize = 6;

fn problem() -> (GraphDiffusion, Measurements) {
    let system =
        GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut Seed::from_u64(150).stream()).unwrap();
    let measurements = simulate(&system, 3, &mut Seed::from_u64(151).stream()).unwrap().measurements;
    (system, measurements)
}

fn config() -> TrainConfig {
    TrainConfig { steps: STEPS, ..TrainConfig::paper(7) }
}

fn regularised() -> TrainConfig {
    TrainConfig { dropout: 0.3, weight_penalty: 0.01, schedule: Schedule::Cosine, ..config() }
}

fn stream() -> Stream {
    Seed::from_u64(152).stream()
}

fn weights(proposal: &dyn Learnable) -> Vec<Vec<f64>> {
    (0..proposal.parameters().len()).map(|at| proposal.parameters().host(at)).collect()
}

#[test]
fn every_family_goes_on_to_the_last_bit() {
    goes_on(&config());
}

/// Masks come from the stream whose position a checkpoint holds, and the learning rate from the number of its losses.
#[test]
fn with_dropout_a_penalty_and_a_falling_learning_rate_too() {
    goes_on(&regularised());
}

fn goes_on(config: &TrainConfig) {
    let (system, measurements) = problem();
    let built = |precision| Backend::built(precision).map(move |backend| (backend, precision));
    for (backend, precision) in [Precision::F32, Precision::F64].into_iter().flat_map(built) {
        let compute = Compute { backend, precision };
        let fresh = || {
            let mut all =
                every_small_family(&ModelShape::on_graph(&system), 3, compute, &Seed::from_u64(153));
            all.retain(|(_, proposal)| config.dropout == 0.0 || !proposal.hidden_readers().is_empty());
            all
        };
        for at in 0..fresh().len() {
            let run = |checkpoint_after: Option<usize>| {
                let (name, mut proposal) = fresh().swap_remove(at);
                let mut first = stream();
                let mut training =
                    Training::new(&*proposal, &system, &measurements, config, &mut first).unwrap();
                let Some(steps) = checkpoint_after else {
                    while !training.is_finished() {
                        training.step(&mut *proposal).unwrap();
                    }
                    return (name, training.into_history(), weights(&*proposal));
                };
                (0..steps).for_each(|_| assert!(training.step(&mut *proposal).is_ok()));
                let bytes = training.checkpoint(&*proposal).unwrap();
                let (name, mut proposal) = fresh().swap_remove(at);
                let mut second = stream();
                let mut training =
                    Training::new(&*proposal, &system, &measurements, config, &mut second).unwrap();
                training.resume(&mut *proposal, &bytes).unwrap();
                assert_eq!(training.history().losses.len(), steps);
                while !training.is_finished() {
                    training.step(&mut *proposal).unwrap();
                }
                (name, training.into_history(), weights(&*proposal))
            };
            let expected = run(None);
            for steps in [0, 1, 4, STEPS] {
                assert_eq!(run(Some(steps)), expected, "{backend:?} {precision:?} after {steps} steps");
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let (system, measurements) = problem();
    let compute = Compute { backend: Backend::Native, precision: Precision::F32 };
    let all = |compute| every_small_family(&ModelShape::on_graph(&system), 3, compute, &Seed::from_u64(153));
    let checkpoint = |at: usize, compute: Compute, steps: usize| {
        let (_, mut proposal) = all(compute).swap_remove(at);
        let (config, mut stream) = (config(), stream());
        let mut training = Training::new(&*proposal, &system, &measurements, &config, &mut stream).unwrap();
        (0..steps).for_each(|_| assert!(training.step(&mut *proposal).is_ok()));
        training.checkpoint(&*proposal).unwrap()
    };
    let good = checkpoint(0, compute, 5);
    let (_, mut proposal) = all(compute).swap_remove(0);
    let before = weights(&*proposal);
    let mut refused = |bytes: &[u8], steps: usize, expected: &str| {
        let (config, mut stream) = (TrainConfig { steps, ..config() }, stream());
        let mut training = Training::new(&*proposal, &system, &measurements, &config, &mut stream).unwrap();
        let error = training.resume(&mut *proposal, bytes).unwrap_err();
        assert!(matches!(error, TrainError::NotResumed { .. }));
        assert!(error.to_string().contains(expected), "{error}");
        assert!(training.history().losses.is_empty());
        assert_eq!(weights(&*proposal), before);
    };
    refused(&checkpoint(1, compute, 1), STEPS, "instead of");
    refused(&checkpoint(0, Compute { precision: Precision::F64, ..compute }, 1), STEPS, "F64 and not F32");
    refused(&good, 4, "it took 5 steps of 4");
    // With other bytes in the place of the first ones of a part.
    let tampered = |name: &str, bytes: &[u8]| {
        let from =
            safetensors::SafeTensors::deserialize(&good).unwrap().tensor(name).unwrap().data().as_ptr();
        let at = from as usize - good.as_ptr() as usize;
        let mut other = good.clone();
        other[at..at + bytes.len()].copy_from_slice(bytes);
        other
    };
    refused(&tampered("losses", &f64::NAN.to_le_bytes()), STEPS, "losses are not all finite");
    for steps in [6, -1, i32::MAX] {
        let expected = format!("a matrix took {steps} steps of 5");
        refused(&tampered("steps of each matrix", &steps.to_le_bytes()), STEPS, &expected);
    }
    for length in [0, 8, 100, good.len() - 1] {
        refused(&good[..length], STEPS, "not a checkpoint");
    }
}
