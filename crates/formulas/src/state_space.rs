//! A model of formulas is a state-space model: what follows from its equations, by functions that are not generic, so that it is compiled here and nowhere else.

use std::ops::Range;

use motes_models::batch::Rows;
use motes_models::equations::{Draw, Equations, Guide, Lanes, Linearise, NoiseSpace, Transport};
use motes_models::{
    Marginal, ModelError, Simulator, StateGradients, StateSpaceModel, Step, Stream, TransitionDensity,
};

use crate::model::FormulaModel;

impl StateSpaceModel for FormulaModel {
    fn state_dim(&self) -> usize {
        self.equations().dimensions()[0]
    }

    fn measurement_dim(&self) -> usize {
        self.equations().dimensions()[1]
    }

    fn input_dim(&self) -> usize {
        self.0.inputs.len()
    }

    /// That of the schedule, where there is one; else rows are one unit of time apart, and what inputs are is not known: NaN.
    fn step_of_index(&self, index: usize) -> Step<'_> {
        match &self.1 {
            Some(schedule) => schedule.step_of_index(index),
            None => Step {
                inputs: &self.0.inputs,
                sub_steps: if index == 0 { 1 } else { self.frame().sub_steps_of_unit() },
                ..Step::of_index(index)
            },
        }
    }

    /// Those of its schedule.
    fn own_sequences(&self) -> &[Range<usize>] {
        self.1.as_ref().map_or(&[], |schedule| schedule.sequences())
    }

    fn sample_states(
        &self,
        step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        self.equations().sample_states(step, previous, streams, states);
    }

    fn log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        self.equations().log_likelihoods(step, states, measurement, out)
    }

    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> Result<f64, ModelError> {
        self.equations().log_likelihood(step, state, measurement)
    }

    /// It is there where each line draws its coordinate, independently of the others, and none is a count. A program does so at any time and state, so that there is
    /// nothing to check.
    fn density(&self) -> Option<&dyn TransitionDensity> {
        self.0.has_density.then_some(self)
    }

    fn noise_space(&self) -> Option<&dyn NoiseSpace> {
        Some(self)
    }
}

impl TransitionDensity for FormulaModel {
    fn log_density(&self, step: &Step<'_>, previous: Option<&[f64]>, state: &[f64]) -> f64 {
        self.equations().log_density(step, previous, state)
    }

    fn log_densities(&self, step: &Step<'_>, previous: Option<Rows<'_>>, states: &[f64], out: &mut [f64]) {
        self.equations().log_densities(step, previous, states, out);
    }
}

impl Simulator for FormulaModel {
    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        self.equations().sample_measurements(step, states, streams, out);
    }

    fn marginals(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        stream: &mut Stream,
        out: &mut [Marginal],
    ) {
        self.equations().marginals(step, states, measurement, stream, out);
    }
}

impl StateGradients for FormulaModel {
    fn initial_gradients(&self, step: &Step<'_>, states: &[f64], d_states: &mut [f64]) {
        self.equations().initial_gradients(step, states, d_states);
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

impl NoiseSpace for FormulaModel {
    fn draws(&self, step: &Step<'_>) -> Vec<Draw> {
        let [of_start, of_sub_step] = &self.0.draws;
        match step {
            Step { index: 0, .. } => of_start.get_or_init(|| self.equations().draws(step)).clone(),
            Step { sub_steps: 0, .. } => Vec::new(),
            _ => {
                let of_one = of_sub_step.get_or_init(|| {
                    let mut all = self.equations().draws(step);
                    all.truncate(all.len() / step.sub_steps);
                    all
                });
                of_one.repeat(step.sub_steps)
            }
        }
    }

    fn are_alike(&self, one: &Step<'_>, other: &Step<'_>) -> bool {
        self.equations().are_alike(one, other)
    }

    fn tile_states(&self, step: &Step<'_>, previous: Option<&[f64]>, noise: &[f64], states: &mut [f64]) {
        self.equations().tile_states(step, previous, noise, states);
    }

    fn tile_guided_states(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        guide: Guide<'_>,
        noise: &mut [f64],
        states: &mut [f64],
    ) -> Lanes {
        self.equations().tile_guided_states(step, previous, guide, noise, states)
    }

    fn tile_noise_scores(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    ) {
        self.equations().tile_noise_scores(step, previous, measurement, slopes, information, jacobian);
    }

    fn tile_linearised(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        noise: &[f64],
        particles: usize,
        states: &mut [f64],
        jacobian: &mut [f64],
    ) {
        self.equations().tile_linearised(step, previous, noise, particles, states, jacobian);
    }

    fn tile_sites(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<Lanes>],
        particles: usize,
        slopes: &mut [f64],
        roots: &mut [f64],
    ) {
        self.equations().tile_sites(step, states, measurement, particles, slopes, roots);
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
