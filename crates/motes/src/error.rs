//! What can go wrong, and whose fault it is.

use motes_formulas::FileError;
use motes_models::ModelError;
use motes_proposals::SavedError;
use motes_smc::{FilterError, ProposalError};
use motes_train::TrainError;
use thiserror::Error;

use crate::data::{DataError, RowSource};
use crate::timeline::TimelineError;

/// Why there is no result.
#[derive(Debug, Error)]
pub enum MotesError {
    /// The model file cannot be used.
    #[error(transparent)]
    Model(#[from] FileError),
    /// The data cannot be used.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The proposal cannot be had for this model.
    #[error("--proposal {proposal}: {reason}")]
    Proposal {
        /// Its name.
        proposal: String,
        /// Why not, and what to take instead.
        reason: String,
    },
    /// A setting is out of range.
    #[error("{0}")]
    Setting(String),
    /// A simulated row has no time, or an input has no value.
    #[error(transparent)]
    Timeline(Box<TimelineError>),
    /// Rows after the last one cannot be predicted.
    #[error("a forecast: {0}")]
    Ahead(Box<TimelineError>),
    /// A filter failed.
    #[error("{place}: {reason}")]
    Filter {
        /// Which series and time.
        place: String,
        /// What happened, and what to do.
        reason: String,
    },
    /// The model draws numbers that are not finite.
    #[error("{0}")]
    Simulation(String),
    /// A learned proposal cannot be read or written.
    #[error("{}", with_command(.0))]
    Saved(SavedError),
    /// Bytes that hold a value cannot be read, or the value cannot be written as bytes.
    #[error("{what}: {reason}")]
    Packed {
        /// What the value is.
        what: String,
        /// What is the matter.
        reason: String,
    },
    /// A folder has no fit for this model.
    #[error("--parameters {folder}: {reason}")]
    Fit {
        /// The folder.
        folder: String,
        /// What is the matter.
        reason: String,
    },
    /// Something could not be written.
    #[error("{file}: {source}")]
    Output {
        /// Where to.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A figure could not be drawn.
    #[error("the report cannot be drawn: {0}")]
    Report(String),
    /// It was asked to stop.
    #[error("stopped")]
    Interrupted,
}

impl MotesError {
    /// The exit status: 2 for bad input, 3 where input or output failed.
    pub fn exit_status(&self) -> u8 {
        match self {
            MotesError::Model(error) if error.is_io() => 3,
            MotesError::Data(error) if error.is_io() => 3,
            MotesError::Saved(SavedError::Io { .. }) => 3,
            MotesError::Output { .. } | MotesError::Report(_) => 3,
            _ => 2,
        }
    }
}

impl MotesError {
    /// Where input or output failed by the system: the file, and what kind of failure it is.
    pub fn io(&self) -> Option<(&str, std::io::ErrorKind)> {
        match self {
            MotesError::Model(FileError::Read { file, kind, .. })
            | MotesError::Data(DataError::Read { file, kind: Some(kind), .. }) => Some((file, *kind)),
            MotesError::Saved(SavedError::Io { path, source }) => Some((path.to_str()?, source.kind())),
            MotesError::Output { file, source } => Some((file, source.kind())),
            _ => None,
        }
    }

    /// The same with the row of data at which a filter failed, and its series where there are several.
    #[must_use]
    pub fn at_row(self, source: &RowSource, series: Option<&str>, line: u64) -> Self {
        match self {
            MotesError::Filter { place, reason } => {
                MotesError::Filter { place: format!("{}, {place}", source.row(series, line)), reason }
            }
            other => other,
        }
    }
}

/// The error, and the command that makes a proposal anew where its format is not read.
fn with_command(error: &SavedError) -> String {
    match error {
        SavedError::Format { path, .. } => {
            format!("{error}, as by motes learn MODEL --output {}", path.display())
        }
        _ => error.to_string(),
    }
}

impl From<ModelError> for MotesError {
    fn from(error: ModelError) -> Self {
        MotesError::Setting(error.to_string())
    }
}

impl From<FilterError> for MotesError {
    fn from(error: FilterError) -> Self {
        MotesError::Setting(error.to_string())
    }
}

impl From<ProposalError> for MotesError {
    fn from(error: ProposalError) -> Self {
        MotesError::Setting(error.to_string())
    }
}

impl From<TrainError> for MotesError {
    fn from(error: TrainError) -> Self {
        MotesError::Setting(error.to_string())
    }
}
