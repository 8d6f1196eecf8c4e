//! The paper's claims held against finished runs.
//!
//! Each claim is a few predicates that were fixed before any result was seen, over `units.csv`, paired over repetitions. "Not
//! run" says that a claim cannot be judged yet; one point that contradicts it is enough for "not reproduced".

mod claims;
mod error;
mod held_out;
mod judge;
mod numbers;
mod predicates;
mod report;
mod verdict;

pub use error::VerifyError;
pub(crate) use verdict::judges;
pub use verdict::verify;
