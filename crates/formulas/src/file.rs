//! A model file, read.

use std::path::Path;

use motes_models::LinearGaussian;

use crate::document::{self, Table};
use crate::error::{Fault, FileError, Problem};
use crate::matrices::{self, Matrices, Model};
use crate::model::FormulaModel;
use crate::statement::{self, Line};
use crate::text::Text;

/// What a model file says.
#[derive(Debug, Clone)]
pub struct ModelFile {
    /// The model's name; that of the file, without its extension, where the file gives none.
    pub name: String,
    /// The states' names, as in headers of data: `x`, or `x[0]`, `x[1]`, … for a vector.
    pub states: Vec<String>,
    /// The measurements' names, likewise.
    pub measurements: Vec<String>,
    /// The parameters with their values.
    pub parameters: Vec<(String, f64)>,
    /// The text that says all this.
    pub text: String,
    /// The model itself.
    pub model: FileModel,
}

/// The kinds of models that files can state.
#[derive(Debug, Clone)]
pub enum FileModel {
    /// One of formulas.
    Formulas(FormulaModel),
    /// One of matrices, with correlated noise and exact answers.
    LinearGaussian(Box<LinearGaussian>),
}

/// Reads a model file; `overrides` replace the values of parameters.
///
/// # Errors
/// [`FileError::Read`] if the file cannot be read, and as [`parse`].
pub fn read(path: &Path, overrides: &[(String, f64)]) -> Result<ModelFile, FileError> {
    let file = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|error| FileError::Read {
        file: file.clone(),
        kind: error.kind(),
        reason: reason(&error),
    })?;
    match std::str::from_utf8(&bytes) {
        Ok(text) => parse(text, &file, overrides),
        Err(error) => {
            let valid = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
            Err(Fault::at(valid.len(), Problem::NotUtf8).in_file(&file, &valid))
        }
    }
}

/// Makes a model of a text, which is called `file` in errors; `overrides` replace the values of parameters.
///
/// # Errors
/// [`FileError::Refused`] if the text states no model, or an override no parameter.
pub fn parse(text: &str, file: &str, overrides: &[(String, f64)]) -> Result<ModelFile, FileError> {
    model_of(text, Text { file, has_lines: true }, overrides)
}

/// [`parse`] of a text that a program wrote: errors, those at run time too, name sections and keys, and no lines of a text that nobody sees.
///
/// # Errors
/// As [`parse`].
pub fn parse_generated(text: &str, name: &str, overrides: &[(String, f64)]) -> Result<ModelFile, FileError> {
    model_of(text, Text { file: name, has_lines: false }, overrides)
}

impl ModelFile {
    /// The same with other values of parameters; those that are not given stay as they are.
    ///
    /// # Errors
    /// As [`parse`].
    pub fn with_parameters(&self, values: &[(String, f64)]) -> Result<ModelFile, FileError> {
        let mut all = self.parameters.clone();
        all.extend(values.iter().cloned());
        match &self.model {
            FileModel::Formulas(model) => {
                let of = Text { file: model.file(), has_lines: model.has_lines() };
                Ok(ModelFile { name: self.name.clone(), ..model_of(&self.text, of, &all)? })
            }
            FileModel::LinearGaussian(_) => parse(&self.text, &self.name, values),
        }
    }

