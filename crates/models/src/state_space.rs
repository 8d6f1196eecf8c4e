//! The traits of a state-space model: what a filter needs, and what training and designed proposals add.

use faer::MatRef;

use crate::batch::{Rows, load, particles_by_stream, store, with_scratch};
use crate::{Gaussian, ModelError, Step, Stream};

/// A hidden Markov model on ℝᴺ, measured in ℝᴹ: `p(x_0)`, `p(x_t | x_{t−1})`, `p(y_t | x_t)`.
///
/// Densities are logarithmic and normalised; −∞ says that a point lies outside the support. The step is the one to the state
/// that is drawn or weighed. A transition therefore has an index of 1 at least.
///
/// The plural methods do the same for a batch of `K` particles, row-major `K×N`. Their default is a loop. A model overrides
/// them where a batch is cheaper than its rows.
pub trait StateSpaceModel: Sync {
    /// `N`, the number of coordinates of a state.
    fn state_dim(&self) -> usize;

    /// `M`, the number of coordinates of a measurement.
    fn measurement_dim(&self) -> usize;

    /// The step of that index where nobody says more: rows one unit of time apart, the first at 0, with the inputs and parameters that the model has by itself.
    ///
    /// How many inputs and parameters it has is how many the model takes.
    fn step_of_index(&self, index: usize) -> Step<'_> {
        Step::of_index(index)
    }

    /// Draws `x_0 ~ p(x_0)` into `state` (`N`).
    fn sample_initial(&self, stream: &mut Stream, state: &mut [f64]);

    /// Draws `x_t ~ p(x_t | x_{t−1})` into `state` (`N`), given `previous` (`N`).
    fn sample_transition(&self, step: &Step<'_>, previous: &[f64], stream: &mut Stream, state: &mut [f64]);

    /// `log p(x_0)` at `state` (`N`).
    fn log_initial(&self, state: &[f64]) -> f64;

    /// `log p(x_t | x_{t−1})` at `state` (`N`), given `previous` (`N`).
    fn log_transition(&self, step: &Step<'_>, previous: &[f64], state: &[f64]) -> f64;

    /// `log p(y_t | x_t)` of `measurement` (`M`) at `state` (`N`).
    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> f64;

    /// [`StateSpaceModel::sample_initial`] for each of `K` rows; the rows are split evenly over `streams`, in order.
    ///
    /// # Panics
    /// If `K` is not a multiple of the number of streams.
    fn sample_initials(&self, streams: &mut [Stream], states: &mut [f64]) {
        let width = self.state_dim();
        let particles = states.len() / width;
        for (stream, states) in particles_by_stream(streams, states, width, particles) {
            for state in states.chunks_exact_mut(width) {
                self.sample_initial(stream, state);
            }
        }
    }

    /// [`StateSpaceModel::sample_transition`] for each of `K` rows, whose previous states may be picked from others by resampling; the rows are
    /// split evenly over `streams`, in order.
    ///
    /// A model may take another amount of a stream here than row by row. The numbers of one stream do not depend on the other
    /// streams in the call.
    ///
    /// # Panics
    /// If `K` is not a multiple of the number of streams.
    fn sample_transitions(
        &self,
        step: &Step<'_>,
        previous: Rows<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        let width = self.state_dim();
        let particles = states.len() / width;
        let mut row = 0;
        for (stream, states) in particles_by_stream(streams, states, width, particles) {
            for state in states.chunks_exact_mut(width) {
                self.sample_transition(step, previous.row(row), stream, state);
                row += 1;
            }
        }
    }

    /// Says that these particles (`K×N`) will be asked for next, a tile at a time: a model whose answers cost less together may find them now. No answer is
    /// another for it.
    fn foresee(&self, _step: &Step<'_>, _previous: Rows<'_>) {}

    /// This model as one that draws and weighs in one pass, if it has such a form.
    fn propagator(&self) -> Option<&dyn Propagator> {
        None
    }

    /// [`StateSpaceModel::log_initial`] of each of `K` rows, into `out` (`K`).
    fn log_initials(&self, states: &[f64], out: &mut [f64]) {
        for (state, out) in states.chunks_exact(self.state_dim()).zip(out) {
            *out = self.log_initial(state);
        }
    }

    /// [`StateSpaceModel::log_transition`] of each of `K` rows, whose previous states may be picked from others, into `out` (`K`).
    fn log_transitions(&self, step: &Step<'_>, previous: Rows<'_>, states: &[f64], out: &mut [f64]) {
        for (row, (state, out)) in states.chunks_exact(self.state_dim()).zip(out).enumerate() {
            *out = self.log_transition(step, previous.row(row), state);
        }
    }

    /// [`StateSpaceModel::log_likelihood`] of one measurement at each of `K` rows, into `out` (`K`).
    fn log_likelihoods(&self, step: &Step<'_>, states: &[f64], measurement: &[f64], out: &mut [f64]) {
        for (state, out) in states.chunks_exact(self.state_dim()).zip(out) {
            *out = self.log_likelihood(step, state, measurement);
        }
    }
}

/// A model that can draw transitions and weigh them in one pass over the particles.
///
/// It gives what [`StateSpaceModel::sample_transitions`] and then [`StateSpaceModel::log_likelihoods`] give, to the last bit, and saves bringing the
/// states that were drawn from memory once more.
pub trait Propagator: Sync {
    /// Draws `x_t ~ p(x_t | x_{t−1})` for each of `K` rows into `states` (`K×N`) and writes `log p(y_t | x_t)` into `log_likelihoods` (`K`). The rows are
    /// split evenly over `streams`, in order.
    ///
    /// # Panics
    /// If `K` is not a multiple of the number of streams.
    fn propagate(
        &self,
        step: &Step<'_>,
        previous: Rows<'_>,
        measurement: &[f64],
        streams: &mut [Stream],
        states: &mut [f64],
        log_likelihoods: &mut [f64],
    );
}

/// Refuses a model without states or without measurements.
///
/// Everything that takes a model refuses it with these words: simulation, filters, proposals and training.
///
/// # Errors
/// [`ModelError::Parameter`] if `N` or `M` is 0.
pub fn check_dimensions(model: &(impl StateSpaceModel + ?Sized)) -> Result<(), ModelError> {
    let dimensions = [
        ("the model's state dimension N", model.state_dim()),
        ("the model's measurement dimension M", model.measurement_dim()),
    ];
    match dimensions.into_iter().find(|(_, dimension)| *dimension == 0) {
        Some((name, _)) => Err(ModelError::Parameter { name, value: "0".into(), expected: "at least 1" }),
        None => Ok(()),
    }
}

/// A model that can also draw measurements, and so simulate itself.
pub trait Simulator: StateSpaceModel {
    /// Draws `y_t ~ p(y_t | x_t)` into `measurement` (`M`), given `state` (`N`).
    fn sample_measurement(
        &self,
        step: &Step<'_>,
        state: &[f64],
        stream: &mut Stream,
        measurement: &mut [f64],
    );

    /// [`Simulator::sample_measurement`] for each of `K` rows of `states` (`K×N`) into `out` (`K×M`); the rows are split evenly over `streams`, in order.
    ///
    /// A model may take another amount of a stream here than row by row. The numbers of one stream do not depend on the other
    /// streams in the call.
    ///
    /// # Panics
    /// If `K` is not a multiple of the number of streams.
    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        let (n, m) = (self.state_dim(), self.measurement_dim());
        let particles = states.len() / n;
        let mut states = states.chunks_exact(n);
        for (stream, out) in particles_by_stream(streams, out, m, particles) {
            for (measurement, state) in out.chunks_exact_mut(m).zip(&mut states) {
                self.sample_measurement(step, state, stream, measurement);
            }
        }
    }
}

