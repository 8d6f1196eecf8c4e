//! The arguments of a fit as Python hands them over.

use motes::{FitOptions, ProposalName};
use pyo3::prelude::*;

use crate::arguments::{integer, seed_of};
use crate::errors::refused;
use crate::options::ProposalArgument;

/// The arguments of a fit.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FitArguments<'py> {
    proposal: Option<ProposalArgument<'py>>,
    particles: Option<i64>,
    chains: i64,
    draws: Option<i64>,
    profile: Vec<String>,
    passes: Option<i64>,
    budget: Option<f64>,
    seed: i128,
}

impl FitArguments<'_> {
    /// The same, checked.
    pub(crate) fn options(&self) -> PyResult<FitOptions> {
        let count = |name: &str, value: Option<i64>, least: usize| {
            value.map(|value| integer(name, value, least, 1_000_000_000)).transpose()
        };
        let proposal: Option<ProposalName> =
            self.proposal.as_ref().map(ProposalArgument::name).transpose()?;
        if let Some(budget) = self.budget
            && !(budget > 0.0 && budget.is_finite())
        {
            return Err(refused("budget", budget, "a number of seconds above 0"));
        }
        Ok(FitOptions {
            proposal,
            particles: count("particles", self.particles, 1)?,
            chains: integer("chains", self.chains, 1, 1000)?,
            draws: count("draws", self.draws, 4)?,
            profiles: self.profile.clone(),
            passes: count("passes", self.passes, 1)?,
            seconds: self.budget,
            seed: seed_of(self.seed)?,
        })
    }
}
