//! The steps of a series, one by one, each with what is measured then.

use motes_models::StepRecord;

/// The steps to a row, each with what is measured then: the last one with all of it, the others with nothing.
pub(super) fn with_measurements<'a>(
    steps: &'a [StepRecord],
    measurement: &'a [Option<f64>],
) -> impl Iterator<Item = (&'a StepRecord, Vec<Option<f64>>)> {
    steps.iter().enumerate().map(move |(number, step)| {
        let is_last = number + 1 == steps.len();
        (step, if is_last { measurement.to_vec() } else { vec![None; measurement.len()] })
    })
}

/// All steps of a series with what is measured then.
pub(super) fn series<'a>(
    steps: &'a [&'a [StepRecord]],
    rows: &'a [&'a [Option<f64>]],
) -> Vec<(&'a StepRecord, Vec<Option<f64>>)> {
    steps.iter().zip(rows).flat_map(|(steps, row)| with_measurements(steps, row)).collect()
}