/// A model that can weigh a measurement some of whose entries are missing.
pub trait PartialLikelihood: StateSpaceModel {
    /// `log p(y_t^O | x_t)` at each of `K` rows of `states` (`K×N`), into `out` (`K`).
    ///
    /// It is the marginal density of those entries `O` of `measurement` (`M`) that are there, and 0 where none is.
    ///
    /// # Errors
    /// [`ModelError`] if the marginal density cannot be had in floating point.
    fn partial_log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError>;
}

/// The gradients of a model's log densities with respect to states, which is all that training asks of it.
///
/// All slices are batches of `K` rows; outputs are overwritten.
pub trait StateGradients: StateSpaceModel {
    /// Whether there are any; all are NaN if not.
    fn has_gradients(&self) -> bool {
        true
    }

    /// `∂ log p(x_0) / ∂x_0` for each row of `states` (`K×N`).
    fn initial_gradients(&self, states: &[f64], d_states: &mut [f64]);

    /// `∂ log p(x_t | x_{t−1}) / ∂x_{t−1}` and `/ ∂x_t` for each row (`K×N` each).
    fn transition_gradients(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    );

    /// `∂ log p(y_t | x_t) / ∂x_t` for each row (`K×N`).
    fn likelihood_gradients(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    );
}

/// Second-order knowledge of a system `x_t = f(x_{t−1}) + v_t`, `y_t = C x_t + w_t`: what the
/// minimum-degeneracy proposal needs.
///
/// It is exact when `v_t` and `w_t` are Gaussian; otherwise it is the Gaussian with the same moments.
pub trait AdditiveGaussian: StateSpaceModel {
    /// Whether `x_0`, `v_t` and `w_t` are Gaussian, so that these moments determine them; `false` unless a model says so.
    fn is_gaussian(&self) -> bool {
        false
    }

    /// The mean and covariance of `x_0`.
    fn initial(&self) -> &Gaussian;

    /// `f(x_{t−1})` for each row of `previous` (`K×N`), into `means` (`K×N`).
    fn transition_means(&self, step: &Step<'_>, previous: &[f64], means: &mut [f64]);

    /// `f(x_{t−1})` for each of the first `particles` lanes of a tile of states (`N × LANES`, see [`crate::batch`]), into the tile `means`.
    fn tile_transition_means(&self, step: &Step<'_>, previous: &[f64], particles: usize, means: &mut [f64]) {
        let n = self.state_dim();
        with_scratch(2 * particles * n, |rows| {
            let (from, to) = rows.split_at_mut(particles * n);
            store(previous, n, from);
            self.transition_means(step, from, to);
            load(to, n, means);
        });
    }

    /// `Σ_v`, `N×N`.
    fn transition_covariance(&self) -> MatRef<'_, f64>;

    /// `C`, `M×N`.
    fn measurement_matrix(&self) -> MatRef<'_, f64>;

    /// `Σ_w`, `M×M`.
    fn measurement_covariance(&self) -> MatRef<'_, f64>;
}
