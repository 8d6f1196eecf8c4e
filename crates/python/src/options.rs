//! What a filter is made with.

use motes::smc::Resampling;
use motes::{DEFENSIVE_SHARE, ProposalName};
use pyo3::prelude::*;

use crate::arguments::{integer, seed_of, share_of, threads_of};
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
