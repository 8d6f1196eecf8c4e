//! The log-evidence of data with its standard error, by independent runs.

use std::ops::ControlFlow;

use motes_inference::map_on_threads;
use motes_models::Seed;
use motes_smc::LARGEST_ERROR;

use super::estimator::EvidenceEstimator;
use super::options::EvidenceOptions;
use super::pilot::Pilot;
use super::runs::{mean_of_runs, variance};
use super::sequence::Proceed;
use crate::data::Data;
use crate::error::MotesError;
use crate::model::Model;
use crate::options::ProposalName;
use crate::outside_prior::outside_of_learning;
use crate::warning::Warning;

/// The log-evidence of data.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// What the particles of each series were drawn from.
    pub proposals: Vec<ProposalName>,
    /// What pilots said, where they chose it.
    pub pilots: Vec<Pilot>,
    /// The log-evidence of each series: the logarithm of the mean of `ẑ` over runs.
    pub log_evidence_per_series: Vec<f64>,
    /// Its standard error, widened as Student's t for so few runs, so that twice it is an interval of 95 %; none of a single run.
    pub standard_error_per_series: Vec<Option<f64>>,
    /// `log ẑ` of each run, of all series; one run if it is exact.
    pub runs: Vec<f64>,
    /// Where another proposal has found more than the one that was asked for or chosen.
    pub missed: Vec<MissedMass>,
    /// That parameters lie beyond the prior that the proposal was learned over.
    pub beyond_prior: Option<Warning>,
    /// Where no particle of any run explains a measurement: the series, the row and why.
    pub impossible: Option<Warning>,
}

/// A proposal whose runs agree, and miss states that explain the data.
#[derive(Debug, Clone, PartialEq)]
pub struct MissedMass {
    /// The name of the series, if there are several.
    pub series: Option<String>,
    /// The proposal that misses them.
    pub by: ProposalName,
    /// The one that finds them.
    pub found_by: ProposalName,
    /// How much more log-evidence it finds.
    pub nats: f64,
    /// Whether the log-evidence is that of the one that finds them: so it is where nobody named a proposal.
    pub is_replaced: bool,
}

impl Evidence {
    /// Whether it has no error.
    pub fn is_exact(&self) -> bool {
        self.proposals.first() == Some(&ProposalName::Exact)
    }

    /// The proposals of all series, each once.
    pub fn proposal_names(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        for proposal in &self.proposals {
            if !names.contains(&proposal.as_str()) {
                names.push(proposal.as_str());
            }
        }
        names.join(", ")
    }

    /// What is to be said where it cannot be trusted.
    pub fn warnings(&self) -> Vec<Warning> {
        let missed = self.missed.iter().filter(|missed| !missed.is_replaced).map(|missed| {
            let MissedMass { by, found_by, nats, .. } = missed;
            let text = format!(
                "the log-evidence is too low: --proposal {found_by} finds {nats:.1} more, so that {by} misses states that explain the data; leave out --proposal"
            );
            Warning { series: missed.series.clone(), text }
        });
        let mut warnings: Vec<Warning> = self.beyond_prior.iter().cloned().chain(missed).collect();
        warnings.extend(self.impossible.clone());
        if self.impossible.is_none()
            && let Some(error) = self.standard_error()
            && error > LARGEST_ERROR
        {
            let text = format!(
                "the log-evidence is too low by an unknown amount, as its standard error of {error:.1} shows: compare no models with it; take more particles"
            );
            warnings.push(Warning { series: None, text });
        }
        warnings
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
        if self.is_exact() { Some(0.0) } else { variance(&self.runs) }
    }
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
    let mut logs: Vec<Vec<f64>> =
        (0..estimator.series()).map(|series| runs.iter().map(|run| run[series]).collect()).collect();
    let mut proposals: Vec<ProposalName> = estimator.proposals().into_iter().cloned().collect();
    let mut missed = Vec::new();
    if options.check && !estimator.is_exact() {
        let seed = Seed::from_u64(options.seed).child("evidence").child("second opinion");
        let opinions = map_on_threads(&logs, |series, logs| {
            estimator.second_opinion(series, logs, &seed.nth(series as u64), proceed)
        });
        for (series, opinion) in opinions.into_iter().enumerate() {
            let Some(opinion) = opinion? else { continue };
            let is_replaced = options.proposal.is_none();
            missed.push(MissedMass {
                series: data.columns.has_series().then(|| data.series[series].clone()),
                by: proposals[series].clone(),
                found_by: opinion.proposal.clone(),
                nats: opinion.nats,
                is_replaced,
            });
            if is_replaced {
                proposals[series] = opinion.proposal;
                logs[series] = opinion.logs;
            }
        }
    }
    let of_series = |logs: &Vec<f64>| -> (f64, Option<f64>) {
        let (log, error) = mean_of_runs(logs);
        (log, if estimator.is_exact() { Some(0.0) } else { error })
    };
    let (log_evidence_per_series, standard_error_per_series): (Vec<f64>, _) =
        logs.iter().map(of_series).unzip();
    let impossible = log_evidence_per_series.iter().position(|log| *log == f64::NEG_INFINITY);
    let impossible = impossible.map(|series| {
        let none = || "no particle of any run explains some measurement".to_string();
        let reason = estimator.failure(series, seed.nth(0).nth(series as u64)).unwrap_or_else(none);
        Warning { series: None, text: format!("{reason}; the log-evidence is −∞") }
    });
    Ok(Evidence {
        proposals,
        pilots: estimator.pilots().to_vec(),
        log_evidence_per_series,
        standard_error_per_series,
        runs: (0..count).map(|run| logs.iter().map(|logs| logs[run]).sum()).collect(),
        missed,
        beyond_prior: options.proposal.as_ref().and_then(|proposal| outside_of_learning(model, proposal)),
        impossible,
    })
}
