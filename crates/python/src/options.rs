//! What a filter is made with.

use std::sync::Arc;

use motes::smc::Resampling;
use motes::{ProposalName, Quantiles};
use pyo3::prelude::*;

use crate::arguments::{integer, seed_of, share_of, threads_of};
use crate::data::Data;
use crate::errors::refused;
use crate::learned::Proposal;

/// The options of a filter, checked.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct FilterOptions {
    pub(crate) options: motes::FilterOptions,
    pub(crate) threads: Option<usize>,
}

/// A proposal by its name, or a learned one.
#[derive(FromPyObject)]
pub(crate) enum ProposalArgument<'py> {
    Name(String),
    Learned(Bound<'py, Proposal>),
}

impl ProposalArgument<'_> {
    pub(crate) fn name(&self) -> PyResult<ProposalName> {
        match self {
            ProposalArgument::Name(name) => name.parse().map_err(|_| {
                refused(
                    "proposal",
                    name,
                    "bootstrap, linearised, optimal, exact, or a Proposal that was learned",
                )
            }),
            ProposalArgument::Learned(proposal) => Ok(ProposalName::Learned(proposal.get().0.clone())),
        }
    }
}

#[pymethods]
impl FilterOptions {
    /// What is not given is as in the command.
    #[new]
    #[pyo3(signature = (*, proposal=None, particles=None, defensive=None, resample_below=None, resampling=None, seed=None, check=None, threads=None, forecast=None, predictive=None, ahead=None, quantiles=None, keep_particles=None))]
    #[expect(clippy::too_many_arguments, reason = "each is an argument of the Python function with its name")]
    fn new(
        proposal: Option<ProposalArgument<'_>>,
        particles: Option<i64>,
        defensive: Option<f64>,
        resample_below: Option<f64>,
        resampling: Option<String>,
        seed: Option<i128>,
        check: Option<bool>,
        threads: Option<i64>,
        forecast: Option<i64>,
        predictive: Option<bool>,
        ahead: Option<&Bound<'_, Data>>,
        quantiles: Option<Vec<f64>>,
        keep_particles: Option<bool>,
    ) -> PyResult<Self> {
        let mut options = motes::FilterOptions::default();
        if let Some(proposal) = proposal {
            options.proposal = proposal.name()?;
        }
        if let Some(count) = particles {
            options.particles = integer("particles", count, 1, 1_000_000_000)?;
        }
        options.defensive = defensive.map(|share| share_of("defensive", share)).transpose()?;
        if let Some(share) = resample_below {
            if !(share > 0.0 && share <= 1.0) {
                return Err(refused("resample_below", share, "above 0 and at most 1"));
            }
            options.resample_below = share;
        }
        if let Some(scheme) = resampling {
            options.resampling = match scheme.as_str() {
                "multinomial" => Resampling::Multinomial,
                "systematic" => Resampling::Systematic,
                "stratified" => Resampling::Stratified,
                "residual" => Resampling::Residual,
                other => {
                    return Err(refused(
                        "resampling",
                        other,
                        "multinomial, systematic, stratified or residual",
                    ));
                }
            };
        }
        if let Some(seed) = seed {
            options.seed = seed_of(seed)?;
        }
        options.check = check.unwrap_or(options.check);
        if let Some(times) = forecast {
            options.forecast = integer("forecast", times, 0, 1_000_000)?;
        }
        options.predictive = predictive.unwrap_or_default();
        options.ahead = ahead.map(|ahead| Arc::new(ahead.get().0.clone()));
        if let Some(probabilities) = quantiles {
            let said = format!("{probabilities:?}");
            let quantiles = Quantiles::new(probabilities);
            options.quantiles = quantiles.ok_or_else(|| refused("quantiles", said, Quantiles::EXPECTED))?;
        }
        options.keep_particles = keep_particles.unwrap_or_default();
        Ok(FilterOptions { options, threads: threads_of(threads)? })
    }
}
