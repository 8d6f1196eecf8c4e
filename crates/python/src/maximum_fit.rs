//! The maximum of a likelihood.

use std::path::PathBuf;
use std::time::Instant;

use motes::output::{maximum_json, maximum_summary, maximum_text};
use motes::{FitFolder, FitRecord, MotesError, pack, unpack};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arguments::threads_of;
use crate::call::ForCall;
use crate::data::Data;
use crate::errors::{in_python, to_python};
use crate::fit_arguments::FitArguments;
use crate::model::Model;
use crate::work::without_lock;

/// What errors call its bytes, and the version of these.
const PACKED: (&str, u32) = ("a maximum", 1);

/// The maximum of a likelihood, and what it was sought with.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct MaximumFit {
    found: motes::MaximumFit,
    record: FitRecord,
    seconds: f64,
}

#[pymethods]
impl MaximumFit {
    /// That of which `__getnewargs__` gives the bytes: for pickles and copies.
    #[new]
    fn new(bytes: &[u8]) -> PyResult<Self> {
        let (found, record, seconds) = unpack(PACKED.0, PACKED.1, bytes).map_err(to_python)?;
        Ok(MaximumFit { found, record, seconds })
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyBytes>,)> {
        let MaximumFit { found, record, seconds } = self;
        let bytes = pack(PACKED.0, PACKED.1, &(found, record, seconds)).map_err(to_python)?;
        Ok((PyBytes::new(py, &bytes),))
    }

    /// The parameters by name: the estimate, and the ends of its interval where there is one.
    fn parameters(&self) -> Vec<(String, f64, Option<f64>, Option<f64>)> {
        let of = self.found.names.iter().zip(&self.found.parameters);
        of.map(|(name, of)| (name.clone(), of.estimate, of.low, of.high)).collect()
    }

    /// The profile of each parameter, flat: the value, the log-likelihood and its standard error of each point.
    fn profiles<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray1<f64>>> {
        let of_profile = |points: &Vec<motes::MaximumProfilePoint>| {
            let figures = points.iter().flat_map(|of| [of.value, of.log_likelihood, of.standard_error]);
            figures.collect::<Vec<f64>>().into_pyarray(py)
        };
        self.found.profiles.iter().map(of_profile).collect()
    }

    /// Reasons not to trust it.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.found.warnings.iter().map(|warning| in_python(&warning.to_string())).collect()
    }

    /// Writes the folder that the command writes.
    fn save(&self, folder: PathBuf) -> PyResult<()> {
        let folder = FitFolder::open(&folder, self.record.clone()).map_err(to_python)?;
        folder.finish_maximum(&self.found).map_err(to_python)
    }

    /// The object that the command prints with --json.
    fn json(&self) -> String {
        maximum_json(&self.found, Some(self.seconds))
    }

    /// The table that the command prints, and its figures.
    fn text(&self) -> String {
        let figures = maximum_summary(&self.found);
        let figures: Vec<String> = figures.iter().map(|(name, value)| format!("{name}: {value}")).collect();
        format!("{}\n{}", maximum_text(&self.found), figures.join("\n"))
    }
}

/// Finds the maximum of the likelihood over the parameters of a model that have a prior; `arguments` are those of the Python function.
#[pyfunction]
pub(crate) fn maximise(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    arguments: FitArguments<'_>,
    threads: Option<i64>,
) -> PyResult<MaximumFit> {
    let options = arguments.options()?;
    let call = model.get().for_call()?;
    let (ForCall { model, failure, .. }, threads) = (&call, call.threads(threads_of(threads)?));
    let (data, start) = (&data.get().0, Instant::now());
    let found: Result<motes::MaximumFit, MotesError> = without_lock(py, threads, &failure.stop, || {
        let observe = &mut |_: motes::SearchProgress<'_>| match failure.asked().is_break() {
            true => Err(MotesError::Interrupted),
            false => Ok(()),
        };
        motes::maximise(model, data, &options, None, &|| failure.asked(), observe)
    })?;
    let found = failure.or(found)?;
    let record = FitRecord::of_maximum(model, data, &options).map_err(to_python)?;
    Ok(MaximumFit { found, record, seconds: start.elapsed().as_secs_f64() })
}
