//! Why networks could not be computed.

use thiserror::Error;

/// Why networks could not be computed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NetworkError {
    /// The backend was not compiled.
    #[error(
        "the backend {backend} is not in this build; it needs the cargo feature `burn` of motes-networks"
    )]
    NotBuilt {
        /// The one that was asked for.
        backend: String,
    },
    /// The backend failed.
    #[error("{reason}")]
    Backend {
        /// What it said.
        reason: String,
    },
    /// A matrix of weights was to be set from another number of values.
    #[error("{found} values are given for a matrix of {expected} weights")]
    Weights {
        /// The number given.
        found: usize,
        /// The number of weights.
        expected: usize,
    },
}
