//! How well a proposal estimates the log-evidence of recorded sequences.

use serde::{Deserialize, Serialize};

/// What is learned, as it is judged: a network for each particle, potentials of a step alone, and potentials of whole sequences.
pub(crate) const NETWORK: &str = "learned, per particle";
pub(crate) const NOW: &str = "learned, now";
pub(crate) const AHEAD: &str = "learned, ahead";

/// The designed proposal that looks ahead.
pub(crate) const LOOK_AHEAD: &str = "look-ahead";

/// How well a proposal estimates the log-evidence of recorded sequences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EvidenceWorth {
    /// The proposal.
    pub proposal: String,
    /// The root-mean-square error of `log ẑ` with 100 particles, in nats: against the mean of all runs of all proposals, which is dominated by the best.
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
