//! Every log density's state gradient against central differences.

use faer::mat;
use motes_models::{
    Drift, Epidemic, EpidemicConfig, Gaussian, GraphDiffusion, GraphDiffusionConfig, LinearGaussian, Noise,
    Seed, Simulator, StateGradients, simulate,
};

/// ‖analytic − numeric‖ / ‖numeric‖ of a gradient in one point.
fn relative_error(analytic: &[f64], at: &[f64], f: impl Fn(&[f64]) -> f64) -> f64 {
    let h = 1e-5;
    let numeric: Vec<f64> = (0..at.len())
        .map(|i| {
            let (mut up, mut down) = (at.to_vec(), at.to_vec());
            up[i] += h;
            down[i] -= h;
            (f(&up) - f(&down)) / (2.0 * h)
        })
        .collect();
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let difference = norm(&mut analytic.iter().zip(&numeric).map(|(a, b)| a - b));
    difference / norm(&mut numeric.iter().copied()).max(1e-3)
}

fn check(model: &(impl StateGradients + Simulator), stream_seed: u64) {
    let n = model.state_dim();
    let trajectory = simulate(model, 3, &mut Seed::from_u64(stream_seed).stream()).unwrap();
    let (previous, state) = (trajectory.states.row(0), trajectory.states.row(1));
    let measurement = trajectory.measurements.row(1);
    let (mut d_previous, mut d_state) = (vec![0.0; n], vec![0.0; n]);

    model.initial_gradients(previous, &mut d_state);
    assert!(relative_error(&d_state, previous, |x| model.log_initial(x)) < 1e-5);

    model.transition_gradients(1, previous, state, &mut d_previous, &mut d_state);
    assert!(relative_error(&d_state, state, |x| model.log_transition(1, previous, x)) < 1e-5);
    assert!(relative_error(&d_previous, previous, |x| model.log_transition(1, x, state)) < 1e-5);

    model.likelihood_gradients(1, state, measurement, &mut d_state);
    assert!(relative_error(&d_state, state, |x| model.log_likelihood(1, x, measurement)) < 1e-5);
}

#[test]
fn graph_diffusion_of_every_drift_and_noise() {
    for drift in [Drift::Identity, Drift::Abs] {
        for noise in [Noise::Gaussian, Noise::Exponential, Noise::Uniform] {
            let config = GraphDiffusionConfig { drift, noise, ..GraphDiffusionConfig::new(7) };
            let system = GraphDiffusion::random(&config, &mut Seed::from_u64(9).stream()).unwrap();
            check(&system, 10);
        }
    }
}

#[test]
fn epidemic_of_every_noise() {
    for noise in [Noise::Gaussian, Noise::Exponential, Noise::Uniform] {
        // More infected than the paper begins with, so that every entry of the Jacobian counts.
        let initial_means = [800.0, 150.0, 50.0];
        check(
            &Epidemic::new(&EpidemicConfig { noise, initial_means, ..EpidemicConfig::paper() }).unwrap(),
            11,
        );
    }
}

#[test]
fn linear_gaussian_with_dense_covariances() {
    let initial = Gaussian::new("P_0", vec![0.5, -1.0], mat![[1.0, 0.3], [0.3, 2.0]]).unwrap();
    let model = LinearGaussian::new(
        initial,
        mat![[0.9, 0.2], [-0.1, 0.8]],
        mat![[0.5, 0.1], [0.1, 0.4]],
        mat![[1.0, 0.4], [-0.3, 0.8], [0.5, 0.2]],
        mat![[0.6, 0.1, 0.0], [0.1, 0.9, -0.2], [0.0, -0.2, 0.7]],
    )
    .unwrap();
    check(&model, 11);
}
