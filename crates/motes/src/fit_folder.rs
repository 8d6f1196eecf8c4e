//! The folder of a fit: its draws, its figures, what it was made with, and, until it is done, where it stands.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use ciborium::Value;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::MotesError;
use crate::fitting::{DRAWS, FitRecord, MAXIMUM, MaximumFit, PosteriorFit, RECORD, SUMMARY};
use crate::output::{Output, fit_draws, fit_json, maximum_json, maximum_table, profile_table};
use crate::packed::{pack, unpack};

/// The profiles of parameters at the maximum.
const PROFILE: &str = "profile.csv";
/// States at what was fitted, and what is predicted.
const STATES: &str = "states.csv";
/// Where it stands; removed when it is done.
const PROGRESS: &str = "progress.cbor";

/// What a fit under way is called where it is written down, and the version of that.
const FIT: &str = "fit";
const VERSION: u32 = 7;

/// The folder of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitFolder {
    path: PathBuf,
    record: FitRecord,
}

impl FitFolder {
    /// A folder for a fit, which is made when something is written into it; one with a fit of the same model to the same data is written over, one with anything else is
    /// refused.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be read, or has something else in it.
    pub fn open(path: &Path, record: FitRecord) -> Result<Self, MotesError> {
        let failed = |source| MotesError::Output { file: path.display().to_string(), source };
        let is_of_a_fit = |name: &std::ffi::OsStr| {
            [DRAWS, MAXIMUM, PROFILE, STATES, RECORD, SUMMARY, PROGRESS].iter().any(|file| name == *file)
        };
        let names: Vec<std::ffi::OsString> = match std::fs::read_dir(path) {
            Ok(entries) => entries.filter_map(Result::ok).map(|entry| entry.file_name()).collect(),
            Err(error) if error.kind() == ErrorKind::NotFound => vec![],
            Err(error) => return Err(failed(error)),
        };
        if !names.is_empty() && !names.iter().any(|name| is_of_a_fit(name)) {
            let reason = "it has files in it, and none of a fit; name a new folder, or an empty one";
            return Err(failed(std::io::Error::new(ErrorKind::AlreadyExists, reason)));
        }
        let folder = FitFolder { path: path.into(), record };
        match folder.other_fit() {
            Some(other) => {
                let folder = path.display();
                Err(MotesError::Setting(format!(
                    "{folder}: it has {other}; name another folder, or remove this one"
                )))
            }
            None => Ok(folder),
        }
    }

    /// What fit is in it, where it is one of another model or to other data, whose draws are not to be lost.
    fn other_fit(&self) -> Option<String> {
        let before = FitRecord::load(&self.path).ok().or_else(|| self.under_way())?;
        if before.model != self.record.model {
            return Some(format!("a fit of another model, {}", before.model));
        }
        if before.model_hash != self.record.model_hash {
            return Some(format!("a fit of {} as its file was before it was changed", before.model));
        }
        (before.data_hash != self.record.data_hash)
            .then(|| format!("a fit of {} to other data", before.model))
    }

    /// What the fit that was stopped in it is made with, if there is one.
    fn under_way(&self) -> Option<FitRecord> {
        let bytes = std::fs::read(self.path.join(PROGRESS)).ok()?;
        unpack::<(FitRecord, Value)>(FIT, VERSION, &bytes).ok().map(|(record, _)| record)
    }

    /// Where the same fit stood when it was stopped, a [`Posterior`](motes_inference::Posterior) or a [`MaximumSearch`](motes_inference::MaximumSearch); none where there is none,
    /// or that of another one.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be read, [`MotesError::Packed`] if it was damaged.
    pub fn progress<S: DeserializeOwned>(&self) -> Result<Option<S>, MotesError> {
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
        let (record, state): (FitRecord, Value) = unpack(FIT, VERSION, &bytes).map_err(damaged)?;
        match state {
            Value::Bytes(state) if record == self.record => {
                unpack(&record.method, VERSION, &state).map(Some).map_err(damaged)
            }
            _ => Ok(None),
        }
    }

