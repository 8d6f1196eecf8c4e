//! Filters of data.

use std::time::Instant;

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

use crate::call::ForCall;
use crate::data::Data;
use crate::filtered::Filtered;
use crate::model::Model;
use crate::options::FilterOptions;
use crate::work::without_lock;

/// The particles of all rows, flat: `rows × K × N` numbers, and `rows × K` weights.
type ParticleArrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Filters each series; with the particles where they are to be kept.
#[pyfunction]
pub(crate) fn filter<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: Py<Data>,
    options: &Bound<'py, FilterOptions>,
) -> PyResult<(Filtered, Option<ParticleArrays<'py>>)> {
    let FilterOptions { options, threads } = options.get();
    let (call, rows) = (model.get().for_call()?, &data.get().0);
    let (ForCall { model: of_call, failure, .. }, threads) = (&call, call.threads(*threads));
    let start = Instant::now();
    let filtered = without_lock(py, threads, &failure.stop, || {
        motes::filter(of_call, rows, options, |_| failure.asked())
    })?;
    let mut filtered = failure.or(filtered)?;
    let seconds = start.elapsed().as_secs_f64();
    let kept = std::mem::take(&mut filtered.particles);
    let kept = options.keep_particles.then(|| {
        let states: Vec<f64> = kept.iter().flat_map(|row| row.states.iter().copied()).collect();
        let weights: Vec<f64> = kept.iter().flat_map(|row| row.weights.iter().copied()).collect();
        (states.into_pyarray(py), weights.into_pyarray(py))
    });
    let Model { model, set, .. } = model.get();
    Ok((Filtered::new(model, set, data, options, filtered, None, seconds), kept))
}
