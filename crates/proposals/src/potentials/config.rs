//! Settings of learned potentials.

use serde::{Deserialize, Serialize};

/// What learned potentials are made from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SequencePotentialsConfig {
    /// `H`, the units of each of the two recurrent layers, and of the hidden layer of the network that reads both.
    pub hidden: usize,
    /// `J`, the quadratics of a potential beside the flat one.
    pub components: usize,
}

impl Default for SequencePotentialsConfig {
    /// 24 units and three quadratics.
    fn default() -> Self {
        SequencePotentialsConfig { hidden: 24, components: 3 }
    }
}
