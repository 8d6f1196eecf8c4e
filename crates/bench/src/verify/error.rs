//! Why claims could not be judged.

use std::path::PathBuf;

use thiserror::Error;

use crate::config::ConfigError;

/// Why claims could not be judged.
#[derive(Debug, Error)]
pub enum VerifyError {
    /// An experiment file is unusable.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A table could not be read.
    #[error("{}: {source}", path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// What is wrong with it.
        source: csv::Error,
    },
    /// The report could not be written.
    #[error("{}: {source}", path.display())]
    Write {
        /// The report.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
}

impl VerifyError {
    /// 2 for bad input, 3 where input or output failed.
    pub fn exit_status(&self) -> u8 {
        match self {
            VerifyError::Config(error) => error.exit_status(),
            VerifyError::Table { .. } | VerifyError::Write { .. } => 3,
        }
    }
}