    /// The model of a file of formulas in which each particle has these parameters of its own, those of entries of lists one by one: they are the last numbers of its state, in this order, and
    /// stay as they are in a step. `x_0` is made of them by a step of index 0 from rows that end with them.
    ///
    /// ```
    /// use motes_models::batch::Rows;
    /// use motes_models::{Seed, StateSpaceModel, Step};
    ///
    /// let text = r#"
    ///     [parameters]
    ///     start = "normal(0, 1)"
    ///     q = 1
    ///     [initial]
    ///     x = "start"
    ///     [transition]
    ///     x = "normal(x, q)"
    ///     [measurement]
    ///     y = "normal(x, 1)"
    /// "#;
    /// let file = motes_formulas::parse(text, "walk.toml", &[])?;
    /// let model = file.with_parameters_of_particles(&["start".into()])?;
    /// let before = [f64::NAN, 3.0, f64::NAN, 4.0];
    /// let mut states = [0.0; 4];
    /// let mut streams = [Seed::from_u64(1).stream()];
    /// model.sample_states(&Step::of_index(0), Some(Rows::all(&before, 2)), &mut streams, &mut states);
    /// assert_eq!(states, [3.0, 3.0, 4.0, 4.0]);
    /// # Ok::<(), motes_formulas::FileError>(())
    /// ```
    ///
    /// # Errors
    /// [`FileError::Refused`] if a parameter is not there, or says what must be known before there are particles: the length of a vector, an index, how time goes; or if the file has a kind.
    pub fn with_parameters_of_particles(&self, names: &[String]) -> Result<FormulaModel, FileError> {
        let (file, has_lines) = match &self.model {
            FileModel::Formulas(model) => (model.file(), model.has_lines()),
            FileModel::LinearGaussian(_) => (self.name.as_str(), true),
        };
        let of = Text { file, has_lines };
        let model = document::read(&self.text).and_then(|table| {
            FormulaModel::new(statement::read(&self.text, &table, &self.parameters, names)?, of)
        });
        model.map_err(|fault| refused(fault, of, &self.text))
    }
}

fn model_of(text: &str, of: Text<'_>, overrides: &[(String, f64)]) -> Result<ModelFile, FileError> {
    let model = document::read(text).and_then(|table| of_table(text, of, &table, overrides));
    model.map_err(|fault| refused(fault, of, text))
}

/// The error for the reader of a text.
fn refused(fault: Fault, of: Text<'_>, text: &str) -> FileError {
    Fault { at: fault.at.filter(|_| of.has_lines), ..fault }.in_file(of.file, text)
}

/// The system's words for why it cannot be read.
fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_string(),
        std::io::ErrorKind::IsADirectory => "this is a folder; a model is a file".to_string(),
        std::io::ErrorKind::PermissionDenied => "the permission to read it is missing".to_string(),
        _ => error.to_string(),
    }
}

fn of_table(
    text: &str,
    of: Text<'_>,
    table: &Table,
    overrides: &[(String, f64)],
) -> Result<ModelFile, Fault> {
    match table.iter().find(|entry| entry.key == "kind").map(|entry| &entry.value) {
        None => of_formulas(text, of, table, overrides),
        Some(kind) => match kind.text("kind")? {
            "linear-gaussian" => of_matrices(text, of, table, overrides),
            other => Err(Fault::at(kind.at, Problem::UnknownKind(other.to_string())).of_key("kind")),
        },
    }
}

fn of_formulas(
    text: &str,
    of: Text<'_>,
    table: &Table,
    overrides: &[(String, f64)],
) -> Result<ModelFile, Fault> {
    let statement = statement::read(text, table, overrides, &[])?;
    let names = |lines: &[Line]| {
        let of_line = |line: &Line| (0..line.coordinates()).map(|at| line.coordinate(at)).collect::<Vec<_>>();
        lines.iter().flat_map(of_line).collect()
    };
    Ok(ModelFile {
        name: statement.name.clone().unwrap_or_else(|| stem(of.file)),
        states: statement.states(),
        measurements: names(&statement.measurement),
        parameters: statement.parameters.clone(),
        text: text.to_string(),
        model: FileModel::Formulas(FormulaModel::new(statement, of)?),
    })
}

fn of_matrices(
    text: &str,
    of: Text<'_>,
    table: &Table,
    overrides: &[(String, f64)],
) -> Result<ModelFile, Fault> {
    let Matrices { name, states, measurements, model } = matrices::read(text, table, overrides)?;
    let (parameters, model) = match model {
        Model::Plain(model) => (Vec::new(), FileModel::LinearGaussian(model)),
        Model::Formulas(statement) => {
            (statement.parameters.clone(), FileModel::Formulas(FormulaModel::new(*statement, of)?))
        }
    };
    Ok(ModelFile {
        name: name.unwrap_or_else(|| stem(of.file)),
        states,
        measurements,
        parameters,
        text: text.to_string(),
        model,
    })
}

/// The name of a file without its extension.
fn stem(file: &str) -> String {
    Path::new(file).file_stem().map_or_else(|| file.to_string(), |stem| stem.to_string_lossy().into_owned())
}
