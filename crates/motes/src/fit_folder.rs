//! The folder of a fit: its draws, its figures, what it was made with, and, until it is done, where it stands.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use motes_inference::Posterior;

use crate::error::MotesError;
use crate::fitting::{DRAWS, FitRecord, MAXIMUM, MaximumFit, PosteriorFit, RECORD};
use crate::output::{Output, fit_draws, fit_json, maximum_json, maximum_table};
use crate::packed::{pack, unpack};

/// The figures of all parameters.
const SUMMARY: &str = "summary.json";
/// Where it stands; removed when it is done.
const PROGRESS: &str = "progress.cbor";

/// The version of what is written down of a fit under way.
const VERSION: u32 = 1;

/// The folder of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitFolder {
    path: PathBuf,
    record: FitRecord,
}

impl FitFolder {
    /// A folder for a fit, which is made if there is none; one with another fit is written over, one with anything else is refused.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be made, or has something else in it.
    pub fn open(path: &Path, record: FitRecord) -> Result<Self, MotesError> {
        let failed = |source| MotesError::Output { file: path.display().to_string(), source };
        std::fs::create_dir_all(path).map_err(failed)?;
        let is_of_a_fit = |name: &std::ffi::OsStr| {
            [DRAWS, MAXIMUM, RECORD, SUMMARY, PROGRESS].iter().any(|file| name == *file)
        };
        let names =
            std::fs::read_dir(path).map_err(failed)?.filter_map(Result::ok).map(|entry| entry.file_name());
        let names: Vec<std::ffi::OsString> = names.collect();
        if !names.is_empty() && !names.iter().any(|name| is_of_a_fit(name)) {
            let reason = "it has files in it, and none of a fit; name a new folder, or an empty one";
            return Err(failed(std::io::Error::new(ErrorKind::AlreadyExists, reason)));
        }
        Ok(FitFolder { path: path.into(), record })
    }

    /// Where the same fit stood when it was stopped; none where there is none, or that of another one.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be read, [`MotesError::Packed`] if it was damaged.
    pub fn progress(&self) -> Result<Option<Posterior>, MotesError> {
        let file = self.path.join(PROGRESS);
        let bytes = match std::fs::read(&file) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(MotesError::Output { file: file.display().to_string(), source }),
        };
        let what = file.display().to_string();
        let damaged = |error: MotesError| match error {
            MotesError::Packed { reason, .. } => {
                let reason = format!("{reason}; remove it to begin anew");
                MotesError::Packed { what: what.clone(), reason }
            }
            other => other,
        };
        let (record, posterior): (FitRecord, Posterior) = unpack("fit", VERSION, &bytes).map_err(damaged)?;
        Ok((record == self.record).then_some(posterior))
    }

    /// Writes down where the fit stands.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn keep(&self, posterior: &Posterior) -> Result<(), MotesError> {
        let bytes = pack("fit", VERSION, &(&self.record, posterior))?;
        let file = self.path.join(PROGRESS);
        let failed = |source| MotesError::Output { file: file.display().to_string(), source };
        let mut part = tempfile::NamedTempFile::new_in(&self.path).map_err(failed)?;
        std::io::Write::write_all(&mut part, &bytes).map_err(failed)?;
        part.persist(&file).map(drop).map_err(|refused| failed(refused.error))
    }

    /// Writes the draws that were found, and removes where the fit stood.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn finish(&self, fitted: &PosteriorFit) -> Result<(), MotesError> {
        self.write(&[(DRAWS, fit_draws(fitted)), (SUMMARY, fit_json(fitted, None))])
    }

    /// Writes the maximum that was found.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn finish_maximum(&self, found: &MaximumFit) -> Result<(), MotesError> {
        self.write(&[(MAXIMUM, maximum_table(found)), (SUMMARY, maximum_json(found, None))])
    }

    /// Writes files and what they were made with, and removes those of a fit before.
    fn write(&self, files: &[(&str, String)]) -> Result<(), MotesError> {
        let record = toml::to_string(&self.record)
            .map_err(|error| MotesError::Packed { what: RECORD.into(), reason: error.to_string() })?;
        for (name, text) in files.iter().chain([&(RECORD, record)]) {
            let output = Output::File(self.path.join(name));
            output.write(text).map_err(|source| MotesError::Output { file: output.name(), source })?;
        }
        let is_written = |name: &&str| files.iter().any(|(written, _)| written == name);
        for name in [DRAWS, MAXIMUM, PROGRESS].iter().filter(|name| !is_written(name)) {
            let file = self.path.join(name);
            match std::fs::remove_file(&file) {
                Err(source) if source.kind() != ErrorKind::NotFound => {
                    return Err(MotesError::Output { file: file.display().to_string(), source });
                }
                _ => {}
            }
        }
        Ok(())
    }
}
