//! Estimates over time, for figures that show a trajectory.

use serde::{Deserialize, Serialize};

/// A method's estimates of one trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// One for each coordinate of the state.
    pub states: Vec<StateSeries>,
}

/// Estimates of one coordinate of the state, from `t = 0` on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StateSeries {
    /// Its name.
    pub state: String,
    /// The simulated state.
    pub truth: Vec<f64>,
    /// The mean of the estimates of all runs.
    pub mean: Vec<f64>,
    /// Below which a twentieth of the estimates of single runs lie.
    pub lo: Vec<f64>,
    /// Above which a twentieth of them lie.
    pub hi: Vec<f64>,
}
