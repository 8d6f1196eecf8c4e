//! Estimates of rows as arrays.

use motes::Estimate;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

/// Arrays of one kind of estimate, flat: `rows × N` numbers and `rows × N × 3` quantiles.
pub(crate) type States<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Means, standard deviations and quantiles of each coordinate in each estimate.
pub(crate) fn states<'py>(py: Python<'py>, estimates: &[Estimate]) -> States<'py> {
    let coordinates = || estimates.iter().flat_map(|estimate| &estimate.state);
    let means: Vec<f64> = coordinates().map(|coordinate| coordinate.mean).collect();
    let sds: Vec<f64> = coordinates().map(|coordinate| coordinate.sd).collect();
    let quantiles: Vec<f64> = coordinates().flat_map(|coordinate| coordinate.quantiles).collect();
    (means.into_pyarray(py), sds.into_pyarray(py), quantiles.into_pyarray(py))
}
