//! What can be said of a filter.

use std::fmt;
use std::str::FromStr;

use motes_smc::{FilterSettings, ResampleWhen, Resampling};

/// A proposal by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ProposalName {
    /// The transition, blind to the measurement.
    #[default]
    Bootstrap,
    /// A Gaussian by one Fisher-scoring step from the predicted state.
    Linearised,
    /// `p(x_t | x_{t−1}, y_t)` itself, where it has a closed form.
    Optimal,
}

impl ProposalName {
    /// All of them.
    pub const ALL: [ProposalName; 3] =
        [ProposalName::Bootstrap, ProposalName::Linearised, ProposalName::Optimal];
}

impl fmt::Display for ProposalName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            ProposalName::Bootstrap => "bootstrap",
            ProposalName::Linearised => "linearised",
            ProposalName::Optimal => "optimal",
        })
    }
}

impl FromStr for ProposalName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = ProposalName::ALL.into_iter().find(|name| name.to_string() == text);
        named.ok_or_else(|| motes_cli::one_of(text, ["bootstrap", "linearised", "optimal"]))
    }
}

/// What a filter is made with. [`FilterOptions::default`] is what the command takes where nothing else is said.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterOptions {
    /// What particles are drawn from.
    pub proposal: ProposalName,
    /// `K`, the number of particles.
    pub particles: usize,
    /// The share of particles that are drawn from the transition whatever the proposal is; none where it is 0.
    pub defensive: f64,
    /// Resample where the effective sample size is below this share of `K`; at each step where it is 1.
    pub resample_below: f64,
    /// How ancestors are drawn.
    pub resampling: Resampling,
    /// All random numbers come from it.
    pub seed: u64,
    /// For how many times after the last measurement states are predicted.
    pub forecast: usize,
}

impl Default for FilterOptions {
    fn default() -> Self {
        FilterOptions {
            proposal: ProposalName::Bootstrap,
            particles: 1000,
            defensive: 0.0,
            resample_below: 0.5,
            resampling: Resampling::Systematic,
            seed: 1,
            forecast: 0,
        }
    }
}

impl FilterOptions {
    /// The settings of a filter that these options ask for.
    pub(crate) fn settings(&self) -> FilterSettings {
        let resample_when = match self.resample_below {
            1.0 => ResampleWhen::Always,
            fraction => ResampleWhen::EssBelow(fraction),
        };
        FilterSettings {
            resampling: self.resampling,
            resample_when,
            defensive_weight: (self.defensive > 0.0).then_some(self.defensive),
            ..FilterSettings::new(self.particles)
        }
    }
}
