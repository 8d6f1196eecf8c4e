//! Every log density's state gradient against central differences.

use faer::mat;
use motes_models::batch::Rows;
use motes_models::{
    Derivative, Drift, Epidemic, EpidemicConfig, Gaussian, GradientError, GraphDiffusion,
    GraphDiffusionConfig, LinearGaussian, ModelError, Noise, Seed, Simulator, StateGradients,
    StateSpaceModel, Step, Stream, TransitionDensity, check_gradients,
};

const TOLERANCE: f64 = 1e-5;

fn check(model: &(impl StateGradients + Simulator), stream_seed: u64) {
    let report = check_gradients(model, 3, TOLERANCE, &mut Seed::from_u64(stream_seed).stream()).unwrap();
    assert!(report.compared > 10 * report.skipped, "{report:?}");
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

fn dense() -> LinearGaussian {
    let initial = Gaussian::new("P_0", vec![0.5, -1.0], mat![[1.0, 0.3], [0.3, 2.0]]).unwrap();
    LinearGaussian::new(
        initial,
        mat![[0.9, 0.2], [-0.1, 0.8]],
        mat![[0.5, 0.1], [0.1, 0.4]],
        mat![[1.0, 0.4], [-0.3, 0.8], [0.5, 0.2]],
        mat![[0.6, 0.1, 0.0], [0.1, 0.9, -0.2], [0.0, -0.2, 0.7]],
    )
    .unwrap()
}

#[test]
fn linear_gaussian_with_dense_covariances() {
    check(&dense(), 11);
}

/// A mistake in gradients: what it does to the batch of the derivative that it concerns.
struct Mistaken {
    model: LinearGaussian,
    derivative: Derivative,
    mistake: fn(&mut [f64]),
}

impl Mistaken {
    fn make(&self, derivative: Derivative, gradients: &mut [f64]) {
        if derivative == self.derivative {
            (self.mistake)(gradients);
        }
    }
}

impl StateSpaceModel for Mistaken {
    fn state_dim(&self) -> usize {
        self.model.state_dim()
    }
    fn measurement_dim(&self) -> usize {
        self.model.measurement_dim()
    }
    fn sample_states(
        &self,
        step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        self.model.sample_states(step, previous, streams, states);
    }
    fn log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        self.model.log_likelihoods(step, states, measurement, out)
    }
    fn density(&self) -> Option<&dyn TransitionDensity> {
        self.model.density()
    }
}

impl Simulator for Mistaken {
    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        self.model.sample_measurements(step, states, streams, out);
    }
}

impl StateGradients for Mistaken {
    fn initial_gradients(&self, step: &Step<'_>, states: &[f64], d_states: &mut [f64]) {
        self.model.initial_gradients(step, states, d_states);
        self.make(Derivative::Initial, d_states);
    }
    fn transition_gradients(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        self.model.transition_gradients(step, previous, states, d_previous, d_states);
        self.make(Derivative::TransitionByPrevious, d_previous);
        self.make(Derivative::TransitionByState, d_states);
    }
    fn likelihood_gradients(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    ) {
        self.model.likelihood_gradients(step, states, measurement, d_states);
        self.make(Derivative::Likelihood, d_states);
    }
}

#[test]
fn a_mistake_in_any_derivative_is_found_in_its_place() {
    // A factor near 1, a sign, a number that was not written, and rows after the first that were forgotten.
    let mistakes: [fn(&mut [f64]); 4] = [
        |batch| batch.iter_mut().skip(1).step_by(2).for_each(|d| *d *= 1.001),
        |batch| batch.iter_mut().skip(1).step_by(2).for_each(|d| *d = -*d),
        |batch| batch[3] = f64::NAN,
        |batch| batch.iter_mut().skip(3).step_by(2).for_each(|d| *d = 0.0),
    ];
    for derivative in [
        Derivative::Initial,
        Derivative::TransitionByPrevious,
        Derivative::TransitionByState,
        Derivative::Likelihood,
    ] {
        for (number, mistake) in mistakes.into_iter().enumerate() {
            let mistaken = Mistaken { model: dense(), derivative, mistake };
            let found = check_gradients(&mistaken, 3, TOLERANCE, &mut Seed::from_u64(12).stream());
            let said = found.as_ref().err().map(ToString::to_string).unwrap_or_default();
            let Err(GradientError::Wrong(worst)) = found else { panic!("{derivative} {number}: {found:?}") };
            assert_eq!((worst.derivative, worst.coordinate), (derivative, 1), "{number}: {worst:?}");
            assert!(worst.relative_error > TOLERANCE || worst.relative_error.is_nan(), "{number}: {worst:?}");
            assert!(
                said.starts_with(&format!("{derivative} at time {}, coordinate 1, is", worst.time)),
                "{said}"
            );
        }
    }
}

#[test]
fn a_derivative_that_cannot_be_compared_is_not_taken_for_right() {
    // With noise this small next to the states, a step is beyond the support.
    let initial_means = [1e9, 0.0, 0.0];
    let config = EpidemicConfig {
        infection_rate: 0.0,
        removal_rate: 0.0,
        initial_means,
        initial_variance: 1e12,
        state_variance: 1e-6,
        measurement_variance: 1e-6,
        noise: Noise::Uniform,
        ..EpidemicConfig::paper()
    };
    let model = Epidemic::new(&config).unwrap();
    let found = check_gradients(&model, 2, TOLERANCE, &mut Seed::from_u64(13).stream());
    assert_eq!(found, Err(GradientError::NotCompared(Derivative::TransitionByPrevious)));
}
