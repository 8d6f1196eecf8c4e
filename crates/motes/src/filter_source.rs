//! What the filters of a learned proposal draw by.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What filters with a learned proposal draw by, as measurements come: whatever had least squared error of the log-evidence times work on simulated sequences.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FilterSource {
    /// A network for each particle.
    Network,
    /// Potentials of a step, by networks that run once for all particles.
    Potential,
    /// A designed proposal of this name, where nothing that was learned pays.
    Designed(String),
}

impl fmt::Display for FilterSource {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FilterSource::Network => formatter.write_str("a network for each particle"),
            FilterSource::Potential => formatter.write_str("potentials of their step"),
            FilterSource::Designed(name) => write!(formatter, "{name}, which is designed"),
        }
    }
}
