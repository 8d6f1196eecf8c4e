//! The verdicts on all claims, written to verdict.md.

use std::collections::BTreeMap;
use std::path::Path;

use super::claims::{FIGURES, claims};
use super::error::VerifyError;
use super::numbers::{Figure, Place, best_profile};
use super::report::report;
use crate::config::{ConfigError, whole_figure};

/// Judges every claim on the results in `from`, of figures described in `experiments`; writes `verdict.md` there and returns
/// what it says.
///
/// # Errors
/// [`VerifyError`] if results or experiments cannot be read, or the report cannot be written.
pub fn verify(from: &Path, experiments: &Path) -> Result<String, VerifyError> {
    let profile = best_profile(from, &FIGURES).ok_or_else(|| {
        let expected = "there is no result; give a folder that holds FIGURE/PROFILE/units.csv";
        ConfigError::option("--from", &from.display().to_string(), expected.into())
    })?;
    let mut figures: BTreeMap<&str, Figure> = BTreeMap::new();
    for name in FIGURES {
        let places =
            whole_figure(experiments, name)?.into_iter().map(|(panel, x)| Place { panel, x }).collect();
        figures.insert(name, Figure::read(from, name, profile, places)?);
    }
    let text = report(profile, &figures, &claims(&figures));
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
