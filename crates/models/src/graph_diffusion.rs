//! The graph-diffusion systems of the paper's figures 1 to 6.

mod batches;

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::batch::{Rows, TileMatrix};
use crate::error::check_matrix;
use crate::{
    AdditiveGaussian, Gaussian, LinearGaussian, ModelError, Noise, PartialLikelihood, RandomGeometricGraph,
    Simulator, StateGradients, StateSpaceModel, Stream, SystemGraph,
};

/// The map `φ` applied to each coordinate of the diffused state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drift {
    /// `φ(x) = x`: a linear system.
    Identity,
    /// `φ(x) = |x|`.
    Abs,
}

impl Drift {
    #[inline]
    fn apply(self, value: f64) -> f64 {
        match self {
            Drift::Identity => value,
            Drift::Abs => value.abs(),
        }
    }

    #[inline]
    fn slope(self, value: f64) -> f64 {
        match self {
            Drift::Identity => 1.0,
            Drift::Abs => value.signum(),
        }
    }
}

/// What determines a [`GraphDiffusion`] but for its random graph. Set fields after [`GraphDiffusionConfig::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct GraphDiffusionConfig {
    /// `N`, the number of nodes and of state coordinates.
    pub state_dim: usize,
    /// `M`, the number of measured coordinates, at most `N` and at least `N/2`.
    pub measurement_dim: usize,
    /// Nearest others that a node is joined to.
    pub neighbours: usize,
    /// Signal-to-noise ratio of both noises, in dB: `σ² = ‖μ₀‖² / 10^(SNR/10)` with `μ₀ = 1`, so `‖μ₀‖² = N`.
    pub snr_db: f64,
    /// `φ`.
    pub drift: Drift,
    /// The family of both noises; the initial state is Gaussian whatever it is.
    pub noise: Noise,
}

impl GraphDiffusionConfig {
    /// The paper's linear Gaussian system with `N` nodes: `M = N − 2`, 3 neighbours, 5 dB.
    pub fn new(state_dim: usize) -> Self {
        GraphDiffusionConfig {
            state_dim,
            measurement_dim: state_dim.saturating_sub(2),
            neighbours: 3,
            snr_db: 5.0,
            drift: Drift::Identity,
            noise: Noise::Gaussian,
        }
    }
}

/// `x_t = φ(A x_{t−1}) + v_t`, `y_t = C x_t + w_t`, `x_0 ~ N(1, I)`.
///
/// `A` is the adjacency matrix of a random geometric graph with spectral norm 1,
/// `C = [I_M, I_{M×(N−M)}]` divided by its spectral norm, and the noises have covariance `σ²I`
/// (the paper's equation for its experiments, section "Numerical Experiments").
#[derive(Debug, Clone)]
pub struct GraphDiffusion {
    adjacency: Mat<f64>,
    measurement_matrix: Mat<f64>,
    diffuse: TileMatrix,
    measure: TileMatrix,
    drift: Drift,
    noise: Noise,
    state_sigma: f64,
    measurement_sigma: f64,
    state_covariance: Mat<f64>,
    measurement_covariance: Mat<f64>,
    initial: Gaussian,
}

impl GraphDiffusion {
    /// Draws the graph and builds the system on it.
    ///
    /// # Errors
    /// As [`RandomGeometricGraph::draw`] and [`GraphDiffusion::on_graph`].
    pub fn random(config: &GraphDiffusionConfig, stream: &mut Stream) -> Result<Self, ModelError> {
        let graph = RandomGeometricGraph::draw(config.state_dim, config.neighbours, stream)?;
        GraphDiffusion::on_graph(config, graph.adjacency())
    }

    /// Builds the system on a given matrix `A` (`N×N`).
    ///
    /// # Errors
    /// [`ModelError::Shape`] or [`ModelError::NotFiniteEntry`] for `A`; [`ModelError::Parameter`] if `M` is not in `N/2 ..= N` and
    /// positive, or the SNR is not finite.
    pub fn on_graph(config: &GraphDiffusionConfig, adjacency: MatRef<'_, f64>) -> Result<Self, ModelError> {
        let (n, m) = (config.state_dim, config.measurement_dim);
        check_matrix("the diffusion matrix A", adjacency, n, n)?;
        if m == 0 || m > n || 2 * m < n {
            return Err(ModelError::Parameter {
                name: "number of measured coordinates M",
                value: format!("{m} for N = {n}"),
                expected: "positive, at most N and at least N/2",
            });
        }
        let sigma = (n as f64 / 10_f64.powf(config.snr_db / 10.0)).sqrt();
        if !(sigma.is_finite() && sigma > 0.0) {
            return Err(ModelError::Parameter {
                name: "signal-to-noise ratio in dB",
                value: config.snr_db.to_string(),
                expected: "a finite number (with a finite, positive noise variance)",
            });
        }
        // Rows of [I, I'] are e_i + e_{M+i} for i < N − M and e_i else, so the norm is √2 if any overlap.
        let norm = if n > m { 2.0_f64.sqrt() } else { 1.0 };
        let measurement_matrix =
            Mat::from_fn(m, n, |i, j| if j == i || j == m + i { 1.0 / norm } else { 0.0 });
        let scaled_identity = |size, scale| Mat::from_fn(size, size, |i, j| if i == j { scale } else { 0.0 });
        Ok(GraphDiffusion {
            diffuse: TileMatrix::new(adjacency),
            measure: TileMatrix::new(measurement_matrix.as_ref()),
            adjacency: adjacency.to_owned(),
            measurement_matrix,
            drift: config.drift,
            noise: config.noise,
            state_sigma: sigma,
            measurement_sigma: sigma,
            state_covariance: scaled_identity(n, sigma * sigma),
            measurement_covariance: scaled_identity(m, sigma * sigma),
            initial: Gaussian::new("covariance of x_0", vec![1.0; n], Mat::identity(n, n))?,
        })
    }

