//! Why the results folder cannot be used.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why the store cannot be used.
#[derive(Debug, Error)]
pub enum StoreError {
    /// Another runner has the folder.
    #[error("{folder} is in use by another run ({holder}); wait for it, or give another --out", folder = folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// What the lock file says of its holder.
        holder: String,
    },
    /// The figure could not be drawn.
    #[error("figure.svg could not be drawn: {0}")]
    Figure(String),
    /// A trained proposal could not be kept.
    #[error("{0}")]
    Model(String),
    /// A file could not be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Names the path of a failure.
pub(super) fn at(path: &Path) -> impl FnOnce(std::io::Error) -> StoreError + '_ {
    move |source| StoreError::Io { path: path.to_path_buf(), source }
}
