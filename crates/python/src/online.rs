//! A filter that takes in measurements as they come.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

use motes::{MotesError, RowTime, Running};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use self_cell::self_cell;

use crate::call::ForCall;
use crate::estimates::{Expected, measurements};
use crate::functions::Failure;
use crate::model::Model;
use crate::options::FilterOptions;
use crate::work::without_lock;

self_cell!(
    /// A filter beside the model that it borrows.
    struct OwnRunning {
        owner: Arc<motes::Model>,

        #[not_covariant]
        dependent: Running,
    }
);

/// A filter that runs on: one measurement at a time.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct Online {
    running: Mutex<OwnRunning>,
    failure: Failure,
    has_failed: AtomicBool,
    threads: Option<usize>,
}

/// What is known after a step: means, standard deviations, quantiles, the effective sample size and the log-evidence of the measurement; and what was expected of it.
type Known<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Option<f64>,
    Option<f64>,
    Expected<'py>,
);

#[pymethods]
impl Online {
    #[new]
    fn new(model: &Bound<'_, Model>, options: &Bound<'_, FilterOptions>, series: usize) -> PyResult<Self> {
        Online::begun(model, options, false, |model, options| Running::new(model, options, series))
    }

    /// A filter that goes on from a checkpoint of one with that model and these options, which had failed or not.
    #[staticmethod]
    fn resume(
        model: &Bound<'_, Model>,
        options: &Bound<'_, FilterOptions>,
        checkpoint: &[u8],
        has_failed: bool,
    ) -> PyResult<Self> {
        Online::begun(model, options, has_failed, |model, options| {
            Running::resume(model, options, checkpoint)
        })
    }

    /// The filter as bytes.
    fn checkpoint<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let running = self.running()?;
        let bytes = running.with_dependent(|_, running| running.checkpoint());
        Ok(PyBytes::new(py, &self.failure.or(bytes)?))
    }

    /// Whether it failed in a step; no other can follow then.
    #[getter]
    fn has_failed(&self) -> bool {
        self.has_failed.load(Ordering::Relaxed)
    }

    /// Takes in the next measurement, with its time as it is written and the inputs of the model in order, where it has such; NaN is missing.
    #[pyo3(signature = (measurement, time=None, inputs=None))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        measurement: PyReadonlyArray1<'py, f64>,
        time: Option<String>,
        inputs: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Known<'py>> {
        let row = entries(&measurement)?;
        let columns = inputs.as_ref().map(entries).transpose()?.unwrap_or_default();
        self.advance(py, move |running| {
            running.step_row(RowTime { label: time.as_deref(), columns: &columns }, &row)
        })
    }

    /// Predicts the next row, at which nothing is measured: with that time and these inputs, or a gap as the last one ahead.
    #[pyo3(signature = (time=None, inputs=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        time: Option<String>,
        inputs: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Known<'py>> {
        let columns = inputs.as_ref().map(entries).transpose()?;
        self.advance(py, move |running| {
            let is_given = time.is_some() || columns.is_some();
            let columns = columns.unwrap_or_default();
            let row = is_given.then_some(RowTime { label: time.as_deref(), columns: &columns });
            running.predict_row(row).map(|forecast| forecast.estimate)
        })
    }

    /// The log-evidence of all measurements so far.
    #[getter]
    fn log_evidence(&self) -> PyResult<f64> {
        Ok(self.running()?.with_dependent(|_, running| running.log_evidence()))
    }

    /// Its standard error; none where it is not checked, or of too few particles to tell.
    #[getter]
    fn standard_error(&self) -> PyResult<Option<f64>> {
        Ok(self.running()?.with_dependent(|_, running| running.standard_error()))
    }

    /// The Pareto k of the last step's weights.
    #[getter]
    fn pareto_k(&self) -> PyResult<Option<f64>> {
        Ok(self
            .running()?
            .with_dependent(|_, running| running.diagnosis().and_then(|diagnosis| diagnosis.pareto_k)))
    }
}

/// Numbers of which some may be missing, as NaN.
fn entries(values: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<Option<f64>>> {
    Ok(values.as_slice()?.iter().map(|value| (!value.is_nan()).then_some(*value)).collect())
}

impl Online {
    /// A filter that begins as `begin` says.
    fn begun(
        model: &Bound<'_, Model>,
        options: &Bound<'_, FilterOptions>,
        has_failed: bool,
        begin: impl for<'m> FnOnce(&'m motes::Model, &motes::FilterOptions) -> Result<Running<'m>, MotesError>,
    ) -> PyResult<Self> {
        let FilterOptions { options, threads } = options.get();
        let ForCall { model, failure, .. } = model.get().for_call()?;
        let running = OwnRunning::try_new(model, |model| begin(model, options));
        Ok(Online {
            running: Mutex::new(failure.or(running)?),
            failure,
            has_failed: AtomicBool::new(has_failed),
            threads: *threads,
        })
    }

    /// The filter, which only one thread at a time can have: who waits for it may be who it waits for.
    fn running(&self) -> PyResult<MutexGuard<'_, OwnRunning>> {
        match self.running.try_lock() {
            Ok(running) => Ok(running),
            Err(TryLockError::Poisoned(running)) => Ok(running.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err("the filter is in a step")),
        }
    }

    fn advance<'py>(
        &self,
        py: Python<'py>,
        step: impl FnOnce(&mut Running<'_>) -> Result<motes::Estimate, MotesError> + Send,
    ) -> PyResult<Known<'py>> {
        let mut running = self.running()?;
        if self.has_failed.load(Ordering::Relaxed) {
            return Err(PyValueError::new_err("the filter failed in an earlier step; begin with a new one"));
        }
        let running = &mut *running;
        let estimate = without_lock(py, self.threads, &self.failure.stop, move || {
            running.with_dependent_mut(|_, running| step(running))
        });
        // A row that was refused has changed nothing: another can come in its place.
        let is_refused = matches!(estimate, Ok(Err(MotesError::Timeline(_) | MotesError::Ahead(_))));
        let estimate = estimate.and_then(|estimate| self.failure.or(estimate));
        let estimate = estimate.inspect_err(|_| {
            self.has_failed.store(!is_refused, Ordering::Relaxed);
            // The model can be asked again: a checkpoint is one of a filter that failed, too.
            self.failure.stop.withdraw();
        })?;
        let (means, sds, quantiles) = crate::estimates::states(py, std::slice::from_ref(&estimate));
        let expected = measurements(py, std::iter::once(&estimate));
        Ok((means, sds, quantiles, estimate.ess, estimate.log_evidence, expected))
    }
}
