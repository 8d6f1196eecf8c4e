//! Whether another filter's evidence contradicts a filter's own.

mod misses;
mod opinion;
mod trust;
mod verdict;
mod windows;

pub use opinion::SecondOpinion;
pub use verdict::Verdict;
