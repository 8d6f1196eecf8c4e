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

/// A step with its inputs, which have these names.
pub(super) fn step<'py>(
    py: Python<'py>,
    step: &Step<'_>,
    names: &[String],
    parameters: &Py<PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let arguments = (step.index, step.time, step.length, names.to_vec(), step.inputs.to_vec(), parameters);
    module(py)?.call_method1(intern!(py, "_step"), arguments)
}
