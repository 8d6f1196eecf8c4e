//! What fitted models say of data before they see them.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use motes_inference::{LogMean, MarginalLikelihood, map_on_threads};
use motes_smc::FilterError;

use super::folder::FittedModel;
use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::evidence::is_exact;
use crate::mixture::options_of_draw;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};

/// Draws of a posterior that scores are averaged over.
const DRAWS: usize = 100;

/// What a fitted model says of data.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedScore {
    /// The model's name.
    pub model: String,
    /// `log p(y)`, averaged over the prior of its parameters; none of a maximum, and where draws do not tell.
    pub marginal_likelihood: Option<MarginalLikelihood>,
    /// Akaike's information criterion; none of a posterior.
    pub aic: Option<f64>,
    /// `log p(y_t | y_{0:t−1})` of each row in which something was measured, one step ahead, averaged over the posterior of parameters.
    pub log_scores: Vec<f64>,
}

/// Two models that were fitted to the same data.
#[derive(Debug, Clone, PartialEq)]
pub struct FitComparison {
    /// What each of them says.
    pub models: [FittedScore; 2],
}

impl FittedScore {
    /// The log scores added up.
    pub fn log_score(&self) -> f64 {
        self.log_scores.iter().sum()
    }
}

impl FitComparison {
    /// By how much the first model's `log p(y)` is larger, and the standard error of that; none where one of them is not known.
    pub fn log_bayes_factor(&self) -> Option<[f64; 2]> {
        let [a, b] = self.models.each_ref().map(|model| model.marginal_likelihood);
        let (a, b) = a.zip(b)?;
        Some([a.log - b.log, a.standard_error.hypot(b.standard_error)])
    }

    /// By how much the first model's log scores are larger in sum, and the standard error of that: how sums of as many such differences `d_t` vary, `√T · sd(d_t)`; NaN of
    /// fewer than two rows.
    pub fn score_difference(&self) -> [f64; 2] {
        let [a, b] = &self.models;
        let differences: Vec<f64> = a.log_scores.iter().zip(&b.log_scores).map(|(a, b)| a - b).collect();
        let count = differences.len() as f64;
        let (sum, mean) = (differences.iter().sum::<f64>(), differences.iter().sum::<f64>() / count);
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (count - 1.0);
        [sum, (count * variance).sqrt()]
    }
}

/// Holds two models beside each other that were fitted to the same data: their marginal likelihoods, which parameters had no part of, and how well each expects the next
/// measurement, with parameters that have seen all data. `proceed` is asked after each row of each draw, with the share of the work that is done.
///
/// # Errors
/// [`MotesError::Setting`] if they do not measure the same in the same rows; as [`crate::filter`].
pub fn compare_fits(
    fits: [&FittedModel; 2],
    options: &FilterOptions,
    proceed: &(dyn Fn(f64) -> ControlFlow<()> + Sync),
) -> Result<FitComparison, MotesError> {
    let [a, b] = fits;
    let measured =
        |fit: &FittedModel| fit.data.rows.iter().map(|row| row.measurement.clone()).collect::<Vec<_>>();
    if a.model.measurements() != b.model.measurements() || measured(a) != measured(b) {
        let [of_a, of_b] = fits.map(|fit| fit.model.measurements().join(", "));
        return Err(MotesError::Setting(format!(
            "{} has {of_a} as its measurements and {} has {of_b}: models of different measurements cannot be held beside each other",
            a.model.name(),
            b.model.name()
        )));
    }
    let models = fits.map(|fit| fit.parameters.spread(&fit.model, DRAWS));
    let [of_a, of_b] = models;
    let models = [of_a?, of_b?];
    let all = models.iter().map(Vec::len).sum::<usize>() * a.data.rows.len();
    let done = AtomicUsize::new(0);
    let proceed = || proceed((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
    let score = |fit: &FittedModel, models: &[Model]| -> Result<FittedScore, MotesError> {
        let proposal = match is_exact(&fit.model, &fit.data) {
            true => ProposalName::Exact,
            false => options.proposal.clone(),
        };
        let options =
            FilterOptions { proposal, check: false, predictive: false, forecast: 0, ..options.clone() };
        let of_draws = map_on_threads(models, |number, model| {
            increments(model, &fit.data, &options_of_draw(&options, number), &proceed)
        });
        let of_draws = of_draws.into_iter().collect::<Result<Vec<Vec<f64>>, MotesError>>()?;
        let rows = fit.data.rows.iter().enumerate();
        let rows = rows.filter(|(_, row)| row.measurement.iter().any(Option::is_some));
        let of_row = |(at, _)| LogMean::of(&of_draws.iter().map(|draw| draw[at]).collect::<Vec<f64>>()).log();
        Ok(FittedScore {
            model: fit.model.name().to_string(),
            marginal_likelihood: fit.marginal_likelihood,
            aic: fit.aic,
            log_scores: rows.map(of_row).collect(),
        })
    };
    Ok(FitComparison { models: [score(a, &models[0])?, score(b, &models[1])?] })
}

/// `log p(y_t | y_{0:t−1})` of each row by one filter.
fn increments(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Result<Vec<f64>, MotesError> {
    let mut found = vec![0.0; data.rows.len()];
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then_some(name.as_str());
        let mut running = Running::new(model, options, series)?;
        for (number, &at) in places.iter().enumerate() {
            let row = &data.rows[at];
            if let Err(error) = running.advance_by(&row.steps, &row.measurement) {
                // A draw of parameters by which no particle explains a measurement has no part in what is expected of it, nor of those after it.
                if let Some(FilterError::Collapse { .. }) = running.filter.failure() {
                    places[number..].iter().for_each(|at| found[*at] = f64::NEG_INFINITY);
                    break;
                }
                return Err(error.at_row(&data.source, name, row.line));
            }
            found[at] = running.last_increment();
            if proceed().is_break() {
                return Err(MotesError::Interrupted);
            }
        }
    }
    Ok(found)
}
