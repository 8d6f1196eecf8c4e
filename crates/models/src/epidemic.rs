//! The epidemic of the paper's figure 7 and table 1.

mod transport;

use faer::{Mat, MatRef};

use crate::batch::{LANES, Rows, draw_rows, draw_single_rows, with_noise};
use crate::{
    AdditiveGaussian, Gaussian, ModelError, Noise, Simulator, StateGradients, StateSpaceModel, Step, Stream,
    TransitionDensity,
};

/// `S`, `I` and `R`.
const N: usize = 3;
/// `S` and `R`.
const MEASURED: [usize; 2] = [0, 2];

/// What determines an [`Epidemic`]. Set fields after [`EpidemicConfig::paper`].
#[derive(Debug, Clone, PartialEq)]
pub struct EpidemicConfig {
    /// `β`: infections per susceptible, infected person and unit of time.
    pub infection_rate: f64,
    /// `γ`: the share of the infected that is removed in a unit of time.
    pub removal_rate: f64,
    /// `Δ`, the length of a step in units of time.
    pub time_step: f64,
    /// The means of `S_0`, `I_0` and `R_0`.
    pub initial_means: [f64; N],
    /// The variance of each of them.
    pub initial_variance: f64,
    /// The variance of each coordinate of `v_t`.
    pub state_variance: f64,
    /// The variance of each coordinate of `w_t`.
    pub measurement_variance: f64,
    /// The family of `x_0`, `v_t` and `w_t`.
    pub noise: Noise,
}

impl EpidemicConfig {
    /// The paper's: `β = 5·10⁻⁴`, `γ = 0.04`, `Δ = 0.7`, means 997, 3 and 0, variances 500, 200 and 2500, exponential noise.
    pub fn paper() -> Self {
        EpidemicConfig {
            infection_rate: 5e-4,
            removal_rate: 0.04,
            time_step: 0.7,
            initial_means: [997.0, 3.0, 0.0],
            initial_variance: 500.0,
            state_variance: 200.0,
            measurement_variance: 2500.0,
            noise: Noise::Exponential,
        }
    }
}

/// The susceptible, infected and removed people of an epidemic, `x_t = (S_t, I_t, R_t)`, in steps of Euler's method with noise:
///
/// - `S_{t+1} = S_t − β S_t I_t Δ + v`
/// - `I_{t+1} = I_t + (β S_t I_t − γ I_t) Δ + v`
/// - `R_{t+1} = R_t + γ I_t Δ + v`
/// - `y_t = (S_t, R_t) + w_t`
///
/// This is the paper's equation "sir". All noises are centred and independent, and `x_0` has the same family around its means.
/// Coordinates can become negative. Where `S` or `I` is negative, states can diverge.
#[derive(Debug, Clone)]
pub struct Epidemic {
    config: EpidemicConfig,
    /// `βΔ` and `γΔ`.
    rates: [f64; 2],
    /// Standard deviations of `x_0`, `v_t` and `w_t`.
    sigmas: [f64; 3],
    initial: Gaussian,
    state_covariance: Mat<f64>,
    measurement_matrix: Mat<f64>,
    measurement_covariance: Mat<f64>,
}

impl Epidemic {
    /// Builds the system.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] if a rate or the step is negative, a variance not positive, or anything not finite.
    pub fn new(config: &EpidemicConfig) -> Result<Self, ModelError> {
        let EpidemicConfig { infection_rate, removal_rate, time_step, initial_means, .. } = *config;
        let refuse = |name, value: f64, expected| {
            Err(ModelError::Parameter { name, value: value.to_string(), expected })
        };
        for (name, value) in [
            ("the infection rate β", infection_rate),
            ("the removal rate γ", removal_rate),
            ("the time step Δ", time_step),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return refuse(name, value, "at least 0 and finite");
            }
        }
        if let Some(mean) = initial_means.into_iter().find(|mean| !mean.is_finite()) {
            return refuse("a mean of x_0", mean, "finite");
        }
        let variances = [config.initial_variance, config.state_variance, config.measurement_variance];
        let names = [
            "the variance of x_0",
            "the variance of the state noise",
            "the variance of the measurement noise",
        ];
        for (name, variance) in names.into_iter().zip(variances) {
            if !(variance > 0.0 && variance.is_finite()) {
                return refuse(name, variance, "positive and finite");
            }
        }
        let scaled = |size, variance| Mat::from_fn(size, size, |i, j| if i == j { variance } else { 0.0 });
        let [of_initial, of_states, of_measurements] = variances;
        Ok(Epidemic {
            rates: [infection_rate * time_step, removal_rate * time_step],
            sigmas: variances.map(f64::sqrt),
            initial: Gaussian::new("covariance of x_0", initial_means.to_vec(), scaled(N, of_initial))?,
            state_covariance: scaled(N, of_states),
            measurement_matrix: Mat::from_fn(MEASURED.len(), N, |i, j| f64::from(MEASURED[i] == j)),
            measurement_covariance: scaled(MEASURED.len(), of_measurements),
            config: config.clone(),
        })
    }

    /// The same system with another noise family of the same moments: what a filter that assumes Gaussian densities believes, for
    /// instance.
    #[must_use]
    pub fn with_noise(&self, noise: Noise) -> Self {
        let config = EpidemicConfig { noise, ..self.config.clone() };
        Epidemic { config, ..self.clone() }
    }

    /// The step without noise.
    #[inline]
    fn flow(&self, previous: &[f64]) -> [f64; N] {
        let [infect, remove] = self.rates;
        let &[s, i, r] = row(previous);
        let (infected, removed) = (infect * s * i, remove * i);
        [s - infected, i + infected - removed, r + removed]
    }

    fn initial_deviation(&self, state: &[f64]) -> [f64; N] {
        std::array::from_fn(|j| state[j] - self.config.initial_means[j])
    }
}

