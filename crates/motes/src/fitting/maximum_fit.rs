//! The maximum of the likelihood.

use std::ops::ControlFlow;

use motes_inference::{
    EstimatorChoice, FitError, IteratedSettings, Maximum, MaximumSearch, MaximumSettings, Profile,
    ProfilePoint,
};
use motes_models::Seed;
use serde::{Deserialize, Serialize};

use super::budget::Budget;
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
    /// The lower end of its interval; none where its profile was not sought.
    pub low: Option<f64>,
    /// The upper end.
    pub high: Option<f64>,
}

/// A point of the profile of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MaximumProfilePoint {
    /// The parameter's value.
    pub value: f64,
    /// The largest log-likelihood over all other parameters.
    pub log_likelihood: f64,
    /// Its standard error; 0 where it is exact.
    pub standard_error: f64,
}

/// The maximum of the likelihood over the free parameters of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaximumFit {
    /// The names of the parameters.
    pub names: Vec<String>,
    /// Each of them.
    pub parameters: Vec<MaximumParameter>,
    /// How many numbers were sought: the shares of a dirichlet are one fewer than there are.
    pub dimension: usize,
    /// The profile of each parameter; nothing where it was not sought.
    pub profiles: Vec<Vec<MaximumProfilePoint>>,
    /// The probability of the intervals.
    pub level: f64,
    /// The log-likelihood at the maximum: `log` of the average of some estimates.
    pub log_likelihood: f64,
    /// Its standard error; 0 where it is exact.
    pub log_likelihood_error: f64,
    /// How many searches came as high as the best one.
    pub agreeing: usize,
    /// The log-likelihood where each search ended, in their order.
    pub search_log_likelihoods: Vec<f64>,
    /// The passes of iterated filtering by which they went; none where they went by quadratics.
    pub passes: Option<usize>,
    /// The estimator of the likelihood, as `--proposal` names it.
    pub proposal: String,
    /// Its number of particles.
    pub particles: usize,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

impl MaximumFit {
    /// Akaike's information criterion, `2 D − 2 log L` for `D` free numbers.
    pub fn aic(&self) -> f64 {
        2.0 * self.dimension as f64 - 2.0 * self.log_likelihood
    }
}

/// Searches for a maximum under way, between two pieces of their work.
#[derive(Debug)]
pub struct SearchProgress<'a> {
    /// All of them, which can be written down.
    pub search: &'a MaximumSearch,
    dimension: usize,
    /// Whether they stop here, before they are done: what is not written down now is lost.
    pub is_stopped: bool,
}

impl SearchProgress<'_> {
    /// The share of the work that is done.
    pub fn share(&self) -> f64 {
        let (done, all) = self.search.progress(self.dimension);
        done as f64 / all as f64
    }
}

/// So many parameters are sought by iterated filtering, whose work does not grow with their number: a quadratic has a coefficient for each pair of them.
const MANY: usize = 8;

/// What it is done with.
fn iterated(options: &FitOptions) -> IteratedSettings {
    let IteratedSettings { particles, passes } = IteratedSettings::default();
    IteratedSettings {
        particles: options.particles.unwrap_or(particles),
        passes: options.passes.unwrap_or(passes),
    }
}

/// The places of the parameters whose profiles were asked for by name, or of all that have one: a share of a dirichlet has no number of its own that could be held.
fn profiled(free: &FreeParameters, asked: &[String], is_iterated: bool) -> Result<Vec<usize>, MotesError> {
    let names = free.names();
    let alone: Vec<bool> = free
        .priors()
        .iter()
        .flat_map(|prior| vec![prior.entries().len() == 1; prior.entries().len()])
        .collect();
    let place = |name: &String| match names.iter().position(|other| other == name) {
        Some(at) if alone[at] => Ok(at),
        Some(_) => Err(MotesError::Setting(format!(
            "--profile {name}: a share of a dirichlet has no profile, since no other stays where it is when it moves; draws of the posterior have its quantiles"
        ))),
        None => {
            let reason =
                format!("--profile {name}: that is no free parameter; there are {}", names.join(", "));
            Err(MotesError::Setting(reason))
        }
    };
    if asked.is_empty() {
        return Ok((0..names.len()).filter(|at| alone[*at] && !is_iterated).collect());
    }
    let mut places = asked.iter().map(place).collect::<Result<Vec<usize>, MotesError>>()?;
    places.sort_unstable();
    places.dedup();
    Ok(places)
}

