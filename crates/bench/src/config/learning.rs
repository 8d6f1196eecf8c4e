//! How proposals are learned once, where an experiment judges them on sequences that they never saw.

use motes_proposals::{Base, HeadConfig};
use serde::{Deserialize, Serialize};

use super::densities::Densities;

/// `[learning]`: each family is learned once for a system, from what the model of the filters draws for itself.
///
/// Repetitions are then sequences of one system, none of which was learned from. `fcnn` and `gnn` learn by the inclusive objective,
/// `rnn` and `psi` by the evidence lower bound of fresh sequences of measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Learning {
    /// Times of a sequence that is learned from.
    pub horizon: usize,
    /// A sequence ends where a coordinate of its state becomes larger than this, or smaller than its negative; none does if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_state: Option<f64>,
    /// Adam's step size at the start; it falls to 0 along half a cosine.
    pub learning_rate: f64,
    /// Rows `(x_{t−1}, x_t, y_t)` in a step.
    pub rows: usize,
    /// The designed proposal that `fcnn` and `gnn` are built around.
    pub base: Base,
    /// What their networks emit under Gaussian densities.
    pub head: HeadConfig,
    /// What their networks emit under exact densities of other families; the same if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exact_head: Option<HeadConfig>,
    /// How `rnn` and `psi` learn.
    pub elbo: Elbo,
}

/// Learning by the evidence lower bound.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Elbo {
    /// Particles that are drawn along a sequence.
    pub particles: usize,
    /// New sequences in a step.
    pub sequences: usize,
    /// How many steps of the other families come to one of these.
    pub steps_for_one: usize,
    /// Trajectories of the model by which inputs and outputs are brought to its units, around a linear prediction.
    pub trajectories: usize,
}

impl Learning {
    /// What networks emit under these densities.
    pub(crate) fn head(&self, densities: Densities) -> HeadConfig {
        match densities {
            Densities::Gaussian => self.head,
            Densities::Exact => self.exact_head.unwrap_or(self.head),
        }
    }
}
