//! What a unit found.

use crate::metric::Metric;
use crate::provenance::Provenance;
use crate::series::Series;

/// What a unit found.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// What depends on nothing but the configuration.
    pub metrics: Vec<Metric>,
    /// What depends on the clock.
    pub timings: Vec<Metric>,
    /// Estimates over time, where the experiment shows them.
    pub series: Option<Series>,
    /// What began the training, if it was resumed.
    pub(crate) earlier: Vec<Provenance>,
}
