//! A model as the command has it: from a file, with names for its coordinates.

use std::path::Path;

use motes_formulas::{Description, FileError, FileModel, ModelFile};

/// A model of a file or a text.
#[derive(Debug, Clone)]
pub struct Model {
    file: ModelFile,
}

impl Model {
    /// Reads a model file; `overrides` replace the values of parameters.
    ///
    /// # Errors
    /// [`FileError`] as [`motes_formulas::read`].
    pub fn read(path: &Path, overrides: &[(String, f64)]) -> Result<Self, FileError> {
        Ok(Model { file: motes_formulas::read(path, overrides)? })
    }

    /// Makes a model of a text, which errors call `name`.
    ///
    /// # Errors
    /// [`FileError`] as [`motes_formulas::parse`].
    pub fn parse(text: &str, name: &str, overrides: &[(String, f64)]) -> Result<Self, FileError> {
        Ok(Model { file: motes_formulas::parse(text, name, overrides)? })
    }

    /// What it calls itself.
    pub fn name(&self) -> &str {
        &self.file.name
    }

    /// The names of the `N` coordinates of a state.
    pub fn states(&self) -> &[String] {
        &self.file.states
    }

    /// The names of the `M` coordinates of a measurement, which are the columns of data.
    pub fn measurements(&self) -> &[String] {
        &self.file.measurements
    }

    /// The parameters with their values.
    pub fn parameters(&self) -> &[(String, f64)] {
        &self.file.parameters
    }

    /// Its coordinates and what they are distributed as, for people.
    pub fn describe(&self) -> Description {
        self.file.describe()
    }

    /// The model itself.
    pub fn model(&self) -> &FileModel {
        &self.file.model
    }
}
