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
}

fn model_of(text: &str, of: Text<'_>, overrides: &[(String, f64)]) -> Result<ModelFile, FileError> {
    let model = document::read(text).and_then(|table| of_table(text, of, &table, overrides));
    model.map_err(|fault| Fault { at: fault.at.filter(|_| of.has_lines), ..fault }.in_file(of.file, text))
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
    let statement = statement::read(text, table, overrides)?;
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
        Model::Plain(model) => (Vec::new(), FileModel::LinearGaussian(Box::new(model))),
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
