//! Estimates over time, for figures that show a trajectory.

use serde::{Deserialize, Serialize};

use crate::UnitConfig;
use crate::config::Epidemic;
use crate::metrics::{Recorded, mean, quantiles};
use crate::problem::Problem;
use crate::unit::UnitSystem;

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

impl Series {
    /// What a unit shows over time: the first repetition of an epidemic, and nothing else.
    pub(crate) fn of(unit: &UnitConfig, problem: &Problem, recorded: &Recorded) -> Option<Series> {
        if !matches!(unit.system, UnitSystem::Epidemic(_)) || unit.repetition > 0 {
            return None;
        }
        let truth = &problem.trajectory.states;
        let states = Epidemic::STATES.iter().enumerate().map(|(state, name)| {
            let mut series = StateSeries {
                state: (*name).to_string(),
                truth: truth.rows().map(|row| row[state]).collect(),
                mean: Vec::with_capacity(truth.len()),
                lo: Vec::with_capacity(truth.len()),
                hi: Vec::with_capacity(truth.len()),
            };
            for time in 0..truth.len() {
                let of_runs: Vec<f64> = recorded.coordinate(time, truth.width(), state).collect();
                let [lo, hi] = quantiles(&of_runs, [0.05, 0.95]);
                series.mean.push(mean(&of_runs));
                series.lo.push(lo);
                series.hi.push(hi);
            }
            series
        });
        Some(Series { states: states.collect() })
    }
}
