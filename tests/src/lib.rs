//! What the cross-crate tests share; the tests themselves are in `tests/tests`.

mod differences;
mod families;
mod module_graph;
mod module_tree;
mod offspring;
mod planted;
mod reference;
mod replay;
mod shifted;

pub use differences::{central_differences, distance, norm, relative_distance};
pub use families::{
    every_small_family, small_families, small_fcnn, small_gnn, small_psi, small_rnn, trained_family,
};
pub use module_graph::ModuleGraph;
pub use offspring::{OFFSPRING_WEIGHTS, Offspring, systematic_bounds, systematic_variance};
pub use planted::{Bug, Forgetful, Stuck, plain_filter_scores, systematic_with_a_fixed_offset};
pub use reference::{
    NEVER_HALF_ALWAYS, PARTICLES, REFUSED, RUNS, Reference, ScalarGaussian, evidence_scores, is_unbiased,
    reference, reference_with_gaps, score,
};
pub use replay::{Replay, replay, replayed_system};
pub use shifted::Shifted;

/// The README's code, compiled and run as a documentation test.
#[doc = include_str!("../../README.md")]
#[cfg(doctest)]
pub struct Readme;
