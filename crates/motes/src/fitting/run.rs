//! Fits the parameters of a model to data.

use std::ops::ControlFlow;

use motes_inference::{
    Estimator, EstimatorChoice, FitError, LogMean, ParameterSummary, Posterior, PosteriorSettings, Stage,
    map_on_threads,
};
use motes_models::Seed;

use super::budget::Budget;
use super::free::FreeParameters;
use super::likelihood::ModelLikelihood;
use super::options::FitOptions;
use super::posterior_fit::{PosteriorChain, PosteriorFit};
use super::trust;
use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::evidence::{EvidenceEstimator, EvidenceOptions};
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::priors::nearest_value;
use crate::warning::Warning;

/// Estimates of the likelihood at the posterior's mean.
const ESTIMATES: usize = 32;

/// Quantiles by which a prior is drawn beside the posterior.
const QUANTILES: usize = 400;

/// A fit under way, between two pieces of its work.
#[derive(Debug)]
pub struct FitProgress<'a> {
    /// All of it, which can be written down.
    pub posterior: &'a Posterior,
    /// Whether it stops here, before it is done: what is not written down now is lost.
    pub is_stopped: bool,
}

/// How far the draws of a fit have come.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SamplingProgress {
    rhat: f64,
    /// The least effective sample size; infinite before there is one.
    effective: f64,
    /// The share of the draws that are there, as far as can be told.
    share: f64,
}

impl FitProgress<'_> {
    /// What is being done, in a few words, and the share of the draws that are there, as far as can be told; none before the first.
    pub fn describe(&self) -> (String, Option<f64>) {
        let posterior = self.posterior;
        match posterior.stage() {
            Stage::Starting => {
                let share = 100.0 * posterior.power().powf(0.25);
                (format!("from the prior to the posterior: {share:.0} %"), None)
            }
            Stage::WarmUp => ("warm-up".into(), None),
            Stage::Sampling | Stage::Done => {
                let SamplingProgress { rhat, effective, share } = self.sampling();
                let size = if effective.is_finite() {
                    format!(", ESS at least {effective:.0}")
                } else {
                    String::new()
                };
                let text = format!("{} draws of each chain, R̂ at most {rhat:.3}{size}", posterior.kept());
                (text, (share > 0.0).then_some(share))
            }
        }
    }

    fn sampling(&self) -> SamplingProgress {
        /// A fit that has its effective sample size and not its R̂ is not done.
        const MOST: f64 = 0.95;
        let (posterior, settings) = (self.posterior, self.posterior.settings());
        let worst = |worst: (f64, f64), i: usize| {
            let summary = ParameterSummary::of(&posterior.coordinate(i));
            summary.map_or(worst, |summary| {
                let size = summary.ess_bulk.min(summary.ess_tail);
                (worst.0.max(summary.rhat), worst.1.min(size))
            })
        };
        let dimension = posterior.draws(0).next().map_or(0, |(v, _)| v.len());
        let (rhat, effective) = (0..dimension).fold((1.0, f64::INFINITY), worst);
        let of_draws = posterior.kept() as f64 / settings.draws.unwrap_or(settings.most_draws) as f64;
        let of_size = if effective.is_finite() { effective / settings.effective } else { 0.0 };
        let share = match settings.draws {
            Some(_) => of_draws,
            None => of_draws.max(of_size.min(MOST)),
        };
        SamplingProgress { rhat, effective, share }
    }
}

