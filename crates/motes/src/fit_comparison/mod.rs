//! Models that were fitted to the same data, beside each other.

mod folder;
mod score;

pub use folder::FittedModel;
pub use score::{FitComparison, FittedScore, compare_fits};
