//! A fit as one JSON object.

use serde::Serialize;
use serde_json::Value;

use crate::fitting::PosteriorFit;

#[derive(Serialize)]
struct FitObject<'a> {
    parameters: serde_json::Map<String, Value>,
    log_likelihood: f64,
    log_likelihood_error: f64,
    log_marginal_likelihood: Option<f64>,
    log_marginal_likelihood_error: Option<f64>,
    acceptance: f64,
    proposal: &'a str,
    particles: usize,
    variance: Option<f64>,
    chains: usize,
    draws: usize,
    warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
}

/// The object of a fit: each parameter with its figures, the log-likelihood at their means, the marginal likelihood, how it was found, warnings, and how long it took if that is
/// said.
pub fn fit_json(fitted: &PosteriorFit, seconds: Option<f64>) -> String {
    let of_parameter = |summary: &_| serde_json::to_value(summary).unwrap_or(Value::Null);
    let marginal = fitted.marginal_likelihood;
    let object = FitObject {
        parameters: fitted.names.iter().cloned().zip(fitted.parameters.iter().map(of_parameter)).collect(),
        log_likelihood: fitted.log_likelihood,
        log_likelihood_error: fitted.log_likelihood_error,
        log_marginal_likelihood: marginal.map(|marginal| marginal.log),
        log_marginal_likelihood_error: marginal.map(|marginal| marginal.standard_error),
        acceptance: fitted.acceptance_of_all(),
        proposal: &fitted.proposal,
        particles: fitted.particles,
        variance: Some(fitted.variance).filter(|variance| variance.is_finite()),
        chains: fitted.chains.len(),
        draws: fitted.draws(),
        warnings: fitted.warnings.iter().map(ToString::to_string).collect(),
        seconds,
    };
    serde_json::to_string(&object).expect("numbers and texts") + "\n"
}
