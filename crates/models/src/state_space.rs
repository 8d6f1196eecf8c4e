//! The traits of a state-space model: what a filter needs, and what training and designed proposals add.

use std::ops::Range;
use std::slice::from_mut;

use faer::MatRef;

use crate::batch::{Rows, load, store, with_scratch};
use crate::equations::NoiseSpace;
use crate::marginal::by_draws;
use crate::{Gaussian, Marginal, ModelError, Step, Stream};

/// A hidden Markov model on ℝᴺ, measured in ℝᴹ: `p(x_0)`, `p(x_t | x_{t−1})`, `p(y_t | x_t)`.
///
/// All is asked for by blocks of `K` particles, row-major `K×N`. The step is the one to the states that are drawn or weighed. Where there are no previous states it
/// is the start of a sequence.
///
/// What a model may or may not have is asked for by an `Option`: [`StateSpaceModel::density`], [`StateSpaceModel::noise_space`], [`StateSpaceModel::propagator`].
pub trait StateSpaceModel: Sync {
    /// `N`, the number of coordinates of a state.
    fn state_dim(&self) -> usize;

    /// `M`, the number of entries of a measurement.
    fn measurement_dim(&self) -> usize;

    /// `U`, the number of inputs of a sub-step, and of a measurement.
    fn input_dim(&self) -> usize {
        self.step_of_index(0).inputs.len()
    }

    /// The step of that index where nobody says more: rows one unit of time apart, the first at 0, with the inputs and parameters that the model has by itself.
    ///
    /// How many parameters it has is how many the model takes.
    fn step_of_index(&self, index: usize) -> Step<'_> {
        Step::of_index(index)
    }

    /// The sequences that its own steps are of, where it has several or their ends are known: ranges of indices one behind the other, the first step of each of which has
    /// the index 0. None where one sequence goes on for ever.
    fn own_sequences(&self) -> &[Range<usize>] {
        &[]
    }

    /// Draws `x_t ~ p(x_t | x_{t−1})` for each of `K` rows into `states` (`K×N`), or `x_0 ~ p(x_0)` where there are no previous states. Those may be picked from others
    /// by resampling. The rows are split evenly over `streams`, in order.
    ///
    /// How much of a stream is taken may depend on how many rows it draws. The numbers of one stream do not depend on the other streams in the call.
    ///
    /// # Panics
    /// If `K` is not a multiple of the number of streams.
    fn sample_states(
        &self,
        step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    );

    /// `log p(y_t | x_t)` of one measurement at each of `K` rows of `states` (`K×N`), into `out` (`K`): normalised, −∞ outside the support.
    ///
    /// Where entries of the measurement (`M`) are missing it is the marginal density of the others, and 0 where none is there.
    ///
    /// # Errors
    /// [`ModelError`] if a marginal density cannot be had in floating point.
    fn log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError>;

    /// [`StateSpaceModel::log_likelihoods`] at one state (`N`), of a measurement (`M`) in which nothing is missing.
    ///
    /// # Errors
    /// As there.
    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> Result<f64, ModelError> {
        let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
        let mut out = [f64::NAN];
        self.log_likelihoods(step, state, &entries, &mut out)?;
        Ok(out[0])
    }

    /// The densities of states, if the model has them.
    fn density(&self) -> Option<&dyn TransitionDensity> {
        None
    }

    /// The model as a map of standard normal noise, if it is one.
    fn noise_space(&self) -> Option<&dyn NoiseSpace> {
        None
    }

    /// [`StateSpaceModel::noise_space`] where states have no density, so that what a proposal draws is the noise.
    fn noise_without_density(&self) -> Option<&dyn NoiseSpace> {
        if self.density().is_some() { None } else { self.noise_space() }
    }

    /// This model as one that draws and weighs in one pass, if it has such a form.
    fn propagator(&self) -> Option<&dyn Propagator> {
        None
    }

    /// Says that these particles (`K×N`) will be asked for next, a tile at a time: a model whose answers cost less together may find them now. No answer is
    /// another for it.
    fn foresee(&self, _step: &Step<'_>, _previous: Rows<'_>) {}

    /// Looks for what cannot be seen by types: a model that says of itself what is not so.
    ///
    /// # Errors
    /// [`ModelError`] with what is wrong.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }
}

/// `p(x_0)` and `p(x_t | x_{t−1})` as densities of states.
///
/// A state with a coordinate that follows from others, or two that share a draw, has none.
pub trait TransitionDensity: Sync {
    /// `log p(x_t | x_{t−1})` of each of `K` rows of `states` (`K×N`), or `log p(x_0)` where there are no previous states, into `out` (`K`): normalised, −∞ outside the
    /// support.
    fn log_densities(&self, step: &Step<'_>, previous: Option<Rows<'_>>, states: &[f64], out: &mut [f64]);

    /// [`TransitionDensity::log_densities`] of one state (`N`), given the one before (`N`) if there is one.
    fn log_density(&self, step: &Step<'_>, previous: Option<&[f64]>, state: &[f64]) -> f64 {
        let mut out = [f64::NAN];
        self.log_densities(step, previous.map(|row| Rows::all(row, row.len())), state, &mut out);
        out[0]
    }
}

/// A model that can draw transitions and weigh them in one pass over the particles.
///
/// It gives what [`StateSpaceModel::sample_states`] and then [`StateSpaceModel::log_likelihoods`] give, to the last bit, and saves bringing the
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

/// Refuses a model without states or without measurements, and one that fails its own check.
///
/// Everything that takes a model refuses it with these words: simulation, filters, proposals and training.
///
/// # Errors
/// [`ModelError::Parameter`] if `N` or `M` is 0, and as [`StateSpaceModel::check`].
pub fn check_model(model: &(impl StateSpaceModel + ?Sized)) -> Result<(), ModelError> {
    let dimensions = [
        ("the model's state dimension N", model.state_dim()),
        ("the model's measurement dimension M", model.measurement_dim()),
    ];
    match dimensions.into_iter().find(|(_, dimension)| *dimension == 0) {
        Some((name, _)) => Err(ModelError::Parameter { name, value: "0".into(), expected: "at least 1" }),
        None => model.check(),
    }
}

/// A model that can also draw measurements, and so simulate itself.
pub trait Simulator: StateSpaceModel {
    /// Draws `y_t ~ p(y_t | x_t)` for each of `K` rows of `states` (`K×N`) into `out` (`K×M`); the rows are split evenly over `streams`, in order.
    ///
    /// How much of a stream is taken may depend on how many rows it draws. The numbers of one stream do not depend on the other streams in the call.
    ///
    /// # Panics
    /// If `K` is not a multiple of the number of streams.
    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]);

    /// What is expected of each of the `M` entries of `y_t` at each of `K` rows of `states` (`K×N`), into `out` (`K×M`), and where what was measured (`M`) lies in it.
    ///
    /// Draws say so where a model does not know better.
    fn marginals(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        stream: &mut Stream,
        out: &mut [Marginal],
    ) {
        by_draws(measurement, out, |drawn| self.sample_measurements(step, states, from_mut(stream), drawn));
    }
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
    fn initial_gradients(&self, step: &Step<'_>, states: &[f64], d_states: &mut [f64]);

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
