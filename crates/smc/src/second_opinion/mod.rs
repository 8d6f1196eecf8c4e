//! Whether another filter's evidence contradicts a filter's own.

mod evidence_error;
mod misses;
mod opinion;
mod trust;
mod verdict;
mod windows;

pub use evidence_error::EvidenceError;
pub use opinion::SecondOpinion;
pub use verdict::Verdict;
