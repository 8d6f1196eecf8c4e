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
    /// The steps of simulated sequences by which units are found anew for each model, where it serves several, as with other parameters; none if units are those of one model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<usize>,
}

impl Default for LearnedPotentialsConfig {
    /// 24 units and three quadratics, for one model.
    fn default() -> Self {
        LearnedPotentialsConfig { hidden: 24, components: 3, simulated: None }
    }
}
