//! Why a sweep cannot be handed to a cluster, or a task cannot work.

use std::path::{Path, PathBuf};

use thiserror::Error;

use motes_proposals::networks::NetworkError;

use crate::config::ConfigError;
use crate::store::StoreError;
use crate::verify::VerifyError;

/// Why a sweep cannot be handed to a cluster, or a task of it cannot work.
#[derive(Debug, Error)]
pub enum ClusterError {
    /// There is no Slurm here.
    #[error("sbatch is not on the path; give --engine slurm on a login node of a cluster, or leave it out")]
    NoSlurm,
    /// Slurm refuses a job.
    #[error("{command}: {words}")]
    Refused {
        /// The command that it refuses.
        command: String,
        /// Its own words.
        words: String,
    },
    /// Nodes do not see what they have to.
    #[error("job {job} ran on a node that cannot run this program, or does not see {out} ({said}); --out must be a folder that all nodes share", out = out.display())]
    NotShared {
        /// The job that tried.
        job: String,
        /// The folder of results.
        out: PathBuf,
        /// The last that it said, as far as that is seen here.
        said: String,
    },
    /// A file of a submission is damaged.
    #[error("{path}: {reason}; the command that submitted it submits again what is missing", path = path.display())]
    Submission {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A file cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// What computes the networks is not there.
    #[error("--backend: {0}")]
    Backend(#[from] NetworkError),
    /// It was stopped; nothing was submitted.
    #[error("stopped; nothing was submitted")]
    Interrupted,
    /// The results folder cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The experiment cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Verdicts cannot be made.
    #[error(transparent)]
    Verify(#[from] VerifyError),
}

impl ClusterError {
    /// 2 for what the user gave, 3 for what the system or Slurm refuses.
    pub fn exit_status(&self) -> u8 {
        match self {
            ClusterError::Config(error) => error.exit_status(),
            ClusterError::Verify(error) => error.exit_status(),
            ClusterError::Backend(NetworkError::NotBuilt { .. }) => 2,
            _ => 3,
        }
    }
}

/// Names the path of a failure.
pub(super) fn at(path: &Path) -> impl FnOnce(std::io::Error) -> ClusterError + '_ {
    move |source| ClusterError::File { path: path.to_path_buf(), source }
}
