//! The forward algorithm: exact probabilities and log-evidence of a model whose hidden states are discrete and few.

mod error;
mod filter;
mod layer;
mod probabilities;
mod smoother;
mod system;

pub use error::ForwardError;
pub use filter::{ForwardFilter, ForwardStep};
pub use layer::Layer;
pub use probabilities::StateProbabilities;
pub use smoother::{Backward, smooth_states};
pub use system::{FiniteSystem, Limits};
