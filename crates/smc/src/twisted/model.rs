//! A model as a twisted filter weighs it.

use motes_models::batch::{Rows, with_scratch};
use motes_models::equations::Linearise;
use motes_models::{ModelError, PartialLikelihood, PartialMeasurements, StateSpaceModel, Step, Stream};

use super::quadratic::Quadratic;

/// A model with `V_t(x_t)` in its likelihood and `1 / V_{t−1}(x_{t−1})` in its transition density: the evidence of a whole sequence stays what it was.
///
/// Its measurements are its own, so that a filter draws from its proposal at times without any, too: it is to be stepped by numbers that nobody looks at.
pub(super) struct TwistedModel<'a, M: ?Sized> {
    pub(super) model: &'a M,
    pub(super) measurements: &'a PartialMeasurements,
    pub(super) functions: &'a [Quadratic],
}

/// `log p(y_t | x_t) + log V_t(x_t)` of each of `K` rows of `states` (`K×N`), into `out` (`K`); `next` is `φ_{t+1}`, if `t` is not the last time.
///
/// # Errors
/// [`ModelError`] if the density of a measurement with gaps cannot be had.
pub(super) fn look_ahead<M: Linearise + PartialLikelihood + ?Sized>(
    model: &M,
    step: &Step<'_>,
    measurement: &[Option<f64>],
    next: Option<&Quadratic>,
    states: &[f64],
    out: &mut [f64],
) -> Result<(), ModelError> {
    model.partial_log_likelihoods(step, states, measurement, out)?;
    if let Some(next) = next {
        add_expectations(
            model,
            &model.step_of_index(step.index + 1),
            next,
            Rows::all(states, model.state_dim()),
            1.0,
            out,
        );
    }
    Ok(())
}

/// Adds `sign · log V_{t−1}(x_{t−1})` of each of the rows `x_{t−1}` (`K×N`) to `out` (`K`); `function` is `φ_t`.
fn add_expectations<M: Linearise + ?Sized>(
    model: &M,
    step: &Step<'_>,
    function: &Quadratic,
    previous: Rows<'_>,
    sign: f64,
    out: &mut [f64],
) {
    with_scratch(out.len(), |found| {
        function.log_expectations(model, step, previous, found);
        out.iter_mut().zip(found).for_each(|(out, found)| *out += sign * *found);
    });
}

impl<M: Linearise + PartialLikelihood + ?Sized> StateSpaceModel for TwistedModel<'_, M> {
    fn state_dim(&self) -> usize {
        self.model.state_dim()
    }

    fn measurement_dim(&self) -> usize {
        self.model.measurement_dim()
    }

    fn step_of_index(&self, index: usize) -> Step<'_> {
        self.model.step_of_index(index)
    }

    fn sample_initial(&self, stream: &mut Stream, state: &mut [f64]) {
        self.model.sample_initial(stream, state);
    }

    fn sample_transition(&self, step: &Step<'_>, previous: &[f64], stream: &mut Stream, state: &mut [f64]) {
        self.model.sample_transition(step, previous, stream, state);
    }

    fn log_initial(&self, state: &[f64]) -> f64 {
        self.model.log_initial(state)
    }

    fn log_transition(&self, step: &Step<'_>, previous: &[f64], state: &[f64]) -> f64 {
        let mut out = [f64::NAN];
        self.log_transitions(step, Rows::all(previous, previous.len()), state, &mut out);
        out[0]
    }

    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], _measurement: &[f64]) -> f64 {
        let mut out = [f64::NAN];
        self.log_likelihoods(step, state, &[], &mut out);
        out[0]
    }

    fn log_initials(&self, states: &[f64], out: &mut [f64]) {
        self.model.log_initials(states, out);
    }

    fn log_transitions(&self, step: &Step<'_>, previous: Rows<'_>, states: &[f64], out: &mut [f64]) {
        self.model.log_transitions(step, previous, states, out);
        if let Some(function) = self.functions.get(step.index) {
            add_expectations(self.model, step, function, previous, -1.0, out);
        }
    }

    fn log_likelihoods(&self, step: &Step<'_>, states: &[f64], _measurement: &[f64], out: &mut [f64]) {
        let (measurement, next) =
            (self.measurements.rows().nth(step.index), self.functions.get(step.index + 1));
        let found = measurement.map(|row| look_ahead(self.model, step, row, next, states, out));
        // Steps refuse what is not a number.
        if !matches!(found, Some(Ok(()))) {
            out.fill(f64::NAN);
        }
    }
}
