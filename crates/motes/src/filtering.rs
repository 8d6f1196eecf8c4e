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
    /// What the weights of all steps say.
    pub weights: WeightReport,
    /// The least effective sample size of all steps.
    pub least_ess: f64,
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
    let (mut forecasts, mut log_evidence_per_series, mut opinions) = (vec![], vec![], vec![]);
    let mut warnings: Vec<Warning> = of_proposal(options).into_iter().chain(data.warnings()).collect();
    let (mut weights, mut least_ess, mut done) = (WeightReport::default(), f64::INFINITY, 0);
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then(|| name.clone());
        let mut running = Running::new(model, options, series)?;
        let mut report = WeightReport::default();
        for &at in &places {
            let (estimate, diagnosis) =
                running.step_and_diagnose(&data.rows[at].measurement).map_err(|error| {
                    of_series(name.as_deref(), error.at_row(data.counted, data.rows[at].line))
                })?;
            report.add(&diagnosis);
            weights.add(&diagnosis);
            least_ess = estimate.ess.map_or(least_ess, |ess| least_ess.min(ess));
            estimates[at] = Some(estimate);
            done += 1;
            if proceed(done).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        log_evidence_per_series.push(running.log_evidence());
        warnings.extend(
            report.warnings().map(|warning| Warning { series: name.clone(), text: warning.to_string() }),
        );
        let verdict = running.verdict();
        let label = |time: usize| places.get(time).and_then(|at| data.rows[*at].label.as_deref());
        warnings.extend(of_opinion(name.as_deref(), verdict, label));
        opinions.push(verdict);
        let mut forecast = Vec::new();
        for _ in 0..options.forecast {
            forecast.push(running.predict().map_err(|error| of_series(name.as_deref(), error))?);
            if proceed(done).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        forecasts.push(forecast);
    }
    let estimates = estimates.into_iter().flatten().collect();
    Ok(Filtered { estimates, forecasts, log_evidence_per_series, weights, least_ess, warnings, opinions })
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

/// What a bootstrap filter beside another says against it, if it does; `label` is what the data call a time.
pub fn of_opinion<'a>(
    series: Option<&str>,
    verdict: Option<Verdict>,
    label: impl FnOnce(usize) -> Option<&'a str>,
) -> Option<Warning> {
    let Some(Verdict::Warns { first_step, difference, error }) = verdict else { return None };
    let called = label(first_step).map_or_else(String::new, |label| format!(" ({label})"));
    let text = format!(
        "from t = {first_step}{called} on the filter misses mass: the log-evidence of a bootstrap filter is {difference:.1} ± {error:.1} larger; \
         take --proposal bootstrap, more particles, or a larger --defensive share"
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
