//! Derivatives that the proposals and training take, against central differences in f64.

use faer::{Mat, MatRef, Side};
use motes_models::{Drift, GraphDiffusion, GraphDiffusionConfig, Measurements, Noise, Seed, simulate};
use motes_proposals::{
    Backend, Compute, Fcnn, FcnnConfig, GaussianBatch, KernelCovariance, Learnable, Precision,
    cholesky_adjoint,
};
use motes_smc::Conditional;
use motes_tests::{central_differences, relative_distance};
use motes_train::{Objective, rollout};
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

fn small_fcnn(system: &GraphDiffusion, compute: Compute) -> Fcnn {
    let config = FcnnConfig { widths: vec![6, 7], ridge: 1e-3 };
    Fcnn::new(&config, system, 3, compute, &Seed::from_u64(69)).unwrap()
}

/// The value of the loss and its gradient with respect to each matrix of weights.
fn loss_and_gradients(
    proposal: &dyn Learnable,
    system: &GraphDiffusion,
    measurements: &Measurements,
    objective: Objective,
) -> (f64, Vec<Vec<f64>>) {
    let mut stream = Seed::from_u64(70).stream();
    let found = rollout(proposal, system, measurements, objective, 4, &mut stream).unwrap();
    let gradients = found.gradients.tensors().iter().map(|gradient| {
        gradient.clone().expect("every matrix has a gradient").try_into_vec_as::<f64>().unwrap()
    });
    (-found.objective, gradients.collect())
}

#[test]
fn the_whole_objective_with_respect_to_every_weight() {
    let compute = Compute { backend: Backend::Flex, precision: Precision::F64 };
    for drift in [Drift::Identity, Drift::Abs] {
        let (system, measurements) = problem(drift);
        for objective in [Objective::LogLikelihood, Objective::Literal, Objective::Elbo] {
            let mut proposal = small_fcnn(&system, compute);
            let (_, gradients) = loss_and_gradients(&proposal, &system, &measurements, objective);
            for (index, gradient) in gradients.iter().enumerate() {
                let values = proposal.parameters().host(index).unwrap();
                let numeric = central_differences(&values, 1e-5, |values| {
                    proposal.parameters_mut().set_host(index, values).unwrap();
                    loss_and_gradients(&proposal, &system, &measurements, objective).0
                });
                proposal.parameters_mut().set_host(index, &values).unwrap();
                let error = relative_distance(gradient, &numeric);
                let name = &proposal.parameters().names()[index];
                assert!(error < 1e-5, "{drift:?}, {objective:?}, {name}: relative error {error:e}");
            }
        }
    }
}

#[test]
fn backends_agree_on_loss_and_gradients() {
    let (system, measurements) = problem(Drift::Identity);
    for (precision, tolerance) in [(Precision::F32, 1e-4), (Precision::F64, 1e-9)] {
        for objective in [Objective::LogLikelihood, Objective::Elbo] {
            let [flex, ndarray] = [Backend::Flex, Backend::NdArray].map(|backend| {
                let proposal = small_fcnn(&system, Compute { backend, precision });
                loss_and_gradients(&proposal, &system, &measurements, objective)
            });
            assert!((flex.0 / ndarray.0 - 1.0).abs() < tolerance);
            let distance = relative_distance(&flex.1.concat(), &ndarray.1.concat());
            assert!(distance < tolerance, "{precision:?}: gradients differ by {distance:e}");
        }
    }
}