    /// The same system with another noise family of the same moments: what a filter that assumes Gaussian
    /// densities believes, for instance.
    #[must_use]
    pub fn with_noise(&self, noise: Noise) -> Self {
        GraphDiffusion { noise, ..self.clone() }
    }

    /// `A` (`N×N`).
    pub fn adjacency(&self) -> MatRef<'_, f64> {
        self.adjacency.as_ref()
    }

    /// The linear Gaussian model with this system's matrices and second moments, for exact inference.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] unless `φ` is the identity.
    pub fn moment_matched(&self) -> Result<LinearGaussian, ModelError> {
        if self.drift != Drift::Identity {
            return Err(ModelError::Parameter {
                name: "drift",
                value: format!("{:?}", self.drift),
                expected: "Identity, for a linear model",
            });
        }
        LinearGaussian::new(
            self.initial.clone(),
            self.adjacency.clone(),
            self.state_covariance.clone(),
            self.measurement_matrix.clone(),
            self.measurement_covariance.clone(),
        )
    }

    /// `φ(A x)ᵢ`.
    #[inline]
    fn diffused(&self, i: usize, previous: &[f64]) -> f64 {
        self.drift.apply(self.diffuse.row_times(i, previous))
    }
}

impl StateSpaceModel for GraphDiffusion {
    fn state_dim(&self) -> usize {
        self.adjacency.nrows()
    }

    fn measurement_dim(&self) -> usize {
        self.measure.len()
    }

    fn sample_initial(&self, stream: &mut Stream, state: &mut [f64]) {
        self.initial.sample(stream, state);
    }

    fn sample_transition(&self, _time: usize, previous: &[f64], stream: &mut Stream, state: &mut [f64]) {
        for (i, value) in state.iter_mut().enumerate() {
            *value = self.diffused(i, previous) + self.noise.sample(self.state_sigma, stream);
        }
    }

    fn log_initial(&self, state: &[f64]) -> f64 {
        self.initial.log_density(state)
    }

    fn log_transition(&self, _time: usize, previous: &[f64], state: &[f64]) -> f64 {
        let residuals = state.iter().enumerate().map(|(i, value)| value - self.diffused(i, previous));
        self.noise.log_density_of_all(self.state_sigma, residuals)
    }

    fn log_likelihood(&self, _time: usize, state: &[f64], measurement: &[f64]) -> f64 {
        let residuals =
            measurement.iter().enumerate().map(|(i, value)| value - self.measure.row_times(i, state));
        self.noise.log_density_of_all(self.measurement_sigma, residuals)
    }

    fn sample_initials(&self, streams: &mut [Stream], states: &mut [f64]) {
        self.initial.samples(streams, states);
    }

    fn sample_transitions(&self, _time: usize, previous: &[f64], streams: &mut [Stream], states: &mut [f64]) {
        batches::sample_transitions(self, previous, streams, states);
    }

    fn propagate(
        &self,
        _time: usize,
        previous: Rows<'_>,
        measurement: &[f64],
        streams: &mut [Stream],
        states: &mut [f64],
        log_likelihoods: &mut [f64],
    ) {
        batches::propagate(self, previous, measurement, streams, states, log_likelihoods);
    }

    fn log_initials(&self, states: &[f64], out: &mut [f64]) {
        self.initial.log_densities(states, out);
    }

    fn log_transitions(&self, _time: usize, previous: &[f64], states: &[f64], out: &mut [f64]) {
        batches::log_transitions(self, previous, states, out);
    }

    fn log_likelihoods(&self, _time: usize, states: &[f64], measurement: &[f64], out: &mut [f64]) {
        batches::log_likelihoods(self, states, measurement, out);
    }

