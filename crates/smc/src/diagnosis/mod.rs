//! Whether weights can be trusted: how many particles they leave, and whether they have a variance.

mod pareto;
mod report;

pub(crate) use pareto::pareto_k_within;
pub use pareto::{PARETO_K_LIMIT, pareto_k};
pub use report::{LEAST_EFFECTIVE_PARTICLES, WeightDiagnosis, WeightReport, WeightWarning};
