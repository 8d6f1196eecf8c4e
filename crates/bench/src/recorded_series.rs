//! What is recorded of a unit's filters, as series over time.

use crate::config::Epidemic;
use crate::metrics::Recorded;
use crate::problem::Problem;
use crate::series::{Series, StateSeries};
use crate::statistics::{mean, quantiles};
use crate::unit::{UnitConfig, UnitSystem};

/// What a unit shows over time: the first repetition of an epidemic, and nothing else.
pub(crate) fn series(unit: &UnitConfig, problem: &Problem, recorded: &Recorded) -> Option<Series> {
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
