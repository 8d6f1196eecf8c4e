//! Learning once, from a model's own simulations, by the inclusive objective.

mod learn;
mod recorded;
mod rows;
mod settings;

pub use learn::{Learned, learn};
pub use settings::LearnConfig;
