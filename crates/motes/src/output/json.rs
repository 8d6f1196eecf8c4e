//! Results as one JSON object.

use serde::Serialize;

use crate::filtered::Filtered;
use crate::mixture::PosteriorEstimates;
use crate::options::FilterOptions;

#[derive(Serialize)]
struct FilterObject<'a> {
    log_evidence: f64,
    log_evidence_per_series: &'a [f64],
    standard_error: Option<f64>,
    standard_error_per_series: &'a [Option<f64>],
    exact_log_evidence_per_series: &'a [Option<f64>],
    ess_mean: Option<f64>,
    ess_min: Option<f64>,
    pareto_k: Option<f64>,
    warnings: Vec<String>,
    particles: usize,
    seconds: f64,
}

/// The object of a filter: evidence, what the weights say, warnings, and how long it took.
pub fn filter_json(filtered: &Filtered, options: &FilterOptions, seconds: f64) -> String {
    let object = FilterObject {
        log_evidence: filtered.log_evidence(),
        log_evidence_per_series: &filtered.log_evidence_per_series,
        standard_error: filtered.standard_error(),
        standard_error_per_series: &filtered.standard_error_per_series,
        exact_log_evidence_per_series: &filtered.exact_log_evidence_per_series,
        ess_mean: filtered.weights.effective_sample_size(),
        ess_min: filtered.least_ess,
        pareto_k: filtered.weights.pareto_k(),
        warnings: filtered.warnings.iter().map(ToString::to_string).collect(),
        particles: options.particles,
        seconds,
    };
    serde_json::to_string(&object).expect("numbers and texts") + "\n"
}

/// The keys of a filter, of which an average over parameters has no evidence and no weights.
#[derive(Serialize)]
struct MixtureObject {
    log_evidence: Option<f64>,
    log_evidence_per_series: Vec<Option<f64>>,
    standard_error: Option<f64>,
    standard_error_per_series: Vec<Option<f64>>,
    ess_mean: Option<f64>,
    ess_min: Option<f64>,
    pareto_k: Option<f64>,
    draws: usize,
    warnings: Vec<String>,
    particles: usize,
    seconds: f64,
}

/// The object of a filter or a smoother over the posterior of parameters, which has no log-evidence.
pub fn mixture_json(mixed: &PosteriorEstimates, options: &FilterOptions, seconds: f64) -> String {
    let of_series = vec![None; mixed.forecasts.len()];
    let object = MixtureObject {
        log_evidence: None,
        log_evidence_per_series: of_series.clone(),
        standard_error: None,
        standard_error_per_series: of_series,
        ess_mean: None,
        ess_min: None,
        pareto_k: None,
        draws: mixed.draws,
        warnings: mixed.warnings.iter().map(ToString::to_string).collect(),
        particles: options.particles,
        seconds,
    };
    serde_json::to_string(&object).expect("numbers and texts") + "\n"
}
