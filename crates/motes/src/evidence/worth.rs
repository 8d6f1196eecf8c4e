//! How well proposals estimate the log-evidence of recorded sequences.

use serde::{Deserialize, Serialize};

use crate::filter_source::FilterSource;

/// The designed proposal that looks ahead.
pub(crate) const LOOK_AHEAD: &str = "look-ahead";

/// How well a proposal estimates the log-evidence of recorded sequences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EvidenceWorth {
    /// The proposal.
    pub proposal: String,
    /// The root-mean-square error of `log ẑ` with 100 particles, in nats: against the surest mean of the runs of a proposal that misses nothing another has found.
    pub error: f64,
    /// The work of a time step, in particles of a bootstrap filter.
    pub work: f64,
}

impl EvidenceWorth {
    /// Squared error times work: what is the same for any number of particles, where errors are small.
    pub fn inefficiency(&self) -> f64 {
        self.error * self.error * self.work
    }
}

/// What was learned for a model beside what is designed, on the same sequences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LearnedWorth {
    /// Each designed proposal, at least `bootstrap`.
    pub designed: Vec<EvidenceWorth>,
    /// A filter with a network for each particle, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_particle: Option<EvidenceWorth>,
    /// A filter with a potential of each step.
    pub now: EvidenceWorth,
    /// Potentials of whole sequences.
    pub ahead: EvidenceWorth,
}

impl LearnedWorth {
    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = &EvidenceWorth> {
        self.designed.iter().chain(&self.per_particle).chain([&self.now, &self.ahead])
    }

    /// The best designed proposal, and how many times its squared error times work is that of the potentials of whole sequences: above 1, learning pays.
    pub fn advantage(&self) -> Option<(&str, f64)> {
        let best = self.designed.iter().min_by(|a, b| a.inefficiency().total_cmp(&b.inefficiency()))?;
        Some((&best.proposal, best.inefficiency() / self.ahead.inefficiency()))
    }

    /// What filters have least squared error times work by; of equals what is simpler.
    pub(crate) fn best_filter(&self) -> FilterSource {
        let designed = self.designed.iter().filter(|worth| worth.proposal != LOOK_AHEAD);
        let designed = designed.map(|worth| (FilterSource::Designed(worth.proposal.clone()), worth));
        let learned = [(FilterSource::Potential, &self.now)];
        let network = self.per_particle.iter().map(|worth| (FilterSource::Network, worth));
        let all = designed.chain(learned).chain(network);
        let best = all.min_by(|(_, a), (_, b)| a.inefficiency().total_cmp(&b.inefficiency()));
        best.map_or(FilterSource::Potential, |(source, _)| source)
    }

    /// Whether the potentials of a smoother do better than those that were learned.
    pub(crate) fn is_behind_look_ahead(&self) -> bool {
        let look_ahead = self.designed.iter().find(|worth| worth.proposal == LOOK_AHEAD);
        look_ahead.is_some_and(|worth| worth.inefficiency() < self.ahead.inefficiency())
    }
}
