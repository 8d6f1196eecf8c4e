//! What filters are compared on.

use motes_models::{StepRecord, Trajectory};
use motes_smc::RecordedStep;

use crate::data::Data;
use crate::known_inputs::all_known;
use crate::recorded::steps_to_row;
use crate::simulating::{Simulated, SimulatedRow};

/// A sequence of measurements, with the states that made them where those are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// The steps that lead to each row.
    pub steps: Vec<Vec<StepRecord>>,
    /// The measurement at each time.
    pub measurements: Vec<Vec<Option<f64>>>,
    /// The state at each time.
    pub truth: Option<Vec<Vec<f64>>>,
}

impl Sequence {
    /// All of its steps, each with what is measured then.
    pub(super) fn recorded(&self) -> Vec<RecordedStep> {
        let rows = self.steps.iter().zip(&self.measurements);
        rows.flat_map(|(steps, measurement)| steps_to_row(steps, measurement)).collect()
    }
}

/// The series of some data.
pub(super) fn of_data(data: &Data) -> Vec<Sequence> {
    let of_series = |series| Sequence {
        steps: data.of_series(series).map(|row| all_known(&row.steps)).collect(),
        measurements: data.of_series(series).map(|row| row.measurement.clone()).collect(),
        truth: None,
    };
    (0..data.series.len()).map(of_series).collect()
}

/// Simulated series.
pub(super) fn of_simulations(simulated: &Simulated) -> Vec<Sequence> {
    let of_trajectory = |(trajectory, rows): (&Trajectory, &Vec<SimulatedRow>)| Sequence {
        steps: rows.iter().map(|row| row.steps.clone()).collect(),
        measurements: trajectory
            .measurements
            .rows()
            .map(|row| row.iter().copied().map(Some).collect())
            .collect(),
        truth: Some(trajectory.states.rows().map(<[f64]>::to_vec).collect()),
    };
    simulated.series.iter().zip(&simulated.rows).map(of_trajectory).collect()
}
