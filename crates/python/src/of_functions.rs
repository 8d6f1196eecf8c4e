//! Making a model of functions.

use std::sync::Arc;

use pyo3::prelude::*;

use crate::call::Made;
use crate::functions::{Failure, Frame, Functions};
use crate::model::Model;

/// The model of functions. `initial` are distributions, or a function of parameters; `slopes` are the other two functions with derivatives.
#[pyfunction]
pub(crate) fn of_functions(
    py: Python<'_>,
    name: String,
    frame: Frame,
    initial: &Bound<'_, PyAny>,
    functions: [Py<PyAny>; 2],
    slopes: Option<[Py<PyAny>; 2]>,
) -> PyResult<Model> {
    let functions = Arc::new(Functions::new(py, name, frame, initial, functions, slopes)?);
    let failure = Failure::default();
    let model = Arc::new(failure.or(functions.model(&failure, false, &[]))?);
    Ok(Model { model, set: Vec::new(), made: Made::Functions(functions) })
}
