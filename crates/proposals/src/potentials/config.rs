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
    /// The steps of sequences that each model draws, by which its units are found, where there are several models, as with other parameters; none if units are those of one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps_of_units: Option<usize>,
}

impl Default for LearnedPotentialsConfig {
    /// 24 units and three quadratics, for one model.
    fn default() -> Self {
        LearnedPotentialsConfig { hidden: 24, components: 3, steps_of_units: None }
    }
}
