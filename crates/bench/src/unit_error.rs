//! Why a unit has no result.

use thiserror::Error;

/// Why a unit has no result.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnitError {
    /// It failed, and would fail again.
    #[error("{0}")]
    Failed(String),
    /// Its trained proposal could not be written; nothing is wrong with the unit.
    #[error("{0}")]
    NotKept(String),
    /// It was abandoned because the run is being stopped.
    #[error("interrupted")]
    Interrupted,
}

/// A failure for any reason.
pub(crate) fn failed(error: impl ToString) -> UnitError {
    UnitError::Failed(error.to_string())
}
