//! A maximum that was found, and what the likelihood is around it.

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

/// The largest log-likelihood that there is where one coordinate of positions is given, as a function of that coordinate, and the interval that follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Which coordinate it is.
    pub at: usize,
    /// The lower end of its interval.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// What was found, in the order of the coordinate.
    pub points: Vec<ProfilePoint>,
}

/// A point of a profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProfilePoint {
    /// The coordinate.
    pub v: f64,
    /// The largest log-likelihood over the others that was found: of estimates the logarithm of their mean.
    pub log_likelihood: f64,
    /// Its standard error.
    pub standard_error: f64,
}
