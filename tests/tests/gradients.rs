//! Derivatives that the proposals and training take, against central differences in f64.

use std::ops::ControlFlow;

use faer::{Mat, MatRef, Side};
use motes_models::{Drift, GraphDiffusion, GraphDiffusionConfig, Measurements, Noise, Seed, simulate};
use motes_proposals::{
    Backend, Compute, GaussianBatch, Gradients, KernelCovariance, Learnable, Precision, cholesky_adjoint,
};
use motes_smc::Conditional;
use motes_tests::{central_differences, distance, norm, relative_distance, small_families};
use motes_train::{AdamConfig, GradientFlow, Objective, TrainConfig, rollout, train};
use rand::RngExt;

fn random(count: usize, seed: u64) -> Vec<f64> {
    let mut stream = Seed::from_u64(seed).stream();
    (0..count).map(|_| 2.0 * stream.random::<f64>() - 1.0).collect()
}

fn lower(covariance: MatRef<'_, f64>) -> Mat<f64> {
    covariance.llt(Side::Lower).unwrap().L().to_owned()
}

#[test]
fn the_adjoint_of_the_cholesky_factor() {
    let n = 5;
    let b = random(n * n, 60);
    let b = MatRef::from_column_major_slice(&b, n, n);
    let covariance = b * b.transpose() + Mat::<f64>::identity(n, n);
    let weights = random(n * n, 61);
    // The scalar Σᵢⱼ wᵢⱼ Lᵢⱼ of the lower triangle, as a function of the lower triangle of Σ.
    let scalar = |values: &[f64]| {
        let sigma = MatRef::from_column_major_slice(values, n, n);
        let l = lower(sigma);
        (0..n).flat_map(|j| (j..n).map(move |i| (i, j))).map(|(i, j)| weights[i + n * j] * l[(i, j)]).sum()
    };
    let values: Vec<f64> = (0..n * n).map(|at| covariance[(at % n, at / n)]).collect();
    let numeric = central_differences(&values, 1e-6, scalar);
    let d_lower = Mat::from_fn(n, n, |i, j| if i >= j { weights[i + n * j] } else { 0.0 });
    let adjoint = cholesky_adjoint(lower(covariance.as_ref()).as_ref(), d_lower.as_ref());
    let (mut found, mut expected) = (vec![], vec![]);
    for j in 0..n {
        for i in j..n {
            // An entry below the diagonal stands for itself and its mirror image.
            found.push(adjoint[(i, j)] * if i == j { 1.0 } else { 2.0 });
            expected.push(numeric[i + n * j]);
        }
    }
    assert!(relative_distance(&found, &expected) < 1e-5);
}

#[test]
fn a_sample_and_its_log_density_through_the_kernel_covariance() {
    let (n, particles) = (4, 3);
    let (z, mixing) = (random(n * particles, 62), random(n * n, 63));
    let (noise, d_states, d_log) =
        (random(n * particles, 64), random(n * particles, 65), random(particles, 66));
    let ridge = 0.05;
    let scalar = |z: &[f64], mixing: &[f64]| {
        let lowers = KernelCovariance::new(n, mixing, ridge).unwrap().factors(z).unwrap();
        let mut states = vec![0.0; n * particles];
        for row in 0..particles {
            let l = MatRef::from_column_major_slice(&lowers[row * n * n..(row + 1) * n * n], n, n);
            for i in 0..n {
                states[row * n + i] = (0..n).map(|j| l[(i, j)] * noise[row * n + j]).sum();
            }
        }
        let mut log_density = vec![0.0; particles];
        GaussianBatch::new(n, vec![0.0; n * particles], lowers).log_density(&states, &mut log_density);
        let of_states: f64 = states.iter().zip(&d_states).map(|(x, d)| x * d).sum();
        of_states + log_density.iter().zip(&d_log).map(|(l, d)| l * d).sum::<f64>()
    };
    let covariance = KernelCovariance::new(n, &mixing, ridge).unwrap();
    let lowers = covariance.factors(&z).unwrap();
    let (d_z, d_mixing) = covariance.pull_back(&z, &lowers, &noise, &d_states, &d_log);
    assert!(relative_distance(&d_z, &central_differences(&z, 1e-6, |z| scalar(z, &mixing))) < 1e-5);
    let numeric = central_differences(&mixing, 1e-6, |mixing| scalar(&z, mixing));
    assert!(relative_distance(&d_mixing, &numeric) < 1e-5);
}

fn problem(drift: Drift) -> (GraphDiffusion, Measurements) {
    let config = GraphDiffusionConfig { drift, noise: Noise::Gaussian, ..GraphDiffusionConfig::new(5) };
    let system = GraphDiffusion::random(&config, &mut Seed::from_u64(67).stream()).unwrap();
    let measurements = simulate(&system, 3, &mut Seed::from_u64(68).stream()).unwrap().measurements;
    (system, measurements)
}

fn families(system: &GraphDiffusion, compute: Compute) -> Vec<(String, Box<dyn Learnable>)> {
    small_families(system, 3, compute, &Seed::from_u64(69))
}

