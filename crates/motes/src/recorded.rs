//! A series of data as a filter takes it, step by step.

use motes_smc::RecordedStep;

use crate::data::Data;

/// The steps of a series whose rows stand at `places`, each with what is measured then: the last one to a row with all of it, those before with nothing.
pub(crate) fn recorded_steps(data: &Data, places: &[usize]) -> Vec<RecordedStep> {
    let mut recorded = Vec::with_capacity(places.len());
    for row in places.iter().map(|at| &data.rows[*at]) {
        for (number, step) in row.steps.iter().enumerate() {
            let is_last = number + 1 == row.steps.len();
            let measurement = if is_last { row.measurement.clone() } else { vec![None; row.measurement.len()] };
            recorded.push(RecordedStep { step: step.clone(), measurement });
        }
    }
    recorded
}
