//! The linear Gaussian model with dense covariances: the one with exact answers.

use std::slice::from_mut;

use faer::{Mat, MatRef};

use crate::batch::{
    LANES, Rows, TileMatrix, draw_rows, draw_single_rows, load, store, with_noise, with_scratch,
};
use crate::equations::{Coordinates, Marginals, normal};
use crate::error::check_matrix;
use crate::marginal::by_draws;
use crate::{
    AdditiveGaussian, Gaussian, Marginal, ModelError, Simulator, StateGradients, StateSpaceModel, Step,
    Stream, TransitionDensity, fill_standard_normal,
};

/// `x_0 ~ N(μ₀, P₀)`, `x_t = A x_{t−1} + v_t`, `v_t ~ N(0, Q)`, `y_t = C x_t + w_t`, `w_t ~ N(0, R)`.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian};
///
/// // A damped random walk, measured with unit noise.
/// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]])?;
/// # Ok::<(), motes_models::ModelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct LinearGaussian {
    initial: Gaussian,
    transition_matrix: Mat<f64>,
    state_noise: Gaussian,
    measurement_matrix: Mat<f64>,
    measurement_noise: Gaussian,
    transition_tiles: TileMatrix,
    measurement_tiles: TileMatrix,
}

impl LinearGaussian {
    /// Takes `p(x_0)`, `A` (`N×N`), `Q` (`N×N`), `C` (`M×N`) and `R` (`M×M`).
    ///
    /// # Errors
    /// [`ModelError::Shape`] or [`ModelError::NotFiniteEntry`] for `A` or `C`, [`ModelError::Covariance`] for `Q` or `R`;
    /// [`ModelError::Parameter`] if `M` is 0.
    pub fn new(
        initial: Gaussian,
        transition_matrix: Mat<f64>,
        state_covariance: Mat<f64>,
        measurement_matrix: Mat<f64>,
        measurement_covariance: Mat<f64>,
    ) -> Result<Self, ModelError> {
        let n = initial.mean().len();
        let m = measurement_covariance.nrows();
        if m == 0 {
            return Err(ModelError::Parameter {
                name: "the model's measurement dimension M",
                value: "0".into(),
                expected: "at least 1",
            });
        }
        check_matrix("the transition matrix A", transition_matrix.as_ref(), n, n)?;
        check_matrix("the measurement matrix C", measurement_matrix.as_ref(), m, n)?;
        Ok(LinearGaussian {
            transition_tiles: TileMatrix::new(transition_matrix.as_ref()),
            measurement_tiles: TileMatrix::new(measurement_matrix.as_ref()),
            initial,
            transition_matrix,
            state_noise: Gaussian::new("the state-noise covariance Q", vec![0.0; n], state_covariance)?,
            measurement_matrix,
            measurement_noise: Gaussian::new(
                "the measurement-noise covariance R",
                vec![0.0; m],
                measurement_covariance,
            )?,
        })
    }

    /// `A`, `N×N`.
    pub fn transition_matrix(&self) -> MatRef<'_, f64> {
        self.transition_matrix.as_ref()
    }
}

#[inline]
fn row_times(matrix: &Mat<f64>, i: usize, x: &[f64]) -> f64 {
    x.iter().enumerate().map(|(j, value)| matrix[(i, j)] * value).sum()
}

impl StateSpaceModel for LinearGaussian {
    fn state_dim(&self) -> usize {
        self.transition_matrix.nrows()
    }

    fn measurement_dim(&self) -> usize {
        self.measurement_matrix.nrows()
    }

    fn sample_states(
        &self,
        _step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        let n = self.state_dim();
        if draw_single_rows(streams, n, states, |row, stream, state| {
            let Some(previous) = previous else { return self.initial.sample(stream, state) };
            self.state_noise.sample_deviation(stream, state);
            for (i, value) in state.iter_mut().enumerate() {
                *value += row_times(&self.transition_matrix, i, previous.row(row));
            }
        }) {
            return;
        }
        let Some(previous) = previous else { return self.initial.samples(streams, states) };
        with_scratch(2 * n * LANES, |scratch| {
            let (from, to) = scratch.split_at_mut(n * LANES);
            with_noise(streams, n, states.len() / n, fill_standard_normal, |particles, noise| {
                previous.load(particles.start, from);
                self.transition_tiles.times(from, to);
                self.state_noise.tile_add_deviation(noise, to);
                store(to, n, &mut states[particles.start * n..particles.end * n]);
            });
        });
    }

