//! A model with a constant added to its log-likelihoods.

use motes_models::batch::Rows;
use motes_models::{ModelError, StateSpaceModel, Step, Stream, TransitionDensity};

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
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        self.model.log_likelihoods(step, states, measurement, out)?;
        if step.index >= self.from {
            out.iter_mut().for_each(|log_likelihood| *log_likelihood += self.shift);
        }
        Ok(())
    }
    fn density(&self) -> Option<&dyn TransitionDensity> {
        self.model.density()
    }
}
