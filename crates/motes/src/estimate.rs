//! What a filter says of the state at one time.

use motes_smc::Predictive;
use serde::{Deserialize, Serialize};

/// What tables call the moments of a coordinate, or of a measurement that is expected, behind its name and `_`.
pub(crate) const MOMENTS: [&str; 2] = ["mean", "sd"];

/// What they call the place of a measurement in what was expected of it.
pub(crate) const PLACE: &str = "pit";

/// What they call the figures of a filter's weights.
pub(crate) const OF_WEIGHTS: [&str; 2] = ["ess", "log_evidence"];

/// A coordinate of the state at one time, given measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coordinate {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation; NaN where it cannot be told from one particle.
    pub sd: f64,
    /// Its quantiles, those that were asked for ([`FilterOptions::quantiles`](crate::FilterOptions::quantiles)); NaN where they cannot be told from one particle.
    pub quantiles: Vec<f64>,
}

/// The state at one time given the measurements up to it, and what its measurement said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Each of the `N` coordinates of the state.
    pub state: Vec<Coordinate>,
    /// The effective sample size before resampling, in particles; none in a forecast.
    pub ess: Option<f64>,
    /// `log p(y_t | y_{0:t−1})`; 0 where nothing was measured, none in a forecast.
    pub log_evidence: Option<f64>,
    /// What was expected of each of the `M` entries of the measurement before it was used ([`FilterOptions::predictive`](crate::FilterOptions::predictive)), or is
    /// expected in a forecast; empty elsewhere.
    pub predictive: Vec<Predictive>,
}

impl Estimate {
    /// A state alone.
    pub(crate) fn of_state(state: Vec<Coordinate>) -> Self {
        Estimate { state, ess: None, log_evidence: None, predictive: vec![] }
    }
}

/// What is predicted for a row at which nothing was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// Its time.
    pub time: f64,
    /// Its time as it is written: as it was given, or as the model's clock has it; none where rows count as steps.
    pub label: Option<String>,
    /// Whether the label was given.
    pub is_given: bool,
    /// The state and the measurement then, without an effective sample size and evidence.
    pub estimate: Estimate,
}
