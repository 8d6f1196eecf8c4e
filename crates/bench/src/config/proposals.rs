//! Settings of the learned families: what all profiles share, and the sizes of a profile.

use motes_proposals::{Adapter, Cell, Origin};
use serde::{Deserialize, Serialize};

/// `[proposals]`: settings of the learned families that all profiles share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Proposals {
    /// The fully connected proposal.
    pub fcnn: Fcnn,
    /// The recurrent proposal.
    pub rnn: Rnn,
    /// The graph proposal, where there is a graph.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gnn: Option<Gnn>,
    /// What the method `gnn-short-steps` has of its own; the rest is that of `gnn`.
    #[serde(default, rename = "gnn-short-steps", skip_serializing_if = "Option::is_none")]
    pub gnn_short_steps: Option<ShortSteps>,
    /// The transform of uniform noise.
    pub psi: Psi,
    /// In which units networks work; in those of the system if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standardised: Option<Standardised>,
}

/// Networks in the units of simulated trajectories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Standardised {
    /// What the outputs of `fcnn`, `rnn` and `psi` are counted from.
    pub origin: Origin,
    /// How many trajectories of the system are simulated.
    pub trajectories: usize,
}

/// Settings of the fully connected proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fcnn {
    /// Added to the diagonal of the covariance.
    pub ridge: f64,
}

/// Settings of the recurrent proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rnn {
    /// What a layer computes.
    pub cell: Cell,
    /// Layers on top of each other.
    pub depth: usize,
    /// Added to the diagonal of the covariance.
    pub ridge: f64,
}

/// Settings of the graph proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gnn {
    /// D: filters have D + 1 taps.
    pub order: usize,
    /// How measurements are brought to the nodes.
    pub adapter: Adapter,
    /// Added to the diagonal of the covariance.
    pub ridge: f64,
}

/// A length of steps that replaces that of `[training]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShortSteps {
    /// Adam's step size.
    pub learning_rate: f64,
}

/// Settings of the transform of uniform noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Psi {
    /// Added to the diagonal of each matrix that is inverted.
    pub ridge: f64,
}

/// `[profiles.*.sizes]`: how large the networks of a profile are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sizes {
    /// Hidden widths of the fully connected proposal.
    pub fcnn: Vec<usize>,
    /// Hidden units of the recurrent proposal.
    pub rnn: usize,
    /// Features of the graph proposal, where there is a graph.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gnn: Option<Vec<usize>>,
    /// Square layers of the transform.
    pub psi: usize,
}
