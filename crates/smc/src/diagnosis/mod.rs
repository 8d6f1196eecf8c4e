//! Whether weights can be trusted: how many particles they leave, and whether they have a variance.

mod report;
mod tail;

pub use report::{LEAST_EFFECTIVE_PARTICLES, WeightDiagnosis, WeightReport, WeightWarning};
pub use tail::{TAIL_INDEX_LIMIT, tail_index};
