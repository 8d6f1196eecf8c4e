//! What filters and smoothers made of data.

use std::fmt::Write as _;
use std::sync::Arc;

use motes::output::{EstimateTable, Report, filter_json, filter_settings, filter_summary, report};
use motes::smc::SmoothedPaths;
use motes::{Estimate, MotesError};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

use crate::data::Data;
use crate::errors::{in_python, to_python};
use crate::estimates::{States, states};

/// The result of a filter, or of a smoother.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct Filtered {
    pub(crate) model: Arc<motes::Model>,
    pub(crate) set: Vec<(String, f64)>,
    pub(crate) data: Py<Data>,
    pub(crate) options: motes::FilterOptions,
    pub(crate) filtered: motes::Filtered,
    /// The estimates of a smoother, and its paths.
    pub(crate) smoothed: Option<(Vec<Estimate>, Vec<SmoothedPaths>)>,
    pub(crate) seconds: f64,
}

impl Filtered {
    fn rows(&self) -> &[Estimate] {
        self.smoothed.as_ref().map_or(&self.filtered.estimates, |(estimates, _)| estimates)
    }

    fn summary(&self) -> Vec<(String, String)> {
        let data = &self.data.get().0;
        filter_summary(data.rows.len(), data.columns.has_series(), &self.filtered, &self.options)
    }
}

#[pymethods]
impl Filtered {
    /// Means, standard deviations and quantiles of the states, row by row.
    fn states<'py>(&self, py: Python<'py>) -> States<'py> {
        states(py, self.rows())
    }

    /// The same of what is predicted after each series, one after the other.
    fn forecasts<'py>(&self, py: Python<'py>) -> States<'py> {
        states(py, &self.filtered.forecasts.concat())
    }

    /// The effective sample size of each row, in particles.
    fn ess<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let sizes = self.filtered.estimates.iter().map(|estimate| estimate.ess.unwrap_or(f64::NAN));
        sizes.collect::<Vec<_>>().into_pyarray(py)
    }

    /// The log-evidence of each row.
    fn log_evidence_increments<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let of_rows =
            self.filtered.estimates.iter().map(|estimate| estimate.log_evidence.unwrap_or(f64::NAN));
        of_rows.collect::<Vec<_>>().into_pyarray(py)
    }

    /// The log-evidence of each series.
    fn log_evidence_per_series<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.filtered.log_evidence_per_series.clone().into_pyarray(py)
    }

    /// The log-evidence of all series.
    #[getter]
    fn log_evidence(&self) -> f64 {
        self.filtered.log_evidence()
    }

    /// The Pareto k of the weights of all steps; none where it cannot be fitted.
    #[getter]
    fn pareto_k(&self) -> Option<f64> {
        self.filtered.weights.pareto_k()
    }

    /// Reasons not to trust the estimates.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.filtered.warnings.iter().map(|warning| in_python(&warning.to_string())).collect()
    }

    /// The trajectories of a series that a smoother drew, flat: `B × T × N` numbers, with the number of them.
    fn paths<'py>(&self, py: Python<'py>, series: usize) -> Option<(usize, Bound<'py, PyArray1<f64>>)> {
        let paths = self.smoothed.as_ref()?.1.get(series)?;
        let values: Vec<f64> = (0..paths.len()).flat_map(|path| paths.path(path).iter().copied()).collect();
        Some((paths.len(), values.into_pyarray(py)))
    }

    #[getter]
    fn seconds(&self) -> f64 {
        self.seconds
    }

    #[getter]
    fn particles(&self) -> usize {
        self.options.particles
    }

    /// The table that the command writes.
    fn csv(&self) -> String {
        let data = &self.data.get().0;
        let table = EstimateTable::new(&self.model, &data.columns, self.smoothed.is_none());
        match &self.smoothed {
            Some((estimates, _)) => table.smoothed(data, estimates),
            None => table.filtered(data, &self.filtered),
        }
    }

    /// The object that the command prints with --json.
    fn json(&self) -> String {
        filter_json(&self.filtered, &self.options, self.seconds)
    }

    /// The report, an HTML page that needs nothing else; `call` is what made it.
    fn html(&self, call: &str) -> PyResult<String> {
        let settings = filter_settings(self.model.name(), &self.set, &self.options);
        let page = report(&Report {
            title: if self.smoothed.is_some() { "Smoother" } else { "Filter" },
            model: &self.model,
            data: &self.data.get().0,
            estimates: self.rows(),
            forecasts: &self.filtered.forecasts,
            summary: &self.summary(),
            settings: &settings,
            warnings: &self.warnings(),
            command: call,
        });
        page.map_err(|error| to_python(MotesError::Report(error.to_string())))
    }

    /// The run in a few figures, one per line.
    fn text(&self) -> String {
        let mut text = String::new();
        for (name, value) in self.summary() {
            let _ = writeln!(text, "{name}: {value}");
        }
        self.warnings().iter().for_each(|warning| {
            let _ = writeln!(text, "warning: {warning}");
        });
        text
    }
}
