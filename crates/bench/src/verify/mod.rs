//! The paper's claims held against finished runs.
//!
//! Each claim is a few predicates that were fixed before any result was seen, over `units.csv`, paired over repetitions. "Not
//! run" says that a claim cannot be judged yet; one point that contradicts it is enough for "not reproduced".

mod claims;
mod judge;
mod numbers;
mod predicates;
mod report;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::config::{ConfigError, whole_figure};
use claims::{FIGURES, claims};
use numbers::{Figure, Place, best_profile};

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

/// Judges every claim on the results in `from`, of figures described in `experiments`; writes `verdict.md` there and returns
/// what it says.
///
/// # Errors
/// [`VerifyError`] if results or experiments cannot be read, or the report cannot be written.
pub fn verify(from: &Path, experiments: &Path) -> Result<String, VerifyError> {
    let profile = best_profile(from, &FIGURES).ok_or_else(|| {
        VerifyError::Config(ConfigError::Option {
            option: "--from".into(),
            value: from.display().to_string(),
            expected: "there is no result; give a folder that holds FIGURE/PROFILE/units.csv".into(),
        })
    })?;
    let mut figures: BTreeMap<&str, Figure> = BTreeMap::new();
    for name in FIGURES {
        let places =
            whole_figure(experiments, name)?.into_iter().map(|(panel, x)| Place { panel, x }).collect();
        figures.insert(name, Figure::read(from, name, profile, places)?);
    }
    let text = report::report(profile, &figures, &claims(&figures));
    let path = from.join("verdict.md");
    std::fs::write(&path, &text).map_err(|source| VerifyError::Write { path, source })?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_without_results_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = verify(folder.path(), Path::new("../../experiments")).unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.to_string().contains("there is no result"), "{error}");
        assert!(!folder.path().join("verdict.md").exists());
    }
}
