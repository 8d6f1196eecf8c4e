//! Filtering all series of some data.

use std::ops::ControlFlow;

use motes_smc::{Verdict, WeightReport};
use serde::{Deserialize, Serialize};

use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::estimate::Estimate;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::tally::{Measured, SeriesTally, Tally};
use crate::warning::Warning;

/// What filters made of data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Filtered {
    /// The estimate of each row of the data, in their order.
    pub estimates: Vec<Estimate>,
    /// What is predicted after the last measurement of each series.
    pub forecasts: Vec<Vec<Estimate>>,
    /// The log-evidence of each series.
    pub log_evidence_per_series: Vec<f64>,
    /// Its standard error; none where it is not checked, or of too few particles to tell, and 0 where the log-evidence is exact.
    pub standard_error_per_series: Vec<Option<f64>>,
    /// The exact log-evidence of each series by the Kalman filter, where the model is linear and Gaussian and filters are checked.
    pub exact_log_evidence_per_series: Vec<Option<f64>>,
    /// What the weights of all steps say.
    pub weights: WeightReport,
    /// The least effective sample size of all steps; none without particles.
    pub least_ess: Option<f64>,
    /// Reasons not to trust the estimates.
    pub warnings: Vec<Warning>,
    /// What a bootstrap filter beside that of each series says; none where none ran.
    pub opinions: Vec<Option<Verdict>>,
}

impl Filtered {
    /// The log-evidence of all series together.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence_per_series.iter().sum()
    }

    /// Its standard error: series are independent, so their variances add up. None if a series has none.
    pub fn standard_error(&self) -> Option<f64> {
        let errors = self.standard_error_per_series.iter().copied();
        let variance: Option<f64> = errors.map(|error| error.map(|error| error * error)).sum();
        variance.map(f64::sqrt)
    }
}

/// Filters each series of `data`; `proceed` is asked after each row, and after each time of a forecast, with how many rows are done.
///
/// # Errors
/// [`MotesError`] if an option is out of range, a filter failed, or `proceed` said to stop.
pub fn filter(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Filtered, MotesError> {
    filter_until(model, data, options, &mut proceed)
}

/// [`filter`], compiled once whatever asks.
fn filter_until(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Filtered, MotesError> {
    let mut estimates: Vec<Option<Estimate>> = vec![None; data.rows.len()];
    let mut tally = Tally::new(of_proposal(options).into_iter().chain(data.warnings()).collect());
    let (mut forecasts, mut done) = (vec![], 0);
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then_some(name.as_str());
        let mut running = Running::new(model, options, series)?;
        let mut of_this = SeriesTally::new(model, options);
        for &at in &places {
            let row = &data.rows[at];
            let (estimate, diagnosis) = running
                .step_and_diagnose(&row.measurement)
                .map_err(|error| of_series(name, error.at_row(data.counted, row.line)))?;
            tally.step(&mut of_this, &row.measurement, diagnosis.as_ref());
            estimates[at] = Some(estimate);
            done += 1;
            if proceed(done).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        tally.end_series(name, &of_this, &running, |time| measured(model, data, places[time]));
        let mut forecast = Vec::new();
        for _ in 0..options.forecast {
            forecast.push(running.predict().map_err(|error| of_series(name, error))?);
            if proceed(done).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        forecasts.push(forecast);
    }
    Ok(tally.into_filtered(estimates.into_iter().flatten().collect(), forecasts))
}

/// What was measured in a row of data.
pub(crate) fn measured(model: &Model, data: &Data, row: usize) -> Measured {
    let row = &data.rows[row];
    let values = model.measurements().iter().zip(&row.measurement);
    let values = values.filter_map(|(name, value)| value.map(|value| (name.clone(), value)));
    Measured { label: row.label.clone(), values: values.collect() }
}

/// What is to be said of the proposal itself, whatever the data are.
pub fn of_proposal(options: &FilterOptions) -> Option<Warning> {
    let ProposalName::Learned(learned) = &options.proposal else { return None };
    let designed = learned.notes().worse_than.as_ref()?;
    let text = format!(
        "--proposal {} did worse than {designed} on sequences of its own model when it was learned; take --proposal {designed}",
        learned.name()
    );
    Some(Warning { series: None, text })
}

/// What a bootstrap filter beside another says against it, if it does; `larger` is by how much its log-evidence of all steps is larger, and `at` what the data call
/// a time.
pub(crate) fn of_opinion(
    series: Option<&str>,
    verdict: Option<Verdict>,
    larger: f64,
    at: impl FnOnce(usize) -> String,
) -> Option<Warning> {
    let Some(Verdict::Warns { first_step, difference, error }) = verdict else { return None };
    // What has less evidence in all is no better, even if it was once.
    let bootstrap = if larger > 0.0 { "--proposal bootstrap, " } else { "" };
    let text = format!(
        "from {} on the filter misses mass: the log-evidence of a bootstrap filter is {difference:.1} ± {error:.1} larger; take {bootstrap}more \
         particles, or a larger --defensive share",
        at(first_step)
    );
    Some(Warning { series: series.map(String::from), text })
}

/// Says which series an error is about.
pub(crate) fn of_series(name: Option<&str>, error: MotesError) -> MotesError {
    match (name, error) {
        (Some(name), MotesError::Filter { place, reason }) => {
            MotesError::Filter { place: format!("series {name}, {place}"), reason }
        }
        (_, error) => error,
    }
}
