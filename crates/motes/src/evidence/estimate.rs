//! The log-evidence of data with its standard error, by independent runs.

use std::ops::ControlFlow;

use motes_inference::{LogMean, map_on_threads};
use motes_models::Seed;

use super::estimator::EvidenceEstimator;
use super::options::EvidenceOptions;
use super::pilot::Pilot;
use super::sequence::Proceed;
use crate::data::Data;
use crate::error::MotesError;
use crate::model::Model;
use crate::options::ProposalName;
use crate::warning::Warning;

/// The log-evidence of data.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// What particles were drawn from.
    pub proposal: ProposalName,
    /// What pilots said, where they chose it.
    pub pilots: Vec<Pilot>,
    /// The log-evidence of each series: the logarithm of the mean of `ẑ` over runs.
    pub log_evidence_per_series: Vec<f64>,
    /// Its standard error; none of a single run.
    pub standard_error_per_series: Vec<Option<f64>>,
    /// `log ẑ` of each run, of all series; one run if it is exact.
    pub runs: Vec<f64>,
}

/// A standard error above this (nats) hardly says which of two models is better.
const LARGEST_ERROR: f64 = 10.0;

impl Evidence {
    /// Whether it has no error.
    pub fn is_exact(&self) -> bool {
        self.proposal == ProposalName::Exact
    }

    /// What is to be said where it cannot be trusted.
    pub fn warning(&self) -> Option<Warning> {
        let text = match self.standard_error() {
            _ if self.log_evidence() == f64::NEG_INFINITY => {
                "no particle of any run explains some measurement: the log-evidence is −∞".to_string()
            }
            Some(error) if error > LARGEST_ERROR => format!(
                "the log-evidence is too low by an unknown amount, as its standard error of {error:.1} shows: compare no models with it; take more particles, or leave out \
                 --proposal"
            ),
            _ => return None,
        };
        Some(Warning { series: None, text })
    }

    /// That of all series.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence_per_series.iter().sum()
    }

    /// Its standard error; none of a single run.
    pub fn standard_error(&self) -> Option<f64> {
        let squares = self.standard_error_per_series.iter().map(|error| error.map(|error| error * error));
        squares.sum::<Option<f64>>().map(f64::sqrt)
    }

    /// The variance of `log ẑ` of all series over runs; none of a single run.
    pub fn variance_per_run(&self) -> Option<f64> {
        match &self.proposal {
            ProposalName::Exact => Some(0.0),
            _ => variance(&self.runs),
        }
    }
}

/// The variance of some numbers; none of one.
fn variance(values: &[f64]) -> Option<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.len() > 1).then(|| values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0))
}

/// The logarithm of the mean of `ẑ` over runs, and its standard error: that of the mean, or of the mean of `log ẑ` where that is larger. The first cannot be above 1 whatever was
/// missed.
fn mean_of_runs(logs: &[f64]) -> (f64, Option<f64>) {
    let mean = LogMean::of(logs);
    let of_logs = variance(logs).map(|variance| (variance / logs.len() as f64).sqrt());
    let error = mean.standard_error().zip(of_logs).map(|(of_mean, of_logs)| of_mean.max(of_logs));
    (mean.log(), error)
}

/// Estimates the log-evidence of all series of `data` by [`EvidenceOptions::runs`] independent runs. `proceed` is asked now and then, from any thread.
///
/// ```
/// use motes::{Data, EvidenceOptions, Model, evidence};
/// use std::ops::ControlFlow;
///
/// let text = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 0.1)\"\n[measurement]\ny = \"poisson(exp(x))\"\n";
/// let model = Model::parse(text, "counts", &[])?;
/// let data = Data::read("y\n1\n0\n2\n9\n".as_bytes(), "y.csv", &model)?;
/// let found = evidence(&model, &data, &EvidenceOptions::default(), || ControlFlow::Continue(()))?;
/// println!("log-evidence {:.3} ± {:.3}", found.log_evidence(), found.standard_error().ok_or("one run")?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`EvidenceEstimator`], [`MotesError::Setting`] if there is no run, and [`MotesError::Interrupted`].
pub fn evidence(
    model: &Model,
    data: &Data,
    options: &EvidenceOptions,
    proceed: impl Fn() -> ControlFlow<()> + Sync,
) -> Result<Evidence, MotesError> {
    evidence_while(model, data, options, &proceed)
}

/// [`evidence`], compiled once whatever asks.
fn evidence_while(
    model: &Model,
    data: &Data,
    options: &EvidenceOptions,
    proceed: Proceed<'_>,
) -> Result<Evidence, MotesError> {
    if options.runs == 0 {
        return Err(MotesError::Setting("the number of runs is 0; it must be at least 1".into()));
    }
    let estimator = EvidenceEstimator::while_proceeding(model, data, options, proceed)?;
    let seed = Seed::from_u64(options.seed).child("evidence").child("runs");
    let count = if estimator.is_exact() { 1 } else { options.runs };
    let runs = map_on_threads(&vec![(); count], |number, ()| {
        estimator.per_series_while(&seed.nth(number as u64), proceed)
    });
    let runs = runs.into_iter().collect::<Result<Vec<Vec<f64>>, MotesError>>()?;
    let of_series = |series: usize| -> (f64, Option<f64>) {
        let logs: Vec<f64> = runs.iter().map(|run| run[series]).collect();
        let (log, error) = mean_of_runs(&logs);
        (log, if estimator.is_exact() { Some(0.0) } else { error })
    };
    let (log_evidence_per_series, standard_error_per_series) = (0..estimator.series()).map(of_series).unzip();
    Ok(Evidence {
        proposal: estimator.proposal().clone(),
        pilots: estimator.pilots().to_vec(),
        log_evidence_per_series,
        standard_error_per_series,
        runs: runs.iter().map(|run| run.iter().sum()).collect(),
    })
}
