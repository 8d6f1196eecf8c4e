//! What a fit found.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use motes::output::{fit_json, fit_summary, fit_text};
use motes::{FitFolder, FitRecord, FreeParameters, MotesError, at_prior_draw, filter_draws, pack, unpack};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arguments::{integer, threads_of};
use crate::call::{ForCall, Made};
use crate::data::Data;
use crate::errors::{in_python, to_python};
use crate::filtered::Filtered;
use crate::fit_arguments::FitArguments;
use crate::model::Model;
use crate::options::FilterOptions;
use crate::work::without_lock;

/// What errors call its bytes, and the version of these.
const PACKED: (&str, u32) = ("a fit", 2);

/// The posterior of parameters by draws.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct PosteriorFit {
    found: Arc<motes::PosteriorFit>,
    /// What it was made with.
    record: FitRecord,
    seconds: f64,
}

#[pymethods]
impl PosteriorFit {
    /// That of which `__getnewargs__` gives the bytes: for pickles and copies.
    #[new]
    fn new(bytes: &[u8]) -> PyResult<Self> {
        let (found, record, seconds) = unpack(PACKED.0, PACKED.1, bytes).map_err(to_python)?;
        Ok(PosteriorFit { found: Arc::new(found), record, seconds })
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyBytes>,)> {
        let content = (&*self.found, &self.record, self.seconds);
        let bytes = pack(PACKED.0, PACKED.1, &content).map_err(to_python)?;
        Ok((PyBytes::new(py, &bytes),))
    }

    /// The names of the parameters.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.found.names.clone()
    }

    /// The values of the parameters, flat: chain by chain, draw by draw.
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let values: Vec<f64> =
            self.found.chains.iter().flat_map(|chain| chain.values.iter().copied()).collect();
        values.into_pyarray(py)
    }

    /// The estimates of the log-likelihood, flat: chain by chain.
    fn log_evidence<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let of_chain = |chain: &motes::PosteriorChain| chain.log_evidence.clone();
        let values: Vec<f64> = self.found.chains.iter().flat_map(of_chain).collect();
        values.into_pyarray(py)
    }

    /// The number of chains.
    #[getter]
    fn chains(&self) -> usize {
        self.found.chains.len()
    }

    /// Reasons not to trust it.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.found.warnings.iter().map(|warning| in_python(&warning.to_string())).collect()
    }

    /// Writes the folder that the command writes.
    fn save(&self, folder: PathBuf) -> PyResult<()> {
        let folder = FitFolder::open(&folder, self.record.clone()).map_err(to_python)?;
        folder.finish(&self.found).map_err(to_python)
    }

    /// The object that the command prints with --json.
    fn json(&self) -> String {
        fit_json(&self.found, Some(self.seconds))
    }

    /// The table that the command prints, and its figures.
    fn text(&self) -> String {
        let figures = fit_summary(&self.found);
        let figures: Vec<String> = figures.iter().map(|(name, value)| format!("{name}: {value}")).collect();
        format!("{}\n{}", fit_text(&self.found), figures.join("\n"))
    }
}

/// Draws from the posterior of the parameters of a model that have a prior; `arguments` are those of the Python function.
#[pyfunction]
pub(crate) fn fit(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    arguments: FitArguments<'_>,
    threads: Option<i64>,
) -> PyResult<PosteriorFit> {
    let options = arguments.options()?;
    let call = model.get().for_call()?;
    let (ForCall { model, failure, .. }, threads) = (&call, call.threads(threads_of(threads)?));
    let (data, start) = (&data.get().0, Instant::now());
    let found: Result<motes::PosteriorFit, MotesError> = without_lock(py, threads, &failure.stop, || {
        motes::fit(model, data, &options, &|| failure.asked(), &mut |_| match failure.asked().is_break() {
            true => Err(MotesError::Interrupted),
            false => Ok(()),
        })
    })?;
    let found = failure.or(found)?;
    let record = FitRecord::of(model, data, &options).map_err(to_python)?;
    Ok(PosteriorFit { found: Arc::new(found), record, seconds: start.elapsed().as_secs_f64() })
}

/// Filters and forecasts at `draws` draws of a posterior, mixed: an average has no log-evidence.
#[pyfunction]
pub(crate) fn filter_over(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    fitted: &Bound<'_, PosteriorFit>,
    data: Py<Data>,
    options: &Bound<'_, FilterOptions>,
    draws: i64,
) -> PyResult<Filtered> {
    let draws = integer("draws", draws, 1, 1_000_000)?;
    let FilterOptions { options, threads } = options.get();
    let call = model.get().for_call()?;
    let (ForCall { model: of_call, failure, .. }, threads) = (&call, call.threads(*threads));
    let (rows, start) = (&data.get().0, Instant::now());
    let values = fitted.get().found.draw_values();
    let models = values.spread(of_call, draws).map_err(to_python)?;
    let mixed = without_lock(py, threads, &failure.stop, || {
        filter_draws(&models, rows, options, &|_| failure.asked())
    })?;
    let mixed = failure.or(mixed)?.into_filtered(rows.series.len());
    let Model { model, set, .. } = model.get();
    let seconds = start.elapsed().as_secs_f64();
    Ok(Filtered::new(model, set, data, options, mixed, None, seconds))
}

/// The names of the parameters that a fit finds; none where no prior is left.
#[pyfunction]
pub(crate) fn free_parameters(model: &Bound<'_, Model>) -> Vec<String> {
    FreeParameters::of(model.get().motes()).map(|free| free.names()).unwrap_or_default()
}

/// So many draws of the parameters that a fit finds from their priors; fewer where the model is none at some of them.
#[pyfunction]
pub(crate) fn prior_draws(model: &Bound<'_, Model>, count: u64) -> Vec<Vec<(String, f64)>> {
    let (model, names) = (model.get().motes(), free_parameters(model));
    let of_draw = |number: u64| {
        let drawn = at_prior_draw(model, number)?;
        let of_name = |name: &String| drawn.parameters().iter().find(|(known, _)| known == name).cloned();
        names.iter().map(of_name).collect::<Option<Vec<(String, f64)>>>()
    };
    (0..count).filter_map(of_draw).collect()
}

/// The log-evidence at each row of `values`, flat, of the parameters `names`.
#[pyfunction]
pub(crate) fn log_evidence_at<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    options: &Bound<'py, FilterOptions>,
    names: Vec<String>,
    values: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let FilterOptions { options, threads } = options.get();
    let (call, rows) = (model.get().for_call()?, &data.get().0);
    let (ForCall { model, failure, .. }, threads) = (&call, call.threads(*threads));
    let values = values.as_slice()?;
    let found = without_lock(py, threads, &failure.stop, || {
        motes::log_evidence_at(model, rows, options, &names, values, &|| failure.asked())
    })?;
    Ok(failure.or(found)?.into_pyarray(py))
}

/// The same model with other values of parameters.
#[pyfunction]
pub(crate) fn with_parameters(model: &Bound<'_, Model>, values: Vec<(String, f64)>) -> PyResult<Model> {
    let Model { model, set, made } = model.get();
    let mut all = set.clone();
    all.retain(|(name, _)| values.iter().all(|(other, _)| other != name));
    all.extend(values.iter().cloned());
    let model = match made {
        Made::Text { .. } => Arc::new(model.with_parameters(&values).map_err(to_python)?),
        Made::Functions(_) => ForCall::new(model, made, &all, false)?.model,
    };
    Ok(Model { model, set: all, made: made.clone() })
}
