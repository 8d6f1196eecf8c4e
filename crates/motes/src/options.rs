//! What can be said of a filter.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use crate::data::Data;
use crate::error::MotesError;
use crate::evidence::LOOK_AHEAD;
use crate::filter_source::FilterSource;
use crate::learned::LearnedProposal;
use crate::quantiles::Quantiles;
use motes_smc::{FilterSettings, ResampleWhen, Resampling};

/// A proposal by its name on the command line.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum ProposalName {
    /// The transition, blind to the measurement.
    #[default]
    Bootstrap,
    /// A Gaussian by one Fisher-scoring step from the predicted state.
    Linearised,
    /// `p(x_t | x_{t−1}, y_t)` itself, where it has a closed form.
    Optimal,
    /// One that was learned for the model.
    Learned(LearnedProposal),
    /// By potentials of a whole recorded sequence: for its evidence and for smoothing, not for filtering.
    LookAhead,
    /// No particles: the Kalman filter and smoother for linear Gaussian models, the forward algorithm for those of few discrete states.
    Exact,
}

impl ProposalName {
    /// Those that are designed, and need no learning.
    pub const DESIGNED: [ProposalName; 3] =
        [ProposalName::Bootstrap, ProposalName::Linearised, ProposalName::Optimal];

    /// As it is written in the command; a learned one by its own name.
    pub fn as_str(&self) -> &str {
        match self {
            ProposalName::Bootstrap => "bootstrap",
            ProposalName::Linearised => "linearised",
            ProposalName::Optimal => "optimal",
            ProposalName::Learned(learned) => learned.name(),
            ProposalName::LookAhead => LOOK_AHEAD,
            ProposalName::Exact => "exact",
        }
    }
}

impl ProposalName {
    /// What it is; a learned one by that alone, whatever it is called.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            ProposalName::Bootstrap => "bootstrap",
            ProposalName::Linearised => "linearised",
            ProposalName::Optimal => "optimal",
            ProposalName::Learned(_) => "learned",
            ProposalName::LookAhead => LOOK_AHEAD,
            ProposalName::Exact => "exact",
        }
    }
}

impl ProposalName {
    /// What a filter draws by: itself, or the designed proposal that a learned one hands out where nothing that was learned pays for filters.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if its folder names one that filters do not have.
    pub(crate) fn of_filter(&self) -> Result<Self, MotesError> {
        let ProposalName::Learned(learned) = self else { return Ok(self.clone()) };
        let Some(name) = learned.designed_filter() else { return Ok(self.clone()) };
        let designed = ProposalName::DESIGNED.into_iter().find(|designed| designed.as_str() == name);
        let reason =
            || format!("its folder says that filters draw by {name}, which they do not have; learn it again");
        designed
            .ok_or_else(|| MotesError::Proposal { proposal: learned.name().to_string(), reason: reason() })
    }
}

impl fmt::Display for ProposalName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.as_str())
    }
}

impl FromStr for ProposalName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut named =
            ProposalName::DESIGNED.into_iter().chain([ProposalName::LookAhead, ProposalName::Exact]);
        let found = named.find(|name| name.as_str() == text);
        found.ok_or_else(|| {
            motes_cli::one_of(text, ["bootstrap", "linearised", "optimal", "look-ahead", "exact"])
        })
    }
}

/// The defensive share of a learned proposal where nothing else is said.
pub const DEFENSIVE_SHARE: f64 = 0.1;

/// What a filter is made with. [`FilterOptions::default`] is what the command takes where nothing else is said.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterOptions {
    /// What particles are drawn from.
    pub proposal: ProposalName,
    /// `K`, the number of particles.
    pub particles: usize,
    /// The share of particles that are drawn from the transition whatever the proposal is; if none is given 0.1 of a learned one,
    /// 0.1 of `linearised` where it draws noise that is not normal, and 0 else.
    pub defensive: Option<f64>,
    /// Resample where the effective sample size is below this share of `K`; at each step where it is 1.
    pub resample_below: f64,
    /// How ancestors are drawn.
    pub resampling: Resampling,
    /// All random numbers come from it.
    pub seed: u64,
    /// Whether each measurement is predicted by those before it, and its place in this prediction is given ([`Estimate::predictive`](crate::Estimate::predictive)).
    pub predictive: bool,
    /// Which quantiles are given of states and of measurements that are predicted.
    pub quantiles: Quantiles,
    /// Whether the particles of each row are kept, with their weights ([`Filtered::particles`](crate::Filtered::particles)).
    pub keep_particles: bool,
    /// For how many times after the last measurement states and measurements are predicted.
    pub forecast: usize,
    /// The times and inputs of the rows that are predicted; they are those of the last gap where there are none.
    pub ahead: Option<Arc<Data>>,
    /// Whether small filters run beside it, which give the standard error of the log-evidence, and a bootstrap filter beside any other proposal, which says
    /// whether it misses mass. They change no other result.
    pub check: bool,
}

impl Default for FilterOptions {
    fn default() -> Self {
        FilterOptions {
            proposal: ProposalName::Bootstrap,
            particles: 1000,
            defensive: None,
            resample_below: 0.5,
            resampling: Resampling::Systematic,
            seed: 1,
            predictive: false,
            quantiles: Quantiles::default(),
            keep_particles: false,
            forecast: 0,
            ahead: None,
            check: true,
        }
    }
}

impl FilterOptions {
    /// The share of particles that are drawn from the transition; beside it `linearised` has a share of its own where it draws noise that is not normal
    /// ([`motes_smc::noise_share`]) and nothing is said here.
    pub fn defensive_share(&self) -> f64 {
        self.defensive.or(self.default_share()).unwrap_or(0.0)
    }

    /// The share where none is given.
    fn default_share(&self) -> Option<f64> {
        // A potential has a flat part of its own, and a designed proposal the share that it has by itself.
        match &self.proposal {
            ProposalName::Learned(learned) if *learned.filters() == FilterSource::Network => {
                Some(DEFENSIVE_SHARE)
            }
            _ => None,
        }
    }

    /// Whether anything is predicted after the last measurement.
    pub fn has_forecasts(&self) -> bool {
        self.forecast > 0 || self.ahead.is_some()
    }

    /// The settings of a filter that these options ask for.
    pub(crate) fn settings(&self) -> FilterSettings {
        let resample_when = match self.resample_below {
            1.0 => ResampleWhen::Always,
            fraction => ResampleWhen::EssBelow(fraction),
        };
        FilterSettings {
            resampling: self.resampling,
            resample_when,
            defensive_weight: self.defensive.or(self.default_share()),
            ..FilterSettings::new(self.particles)
        }
    }
}
