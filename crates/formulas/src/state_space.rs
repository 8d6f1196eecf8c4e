//! A model of formulas is a state-space model: what follows from its equations, by functions that are not generic, so that it is compiled here and nowhere else.

use motes_models::batch::Rows;
use motes_models::equations::{Equations, Lanes, Linearise, Transport};
use motes_models::{ModelError, PartialLikelihood, Simulator, StateGradients, StateSpaceModel, Step, Stream};

use crate::model::FormulaModel;

impl StateSpaceModel for FormulaModel {
    fn state_dim(&self) -> usize {
        self.equations().dimensions()[0]
    }

    fn measurement_dim(&self) -> usize {
        self.equations().dimensions()[1]
    }

    fn sample_initial(&self, stream: &mut Stream, state: &mut [f64]) {
        self.equations().sample_initial(stream, state);
    }

    fn sample_transition(&self, step: &Step<'_>, previous: &[f64], stream: &mut Stream, state: &mut [f64]) {
        self.equations().sample_transition(step, previous, stream, state);
    }

    fn log_initial(&self, state: &[f64]) -> f64 {
        self.equations().log_initial(state)
    }

    fn log_transition(&self, step: &Step<'_>, previous: &[f64], state: &[f64]) -> f64 {
        self.equations().log_transition(step, previous, state)
    }

    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> f64 {
        self.equations().log_likelihood(step, state, measurement)
    }

    fn sample_initials(&self, streams: &mut [Stream], states: &mut [f64]) {
        self.equations().sample_initials(streams, states);
    }

    fn sample_transitions(
        &self,
        step: &Step<'_>,
        previous: Rows<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        self.equations().sample_transitions(step, previous, streams, states);
    }

    fn log_initials(&self, states: &[f64], out: &mut [f64]) {
        self.equations().log_initials(states, out);
    }

    fn log_transitions(&self, step: &Step<'_>, previous: Rows<'_>, states: &[f64], out: &mut [f64]) {
        self.equations().log_transitions(step, previous, states, out);
    }

    fn log_likelihoods(&self, step: &Step<'_>, states: &[f64], measurement: &[f64], out: &mut [f64]) {
        self.equations().log_likelihoods(step, states, measurement, out);
    }
}

impl Simulator for FormulaModel {
    fn sample_measurement(
        &self,
        step: &Step<'_>,
        state: &[f64],
        stream: &mut Stream,
        measurement: &mut [f64],
    ) {
        self.equations().sample_measurement(step, state, stream, measurement);
    }

    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        self.equations().sample_measurements(step, states, streams, out);
    }
}

impl PartialLikelihood for FormulaModel {
    fn partial_log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        self.equations().partial_log_likelihoods(step, states, measurement, out)
    }
}

impl StateGradients for FormulaModel {
    fn initial_gradients(&self, states: &[f64], d_states: &mut [f64]) {
        self.equations().initial_gradients(states, d_states);
    }

    fn transition_gradients(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        self.equations().transition_gradients(step, previous, states, d_previous, d_states);
    }

    fn likelihood_gradients(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    ) {
        self.equations().likelihood_gradients(step, states, measurement, d_states);
    }
}

impl Linearise for FormulaModel {
    fn tile_moments(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        means: &mut [f64],
        variances: &mut [f64],
    ) {
        self.equations().tile_moments(step, previous, means, variances);
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
        self.equations().tile_scores(step, states, measurement, slopes, information, jacobian);
    }
}

impl Transport for FormulaModel {
    fn is_affine(&self) -> bool {
        self.equations().is_affine()
    }

    fn tile_centres(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        centres: &mut [f64],
        slopes: &mut [f64],
    ) {
        self.equations().tile_centres(step, previous, centres, slopes);
    }

    fn tile_from_normal(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    ) {
        self.equations().tile_from_normal(step, previous, values, log_slope);
    }

    fn tile_to_normal(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    ) {
        self.equations().tile_to_normal(step, previous, values, log_slope);
    }

    fn tile_slopes(&self, step: &Step<'_>, previous: Option<&[f64]>, values: &mut [f64]) {
        self.equations().tile_slopes(step, previous, values);
    }
}
