//! How far a filter's log-evidence may be off, and whether it can be trusted at all.

mod ancestry;
mod blocks;
mod check;
mod coordinates;
mod standard_error;
mod surprise;
mod warning;

pub use ancestry::AncestryVariance;
pub use check::{CheckSnapshot, EvidenceCheck, LARGEST_ERROR};
pub use standard_error::{error_of_variance, variance_of_error};
pub use warning::EvidenceWarning;
