//! What functions are told of a step.

use motes::models::Step;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyModule;

/// The module whose classes these are.
fn module(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import(intern!(py, "motes.step"))
}

/// The parameters by their names: numbers, and arrays of those that are lists.
pub(super) fn parameters(py: Python<'_>, values: &[(String, f64)]) -> PyResult<Py<PyAny>> {
    let made = module(py)?.call_method1(intern!(py, "_parameters"), (values.to_vec(),))?;
    Ok(made.unbind())
}

/// What makes the steps of a model, which all have the same names of inputs and the same parameters.
pub(super) struct Steps(Py<PyAny>);

impl Steps {
    pub(super) fn new(py: Python<'_>, names: &[String], parameters: &Py<PyAny>) -> PyResult<Self> {
        let made = module(py)?.call_method1(intern!(py, "_steps"), (names.to_vec(), parameters))?;
        Ok(Steps(made.unbind()))
    }

    /// A step with its inputs.
    pub(super) fn step<'py>(&self, py: Python<'py>, step: &Step<'_>) -> PyResult<Bound<'py, PyAny>> {
        self.0.bind(py).call1((step.index, step.time, step.length, step.inputs.to_vec()))
    }
}
