//! Settings of learned potentials.

use serde::{Deserialize, Serialize};

/// What learned potentials are made from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedPotentialsConfig {
    /// `H`, the units of each of the two recurrent layers, and of the hidden layer of the network that reads both.
    pub hidden: usize,
    /// `J`, the quadratics of a potential beside the flat one.
    pub components: usize,
    /// How many steps each of the sequences has from which the units of a model are found; none if the units of one model are kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standardising_steps: Option<usize>,
}

impl Default for LearnedPotentialsConfig {
    /// 24 units and three quadratics, for one model.
    fn default() -> Self {
        LearnedPotentialsConfig { hidden: 24, components: 3, standardising_steps: None }
    }
}