/// Draws from the posterior of the free parameters of `model`, those with a prior that were given no value, by particle Markov chain Monte Carlo. `proceed` is
/// asked all the time, from any thread; `observe` sees the fit between two pieces of work.
///
/// # Errors
/// [`MotesError::Setting`] if there is nothing to fit, or the likelihood is 0 at every draw from the prior, with the reason at the first;
/// [`MotesError::Proposal`] if the model has no such proposal; [`MotesError::Interrupted`] if `proceed` or `observe` said to stop.
pub fn fit(
    model: &Model,
    data: &Data,
    options: &FitOptions,
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
    observe: &mut dyn FnMut(FitProgress<'_>) -> Result<(), MotesError>,
) -> Result<PosteriorFit, MotesError> {
    fit_from(model, data, options, None, proceed, observe)
}

/// [`fit`] that goes on from where one with the same model, data and options was: it ends with the same draws.
///
/// # Errors
/// As [`fit`].
pub fn fit_from(
    model: &Model,
    data: &Data,
    options: &FitOptions,
    before: Option<Posterior>,
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
    observe: &mut dyn FnMut(FitProgress<'_>) -> Result<(), MotesError>,
) -> Result<PosteriorFit, MotesError> {
    let free = FreeParameters::of(model)?;
    check(model, data, options)?;
    let budget = Budget::new(options.seconds, proceed);
    let proceed = || budget.check();
    let likelihood = ModelLikelihood::new(model, data, &free, options, &proceed)?;
    let settings = PosteriorSettings {
        chains: options.chains,
        draws: options.draws,
        estimator: options.particles.map(EstimatorChoice::Particles),
        ..PosteriorSettings::default()
    };
    let mut posterior = match before {
        Some(posterior) => posterior,
        None => match Posterior::new(&likelihood, settings, options.seed) {
            Err(FitError::Likelihood(MotesError::Interrupted)) if budget.is_over() => {
                return Err(budget.too_short(Stage::Starting));
            }
            made => made.map_err(|error| refused(error, &likelihood))?,
        },
    };
    let mut is_ended = false;
    while posterior.stage() != Stage::Done {
        observe(FitProgress { posterior: &posterior, is_stopped: false })?;
        match posterior.advance(&likelihood) {
            Ok(()) => {}
            // It is as it was before the piece of work that was not done.
            Err(FitError::Likelihood(MotesError::Interrupted)) if budget.is_over() => {}
            Err(FitError::Likelihood(MotesError::Interrupted)) => {
                observe(FitProgress { posterior: &posterior, is_stopped: true })?;
                return Err(MotesError::Interrupted);
            }
            Err(error) => return Err(refused(error, &likelihood)),
        }
        if posterior.stage() != Stage::Done && budget.is_spent() {
            observe(FitProgress { posterior: &posterior, is_stopped: true })?;
            if !posterior.finish() {
                return Err(budget.too_short(posterior.stage()));
            }
            is_ended = true;
        }
    }
    budget.lift();
    let mut found = fitted(&posterior, &free, &likelihood, options.seed)?;
    found.warnings.splice(0..0, trust::of_budget(is_ended));
    Ok(found)
}

/// Why there is no fit, in words.
pub(super) fn refused(error: FitError<MotesError>, likelihood: &ModelLikelihood<'_>) -> MotesError {
    match error {
        FitError::Likelihood(error) => error,
        FitError::Impossible(draw) => {
            let reason = likelihood.reason(&draw).unwrap_or_else(|| "the log-evidence is −∞".into());
            MotesError::Setting(format!(
                "the likelihood is 0 at every draw from the prior: the model cannot give these data; the first time: {reason}"
            ))
        }
        FitError::Nothing => MotesError::Setting("the number of chains is 0; it must be 1 at least".into()),
    }
}

/// Refuses a proposal that the model does not have, before there is any work.
pub(super) fn check(model: &Model, data: &Data, options: &FitOptions) -> Result<(), MotesError> {
    let (proposal, particles) =
        (options.proposal.clone().unwrap_or_default(), options.particles.unwrap_or(1));
    if let ProposalName::Learned(learned) = &proposal {
        learned.check_free(model)?;
    }
    if proposal == ProposalName::LookAhead {
        let options = EvidenceOptions { proposal: Some(proposal), particles, ..EvidenceOptions::default() };
        return EvidenceEstimator::new(model, data, &options).map(drop);
    }
    let options = FilterOptions { proposal, particles, ..FilterOptions::default() };
    Running::new(model, &options, 0).map(drop)
}

/// What there is to say of a posterior that is done.
fn fitted(
    posterior: &Posterior,
    free: &FreeParameters,
    likelihood: &ModelLikelihood<'_>,
    seed: u64,
) -> Result<PosteriorFit, MotesError> {
    let (names, d) = (free.names(), free.len());
    let mut chains = Vec::with_capacity(posterior.chains());
    for chain in 0..posterior.chains() {
        let mut of_chain = PosteriorChain::default();
        for (v, log_evidence) in posterior.draws(chain) {
            of_chain.values.extend(free.at(v));
            of_chain.log_evidence.push(log_evidence);
        }
        chains.push(of_chain);
    }
    let estimator = posterior.estimator();
    let mut found = PosteriorFit {
        names,
        chains,
        parameters: Vec::new(),
        log_likelihood: f64::NAN,
        log_likelihood_error: 0.0,
        marginal_likelihood: posterior.marginal_likelihood(),
        acceptance: posterior.moves().map(|moves| moves.acceptance()),
        proposal: likelihood.proposal(estimator).to_string(),
        particles: estimator.particles,
        variance: posterior.variance(),
        prior_quantiles: free.quantiles(QUANTILES),
        warnings: Vec::new(),
    };
    found.parameters = (0..d)
        .map(|at| ParameterSummary::of(&found.of_parameter(at)).ok_or_else(too_few))
        .collect::<Result<Vec<ParameterSummary>, MotesError>>()?;
    let of_names = found.names.iter().zip(&found.parameters);
    let means: Vec<f64> =
        of_names.map(|(name, summary)| nearest_value(likelihood.model, name, summary.mean)).collect();
    (found.log_likelihood, found.log_likelihood_error) = at_mean(likelihood, &means, estimator, seed)?;
    let of_mean = Seed::from_u64(seed).child("fit").child("mean");
    let missed = likelihood.missed(&means, estimator, &of_mean)?;
    found.warnings.extend(
        missed.map(|missed| Warning { series: None, text: format!("at the posterior mean {missed}") }),
    );
    let positions = |at: usize| posterior.coordinate(at).concat();
    found.warnings.extend(trust::of_chains(&found.names, &found.parameters));
    found.warnings.extend(trust::of_priors(free, &positions));
    found
        .warnings
        .extend(trust::of_possible(posterior.possible(), || likelihood.reason(&posterior.impossible()?)));
    Ok(found)
}

fn too_few() -> MotesError {
    MotesError::Setting("--draws: chains of fewer than 4 draws say nothing of their convergence".into())
}

/// The log-likelihood at the posterior's mean, and its standard error.
fn at_mean(
    likelihood: &ModelLikelihood<'_>,
    means: &[f64],
    estimator: Estimator,
    seed: u64,
) -> Result<(f64, f64), MotesError> {
    let seed = Seed::from_u64(seed).child("fit").child("mean");
    let is_exact = *likelihood.proposal(estimator) == ProposalName::Exact;
    if is_exact {
        return Ok((likelihood.at(means, estimator, &seed)?, 0.0));
    }
    let estimates = map_on_threads(&[(); ESTIMATES], |number, ()| {
        likelihood.at(means, estimator, &seed.nth(number as u64))
    });
    let mean = LogMean::of(&estimates.into_iter().collect::<Result<Vec<f64>, MotesError>>()?);
    Ok((mean.log(), mean.standard_error().unwrap_or(f64::NAN)))
}
