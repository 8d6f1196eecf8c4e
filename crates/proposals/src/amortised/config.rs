//! The settings of an amortised proposal.

use serde::{Deserialize, Serialize};

use super::base::Base;
use super::heads::{Covariance, HeadConfig};

/// The settings of an [`Amortised`](super::Amortised) proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AmortisedConfig {
    /// The widths of the networks' hidden layers; along a graph, the features of each node.
    pub widths: Vec<usize>,
    /// What a unit of a hidden layer sees.
    #[serde(default, skip_serializing_if = "Sees::is_all")]
    pub sees: Sees,
    /// The designed proposal around which it is built.
    pub base: Base,
    /// What the networks emit.
    pub head: HeadConfig,
    /// The number of sub-steps that it proposes the noise of, where states have no density: at a step with another number particles come from the transition.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub sub_steps: usize,
}

fn one() -> usize {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
fn is_one(count: &usize) -> bool {
    *count == 1
}

/// What a unit of a hidden layer sees of the layer below.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sees {
    /// All of it: fully connected layers.
    #[default]
    All,
    /// What lies up to `order` edges away on the system's graph, by graph filters of `order + 1` taps (the paper's equation "meanGNN").
    ///
    /// All nodes have the same filters. The head sees the features of all nodes.
    Graph {
        /// `D`.
        order: usize,
    },
}

impl Sees {
    fn is_all(&self) -> bool {
        *self == Sees::All
    }
}

impl AmortisedConfig {
    /// Two hidden layers of 64, and a Gaussian around the linearised proposal.
    pub fn gaussian() -> Self {
        let head = HeadConfig::Gaussian { covariance: Covariance::Full };
        AmortisedConfig { widths: vec![64, 64], sees: Sees::All, base: Base::Linearised, head, sub_steps: 1 }
    }

    /// Two hidden layers of 64, and a mixture around the linearised proposal.
    pub fn mixture(components: usize) -> Self {
        let head = HeadConfig::Mixture { components, covariance: Covariance::Full };
        AmortisedConfig { head, ..AmortisedConfig::gaussian() }
    }
}
