//! burn's Adam, applied matrix by matrix.

use burn::optim::{Adam, AdamState, Optimizer};
use motes_proposals::{Gradients, Parameters};

use crate::AdamConfig;

/// An optimiser together with what it remembers of each matrix.
pub(crate) struct AdamSteps {
    adam: Adam,
    learning_rate: f64,
    states: Vec<Option<AdamState<2>>>,
}

impl AdamSteps {
    pub(crate) fn new(config: &AdamConfig, parameters: usize) -> Self {
        let adam = burn::optim::AdamConfig::new()
            .with_beta_1(config.beta_1 as f32)
            .with_beta_2(config.beta_2 as f32)
            .with_epsilon(config.epsilon as f32)
            .build();
        AdamSteps { adam, learning_rate: config.learning_rate, states: vec![None; parameters] }
    }

    /// Moves every parameter that has a gradient against it.
    pub(crate) fn step(&mut self, parameters: &mut Parameters, gradients: &Gradients) {
        for (index, gradient) in gradients.tensors().iter().enumerate() {
            if let Some(gradient) = gradient {
                let value = parameters.tensors()[index].clone();
                let state = self.states[index].take();
                let (moved, state) = self.adam.step(self.learning_rate, value, gradient.clone(), state);
                self.states[index] = state;
                parameters.replace(index, moved);
            }
        }
    }
}
