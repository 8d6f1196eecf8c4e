//! The verdicts on all claims, written to verdict.md.

use std::collections::BTreeMap;
use std::path::Path;

use super::claims::{FIGURES, claims};
use super::error::VerifyError;
use super::held_out;
use super::numbers::{Figure, Place, best_profile};
use super::report::report;
use crate::config::{ConfigError, whole_figure};

/// Judges every claim on the results in `from`, of figures described in `experiments`; writes `verdict.md` there, and `verdict-learned-once.md` where
/// proposals were learned once, and returns what they say.
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
        figures.insert(name, read(from, experiments, name, profile)?);
    }
    let text = report(profile, &figures, &claims(&figures));
    write(from, "verdict.md", &text)?;
    let of_profile = best_profile(from, &held_out::FIGURES).unwrap_or(profile);
    let mut figures = Vec::new();
    for name in held_out::FIGURES {
        figures.push((name, read(from, experiments, name, of_profile)?));
    }
    let Some(learned_once) = held_out::report(of_profile, &figures) else { return Ok(text) };
    write(from, "verdict-learned-once.md", &learned_once)?;
    Ok(format!("{text}\n{learned_once}"))
}

/// Whether the paper makes claims on a figure.
pub(crate) fn judges(figure: &str) -> bool {
    FIGURES.contains(&figure)
}

/// The runs of a figure, and all points that it has.
fn read(from: &Path, experiments: &Path, name: &str, profile: &str) -> Result<Figure, VerifyError> {
    let places = whole_figure(experiments, name)?.into_iter().map(|(panel, x)| Place { panel, x }).collect();
    Figure::read(from, name, profile, places)
}

fn write(from: &Path, name: &str, text: &str) -> Result<(), VerifyError> {
    let path = from.join(name);
    std::fs::write(&path, text).map_err(|source| VerifyError::Write { path, source })
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
