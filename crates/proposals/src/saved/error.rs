//! Why a proposal could not be saved or loaded.

use std::path::PathBuf;

use motes_smc::ProposalError;
use thiserror::Error;

use super::description::SAVED_FORMAT;
use super::fingerprint::OtherSystem;

/// Why a proposal could not be saved or loaded.
#[derive(Debug, Error)]
pub enum SavedError {
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file is not what [`crate::save`] writes.
    #[error("{}: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Another version of this library saved it, in a format that this one does not read.
    #[error("{}: it was saved in format {found}, and format {SAVED_FORMAT} is read; learn it again", path.display())]
    Format {
        /// The folder.
        path: PathBuf,
        /// Its format.
        found: u32,
    },
    /// The proposal is whole but not the one that was asked for.
    #[error("{}: {what} is {found}; {expected} was expected", path.display())]
    Unfit {
        /// The folder.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// What the folder has.
        found: String,
        /// What was asked for.
        expected: String,
    },
    /// The proposal was trained for another system.
    #[error("{}: {source}", path.display())]
    OtherSystem {
        /// The folder.
        path: PathBuf,
        /// What differs.
        source: OtherSystem,
    },
    /// The family cannot be made from the saved settings.
    #[error("{}: {source}", path.display())]
    Proposal {
        /// The folder.
        path: PathBuf,
        /// Why not.
        source: ProposalError,
    },
}
