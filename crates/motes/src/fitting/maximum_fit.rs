//! The maximum of the likelihood.

use std::ops::ControlFlow;

use motes_inference::{EstimatorChoice, MaximumSearch, MaximumSettings};
use serde::{Deserialize, Serialize};

use super::free::FreeParameters;
use super::likelihood::ModelLikelihood;
use super::options::FitOptions;
use super::run::{check, refused};
use super::trust;
use crate::data::Data;
use crate::error::MotesError;
use crate::model::Model;
use crate::warning::Warning;

/// A parameter at the maximum of the likelihood, with its interval by the profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MaximumParameter {
    /// Its value at the maximum.
    pub estimate: f64,
    /// The lower end of its interval.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// The maximum of the likelihood over the free parameters of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaximumFit {
    /// The names of the `D` parameters.
    pub names: Vec<String>,
    /// Each of them.
    pub parameters: Vec<MaximumParameter>,
    /// The probability of the intervals.
    pub level: f64,
    /// The log-likelihood at the maximum: `log` of the average of some estimates.
    pub log_likelihood: f64,
    /// Its standard error; 0 where it is exact.
    pub log_likelihood_error: f64,
    /// The number of searches, and how many of them came as high.
    pub starts: [usize; 2],
    /// The estimator of the likelihood, as `--proposal` names it.
    pub proposal: String,
    /// Its number of particles.
    pub particles: usize,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

impl MaximumFit {
    /// Akaike's information criterion, `2 D − 2 log L`.
    pub fn aic(&self) -> f64 {
        2.0 * self.names.len() as f64 - 2.0 * self.log_likelihood
    }
}

/// Finds the maximum of the likelihood over the free parameters of `model`, and the interval of each. The priors say where searches start and in which coordinates
/// they go, and nothing else. `observe` is shown the search between two pieces of its work.
///
/// # Errors
/// As [`crate::fit`].
pub fn maximise(
    model: &Model,
    data: &Data,
    options: &FitOptions,
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
    observe: &mut dyn FnMut(usize, usize) -> Result<(), MotesError>,
) -> Result<MaximumFit, MotesError> {
    let free = FreeParameters::of(model)?;
    let likelihood = ModelLikelihood::new(model, data, &free, options, proceed);
    check(model, data, options)?;
    let settings = MaximumSettings {
        starts: options.chains,
        estimator: options.particles.map(EstimatorChoice::Particles),
        ..MaximumSettings::default()
    };
    let mut search = MaximumSearch::new(settings, options.seed);
    while !search.is_done(free.len()) {
        let (done, all) = search.progress(free.len());
        observe(done, all)?;
        search.advance(&likelihood).map_err(|error| refused(error, &likelihood))?;
    }
    let Some(best) = search.best() else { return Err(MotesError::Interrupted) };
    let estimates = free.at(&best.v);
    let end = |at: usize, value: f64| {
        let mut v = best.v.clone();
        v[at] = value;
        free.at(&v)[at]
    };
    let parameter = |(at, estimate): (usize, &f64)| {
        let interval = search.intervals()[at];
        let (low, high) = (end(at, interval.low), end(at, interval.high));
        // A share of a dirichlet falls where its own number rises, if others do.
        MaximumParameter { estimate: *estimate, low: low.min(high), high: low.max(high) }
    };
    let mut warnings =
        trust::of_starts(search.agreeing(), search.searches()).into_iter().collect::<Vec<Warning>>();
    warnings.extend(trust::of_priors(&free, &|at| vec![best.v[at]]));
    warnings.extend(trust::of_possible(search.possible(), likelihood.reason().as_deref()));
    Ok(MaximumFit {
        names: free.names(),
        parameters: estimates.iter().enumerate().map(parameter).collect(),
        level: settings.level,
        log_likelihood: best.log_likelihood,
        log_likelihood_error: best.standard_error,
        starts: [search.searches(), search.agreeing()],
        proposal: likelihood.proposal(best.estimator).to_string(),
        particles: best.estimator.particles,
        warnings,
    })
}
