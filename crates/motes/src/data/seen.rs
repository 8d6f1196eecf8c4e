//! The series that rows belong to, as they appear, and the steps to their rows.

use std::collections::HashMap;

use motes_models::StepRecord;

use super::columns::Columns;
use super::error::{DataError, Place};
use crate::model::Model;
use crate::timeline::{Clock, RowTime};

/// The series so far, in order of appearance.
#[derive(Default)]
pub(super) struct SeenSeries {
    series: Vec<SeriesPosition>,
    /// The number of each series by its name.
    numbers: HashMap<String, usize>,
}

/// Where a series is after the rows so far.
struct SeriesPosition {
    name: String,
    count: usize,
    /// Where the series is after the last of them.
    clock: Clock,
}

impl SeenSeries {
    /// The number of the series of that name, which is new if it was not there.
    pub(super) fn number_of(&mut self, name: &str) -> usize {
        if let Some(number) = self.numbers.get(name) {
            return *number;
        }
        let number = self.series.len();
        self.numbers.insert(name.into(), number);
        self.series.push(SeriesPosition { name: name.into(), count: 0, clock: Clock::of_series(name) });
        number
    }

    /// How many rows a series has.
    pub(super) fn times(&self, series: usize) -> usize {
        self.series[series].count
    }

    /// One more row of it.
    pub(super) fn add(&mut self, series: usize) {
        self.series[series].count += 1;
    }

    /// The steps to the next row of a series. `place` says where a column of that row is.
    ///
    /// # Errors
    /// [`DataError`] if there are no such steps, or no state can give the measurement.
    pub(super) fn steps_to(
        &mut self,
        series: usize,
        row: RowTime<'_>,
        measurement: &[Option<f64>],
        (model, columns): (&Model, &Columns),
        place: impl Fn(Option<&String>) -> Place,
    ) -> Result<Vec<StepRecord>, DataError> {
        let clock = &mut self.series[series].clock;
        let steps = model.next_steps(clock, row);
        let steps = steps.and_then(|steps| model.measured(clock, measurement).map(|()| steps));
        let steps = steps.map_err(|error| {
            let clock = columns.clock.and_then(|at| columns.names.get(at));
            let column = error.column(|input| model.input_column(input), clock);
            DataError::Timeline { place: place(column.as_ref()), error: Box::new(error) }
        })?;
        if let Some(last) = steps.last()
            && let Some(impossible) = model.impossible(&last.step(), measurement)
        {
            let column = columns.names.get(columns.measurements[impossible.coordinate]);
            return Err(DataError::Impossible { place: place(column), impossible: impossible.into() });
        }
        Ok(steps)
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.series.iter().map(|series| series.name.as_str())
    }

    /// Where each series is after its last row.
    pub(super) fn clocks(&self) -> impl Iterator<Item = &Clock> {
        self.series.iter().map(|series| &series.clock)
    }
}
