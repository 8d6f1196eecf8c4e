//! What filters and smoothers made of data.

use std::fmt::Write as _;

use motes::output::{EstimateTable, Report, filter_json, filter_settings, filter_summary, report};
use motes::smc::SmoothedPaths;
use motes::{Estimate, ModelNames, MotesError, ProposalName, Quantiles, pack, unpack};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::data::Data;
use crate::errors::{in_python, to_python};
use crate::estimates::{Expected, States, measurements, states};

/// What errors call its bytes, and the version of these.
const PACKED: (&str, u32) = ("a result of a filter", 4);

/// The result of a filter, or of a smoother.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct Filtered {
    names: ModelNames,
    data: Py<Data>,
    particles: usize,
    quantiles: Quantiles,
    is_checked: bool,
    is_exact: bool,
    /// What it was made with, a name and a value each.
    settings: Vec<(String, String)>,
    filtered: motes::Filtered,
    /// The estimates of a smoother, and its paths.
    smoothed: Option<(Vec<Estimate>, Vec<SmoothedPaths>)>,
    seconds: f64,
}

impl Filtered {
    /// What came of a filter, or of a smoother with its estimates and paths, of this model with parameters `set` to other values.
    pub(crate) fn new(
        model: &motes::Model,
        set: &[(String, f64)],
        data: Py<Data>,
        options: &motes::FilterOptions,
        filtered: motes::Filtered,
        smoothed: Option<(Vec<Estimate>, Vec<SmoothedPaths>)>,
        seconds: f64,
    ) -> Self {
        let settings = filter_settings(model.name(), set, options);
        Filtered {
            names: ModelNames::from(model),
            data,
            particles: options.particles,
            quantiles: options.quantiles.clone(),
            is_checked: options.check,
            is_exact: options.proposal == ProposalName::Exact,
            settings,
            filtered,
            smoothed,
            seconds,
        }
    }

    /// As much of the options as figures need.
    fn options(&self) -> motes::FilterOptions {
        motes::FilterOptions {
            proposal: if self.is_exact { ProposalName::Exact } else { ProposalName::default() },
            particles: self.particles,
            check: self.is_checked,
            ..motes::FilterOptions::default()
        }
    }

    fn rows(&self) -> &[Estimate] {
        self.smoothed.as_ref().map_or(&self.filtered.estimates, |(estimates, _)| estimates)
    }

    fn summary(&self) -> Vec<(String, String)> {
        let data = &self.data.get().0;
        filter_summary(data.rows.len(), data.columns.has_series(), &self.filtered, &self.options())
    }
}

#[pymethods]
impl Filtered {
    /// That of which `__getnewargs__` gives the bytes and the data: for pickles and copies.
    #[new]
    fn of_bytes(bytes: &[u8], data: Py<Data>) -> PyResult<Self> {
        let (names, (particles, quantiles, is_checked, is_exact), settings, filtered, smoothed, seconds) =
            unpack(PACKED.0, PACKED.1, bytes).map_err(to_python)?;
        Ok(Filtered {
            names,
            data,
            particles,
            quantiles,
            is_checked,
            is_exact,
            settings,
            filtered,
            smoothed,
            seconds,
        })
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyBytes>, Py<Data>)> {
        let Filtered { names, settings, filtered, smoothed, seconds, .. } = self;
        let options = (self.particles, &self.quantiles, self.is_checked, self.is_exact);
        let content = (names, options, settings, filtered, smoothed, seconds);
        let bytes = pack(PACKED.0, PACKED.1, &content).map_err(to_python)?;
        Ok((PyBytes::new(py, &bytes), self.data.clone_ref(py)))
    }

