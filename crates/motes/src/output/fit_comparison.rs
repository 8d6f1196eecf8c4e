//! Two fitted models beside each other, as a table and as JSON.

use serde::Serialize;
use serde_json::{Map, Value};

use super::table::{Table, markdown};
use crate::fit_comparison::{FitComparison, FittedScore};

/// A number that may be missing, with its error.
fn with_error(value: Option<[f64; 2]>) -> String {
    value.map(|[value, error]| format!("{value:.3} ± {error:.3}")).unwrap_or_default()
}

/// What each model is called: by its name, and by a number where both have the same one.
fn names(comparison: &FitComparison) -> [String; 2] {
    let [a, b] = comparison.models.each_ref().map(|model| model.model.clone());
    match a == b {
        true => [format!("{a} (1)"), format!("{b} (2)")],
        false => [a, b],
    }
}

/// A line for each figure, with a column for each model and one for the difference.
pub fn fit_comparison_text(comparison: &FitComparison) -> String {
    let [a, b] = &comparison.models;
    let marginal = |model: &FittedScore| {
        with_error(model.marginal_likelihood.map(|found| [found.log, found.standard_error]))
    };
    let aic = |model: &FittedScore| model.aic.map(|aic| format!("{aic:.2}")).unwrap_or_default();
    let [name_a, name_b] = names(comparison);
    let mut rows = Vec::new();
    let mut row = |name: &str, of: [String; 2], difference: String| {
        let [of_a, of_b] = of;
        if !(of_a.is_empty() && of_b.is_empty()) {
            rows.push(vec![name.to_string(), of_a, of_b, difference]);
        }
    };
    row("log marginal likelihood", [a, b].map(marginal), with_error(comparison.log_bayes_factor()));
    let difference = a.aic.zip(b.aic).map(|(a, b)| format!("{:.2}", a - b)).unwrap_or_default();
    row("AIC", [a, b].map(aic), difference);
    let scores = [a, b].map(|model| format!("{:.3}", model.log_score()));
    row("one-step-ahead log score", scores, with_error(Some(comparison.score_difference())));
    row("rows with a measurement", [a, b].map(|model| model.log_scores.len().to_string()), String::new());
    let header = ["".to_string(), name_a, name_b, "difference".into()];
    markdown(&Table { header: header.to_vec(), rows })
}

#[derive(Serialize)]
struct ScoreObject {
    log_marginal_likelihood: Option<f64>,
    log_marginal_likelihood_error: Option<f64>,
    aic: Option<f64>,
    log_score: f64,
}

#[derive(Serialize)]
struct ComparisonObject {
    models: Map<String, Value>,
    log_bayes_factor: Option<f64>,
    log_bayes_factor_error: Option<f64>,
    log_score_difference: f64,
    log_score_difference_error: Option<f64>,
    rows: usize,
    seconds: f64,
}

/// The same as one JSON object.
pub fn fit_comparison_json(comparison: &FitComparison, seconds: f64) -> String {
    let of_model = |model: &FittedScore| {
        let object = ScoreObject {
            log_marginal_likelihood: model.marginal_likelihood.map(|found| found.log),
            log_marginal_likelihood_error: model.marginal_likelihood.map(|found| found.standard_error),
            aic: model.aic,
            log_score: model.log_score(),
        };
        serde_json::to_value(object).unwrap_or(Value::Null)
    };
    let factor = comparison.log_bayes_factor();
    let [difference, error] = comparison.score_difference();
    let object = ComparisonObject {
        models: names(comparison).into_iter().zip(comparison.models.iter().map(of_model)).collect(),
        log_bayes_factor: factor.map(|[value, _]| value),
        log_bayes_factor_error: factor.map(|[_, error]| error),
        log_score_difference: difference,
        log_score_difference_error: Some(error).filter(|error| error.is_finite()),
        rows: comparison.models[0].log_scores.len(),
        seconds,
    };
    serde_json::to_string(&object).expect("numbers and texts") + "\n"
}
