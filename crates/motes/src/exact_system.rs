//! What a model has exact answers by.

use motes_models::forward::FiniteSystem;
use motes_models::kalman::LinearSystem;

/// A model with exact answers.
#[derive(Clone, Copy)]
pub(crate) enum ExactSystem<'m> {
    /// One that is linear with Gaussian noise.
    Linear(&'m dyn LinearSystem),
    /// One whose states are discrete; whether they are few is found as they are reached.
    Finite(&'m dyn FiniteSystem),
}

impl ExactSystem<'_> {
    /// What gives the answers.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            ExactSystem::Linear(_) => "the Kalman filter",
            ExactSystem::Finite(_) => "the forward algorithm",
        }
    }
}
