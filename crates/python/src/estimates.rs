//! Estimates of rows as arrays.

use motes::Estimate;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

/// Arrays of one kind of estimate, flat: `rows × N` numbers, and `rows × N × Q` quantiles.
pub(crate) type States<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// The same of measurements that are expected (`rows × M`), and the places of what was measured, NaN where there is none.
pub(crate) type Expected<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// What is expected of each entry of a measurement in each estimate; nothing where nobody asked.
pub(crate) fn measurements<'py, 'e>(
    py: Python<'py>,
    estimates: impl Iterator<Item = &'e Estimate> + Clone,
) -> Expected<'py> {
    let entries = || estimates.clone().flat_map(|estimate| &estimate.predictive);
    let means: Vec<f64> = entries().map(|entry| entry.mean).collect();
    let sds: Vec<f64> = entries().map(|entry| entry.sd).collect();
    let quantiles: Vec<f64> = entries().flat_map(|entry| entry.quantiles.iter().copied()).collect();
    let places: Vec<f64> = entries().map(|entry| entry.pit.unwrap_or(f64::NAN)).collect();
    (means.into_pyarray(py), sds.into_pyarray(py), quantiles.into_pyarray(py), places.into_pyarray(py))
}

/// Means, standard deviations and quantiles of each coordinate in each estimate.
pub(crate) fn states<'py>(py: Python<'py>, estimates: &[Estimate]) -> States<'py> {
    let coordinates = || estimates.iter().flat_map(|estimate| &estimate.state);
    let means: Vec<f64> = coordinates().map(|coordinate| coordinate.mean).collect();
    let sds: Vec<f64> = coordinates().map(|coordinate| coordinate.sd).collect();
    let quantiles: Vec<f64> =
        coordinates().flat_map(|coordinate| coordinate.quantiles.iter().copied()).collect();
    (means.into_pyarray(py), sds.into_pyarray(py), quantiles.into_pyarray(py))
}
