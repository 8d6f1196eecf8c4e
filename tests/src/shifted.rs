//! A model with a constant added to its log-likelihoods.

use motes_models::{StateSpaceModel, Step, Stream};

/// `log p(y_t|x_t) + shift` at times `t ≥ from`; in all else the model itself.
#[derive(Debug, Clone)]
pub struct Shifted<M> {
    /// The model itself.
    pub model: M,
    /// What is added: a finite number changes no posterior, an infinite one or NaN leaves none.
    pub shift: f64,
    /// The first time at which it is.
    pub from: usize,
}

impl<M: StateSpaceModel> StateSpaceModel for Shifted<M> {
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
        self.model.log_transition(step, previous, state)
    }
    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> f64 {
        let log_likelihood = self.model.log_likelihood(step, state, measurement);
        if step.index < self.from { log_likelihood } else { log_likelihood + self.shift }
    }
}
