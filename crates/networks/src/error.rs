//! Why networks could not be computed.

use thiserror::Error;

use crate::precision::Precision;

/// Why networks could not be computed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NetworkError {
    /// The backend was not compiled.
    #[error(
        "the backend {backend} is not in this build; it needs the cargo feature `{feature}` of motes-networks"
    )]
    NotBuilt {
        /// The one that was asked for.
        backend: String,
        /// What it needs.
        feature: &'static str,
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
    /// What a caller handed over has not the size that the networks have.
    #[error("{what} is {found}; it must be {expected}")]
    Shape {
        /// What has another size.
        what: &'static str,
        /// The size handed over.
        found: usize,
        /// That of the networks.
        expected: usize,
    },
    /// There must be at least one, and there is none.
    #[error("{what} is 0; it must be at least 1")]
    Empty {
        /// Of what there is none.
        what: &'static str,
    },
    /// The networks were asked about a time that they know nothing of.
    #[error("these networks are unrolled over {horizon} times and were asked for time {time}")]
    PastHorizon {
        /// How many times they know.
        horizon: usize,
        /// The time that they were asked for.
        time: usize,
    },
    /// Hidden values are kept in another precision than the weights.
    #[error("hidden values are kept in {found:?}; the weights are in {expected:?}")]
    Precision {
        /// That of the hidden values.
        found: Precision,
        /// That of the weights.
        expected: Precision,
    },
    /// A workspace holds the gradients of other weights.
    #[error("the workspace was made for weights of other shapes or of another precision")]
    Workspace,
}
