//! Learning potentials of whole sequences from a model's own simulations.

mod learn;
mod settings;
mod supply;

pub use learn::{PotentialHistory, learn_potentials};
pub use settings::PotentialLearnConfig;
pub use supply::{PathRequest, PathSampler, PathSource};
