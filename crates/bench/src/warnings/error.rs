//! Why a study has no result.

use std::path::PathBuf;

use motes::MotesError;
use motes::formulas::FileError;
use motes_models::ModelError;
use thiserror::Error;

use crate::config::ConfigError;

/// Why a study has no result.
#[derive(Debug, Error)]
pub enum StudyError {
    /// Its file, or an argument.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A model file.
    #[error(transparent)]
    Model(#[from] FileError),
    /// A filter, or learning.
    #[error("{model}: {source}")]
    Filter {
        /// The model.
        model: String,
        /// What failed.
        source: Box<MotesError>,
    },
    /// The exact log-evidence.
    #[error("{model}: {source}")]
    Exact {
        /// The model.
        model: String,
        /// What failed.
        source: ModelError,
    },
    /// Something is asked for that is not there.
    #[error("{0}")]
    Setting(String),
    /// A file of results cannot be read or written.
    #[error("{path}: {reason}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system or the reader says.
        reason: String,
    },
    /// It was asked to stop.
    #[error("stopped")]
    Interrupted,
}

impl StudyError {
    /// The exit status: 2 for bad input, 3 where input or output failed, 1 where a filter failed.
    pub fn exit_status(&self) -> u8 {
        match self {
            StudyError::Config(_) | StudyError::Model(_) | StudyError::Setting(_) => 2,
            StudyError::File { .. } => 3,
            StudyError::Filter { .. } | StudyError::Exact { .. } | StudyError::Interrupted => 1,
        }
    }
}
