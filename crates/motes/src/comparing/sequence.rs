//! What filters are compared on.

use crate::data::Data;
use crate::simulating::Simulated;

/// A sequence of measurements, with the states that made them where those are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// The measurement at each time.
    pub measurements: Vec<Vec<Option<f64>>>,
    /// The state at each time.
    pub truth: Option<Vec<Vec<f64>>>,
}

/// The series of some data.
pub(super) fn of_data(data: &Data) -> Vec<Sequence> {
    let of_series = |series| data.of_series(series).map(|row| row.measurement.clone()).collect();
    (0..data.series.len()).map(|series| Sequence { measurements: of_series(series), truth: None }).collect()
}

/// Simulated series.
pub(super) fn of_simulations(simulated: &Simulated) -> Vec<Sequence> {
    let of_trajectory = |trajectory: &motes_models::Trajectory| Sequence {
        measurements: trajectory
            .measurements
            .rows()
            .map(|row| row.iter().copied().map(Some).collect())
            .collect(),
        truth: Some(trajectory.states.rows().map(<[f64]>::to_vec).collect()),
    };
    simulated.series.iter().map(of_trajectory).collect()
}
