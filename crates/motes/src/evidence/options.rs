//! What can be said of an estimate of the log-evidence.

use motes_smc::Resampling;

use crate::options::{FilterOptions, ProposalName};

/// How the log-evidence of recorded data is estimated. [`EvidenceOptions::default`] is what the command takes where nothing else is said.
#[derive(Debug, Clone, PartialEq)]
pub struct EvidenceOptions {
    /// What particles are drawn from. If none is given, `exact` where a model has exact answers, else what pilots choose.
    pub proposal: Option<ProposalName>,
    /// `K`, the number of particles of a run.
    pub particles: usize,
    /// `R`, the number of independent runs.
    pub runs: usize,
    /// The share of particles that are drawn from the transition whatever the proposal is, as [`FilterOptions::defensive`]; if none is given, 0.1 of `linearised`, too: a Gaussian around one
    /// mode of two agrees with itself.
    pub defensive: Option<f64>,
    /// Resample where the effective sample size is below this share of `K`; at each step where it is 1.
    pub resample_below: f64,
    /// How ancestors are drawn.
    pub resampling: Resampling,
    /// Whether one filter of each other proposal is run beside, to see whether it finds more.
    pub check: bool,
    /// All random numbers come from it.
    pub seed: u64,
}

/// The share of the transition that a proposal has where nothing but the evidence is asked for and nobody names one: 0.1 of `linearised`.
pub(crate) fn share_for_evidence(proposal: &ProposalName) -> Option<f64> {
    (*proposal == ProposalName::Linearised).then_some(0.1)
}

impl Default for EvidenceOptions {
    fn default() -> Self {
        let FilterOptions { particles, defensive, resample_below, resampling, seed, .. } =
            FilterOptions::default();
        EvidenceOptions {
            proposal: None,
            particles,
            runs: 4,
            defensive,
            resample_below,
            resampling,
            check: true,
            seed,
        }
    }
}

impl EvidenceOptions {
    /// Those of a filter of so many particles with this proposal, with nothing beside it.
    pub(super) fn of_filter(&self, proposal: ProposalName, particles: usize) -> FilterOptions {
        FilterOptions {
            particles,
            defensive: self.defensive.or(share_for_evidence(&proposal)),
            resample_below: self.resample_below,
            resampling: self.resampling,
            seed: self.seed,
            check: false,
            proposal,
            ..FilterOptions::default()
        }
    }
}
