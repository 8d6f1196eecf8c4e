//! Why there is no measurement.

use std::path::Path;

use thiserror::Error;

/// Why there is no measurement.
#[derive(Debug, Error)]
pub(crate) enum SpeedError {
    /// A file or a process could not be had.
    #[error("{what}: {source}")]
    System {
        /// Which one.
        what: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// A process did not do what it was asked for.
    #[error("{who}: {reason}")]
    Worker {
        /// Which one.
        who: String,
        /// What it said.
        reason: String,
    },
    /// Our own work could not be prepared.
    #[error("{0}")]
    Prepare(String),
    /// No piece of work has a name that was asked for.
    #[error("--only {only}: no piece of work has this in its name; they are: {names}")]
    Only {
        /// What was asked for.
        only: String,
        /// What there is.
        names: String,
    },
    /// A signal came.
    #[error("interrupted")]
    Interrupted,
}

impl SpeedError {
    /// Names what the system refused.
    pub(crate) fn system(what: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> SpeedError {
        move |source| SpeedError::System { what: what.as_ref().display().to_string(), source }
    }
}

/// Our own work could not be prepared, for any reason.
pub(crate) fn prepare(error: impl ToString) -> SpeedError {
    SpeedError::Prepare(error.to_string())
}
