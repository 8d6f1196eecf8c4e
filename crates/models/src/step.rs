//! Where a model is in its sequence, as a value.

use serde::{Deserialize, Serialize};

/// The step of a model to `x_t`, or its start where `index` is 0.
///
/// All that a model may depend on besides its states is here. Numbers are `f64`; formulas see inputs and parameters as their
/// scalars `S`.
///
/// ```
/// use motes_models::Step;
///
/// let step = Step::of_index(3);
/// assert_eq!((step.index, step.time, step.length), (3, 3.0, 1.0));
/// assert!(step.inputs.is_empty() && step.parameters.is_empty());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<'a, S = f64> {
    /// 0, 1, 2, … along a sequence.
    pub index: usize,
    /// `t` at the end of the step.
    pub time: f64,
    /// The time since the step before; 0 at the start.
    pub length: f64,
    /// The inputs `u_t`.
    pub inputs: &'a [S],
    /// The parameters `θ`.
    pub parameters: &'a [S],
}

impl Step<'_> {
    /// The step of that index where rows are one unit of time apart and the first is at 0, without inputs and parameters.
    pub fn of_index(index: usize) -> Self {
        Step {
            index,
            time: index as f64,
            length: if index == 0 { 0.0 } else { 1.0 },
            inputs: &[],
            parameters: &[],
        }
    }
}

/// A [`Step`] with numbers of its own, for who keeps it.
///
/// ```
/// use motes_models::{Step, StepRecord};
///
/// let step = Step { time: 0.5, length: 0.5, inputs: &[2.0], ..Step::of_index(1) };
/// assert_eq!(StepRecord::of(&step).step(), step);
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StepRecord {
    index: usize,
    time: f64,
    length: f64,
    inputs: Vec<f64>,
    parameters: Vec<f64>,
}

impl StepRecord {
    /// That of a step.
    pub fn of(step: &Step<'_>) -> Self {
        let mut record = StepRecord::default();
        record.keep(step);
        record
    }

    /// Keeps another step instead.
    pub fn keep(&mut self, step: &Step<'_>) {
        (self.index, self.time, self.length) = (step.index, step.time, step.length);
        self.inputs.clear();
        self.inputs.extend_from_slice(step.inputs);
        self.parameters.clear();
        self.parameters.extend_from_slice(step.parameters);
    }

    /// The step that is kept; the start of a sequence where none was.
    pub fn step(&self) -> Step<'_> {
        let StepRecord { index, time, length, inputs, parameters } = self;
        Step { index: *index, time: *time, length: *length, inputs, parameters }
    }
}