/// A state of a slice of three.
#[inline]
fn row(state: &[f64]) -> &[f64; N] {
    match state.as_array() {
        Some(state) => state,
        None => panic!("a state of an epidemic has {N} coordinates, not {}", state.len()),
    }
}

impl StateSpaceModel for Epidemic {
    fn state_dim(&self) -> usize {
        N
    }

    fn measurement_dim(&self) -> usize {
        MEASURED.len()
    }

    fn sample_states(
        &self,
        _step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        let around = |means: [f64; N], sigma: f64, stream: &mut Stream, state: &mut [f64]| {
            for (value, mean) in state.iter_mut().zip(means) {
                *value = mean + self.config.noise.sample(sigma, stream);
            }
        };
        let Some(previous) = previous else {
            return draw_rows(streams, N, states, |_, stream, state| {
                around(self.config.initial_means, self.sigmas[0], stream, state);
            });
        };
        if draw_single_rows(streams, N, states, |row, stream, state| {
            around(self.flow(previous.row(row)), self.sigmas[1], stream, state);
        }) {
            return;
        }
        let fill = |stream: &mut Stream, noise: &mut [f64]| self.config.noise.fill_unit(stream, noise);
        with_noise(streams, N, states.len() / N, fill, |particles, noise| {
            let drawn = states[particles.start * N..particles.end * N].chunks_exact_mut(N);
            for (lane, (row, state)) in particles.zip(drawn).enumerate() {
                for (j, (value, flow)) in state.iter_mut().zip(self.flow(previous.row(row))).enumerate() {
                    *value = flow + self.sigmas[1] * noise[j * LANES + lane];
                }
            }
        });
    }

    /// Entries are independent, so those that are there keep their densities.
    fn log_likelihoods(
        &self,
        _step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        for (state, out) in states.chunks_exact(N).zip(out) {
            let residuals = measurement.iter().zip(MEASURED).filter_map(|(y, at)| Some((*y)? - state[at]));
            *out = self.config.noise.log_density_of_all(self.sigmas[2], residuals);
        }
        Ok(())
    }

    fn density(&self) -> Option<&dyn TransitionDensity> {
        Some(self)
    }
}

impl TransitionDensity for Epidemic {
    fn log_densities(&self, _step: &Step<'_>, previous: Option<Rows<'_>>, states: &[f64], out: &mut [f64]) {
        for (row, (state, out)) in states.chunks_exact(N).zip(out).enumerate() {
            let (means, sigma) = match previous {
                None => (self.config.initial_means, self.sigmas[0]),
                Some(previous) => (self.flow(previous.row(row)), self.sigmas[1]),
            };
            let residuals = state.iter().zip(means).map(|(value, mean)| value - mean);
            *out = self.config.noise.log_density_of_all(sigma, residuals);
        }
    }
}

impl Simulator for Epidemic {
    fn sample_measurements(&self, _step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        draw_rows(streams, MEASURED.len(), out, |row, stream, measurement| {
            for (value, at) in measurement.iter_mut().zip(MEASURED) {
                *value = states[row * N + at] + self.config.noise.sample(self.sigmas[2], stream);
            }
        });
    }
}

impl StateGradients for Epidemic {
    fn initial_gradients(&self, _step: &Step<'_>, states: &[f64], d_states: &mut [f64]) {
        for (state, d_state) in states.chunks_exact(N).zip(d_states.chunks_exact_mut(N)) {
            let deviation = self.initial_deviation(state);
            d_state
                .copy_from_slice(&deviation.map(|value| self.config.noise.gradient(self.sigmas[0], value)));
        }
    }

