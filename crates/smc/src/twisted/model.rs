//! A model as a twisted filter weighs it.

use motes_models::batch::{Rows, with_scratch};
use motes_models::equations::Linearise;
use motes_models::{ModelError, PartialMeasurements, StateSpaceModel, Step, Stream, TransitionDensity};

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
pub(super) fn look_ahead<M: Linearise + ?Sized>(
    model: &M,
    step: &Step<'_>,
    measurement: &[Option<f64>],
    next: Option<&Quadratic>,
    states: &[f64],
    out: &mut [f64],
) -> Result<(), ModelError> {
    model.log_likelihoods(step, states, measurement, out)?;
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

impl<M: Linearise + ?Sized> StateSpaceModel for TwistedModel<'_, M> {
    fn state_dim(&self) -> usize {
        self.model.state_dim()
    }

    fn measurement_dim(&self) -> usize {
        self.model.measurement_dim()
    }

    fn input_dim(&self) -> usize {
        self.model.input_dim()
    }

    fn step_of_index(&self, index: usize) -> Step<'_> {
        self.model.step_of_index(index)
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
        _measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        let next = self.functions.get(step.index + 1);
        match self.measurements.rows().nth(step.index) {
            Some(measurement) => look_ahead(self.model, step, measurement, next, states, out),
            // Steps refuse what is not a number.
            None => {
                out.fill(f64::NAN);
                Ok(())
            }
        }
    }

    fn density(&self) -> Option<&dyn TransitionDensity> {
        self.model.density().map(|_| self as _)
    }
}

impl<M: Linearise + ?Sized> TransitionDensity for TwistedModel<'_, M> {
    fn log_densities(&self, step: &Step<'_>, previous: Option<Rows<'_>>, states: &[f64], out: &mut [f64]) {
        match self.model.density() {
            Some(density) => density.log_densities(step, previous, states, out),
            None => out.fill(f64::NAN),
        }
        if let (Some(function), Some(previous)) = (self.functions.get(step.index), previous) {
            add_expectations(self.model, step, function, previous, -1.0, out);
        }
    }
}