    fn log_likelihoods(
        &self,
        _step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        let (n, m) = (self.state_dim(), self.measurement_dim());
        if measurement.iter().any(Option::is_none) {
            let known: Vec<(usize, f64)> =
                measurement.iter().enumerate().filter_map(|(i, value)| Some((i, (*value)?))).collect();
            if known.is_empty() {
                out.fill(0.0);
                return Ok(());
            }
            let noise = self.noise_of(&known)?;
            for (state, out) in states.chunks_exact(n).zip(out) {
                *out = noise.log_density_of(|i| {
                    let (row, value) = known[i];
                    value - row_times(&self.measurement_matrix, row, state)
                });
            }
            return Ok(());
        }
        with_scratch((n + 2 * m) * LANES, |scratch| {
            let (tile, rest) = scratch.split_at_mut(n * LANES);
            let (residuals, whitened) = rest.split_at_mut(m * LANES);
            for (states, out) in states.chunks(n * LANES).zip(out.chunks_mut(LANES)) {
                load(states, n, tile);
                let rows = residuals.as_chunks_mut::<LANES>().0;
                for (row, value) in rows.iter_mut().zip(measurement.iter().flatten()) {
                    row.fill(*value);
                }
                self.measurement_tiles.times_subtract(tile, residuals);
                self.measurement_noise.tile_log_density(residuals, whitened, out);
            }
        });
        Ok(())
    }

    fn log_likelihood(
        &self,
        _step: &Step<'_>,
        state: &[f64],
        measurement: &[f64],
    ) -> Result<f64, ModelError> {
        let residual = |i: usize| measurement[i] - row_times(&self.measurement_matrix, i, state);
        Ok(self.measurement_noise.log_density_of(residual))
    }

    fn density(&self) -> Option<&dyn TransitionDensity> {
        Some(self)
    }
}

impl TransitionDensity for LinearGaussian {
    fn log_density(&self, _step: &Step<'_>, previous: Option<&[f64]>, state: &[f64]) -> f64 {
        match previous {
            None => self.initial.log_density(state),
            Some(previous) => self
                .state_noise
                .log_density_of(|i| state[i] - row_times(&self.transition_matrix, i, previous)),
        }
    }

    fn log_densities(&self, _step: &Step<'_>, previous: Option<Rows<'_>>, states: &[f64], out: &mut [f64]) {
        let Some(previous) = previous else { return self.initial.log_densities(states, out) };
        let n = self.state_dim();
        with_scratch(2 * n * LANES, |scratch| {
            let (from, to) = scratch.split_at_mut(n * LANES);
            for (tile, (states, out)) in states.chunks(n * LANES).zip(out.chunks_mut(LANES)).enumerate() {
                previous.load(tile * LANES, from);
                load(states, n, to);
                self.transition_tiles.times_subtract(from, to);
                self.state_noise.tile_log_density(to, from, out);
            }
        });
    }
}

impl LinearGaussian {
    /// The noise of some entries of a measurement: the marginal of a Gaussian, whose covariance has their rows of `R`.
    fn noise_of(&self, known: &[(usize, f64)]) -> Result<Gaussian, ModelError> {
        let r = self.measurement_covariance();
        Gaussian::new(
            "the covariance of the measured entries",
            vec![0.0; known.len()],
            // Mirrored, so that what rounding is beside large entries is not an asymmetry beside small ones.
            Mat::from_fn(known.len(), known.len(), |i, j| r[(known[i.max(j)].0, known[i.min(j)].0)]),
        )
    }
}