    /// Means, standard deviations and quantiles of the states, row by row.
    fn states<'py>(&self, py: Python<'py>) -> States<'py> {
        states(py, self.rows())
    }

    /// The same of what is predicted after each series, one after the other.
    fn forecasts<'py>(&self, py: Python<'py>) -> States<'py> {
        let of_forecasts = self.filtered.forecasts.iter().flatten();
        let all: Vec<Estimate> = of_forecasts.map(|forecast| forecast.estimate.clone()).collect();
        states(py, &all)
    }

    /// What was expected of the measurements of each row, where it was asked for: means, standard deviations, quantiles and places.
    fn predictive<'py>(&self, py: Python<'py>) -> Expected<'py> {
        measurements(py, self.filtered.estimates.iter())
    }

    /// Whether that was asked for.
    #[getter]
    fn is_predictive(&self) -> bool {
        self.filtered.estimates.iter().any(|estimate| !estimate.predictive.is_empty())
    }

    /// The same of the measurements that are predicted after each series, which have no places.
    fn forecast_measurements<'py>(&self, py: Python<'py>) -> Expected<'py> {
        measurements(py, self.filtered.forecasts.iter().flatten().map(|forecast| &forecast.estimate))
    }

    /// The times of what is predicted, likewise.
    fn forecast_times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let times = self.filtered.forecasts.iter().flatten().map(|forecast| forecast.time);
        times.collect::<Vec<_>>().into_pyarray(py)
    }

    /// How many rows are predicted after each series.
    fn forecast_counts(&self) -> Vec<usize> {
        self.filtered.forecasts.iter().map(Vec::len).collect()
    }

    /// The times of what is predicted as they were given, or as the model's clock has them; none where rows count as steps.
    fn forecast_labels(&self) -> Option<Vec<String>> {
        self.filtered.forecasts.iter().flatten().map(|forecast| forecast.label.clone()).collect()
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

    /// Its standard error for each series; NaN where it is not checked, or of too few particles to tell.
    fn standard_error_per_series<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let errors = self.filtered.standard_error_per_series.iter().map(|error| error.unwrap_or(f64::NAN));
        errors.collect::<Vec<_>>().into_pyarray(py)
    }

    /// The log-evidence of all series.
    #[getter]
    fn log_evidence(&self) -> f64 {
        self.filtered.log_evidence()
    }

    /// Its standard error; none where a series has none.
    #[getter]
    fn standard_error(&self) -> Option<f64> {
        self.filtered.standard_error()
    }

    /// The largest Pareto k of a step's weights, less its sampling error; none where it cannot be fitted.
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
        self.particles
    }

    /// What tables call the quantiles, with their probabilities.
    #[getter]
    fn quantiles(&self) -> Vec<(String, f64)> {
        self.quantiles.names().into_iter().zip(self.quantiles.probabilities().iter().copied()).collect()
    }

    /// The table that the command writes.
    fn csv(&self) -> String {
        let data = &self.data.get().0;
        if let Some((estimates, _)) = &self.smoothed {
            return EstimateTable::new(&self.names, &data.columns, &self.quantiles).smoothed(data, estimates);
        }
        let has_forecasts = self.filtered.forecasts.iter().any(|forecasts| !forecasts.is_empty());
        let (quantiles, is_predictive) = (&self.quantiles, self.is_predictive());
        EstimateTable::of_filter(&self.names, &data.columns, quantiles, is_predictive, has_forecasts)
            .filtered(data, &self.filtered)
    }

    /// What is predicted after each series as a table, with the label of each row in a column of that name if there are any.
    fn forecast_csv(&self, labels: Option<(String, Vec<String>)>) -> String {
        let data = &self.data.get().0;
        let (name, labels) = labels.map_or((None, Vec::new()), |(name, labels)| (Some(name), labels));
        EstimateTable::of_forecasts(&self.names, &data.columns, &self.quantiles, name.as_deref()).forecasts(
            data,
            &self.filtered,
            &labels,
        )
    }

    /// The object that the command prints with --json.
    fn json(&self) -> String {
        filter_json(&self.filtered, &self.options(), self.seconds)
    }

    /// The report, an HTML page that needs nothing else; `call` is what made it.
    fn html(&self, call: &str) -> PyResult<String> {
        let page = report(&Report {
            title: if self.smoothed.is_some() { "Smoother" } else { "Filter" },
            names: &self.names,
            data: &self.data.get().0,
            estimates: self.rows(),
            quantiles: &self.quantiles,
            forecasts: &self.filtered.forecasts,
            summary: &self.summary(),
            settings: &self.settings,
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
