//! What can go wrong in a filter, by kind.

use motes_models::ModelError;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::proposal_error::ProposalError;

impl FilterError {
    /// What this error calls for.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FilterError::Setting { .. } => ErrorKind::BadInput,
            FilterError::Model(ModelError::Numerical { .. }) => ErrorKind::Numerical,
            FilterError::Model(_) => ErrorKind::BadInput,
            FilterError::Proposal { source, .. } => source.kind(),
            FilterError::NotANumber { .. } | FilterError::State { .. } => ErrorKind::Numerical,
            FilterError::Collapse { .. } => ErrorKind::Collapse,
            FilterError::Earlier { kind, .. } => *kind,
        }
    }
}

impl ProposalError {
    /// What this error calls for.
    pub fn kind(&self) -> ErrorKind {
        match self {
            ProposalError::PastHorizon { .. }
            | ProposalError::Mismatch { .. }
            | ProposalError::Setting { .. }
            | ProposalError::Frames { .. }
            | ProposalError::NotPrepared { .. }
            | ProposalError::NoDensity
            | ProposalError::NoNoise
            | ProposalError::NoGraph => ErrorKind::BadInput,
            ProposalError::Backend { .. }
            | ProposalError::Measurement { .. }
            | ProposalError::Singular { .. }
            | ProposalError::Numerical { .. } => ErrorKind::Numerical,
        }
    }
}

/// What an error calls for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ErrorKind {
    /// Mend the call: a setting, a shape or a value is not what it must be.
    BadInput,
    /// The input was fine and a computation failed.
    Numerical,
    /// No particle explains the measurement.
    Collapse,
}

/// An error of a filter; [`FilterError::kind`] says what it calls for.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FilterError {
    /// A setting is outside its range.
    #[error("{name} is {value}; it must be {expected}")]
    Setting {
        /// Which setting.
        name: &'static str,
        /// The value found, as text.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// A measurement or the model is unusable.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The proposal failed.
    #[error("at step {step}: {source}")]
    Proposal {
        /// The step, `t`.
        step: usize,
        /// What failed.
        source: ProposalError,
    },
    /// A particle has a log-weight that is NaN or +∞.
    #[error("at step {step}, particle {particle} of filter {filter} has the log-weight {value}")]
    NotANumber {
        /// The step, `t`.
        step: usize,
        /// The filter in its bank.
        filter: usize,
        /// The particle in its filter.
        particle: usize,
        /// The log-weight.
        value: f64,
    },
    /// A particle that weighs something has a state that is not finite, in a coordinate that no measurement sees.
    #[error(
        "at step {step}, coordinate {coordinate} of the state of particle {particle} of filter {filter} is {value}; the model \
         draws states that are not finite"
    )]
    State {
        /// The step, `t`.
        step: usize,
        /// The filter in its bank.
        filter: usize,
        /// The particle in its filter.
        particle: usize,
        /// The coordinate of its state.
        coordinate: usize,
        /// Its value.
        value: f64,
    },
    /// All weights of a filter are zero.
    #[error(
        "at step {step}, all weights of filter {filter} are zero (ESS before it {ess_before:.1}, largest \
         log-likelihood {largest_log_likelihood:e})"
    )]
    Collapse {
        /// The step, `t`.
        step: usize,
        /// The filter in its bank.
        filter: usize,
        /// Effective sample size after the step before.
        ess_before: f64,
        /// The largest `log p(y_t | x_t)` among the particles.
        largest_log_likelihood: f64,
    },
    /// The filter had failed before it was written down and restored, by an error whose words alone were kept.
    #[error("{words}")]
    Earlier {
        /// What the error called for.
        kind: ErrorKind,
        /// What it said.
        words: String,
    },
}
