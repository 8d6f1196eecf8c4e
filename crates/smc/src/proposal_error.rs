//! Why a proposal could not be used.

use thiserror::Error;

/// Why a proposal could not be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProposalError {
    /// A proposal that has its own parameters for each time was stepped past the last of them.
    #[error("this proposal is unrolled over {horizon} times and was asked for time {time}")]
    PastHorizon {
        /// The number of times it knows, `T`.
        horizon: usize,
        /// The time it was asked for.
        time: usize,
    },
    /// The proposal does not fit the model it is used with.
    #[error("{what} is {found} in the proposal and {expected} in the model")]
    Mismatch {
        /// What differs.
        what: &'static str,
        /// The proposal's value.
        found: usize,
        /// The model's value.
        expected: usize,
    },
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
    /// The proposal works on the graph of a system, and the model has none.
    #[error("the model has no graph, which a graph network needs: see ModelShape::on_graph")]
    NoGraph,
    /// The units in which a proposal's networks work cannot be had from simulations of the system.
    #[error("the units in which the proposal's networks work cannot be had by simulation: {reason}")]
    Frames {
        /// Why not.
        reason: String,
    },
    /// A matrix that must be invertible is not, in floating point.
    #[error("the matrix {matrix} at time {time} is singular: log|det| is {log_abs_det}")]
    Singular {
        /// Which matrix.
        matrix: String,
        /// The time it belongs to.
        time: usize,
        /// The logarithm of its absolute determinant.
        log_abs_det: f64,
    },
    /// A block of particles was to be conditioned before the proposal was prepared for the step.
    #[error("the proposal was not prepared for time {time}: call prepare before condition")]
    NotPrepared {
        /// The time of the step.
        time: usize,
    },
    /// The proposal draws states, and the model has no density of its transition to weigh them by.
    #[error(
        "the model's transition has no density, which a proposal of states is weighed by; bootstrap, linearised and learned proposals do without"
    )]
    NoDensity,
    /// The proposal is one of noise, and the model is no map of noise.
    #[error("the model does not say how its states are made of noise, which learned potentials need")]
    NoNoise,
    /// The proposal cannot be had for a measurement.
    #[error("the proposal cannot take the measurement at time {time}: {reason}")]
    Measurement {
        /// The time of the measurement.
        time: usize,
        /// Why not.
        reason: String,
    },
    /// What computes the proposal's networks failed or is not there.
    #[error("{reason}")]
    Backend {
        /// What it said.
        reason: String,
    },
    /// A computation failed although its input was valid.
    #[error("{computation} failed for particle {particle}: {reason}")]
    Numerical {
        /// What was being computed.
        computation: &'static str,
        /// Row of the particle in its batch.
        particle: usize,
        /// Why it failed.
        reason: String,
    },
}

impl ProposalError {
    /// Refuses a proposal in which `what` is not what it is in the model.
    ///
    /// # Errors
    /// [`ProposalError::Mismatch`] if the two differ.
    pub fn unless_same(what: &'static str, found: usize, expected: usize) -> Result<(), Self> {
        if found == expected { Ok(()) } else { Err(ProposalError::Mismatch { what, found, expected }) }
    }

    /// The same error of a block that begins at row `first` of a batch.
    pub(crate) fn in_batch(self, first: usize) -> Self {
        match self {
            ProposalError::Numerical { computation, particle, reason } => {
                ProposalError::Numerical { computation, particle: first + particle, reason }
            }
            other => other,
        }
    }
}