    /// `S = A`, and a measurement goes with weight 1 to each node that is in it: `Cᵀ` rescaled to ones.
    fn graph(&self) -> Option<SystemGraph> {
        let c = self.measurement_matrix.as_ref();
        let adapter = Mat::from_fn(c.ncols(), c.nrows(), |i, j| if c[(j, i)] != 0.0 { 1.0 } else { 0.0 });
        Some(SystemGraph { shift: self.adjacency.clone(), adapter })
    }
}

/// Entries are independent, so those that are there keep their densities.
impl PartialLikelihood for GraphDiffusion {
    fn partial_log_likelihoods(
        &self,
        _time: usize,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        for (state, out) in states.chunks_exact(self.state_dim()).zip(out) {
            let densities = measurement.iter().enumerate().filter_map(|(i, value)| {
                let residual = (*value)? - self.measure.row_times(i, state);
                Some(self.noise.log_density(self.measurement_sigma, residual))
            });
            *out = densities.sum();
        }
        Ok(())
    }
}

impl Simulator for GraphDiffusion {
    fn sample_measurement(&self, _time: usize, state: &[f64], stream: &mut Stream, measurement: &mut [f64]) {
        for (i, value) in measurement.iter_mut().enumerate() {
            *value = self.measure.row_times(i, state) + self.noise.sample(self.measurement_sigma, stream);
        }
    }
}

impl StateGradients for GraphDiffusion {
    fn initial_gradients(&self, states: &[f64], d_states: &mut [f64]) {
        let n = self.state_dim();
        for (state, d_state) in states.chunks_exact(n).zip(d_states.chunks_exact_mut(n)) {
            self.initial.gradient(|j| state[j] - self.initial.mean()[j], d_state);
        }
    }

    fn transition_gradients(
        &self,
        _time: usize,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        let n = self.state_dim();
        d_previous.fill(0.0);
        for (row, previous) in previous.chunks_exact(n).enumerate() {
            let at = row * n..(row + 1) * n;
            for i in 0..n {
                let flow = self.diffuse.row_times(i, previous);
                let residual = states[at.start + i] - self.drift.apply(flow);
                let slope = self.noise.gradient(self.state_sigma, residual);
                d_states[at.start + i] = slope;
                let back = -slope * self.drift.slope(flow);
                for &(j, value) in self.diffuse.row(i) {
                    d_previous[at.start + j] += back * value;
                }
            }
        }
    }

    fn likelihood_gradients(&self, _time: usize, states: &[f64], measurement: &[f64], d_states: &mut [f64]) {
        let n = self.state_dim();
        d_states.fill(0.0);
        for (state, d_state) in states.chunks_exact(n).zip(d_states.chunks_exact_mut(n)) {
            for (i, value) in measurement.iter().enumerate() {
                let residual = value - self.measure.row_times(i, state);
                let slope = self.noise.gradient(self.measurement_sigma, residual);
                for &(j, entry) in self.measure.row(i) {
                    d_state[j] -= slope * entry;
                }
            }
        }
    }
}

impl AdditiveGaussian for GraphDiffusion {
    fn initial(&self) -> &Gaussian {
        &self.initial
    }

    fn transition_means(&self, _time: usize, previous: &[f64], means: &mut [f64]) {
        batches::transition_means(self, previous, means);
    }

    fn tile_transition_means(&self, _time: usize, previous: &[f64], _particles: usize, means: &mut [f64]) {
        batches::drifted(self, previous, means);
    }

    fn is_gaussian(&self) -> bool {
        self.noise == Noise::Gaussian
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
    fn constants_are_those_of_the_protocol() {
        let config = GraphDiffusionConfig::new(10);
        let system = GraphDiffusion::random(&config, &mut Seed::from_u64(1).stream()).unwrap();
        assert_eq!((system.state_dim(), system.measurement_dim()), (10, 8));
        assert!((system.transition_covariance()[(3, 3)] - 10.0 / 10_f64.powf(0.5)).abs() < 1e-12);
        let c = system.measurement_matrix();
        assert!((c[(0, 8)] - 0.5_f64.sqrt()).abs() < 1e-15 && c[(2, 8)] == 0.0);
        let norm = c.singular_values().unwrap()[0];
        assert!((norm - 1.0).abs() < 1e-14);
    }

    #[test]
    fn unusable_settings_are_refused() {
        let mut stream = Seed::from_u64(1).stream();
        let mut refused = |change: fn(&mut GraphDiffusionConfig)| {
            let mut config = GraphDiffusionConfig::new(10);
            change(&mut config);
            GraphDiffusion::random(&config, &mut stream).unwrap_err().to_string()
        };
        assert!(refused(|c| c.snr_db = f64::NAN).contains("NaN"));
        assert!(refused(|c| c.snr_db = f64::INFINITY).contains("inf"));
        assert!(refused(|c| c.measurement_dim = 0).contains("0 for N = 10"));
        assert!(refused(|c| c.measurement_dim = 11).contains("11 for N = 10"));
    }
}
