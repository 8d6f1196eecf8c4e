//! Files of results.

use std::path::PathBuf;

use motes::MotesError;
use motes::output::Output;
use pyo3::prelude::*;

use crate::errors::to_python;

/// Writes a text into a file, which is replaced when it is whole.
#[pyfunction]
pub(crate) fn write(path: PathBuf, text: &str) -> PyResult<()> {
    let output = Output::File(path);
    output.write(text).map_err(|source| to_python(MotesError::Output { file: output.name(), source }))
}
