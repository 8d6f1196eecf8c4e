//! The settings of an amortised proposal.

use serde::{Deserialize, Serialize};

use super::base::Base;
use super::heads::{Covariance, HeadConfig};

/// The settings of an [`Amortised`](super::Amortised) proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AmortisedConfig {
    /// The widths of the networks' hidden layers.
    pub widths: Vec<usize>,
    /// The designed proposal around which it is built.
    pub base: Base,
    /// What the networks emit.
    pub head: HeadConfig,
}

impl AmortisedConfig {
    /// Two hidden layers of 64, and a Gaussian around the linearised proposal.
    pub fn gaussian() -> Self {
        let head = HeadConfig::Gaussian { covariance: Covariance::Full };
        AmortisedConfig { widths: vec![64, 64], base: Base::Linearised, head }
    }

    /// Two hidden layers of 64, and a mixture around the linearised proposal.
    pub fn mixture(components: usize) -> Self {
        let head = HeadConfig::Mixture { components, covariance: Covariance::Full };
        AmortisedConfig { head, ..AmortisedConfig::gaussian() }
    }
}