impl Simulator for LinearGaussian {
    fn sample_measurements(&self, _step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        let n = self.state_dim();
        draw_rows(streams, self.measurement_dim(), out, |row, stream, measurement| {
            self.measurement_noise.sample_deviation(stream, measurement);
            for (i, value) in measurement.iter_mut().enumerate() {
                *value += row_times(&self.measurement_matrix, i, &states[row * n..(row + 1) * n]);
            }
        });
    }

    fn marginals(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        stream: &mut Stream,
        out: &mut [Marginal],
    ) {
        let (n, m) = (self.state_dim(), self.measurement_dim());
        by_draws(measurement, out, |drawn| self.sample_measurements(step, states, from_mut(stream), drawn));
        for (state, out) in states.chunks_exact(n).zip(out.chunks_exact_mut(m)) {
            let mut marginals = Marginals::of(measurement, out);
            for i in 0..m {
                let mean = row_times(&self.measurement_matrix, i, state);
                marginals.push(normal(mean, self.measurement_covariance()[(i, i)].sqrt()));
            }
        }
    }
}

impl StateGradients for LinearGaussian {
    fn initial_gradients(&self, _step: &Step<'_>, states: &[f64], d_states: &mut [f64]) {
        let n = self.state_dim();
        for (state, d_state) in states.chunks_exact(n).zip(d_states.chunks_exact_mut(n)) {
            self.initial.gradient(|j| state[j] - self.initial.mean()[j], d_state);
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
        let n = self.state_dim();
        for row in 0..states.len() / n {
            let at = row * n..(row + 1) * n;
            let (previous, state) = (&previous[at.clone()], &states[at.clone()]);
            let d_state = &mut d_states[at.clone()];
            self.state_noise
                .gradient(|i| state[i] - row_times(&self.transition_matrix, i, previous), d_state);
            pull_back(&self.transition_matrix, d_state, &mut d_previous[at]);
        }
    }

    fn likelihood_gradients(
        &self,
        _step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    ) {
        let n = self.state_dim();
        let mut d_measurement = vec![0.0; self.measurement_dim()];
        for (state, d_state) in states.chunks_exact(n).zip(d_states.chunks_exact_mut(n)) {
            self.measurement_noise.gradient(
                |i| measurement[i] - row_times(&self.measurement_matrix, i, state),
                &mut d_measurement,
            );
            pull_back(&self.measurement_matrix, &d_measurement, d_state);
        }
    }
}

/// `−matrixᵀ · d`, the gradient of a density of `value − matrix · x` with respect to `x`.
fn pull_back(matrix: &Mat<f64>, d: &[f64], out: &mut [f64]) {
    for (j, out) in out.iter_mut().enumerate() {
        *out = -d.iter().enumerate().map(|(i, d)| matrix[(i, j)] * d).sum::<f64>();
    }
}

impl AdditiveGaussian for LinearGaussian {
    fn initial(&self) -> &Gaussian {
        &self.initial
    }

    fn transition_means(&self, _step: &Step<'_>, previous: &[f64], means: &mut [f64]) {
        let n = self.state_dim();
        with_scratch(2 * n * LANES, |scratch| {
            let (from, to) = scratch.split_at_mut(n * LANES);
            for (previous, means) in previous.chunks(n * LANES).zip(means.chunks_mut(n * LANES)) {
                load(previous, n, from);
                self.transition_tiles.times(from, to);
                store(to, n, means);
            }
        });
    }

    fn tile_transition_means(
        &self,
        _step: &Step<'_>,
        previous: &[f64],
        _particles: usize,
        means: &mut [f64],
    ) {
        self.transition_tiles.times(previous, means);
    }

    fn is_gaussian(&self) -> bool {
        true
    }

    fn transition_covariance(&self) -> MatRef<'_, f64> {
        self.state_noise.covariance()
    }

    fn measurement_matrix(&self) -> MatRef<'_, f64> {
        self.measurement_matrix.as_ref()
    }

    fn measurement_covariance(&self) -> MatRef<'_, f64> {
        self.measurement_noise.covariance()
    }
}
