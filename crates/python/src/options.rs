//! What a filter is made with.

use motes::smc::Resampling;
use motes::{DEFENSIVE_SHARE, ProposalName};
use pyo3::prelude::*;

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
                refused("proposal", name, "bootstrap, linearised, optimal, or a Proposal that was learned")
            }),
            ProposalArgument::Learned(proposal) => Ok(ProposalName::Learned(proposal.get().0.clone())),
        }
    }
}

#[pymethods]
impl FilterOptions {
    #[new]
    #[pyo3(signature = (*, proposal, particles, defensive, resample_below, resampling, seed, check, threads, forecast=0))]
    #[expect(clippy::too_many_arguments, reason = "each is an argument of the Python function with its name")]
    fn new(
        proposal: ProposalArgument<'_>,
        particles: i64,
        defensive: Option<f64>,
        resample_below: f64,
        resampling: &str,
        seed: i128,
        check: bool,
        threads: Option<i64>,
        forecast: i64,
    ) -> PyResult<Self> {
        let options = motes::FilterOptions {
            proposal: proposal.name()?,
            particles: integer("particles", particles, 1, 1_000_000_000)?,
            defensive: defensive.map(|share| share_of("defensive", share)).transpose()?,
            resample_below: match resample_below > 0.0 && resample_below <= 1.0 {
                true => resample_below,
                false => return Err(refused("resample_below", resample_below, "above 0 and at most 1")),
            },
            resampling: match resampling {
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
            },
            seed: seed_of(seed)?,
            forecast: integer("forecast", forecast, 0, 1_000_000)?,
            check,
        };
        Ok(FilterOptions { options, threads: threads_of(threads)? })
    }

    /// The share of the particles that is drawn from the transition.
    #[getter]
    fn defensive(&self) -> f64 {
        self.options.defensive_share()
    }

    /// That share of a learned proposal where nothing else is said.
    #[classattr]
    const DEFENSIVE_OF_LEARNED: f64 = DEFENSIVE_SHARE;
}

/// An integer from `least` to `most`.
pub(crate) fn integer(argument: &str, value: i64, least: usize, most: usize) -> PyResult<usize> {
    let found = usize::try_from(value).ok().filter(|value| (least..=most).contains(value));
    found.ok_or_else(|| refused(argument, value, &format!("an integer from {least} to {most}")))
}

/// A number from 0 to below 1.
pub(crate) fn share_of(argument: &str, value: f64) -> PyResult<f64> {
    match (0.0..1.0).contains(&value) {
        true => Ok(value),
        false => Err(refused(argument, value, "from 0 to below 1")),
    }
}

/// A seed of 64 bits.
pub(crate) fn seed_of(seed: i128) -> PyResult<u64> {
    u64::try_from(seed).map_err(|_| refused("seed", seed, "an integer from 0 to 2^64 − 1"))
}

/// A number of threads; all that there are if `None`.
pub(crate) fn threads_of(threads: Option<i64>) -> PyResult<Option<usize>> {
    threads.map(|threads| integer("threads", threads, 1, 1024)).transpose()
}
