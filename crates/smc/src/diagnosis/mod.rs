//! Whether weights can be trusted: how many particles they leave, and whether they have a variance.

mod pareto;
mod report;
mod upper_end;

pub use pareto::{PARETO_K_LIMIT, pareto_k};
pub(crate) use pareto::{tail_length, tail_within};
pub use report::{LEAST_EFFECTIVE_PARTICLES, WeightDiagnosis, WeightReport, WeightWarning};
pub(crate) use upper_end::{has_upper_end, upper_end_of_sorted};
