//! A model of a program's own with the steps of a timeline.

use std::ops::Range;
use std::sync::Arc;

use motes_formulas::{Frame, Schedule};
use motes_models::batch::Rows;
use motes_models::equations::{Lanes, Linearise, NoiseSpace, Transport};
use motes_models::{
    Marginal, ModelError, Propagator, Simulator, StateGradients, StateSpaceModel, Step, Stream,
    TransitionDensity,
};

/// A model whose own steps are those of a schedule, or where there is none, cut into as many sub-steps as its times say. All else is the model's.
pub(crate) struct ScheduledModel<M: ?Sized> {
    model: Arc<M>,
    schedule: Option<Schedule>,
    /// How many sub-steps a step of one unit of time has.
    sub_steps: usize,
    /// Whether steps can have several, of which no state has a density.
    has_sub_steps: bool,
}

impl<M: ?Sized> ScheduledModel<M> {
    pub(crate) fn new(model: Arc<M>, frame: &Frame, schedule: Option<Schedule>) -> Self {
        let (sub_steps, has_sub_steps) = (frame.sub_steps_of_unit(), frame.has_sub_steps());
        ScheduledModel { model, schedule, sub_steps, has_sub_steps }
    }
}

impl<M: StateSpaceModel + Send + ?Sized> StateSpaceModel for ScheduledModel<M> {
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
        match &self.schedule {
            Some(schedule) => schedule.step_of_index(index),
            None => {
                let sub_steps = if index == 0 { 1 } else { self.sub_steps };
                Step { sub_steps, ..self.model.step_of_index(index) }
            }
        }
    }

    fn own_sequences(&self) -> &[Range<usize>] {
        self.schedule.as_ref().map_or(&[], Schedule::sequences)
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

    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> Result<f64, ModelError> {
        self.model.log_likelihood(step, state, measurement)
    }

    fn density(&self) -> Option<&dyn TransitionDensity> {
        if self.has_sub_steps { None } else { self.model.density() }
    }

    fn noise_space(&self) -> Option<&dyn NoiseSpace> {
        self.model.noise_space()
    }

    /// It would draw one transition of a step that may have several.
    fn propagator(&self) -> Option<&dyn Propagator> {
        if self.has_sub_steps { None } else { self.model.propagator() }
    }

    fn foresee(&self, step: &Step<'_>, previous: Rows<'_>) {
        self.model.foresee(step, previous);
    }

    fn check(&self) -> Result<(), ModelError> {
        self.model.check()
    }
}

impl<M: Simulator + Send + ?Sized> Simulator for ScheduledModel<M> {
    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        self.model.sample_measurements(step, states, streams, out);
    }

    fn marginals(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        stream: &mut Stream,
        out: &mut [Marginal],
    ) {
        self.model.marginals(step, states, measurement, stream, out);
    }
}

impl<M: StateGradients + Send + ?Sized> StateGradients for ScheduledModel<M> {
    fn has_gradients(&self) -> bool {
        self.model.has_gradients()
    }

    fn initial_gradients(&self, step: &Step<'_>, states: &[f64], d_states: &mut [f64]) {
        self.model.initial_gradients(step, states, d_states);
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
    }

    fn likelihood_gradients(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    ) {
        self.model.likelihood_gradients(step, states, measurement, d_states);
    }
}

impl<M: Linearise + Send + ?Sized> Linearise for ScheduledModel<M> {
    fn tile_moments(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        means: &mut [f64],
        variances: &mut [f64],
    ) {
        self.model.tile_moments(step, previous, means, variances);
    }

    fn tile_scores(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    ) {
        self.model.tile_scores(step, states, measurement, slopes, information, jacobian);
    }
}

impl<M: Transport + Send + ?Sized> Transport for ScheduledModel<M> {
    fn is_affine(&self) -> bool {
        self.model.is_affine()
    }

    fn tile_centres(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        centres: &mut [f64],
        slopes: &mut [f64],
    ) {
        self.model.tile_centres(step, previous, centres, slopes);
    }

    fn tile_from_normal(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    ) {
        self.model.tile_from_normal(step, previous, values, log_slope);
    }

    fn tile_to_normal(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    ) {
        self.model.tile_to_normal(step, previous, values, log_slope);
    }

    fn tile_slopes(&self, step: &Step<'_>, previous: Option<&[f64]>, values: &mut [f64]) {
        self.model.tile_slopes(step, previous, values);
    }
}
