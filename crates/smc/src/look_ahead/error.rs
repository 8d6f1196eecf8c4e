//! Why there is no looking ahead.

use motes_models::ModelError;
use thiserror::Error;

/// Why a sequence cannot be looked ahead of.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LookAheadError {
    /// The model's states are not stated as a map of noise.
    #[error("the model does not say how its states are made of noise, which looking ahead needs")]
    NoNoise,
    /// There is nothing to look at.
    #[error("there are no steps to look ahead of")]
    Empty,
    /// A step is not the one that comes next, or a measurement has another number of entries than the model.
    #[error("step {index}: {what} is {found}; it must be {expected}")]
    Step {
        /// Where it stands.
        index: usize,
        /// What is wrong.
        what: &'static str,
        /// The value found.
        found: usize,
        /// What would be right.
        expected: usize,
    },
    /// Derivatives of the model near the smoothed path are not finite.
    #[error(
        "the linearised smoother does not come through step {index}: derivatives of the model are not finite there"
    )]
    NotFinite {
        /// The step.
        index: usize,
    },
    /// A potential that came from elsewhere is not finite.
    #[error("the potential of step {index} is not finite")]
    Potential {
        /// The step.
        index: usize,
    },
    /// Networks that emit potentials failed.
    #[error("{reason}")]
    Networks {
        /// Why.
        reason: String,
    },
    /// The density of a measurement cannot be had.
    #[error(transparent)]
    Model(#[from] ModelError),
}
