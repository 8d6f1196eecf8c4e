//! One line that says what is wrong, where, and what would be right.

use std::path::PathBuf;

use motes_cli::UsageError;
use thiserror::Error;

/// Input that cannot be run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ConfigError {
    /// An argument of the command line.
    #[error(transparent)]
    Usage(#[from] UsageError),
    /// An experiment file that cannot be read or parsed.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A key of an experiment file.
    #[error("{file}: key `{key}` is {value}; {expected}")]
    Key {
        /// The file.
        file: String,
        /// The key with its tables.
        key: String,
        /// The value found.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// The output folder cannot be written.
    #[error("--out {folder}: {reason}; give a folder that can be written", folder = folder.display())]
    Output {
        /// The folder.
        folder: PathBuf,
        /// Why not.
        reason: String,
    },
}

impl ConfigError {
    /// A value of an option that the experiment does not have.
    pub(crate) fn option(option: &str, value: &str, expected: String) -> Self {
        ConfigError::Usage(UsageError::Value { option: option.into(), value: value.into(), expected })
    }

    /// 3 where input or output failed, 2 for every other bad input.
    pub fn exit_status(&self) -> u8 {
        match self {
            ConfigError::Output { .. } => 3,
            _ => 2,
        }
    }
}