/// The value of the loss and its gradient with respect to each matrix of weights.
fn loss_and_gradients(
    proposal: &dyn Learnable,
    system: &GraphDiffusion,
    measurements: &Measurements,
    objective: Objective,
) -> (f64, Vec<Vec<f64>>) {
    let mut stream = Seed::from_u64(70).stream();
    let flow = GradientFlow::Full;
    let found = rollout(proposal, system, measurements, objective, flow, 4, &mut stream).unwrap();
    (-found.objective, host(&found.gradients, proposal))
}

/// The gradient of each matrix; zeros where the loss does not depend on it, as on what multiplies `x_{−1} = 0`.
fn host(gradients: &Gradients, proposal: &dyn Learnable) -> Vec<Vec<f64>> {
    let sizes = proposal.parameters().tensors().iter().map(|matrix| matrix.dims().iter().product());
    let gradients =
        gradients.tensors().iter().zip(sizes).map(|(gradient, size): (_, usize)| match gradient {
            Some(gradient) => gradient.clone().try_into_vec_as::<f64>().unwrap(),
            None => vec![0.0; size],
        });
    gradients.collect()
}

/// Holds the gradient with respect to each matrix against central differences.
fn check_gradients(
    label: &str,
    proposal: &mut dyn Learnable,
    loss_and_gradients: &dyn Fn(&dyn Learnable) -> (f64, Vec<Vec<f64>>),
) {
    let (_, gradients) = loss_and_gradients(proposal);
    let whole = norm(&gradients.concat());
    for (index, gradient) in gradients.iter().enumerate() {
        let values = proposal.parameters().host(index).unwrap();
        let numeric = central_differences(&values, 1e-5, |values| {
            proposal.parameters_mut().set_host(index, values).unwrap();
            loss_and_gradients(proposal).0
        });
        proposal.parameters_mut().set_host(index, &values).unwrap();
        let name = &proposal.parameters().names()[index];
        // What the loss does not depend on (an offset common to all of z, say) has a gradient of rounding errors.
        let error = distance(gradient, &numeric) / (norm(&numeric) + 1e-5 * whole);
        assert!(error < 1e-5, "{label}, {name}: relative error {error:e}");
    }
}

const F64: Compute = Compute { backend: Backend::Flex, precision: Precision::F64 };

#[test]
fn the_whole_objective_with_respect_to_every_weight() {
    for drift in [Drift::Identity, Drift::Abs] {
        let (system, measurements) = problem(drift);
        for (name, mut proposal) in families(&system, F64) {
            for objective in [Objective::LogLikelihood, Objective::Literal, Objective::Elbo] {
                check_gradients(
                    &format!("{name}, {drift:?}, {objective:?}"),
                    proposal.as_mut(),
                    &|proposal| loss_and_gradients(proposal, &system, &measurements, objective),
                );
            }
        }
    }
}

#[test]
fn the_whole_objective_of_trained_proposals() {
    let (system, measurements) = problem(Drift::Identity);
    for (name, mut proposal) in families(&system, F64) {
        let adam = AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() };
        let config = TrainConfig { steps: 50, adam, ..TrainConfig::paper(4) };
        let mut stream = Seed::from_u64(71).stream();
        let proceed = |_, _| ControlFlow::Continue(());
        train(proposal.as_mut(), &system, &measurements, &config, &mut stream, proceed).unwrap();
        check_gradients(&format!("trained {name}"), proposal.as_mut(), &|proposal| {
            loss_and_gradients(proposal, &system, &measurements, Objective::Elbo)
        });
    }
}

#[test]
fn backends_agree_on_loss_and_gradients() {
    let (system, measurements) = problem(Drift::Identity);
    for (precision, tolerance) in [(Precision::F32, 1e-4), (Precision::F64, 1e-9)] {
        for objective in [Objective::LogLikelihood, Objective::Elbo] {
            let of = |backend| families(&system, Compute { backend, precision });
            for ((name, flex), (_, ndarray)) in of(Backend::Flex).into_iter().zip(of(Backend::NdArray)) {
                let [flex, ndarray] = [flex, ndarray]
                    .map(|proposal| loss_and_gradients(proposal.as_ref(), &system, &measurements, objective));
                assert!((flex.0 / ndarray.0 - 1.0).abs() < tolerance, "{name}");
                let distance = relative_distance(&flex.1.concat(), &ndarray.1.concat());
                assert!(distance < tolerance, "{name}, {precision:?}: gradients differ by {distance:e}");
            }
        }
    }
}

#[test]
fn a_truncated_gradient_is_that_of_windows_that_take_their_past_as_given() {
    let (system, measurements) = problem(Drift::Abs);
    let gradients = |proposal: &dyn Learnable, flow| {
        let mut stream = Seed::from_u64(70).stream();
        let objective = Objective::LogLikelihood;
        let found = rollout(proposal, &system, &measurements, objective, flow, 4, &mut stream).unwrap();
        host(&found.gradients, proposal).concat()
    };
    for (name, proposal) in families(&system, F64) {
        let of = |flow| gradients(proposal.as_ref(), flow);
        let (full, whole) = (of(GradientFlow::Full), of(GradientFlow::Truncated { window: 3 }));
        assert_eq!(full, whole, "{name}: one window of all three times is the full gradient");
        let detached = of(GradientFlow::Truncated { window: 1 });
        assert!(relative_distance(&detached, &full) > 1e-3, "{name}: nothing flows through time");
    }
}
