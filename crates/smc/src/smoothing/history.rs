//! What a filter was at each time.

use std::ops::Deref;

use motes_models::StateSpaceModel;
use motes_models::batch::there_is_memory_for;

use super::error::SmoothingError;
use crate::filter::ParticleFilter;
use crate::proposal::Proposal;

/// The particles and weights of a filter at each time from `t = 0` on, recorded after each step. It takes `T·K·(N + 1)` numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FilterHistory {
    pub(super) generations: Vec<Generation>,
}

/// The particles of one time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Generation {
    /// `K×N`.
    pub(super) states: Vec<f64>,
    /// Logarithms of the normalised weights, `K`.
    pub(super) log_weights: Vec<f64>,
}

impl FilterHistory {
    /// Nothing yet.
    pub fn new() -> Self {
        FilterHistory::default()
    }

    /// Keeps what the filter is after its last step.
    ///
    /// # Errors
    /// [`SmoothingError::Memory`] if there is none for it; nothing was kept then.
    pub fn record<D, P>(&mut self, filter: &ParticleFilter<D, P>) -> Result<(), SmoothingError>
    where
        D: Deref<Target: StateSpaceModel>,
        P: Proposal<D::Target>,
    {
        let (states, log_weights) = (filter.particles(), filter.weights().log());
        let numbers = states.len() + log_weights.len();
        if !there_is_memory_for(numbers) {
            return Err(SmoothingError::Memory { numbers });
        }
        self.generations.push(Generation { states: states.to_vec(), log_weights: log_weights.to_vec() });
        Ok(())
    }

    /// `T`, the number of times kept.
    pub fn len(&self) -> usize {
        self.generations.len()
    }

    /// Whether nothing is kept.
    pub fn is_empty(&self) -> bool {
        self.generations.is_empty()
    }
}
