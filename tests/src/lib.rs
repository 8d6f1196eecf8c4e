//! What the cross-crate tests share; the tests themselves are in `tests/tests`.

mod differences;
mod families;
mod reference;

pub use differences::{central_differences, distance, norm, relative_distance};
pub use families::{small_families, small_fcnn, small_gnn, small_psi, small_rnn, trained_family};
pub use reference::{NEVER_HALF_ALWAYS, Reference, ScalarGaussian, evidence_scores, reference, score};

/// The README's code, compiled and run as a documentation test.
#[doc = include_str!("../../README.md")]
#[cfg(doctest)]
pub struct Readme;