    fn transition_gradients(
        &self,
        _step: &Step<'_>,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        let [infect, remove] = self.rates;
        let of_states = states.chunks_exact(N).zip(d_states.chunks_exact_mut(N));
        let of_previous = previous.chunks_exact(N).zip(d_previous.chunks_exact_mut(N));
        for ((state, d_state), (previous, d_previous)) in of_states.zip(of_previous) {
            let flow = self.flow(previous);
            for (j, d) in d_state.iter_mut().enumerate() {
                *d = self.config.noise.gradient(self.sigmas[1], state[j] - flow[j]);
            }
            let (&[s, i, _], &[d_s, d_i, d_r]) = (row(previous), row(d_state));
            // What is infected leaves S for I, what is removed leaves I for R.
            let (by_infected, by_removed) = (d_i - d_s, d_r - d_i);
            d_previous.copy_from_slice(&[
                -(d_s + by_infected * infect * i),
                -(d_i + by_infected * infect * s + by_removed * remove),
                -d_r,
            ]);
        }
    }

    fn likelihood_gradients(
        &self,
        _step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    ) {
        d_states.fill(0.0);
        for (state, d_state) in states.chunks_exact(N).zip(d_states.chunks_exact_mut(N)) {
            for (at, y) in MEASURED.into_iter().zip(measurement) {
                d_state[at] = -self.config.noise.gradient(self.sigmas[2], y - state[at]);
            }
        }
    }
}

impl AdditiveGaussian for Epidemic {
    fn is_gaussian(&self) -> bool {
        self.config.noise == Noise::Gaussian
    }

    fn initial(&self) -> &Gaussian {
        &self.initial
    }

    fn transition_means(&self, _step: &Step<'_>, previous: &[f64], means: &mut [f64]) {
        for (previous, mean) in previous.chunks_exact(N).zip(means.chunks_exact_mut(N)) {
            mean.copy_from_slice(&self.flow(previous));
        }
    }

    fn transition_covariance(&self) -> MatRef<'_, f64> {
        self.state_covariance.as_ref()
    }

    fn measurement_matrix(&self) -> MatRef<'_, f64> {
        self.measurement_matrix.as_ref()
    }

    fn measurement_covariance(&self) -> MatRef<'_, f64> {
        self.measurement_covariance.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seed;

    #[test]
    fn a_step_by_hand() {
        let epidemic = Epidemic::new(&EpidemicConfig::paper()).unwrap();
        // βΔ S I = 3.5e-4 · 900 · 100 = 31.5 and γΔ I = 0.028 · 100 = 2.8.
        let found = epidemic.flow(&[900.0, 100.0, 20.0]);
        for (found, expected) in found.into_iter().zip([868.5, 128.7, 22.8]) {
            assert!((found - expected).abs() < 1e-10);
        }
        let total: f64 = found.iter().sum();
        assert!((total - 1020.0).abs() < 1e-10, "nobody comes and nobody goes");
    }

    #[test]
    fn noises_have_the_moments_of_the_paper() {
        let epidemic = Epidemic::new(&EpidemicConfig::paper()).unwrap();
        let mut stream = Seed::from_u64(4).stream();
        let count = 100_000;
        let (mut state, mut measurement) = ([0.0; N], [0.0; 2]);
        let mut sums = [[0.0; 2]; 3];
        for _ in 0..count {
            let (streams, before) = (std::slice::from_mut(&mut stream), [900.0, 100.0, 20.0]);
            epidemic.sample_states(&Step::of_index(0), None, streams, &mut state);
            let of_initial = state[1] - 3.0;
            let step = Step::of_index(1);
            epidemic.sample_states(&step, Some(Rows::all(&before, N)), streams, &mut state);
            let of_states = state[1] - 128.7;
            epidemic.sample_measurements(&step, &before, streams, &mut measurement);
            let of_measurements = measurement[1] - 20.0;
            for (sums, value) in sums.iter_mut().zip([of_initial, of_states, of_measurements]) {
                sums[0] += value / f64::from(count);
                sums[1] += value * value / f64::from(count);
            }
        }
        for ([mean, square], variance) in sums.into_iter().zip([500.0, 200.0, 2500.0_f64]) {
            // The variance of a squared exponential deviation is 8 times that of the square of its mean.
            assert!(mean.abs() < 5.0 * (variance / f64::from(count)).sqrt(), "mean {mean}");
            assert!((square - variance).abs() < 5.0 * variance * (8.0 / f64::from(count)).sqrt(), "{square}");
        }
    }

    #[test]
    fn unusable_settings_are_refused() {
        let refused = |change: fn(&mut EpidemicConfig)| {
            let mut config = EpidemicConfig::paper();
            change(&mut config);
            Epidemic::new(&config).unwrap_err().to_string()
        };
        assert!(refused(|c| c.infection_rate = -1.0).contains("β"));
        assert!(refused(|c| c.time_step = f64::NAN).contains("NaN"));
        assert!(refused(|c| c.initial_means[2] = f64::INFINITY).contains("inf"));
        assert!(refused(|c| c.state_variance = 0.0).contains("the variance of the state noise"));
    }
}
