//! A maximum that was found.

use serde::{Deserialize, Serialize};

use crate::likelihood::Estimator;

/// The highest point that a search found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Maximum {
    /// Where it is (`D`).
    pub v: Vec<f64>,
    /// The log-likelihood there: `log` of the average of estimates.
    pub log_likelihood: f64,
    /// Its standard error; 0 where it is exact.
    pub standard_error: f64,
    /// `L` (`D×D`, row after row): `L Lᵀ` is the inverse of the curvature. Nothing where a swarm found it.
    pub(super) spread: Vec<f64>,
    /// The estimator that the search used.
    pub estimator: Estimator,
}
