//! The steps of a model: from a row of a series to the next.

use motes_models::{StateSpaceModel, Step, StepRecord};

use crate::model::{Kind, Model};
use crate::timeline::{Clock, RowTime, Timeline, TimelineError};

impl Model {
    /// The column of data that has the times of rows, where the model names one.
    pub fn time_column(&self) -> Option<&str> {
        self.timeline().and_then(Timeline::time_column)
    }

    /// The column of data whose times are dates, where simulations do not know when the first row is.
    pub fn undated_column(&self) -> Option<&str> {
        self.timeline().and_then(Timeline::undated_column)
    }

    /// The columns of data that the model's inputs come from; some may be measurements.
    pub fn input_columns(&self) -> &[String] {
        self.timeline().map_or(&[], Timeline::columns)
    }

    /// The steps to the next row of a series, all but the last of which have no measurement.
    ///
    /// # Errors
    /// [`TimelineError`] if the row's time does not come next, or an input is missing.
    pub fn next_steps(&self, clock: &mut Clock, row: RowTime<'_>) -> Result<Vec<StepRecord>, TimelineError> {
        match self.timeline() {
            Some(timeline) => clock.next(timeline, row),
            None => Ok(vec![StepRecord::of(&self.step_of_index(clock.count()))]),
        }
    }

    /// The steps to a row after the last one, at which nothing is measured: one with this time and these inputs, or a gap as the last one ahead. An input of the measurement
    /// that is not known then is NaN.
    ///
    /// # Errors
    /// [`TimelineError::Ahead`] if an input is not known then, and as [`Model::next_steps`].
    pub fn steps_ahead(
        &self,
        clock: &mut Clock,
        row: Option<RowTime<'_>>,
    ) -> Result<Vec<StepRecord>, TimelineError> {
        match self.timeline() {
            Some(timeline) => clock.ahead(timeline, row),
            None => Ok(vec![StepRecord::of(&self.step_of_index(clock.count()))]),
        }
    }

    /// An input of the measurement that is not known at the end of a step.
    pub(crate) fn unknown_input(&self, step: &Step<'_>) -> Option<String> {
        let frame = self.frame()?;
        let of_measurement = step.end(frame.input_dim()).inputs;
        let unknown = of_measurement.iter().position(|value| value.is_nan())?;
        frame.inputs().get(unknown).map(|input| input.name.clone())
    }

    /// Takes in what was measured at the row that [`Model::next_steps`] led to.
    ///
    /// # Errors
    /// [`TimelineError::NoStepBefore`].
    pub fn measured(&self, clock: &mut Clock, measurement: &[Option<f64>]) -> Result<(), TimelineError> {
        match self.timeline() {
            Some(timeline) => clock.measured(timeline, measurement),
            None => Ok(()),
        }
    }

    /// A measurement that is an input of later steps, if there is one.
    pub(crate) fn fed_back_measurement(&self) -> Option<&str> {
        let measurements = self.measurements();
        self.input_columns().iter().find(|column| measurements.contains(column)).map(String::as_str)
    }

    /// What a row gives of measurements that are inputs: an entry for each measurement.
    pub(crate) fn measurements_of(&self, row: RowTime<'_>) -> Vec<Option<f64>> {
        let given = |name: &String| {
            let column = self.input_columns().iter().position(|column| column == name)?;
            row.columns.get(column).copied().flatten()
        };
        self.measurements().iter().map(given).collect()
    }

    /// The column of data that an input comes from.
    pub(crate) fn input_column(&self, input: &str) -> Option<String> {
        self.timeline()?.column_of(input).map(str::to_string)
    }

    /// The step of an index where nobody says more.
    pub(crate) fn step_of_index(&self, index: usize) -> Step<'_> {
        match self.kind() {
            Kind::Learnable(learnable) => learnable.step_of_index(index),
            Kind::LinearGaussian(linear) => linear.step_of_index(index),
        }
    }
}