    /// Writes down where the fit stands.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn keep(&self, state: &impl Serialize) -> Result<(), MotesError> {
        // The record comes first: the state of another method has another form.
        let state = pack(&self.record.method, VERSION, state)?;
        let bytes = pack(FIT, VERSION, &(&self.record, Value::Bytes(state)))?;
        self.make()?;
        let file = self.path.join(PROGRESS);
        let failed = |source| MotesError::Output { file: file.display().to_string(), source };
        let mut part = tempfile::NamedTempFile::new_in(&self.path).map_err(failed)?;
        std::io::Write::write_all(&mut part, &bytes).map_err(failed)?;
        part.persist(&file).map(drop).map_err(|refused| failed(refused.error))
    }

    /// Whether the fit in it has other options, and is written over.
    pub fn has_other_options(&self) -> bool {
        let before = self.under_way().or_else(|| FitRecord::load(&self.path).ok());
        before.is_some_and(|before| before != self.record)
    }

    /// Says that the fit is whole, with all that goes with it: it is not gone on with any more.
    ///
    /// # Errors
    /// [`MotesError::Output`] if where it stood cannot be removed.
    pub fn complete(&self) -> Result<(), MotesError> {
        self.remove(PROGRESS)
    }

    fn make(&self) -> Result<(), MotesError> {
        let failed = |source| MotesError::Output { file: self.path.display().to_string(), source };
        std::fs::create_dir_all(&self.path).map_err(failed)
    }

    /// Writes the draws that were found, and removes where the fit stood.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn finish(&self, fitted: &PosteriorFit) -> Result<(), MotesError> {
        self.write_so_far(fitted)?;
        self.complete()
    }

    /// Writes the draws that there were when the fit was stopped, and leaves where it stood, so that it can go on.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn write_so_far(&self, fitted: &PosteriorFit) -> Result<(), MotesError> {
        self.write(&Self::files(fitted))
    }

    fn files(fitted: &PosteriorFit) -> [(&'static str, String); 2] {
        [(DRAWS, fit_draws(fitted)), (SUMMARY, fit_json(fitted, None))]
    }

    /// Writes the maximum that was found, and removes where the searches stood.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn finish_maximum(&self, found: &MaximumFit) -> Result<(), MotesError> {
        self.write_maximum_so_far(found)?;
        self.complete()
    }

    /// Writes the maximum that was found when searches were stopped, and leaves where they stood, so that they can go on.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn write_maximum_so_far(&self, found: &MaximumFit) -> Result<(), MotesError> {
        self.write(&[
            (MAXIMUM, maximum_table(found)),
            (PROFILE, profile_table(found)),
            (SUMMARY, maximum_json(found, None)),
        ])
    }

    /// Writes the table of the states at what was fitted, and of what is predicted after the data.
    ///
    /// # Errors
    /// [`MotesError::Output`] if it cannot be written.
    pub fn write_states(&self, table: &str) -> Result<(), MotesError> {
        let output = Output::File(self.path.join(STATES));
        output.write(table).map_err(|source| MotesError::Output { file: output.name(), source })
    }

    /// Writes files and what they were made with, and removes those of another method.
    fn write(&self, files: &[(&str, String)]) -> Result<(), MotesError> {
        let record = toml::to_string(&self.record)
            .map_err(|error| MotesError::Packed { what: RECORD.into(), reason: error.to_string() })?;
        self.make()?;
        for (name, text) in files.iter().chain([&(RECORD, record)]) {
            let output = Output::File(self.path.join(name));
            output.write(text).map_err(|source| MotesError::Output { file: output.name(), source })?;
        }
        let is_written = |name: &&str| files.iter().any(|(written, _)| written == name);
        // States are those of what was fitted before.
        [DRAWS, MAXIMUM, PROFILE, STATES]
            .iter()
            .filter(|name| !is_written(name))
            .try_for_each(|name| self.remove(name))
    }

    fn remove(&self, name: &str) -> Result<(), MotesError> {
        let file = self.path.join(name);
        match std::fs::remove_file(&file) {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                Err(MotesError::Output { file: file.display().to_string(), source })
            }
            _ => Ok(()),
        }
    }
}