/// Finds the maximum of the likelihood over the free parameters of `model`, and the interval of each. The priors say where searches start and in which coordinates
/// they go, and nothing else. Goes on from where the same search was `before`, if it was stopped; `observe` is shown it between two pieces of its work.
///
/// # Errors
/// As [`crate::fit`].
pub fn maximise(
    model: &Model,
    data: &Data,
    options: &FitOptions,
    before: Option<MaximumSearch>,
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
    observe: &mut dyn FnMut(SearchProgress<'_>) -> Result<(), MotesError>,
) -> Result<MaximumFit, MotesError> {
    let free = FreeParameters::of(model)?;
    check(model, data, options)?;
    let budget = Budget::new(options.seconds, proceed);
    let proceed = || budget.check();
    let mut likelihood = ModelLikelihood::new(model, data, &free, options, &proceed)?;
    let names = free.names();
    if names.len() >= MANY || options.passes.is_some() {
        likelihood.perturbed = match likelihood.perturbed_model() {
            Err(reason) if options.passes.is_some() => {
                return Err(MotesError::Setting(format!(
                    "--passes: iterated filtering takes the bootstrap filter of a model file whose free parameters stand in formulas alone; {reason}{}",
                    if reason.ends_with("exact") { "; take --proposal bootstrap" } else { "" }
                )));
            }
            model => model.ok(),
        };
    }
    if let Some(prior) = free.priors().iter().find(|prior| prior.is_discrete()) {
        return Err(MotesError::Setting(format!(
            "--method maximum: {} is a count, and searches go uphill between numbers; fix it by --set {}=…, or take draws of the posterior",
            prior.name(),
            prior.name()
        )));
    }
    let settings = MaximumSettings {
        starts: options.chains,
        profiled: Some(profiled(&free, &options.profiles, likelihood.perturbed.is_some())?),
        estimator: options.particles.map(EstimatorChoice::Particles),
        iterated: likelihood.perturbed.is_some().then(|| iterated(options)),
        ..MaximumSettings::default()
    };
    let mut search = before.unwrap_or_else(|| MaximumSearch::new(settings.clone(), options.seed));
    while !search.is_done(free.len()) {
        observe(SearchProgress { search: &search, dimension: free.len(), is_stopped: false })?;
        match search.advance(&likelihood) {
            Ok(()) if !search.is_done(free.len()) && budget.is_spent() => {
                observe(SearchProgress { search: &search, dimension: free.len(), is_stopped: true })?;
                break;
            }
            Ok(()) => {}
            // It is as it was before the piece of work that was not done.
            Err(FitError::Likelihood(MotesError::Interrupted)) => {
                observe(SearchProgress { search: &search, dimension: free.len(), is_stopped: true })?;
                if budget.is_over() { break } else { return Err(MotesError::Interrupted) }
            }
            Err(error) => return Err(refused(error, &likelihood)),
        }
    }
    budget.lift();
    let Some(best) = search.best() else { return Err(budget.too_short_to_search()) };
    let estimates = free.at(&best.v);
    let end = |at: usize, value: f64| {
        let mut v = best.v.clone();
        v[at] = value;
        free.at(&v)[at]
    };
    let of_parameter = |at: usize| search.profiles().iter().find(|profile| profile.at == at);
    let parameter = |(at, estimate): (usize, &f64)| {
        let ends = of_parameter(at).map(|profile| [profile.low, profile.high].map(|v| end(at, v)));
        MaximumParameter {
            estimate: *estimate,
            low: ends.map(|[low, _]| low),
            high: ends.map(|[_, high]| high),
        }
    };
    let profile = |at: usize| {
        let point = |point: &ProfilePoint| MaximumProfilePoint {
            value: end(at, point.v),
            log_likelihood: point.log_likelihood,
            standard_error: point.standard_error,
        };
        of_parameter(at).map_or(vec![], |profile| profile.points.iter().map(point).collect())
    };
    let unfinished = trust::of_work(&search, free.len());
    let of_starts = trust::of_starts(search.agreeing().count(), search.searches());
    let mut warnings: Vec<Warning> = unfinished.into_iter().chain(of_starts).collect();
    let value = |found: &Maximum, at: usize| free.at(&found.v)[at];
    warnings.extend(trust::of_places(&names, &value, best, search.agreeing(), search.profiles()));
    let of_profile = |profile: &Profile| trust::of_profile(&names[profile.at], profile, best);
    let of_profiles: Vec<Option<Warning>> = search.profiles().iter().map(of_profile).collect();
    // Along a flat likelihood the edge of a prior says nothing.
    let is_in_doubt = |at: usize| {
        let profiles = search.profiles().iter().zip(&of_profiles);
        profiles.into_iter().any(|(profile, warning)| profile.at == at && warning.is_some())
    };
    warnings.extend(trust::of_priors(&free, &|at| if is_in_doubt(at) { vec![] } else { vec![best.v[at]] }));
    warnings.extend(of_profiles.into_iter().flatten());
    warnings.extend(trust::of_possible(search.possible(), || likelihood.reason(&search.impossible()?)));
    let of_maximum = Seed::from_u64(options.seed).child("maximum");
    let missed = likelihood.missed(&estimates, best.estimator, &of_maximum)?;
    warnings.extend(missed.map(|missed| Warning { series: None, text: format!("at the maximum {missed}") }));
    Ok(MaximumFit {
        profiles: (0..names.len()).map(profile).collect(),
        names,
        parameters: estimates.iter().enumerate().map(parameter).collect(),
        level: settings.level,
        log_likelihood: best.log_likelihood,
        log_likelihood_error: best.standard_error,
        agreeing: search.agreeing().count(),
        dimension: free.dimension(),
        search_log_likelihoods: search.log_likelihoods().collect(),
        passes: settings.iterated.map(|iterated| iterated.passes),
        proposal: likelihood.proposal(best.estimator).to_string(),
        particles: best.estimator.particles,
        warnings,
    })
}
