//! The optimiser, against its definition written out weight by weight.

use std::ops::ControlFlow;

use motes_models::{GraphDiffusion, GraphDiffusionConfig, Measurements, ModelShape, Seed, simulate};
use motes_proposals::{Backend, Compute, Family, Fcnn, Parametric, Precision};
use motes_tests::small_fcnn;
use motes_train::{Adam, AdamConfig, GradientFlow, Objective, TrainConfig, TrainError, rollout, train};

const ADAM: AdamConfig = AdamConfig { learning_rate: 0.01, beta_1: 0.8, beta_2: 0.95, epsilon: 1e-6 };
const STEPS: usize = 4;
const PARTICLES: usize = 5;

fn problem(horizon: usize) -> (GraphDiffusion, Measurements) {
    let system =
        GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut Seed::from_u64(130).stream()).unwrap();
    let measurements = simulate(&system, horizon, &mut Seed::from_u64(131).stream()).unwrap().measurements;
    (system, measurements)
}

fn weights(proposal: &Fcnn) -> Vec<Vec<f64>> {
    (0..proposal.parameters().len()).map(|at| proposal.parameters().host(at)).collect()
}

/// Kingma and Ba's algorithm 1, for every weight that has a gradient.
fn by_definition(proposal: &mut Fcnn, system: &GraphDiffusion, measurements: &Measurements) {
    let mut moments: Vec<Vec<[f64; 2]>> =
        weights(proposal).iter().map(|matrix| vec![[0.0; 2]; matrix.len()]).collect();
    let mut stream = Seed::from_u64(132).stream();
    for step in 1..=STEPS as i32 {
        let (objective, flow) = (Objective::LogLikelihood, GradientFlow::Full);
        let found = rollout(proposal, system, measurements, objective, flow, PARTICLES, &mut stream).unwrap();
        let gradients = found.workspace.into_gradients();
        for (at, moments) in moments.iter_mut().enumerate() {
            let Some(gradient) = gradients.host(at) else { continue };
            let mut values = proposal.parameters().host(at);
            for ((value, g), [m, v]) in values.iter_mut().zip(gradient).zip(moments) {
                *m = ADAM.beta_1 * *m + (1.0 - ADAM.beta_1) * g;
                *v = ADAM.beta_2 * *v + (1.0 - ADAM.beta_2) * g * g;
                let (unbiased_m, unbiased_v) =
                    (*m / (1.0 - ADAM.beta_1.powi(step)), *v / (1.0 - ADAM.beta_2.powi(step)));
                *value -= ADAM.learning_rate * unbiased_m / (unbiased_v.sqrt() + ADAM.epsilon);
            }
            proposal.parameters_mut().set_host(at, &values).unwrap();
        }
    }
}

#[test]
fn weights_move_as_the_definition_says_and_those_without_a_gradient_stay() {
    for (precision, tolerance) in [(Precision::F64, 1e-11), (Precision::F32, 2e-4)] {
        // One time fewer than the proposal is unrolled over: its last network has no gradient.
        let (system, measurements) = problem(2);
        let compute = Compute { backend: Backend::Native, precision };
        let drawn =
            Fcnn::create(&small_fcnn(), &ModelShape::of(&system), 3, compute, &Seed::from_u64(133)).unwrap();
        let (mut found, mut expected) = (drawn.clone(), drawn.clone());
        let config = TrainConfig { steps: STEPS, adam: ADAM, ..TrainConfig::paper(PARTICLES) };
        let mut stream = Seed::from_u64(132).stream();
        let proceed = |_, _| ControlFlow::Continue(());
        train(&mut found, &system, &measurements, &config, &mut stream, proceed).unwrap();
        by_definition(&mut expected, &system, &measurements);
        let names = drawn.parameters().names();
        let all = weights(&drawn).into_iter().zip(weights(&found)).zip(weights(&expected)).zip(names);
        for (((before, found), expected), name) in all {
            // How far a weight moved is what is compared.
            let farthest = found
                .iter()
                .zip(&expected)
                .map(|(found, expected)| (found - expected).abs())
                .fold(0.0, f64::max);
            assert!(
                farthest
                    <= tolerance * ADAM.learning_rate * STEPS as f64
                        + 1e-7 * f64::from(precision == Precision::F32),
                "{name}: {farthest:e}"
            );
            assert_eq!(before == found, name.starts_with("mean.2."), "{name}");
        }
    }
}

fn drawn(system: &GraphDiffusion, horizon: usize, precision: Precision) -> Fcnn {
    let compute = Compute { backend: Backend::Native, precision };
    Fcnn::create(&small_fcnn(), &ModelShape::of(system), horizon, compute, &Seed::from_u64(134)).unwrap()
}

#[test]
fn a_loop_of_ones_own_moves_weights_as_training_does() {
    let (system, measurements) = problem(3);
    let mut expected = drawn(&system, 3, Precision::F32);
    let mut found = expected.clone();
    let config = TrainConfig { steps: STEPS, adam: ADAM, ..TrainConfig::paper(PARTICLES) };
    let proceed = |_, _| ControlFlow::Continue(());
    let mut stream = Seed::from_u64(135).stream();
    train(&mut expected, &system, &measurements, &config, &mut stream, proceed).unwrap();

    let (mut adam, mut stream) = (Adam::new(&ADAM).unwrap(), Seed::from_u64(135).stream());
    for _ in 0..STEPS {
        let TrainConfig { objective, gradient, particles, .. } = config;
        let mut step =
            rollout(&found, &system, &measurements, objective, gradient, particles, &mut stream).unwrap();
        adam.step(found.parameters_mut(), &mut step.workspace).unwrap();
    }
    assert_eq!(weights(&found), weights(&expected));
}

#[test]
fn gradients_and_moments_of_other_parameters_are_refused_and_change_nothing() {
    let (system, measurements) = problem(2);
    let workspace = |proposal: &Fcnn| {
        let (objective, flow, mut stream) =
            (Objective::Elbo, GradientFlow::Full, Seed::from_u64(136).stream());
        rollout(proposal, &system, &measurements, objective, flow, 3, &mut stream).unwrap().workspace
    };
    let longer = drawn(&system, 3, Precision::F32);
    let wider = drawn(&system, 2, Precision::F64);
    for other in [&longer, &wider] {
        let mut proposal = drawn(&system, 2, Precision::F32);
        let before = weights(&proposal);
        let mut adam = Adam::new(&ADAM).unwrap();
        let error = adam.step(proposal.parameters_mut(), &mut workspace(other)).unwrap_err();
        assert_eq!(error, TrainError::Optimiser { what: "gradients" });
        assert_eq!(weights(&proposal), before);

        adam.step(other.clone().parameters_mut(), &mut workspace(other)).unwrap();
        let mut own = workspace(&proposal);
        let error = adam.step(proposal.parameters_mut(), &mut own).unwrap_err();
        assert_eq!(error, TrainError::Optimiser { what: "the moments of earlier steps" });
        assert_eq!(weights(&proposal), before);
    }
    assert!(Adam::new(&AdamConfig { beta_1: 1.0, ..ADAM }).is_err());
}
