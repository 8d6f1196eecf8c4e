//! Where a model is in its sequence, as a value.

use serde::{Deserialize, Serialize};

/// The step of a model to `x_t`, or its start where `index` is 0.
///
/// All that a model may depend on besides its states is here. Formulas see parameters as their scalars `S`.
///
/// A step may be cut into sub-steps of equal length: the transition is then made so many times, and the measurement is that of the last. What a transition is given is
/// one of the sub-steps ([`Step::part`]); what a measurement is given is the end of the step ([`Step::end`]).
///
/// ```
/// use motes_models::Step;
///
/// let step = Step::of_index(3);
/// assert_eq!((step.index, step.time, step.length), (3, 3.0, 1.0));
/// assert!(step.inputs.is_empty() && step.parameters.is_empty());
///
/// // Two sub-steps, each with an input, and the input of the measurement.
/// let step = Step { sub_steps: 2, inputs: &[0.1, 0.2, 0.3], ..Step::of_index(3) };
/// let part = step.part(0, 1);
/// assert_eq!((part.time, part.length, part.inputs), (2.5, 0.5, &[0.1][..]));
/// assert_eq!(step.end(1).inputs, [0.3]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<'a, S = f64> {
    /// 0, 1, 2, … along a sequence.
    pub index: usize,
    /// `t` at the end of the step.
    pub time: f64,
    /// The time since the step before; 0 at the start.
    pub length: f64,
    /// Of a part of a step, which one it is, from 0.
    pub sub_step: usize,
    /// How many sub-steps the step has; 0 where no time passes, so that the state stays as it is.
    pub sub_steps: usize,
    /// The inputs: `U` that hold throughout the step, or `U` for each sub-step and `U` more for the measurement. At the start there is one such part, for `x_0`.
    pub inputs: &'a [f64],
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
            sub_step: 0,
            sub_steps: 1,
            inputs: &[],
            parameters: &[],
        }
    }
}

impl<'a, S> Step<'a, S> {
    /// A sub-step of a model that takes `inputs` inputs.
    #[inline(always)]
    pub fn part(&self, sub_step: usize, inputs: usize) -> Step<'a, S> {
        let count = self.sub_steps as f64;
        let behind = self.length * ((self.sub_steps - 1 - sub_step) as f64 / count);
        Step {
            time: self.time - behind,
            length: self.length / count,
            sub_step,
            inputs: self.inputs_of(sub_step, inputs),
            ..*self
        }
    }

    /// The end of the step, where a model that takes `inputs` inputs is measured.
    #[inline(always)]
    pub fn end(&self, inputs: usize) -> Step<'a, S> {
        Step { inputs: self.inputs_of(self.sub_steps, inputs), ..*self }
    }

    /// The inputs of a part of the step.
    #[inline(always)]
    fn inputs_of(&self, part: usize, inputs: usize) -> &'a [f64] {
        match self.inputs.len() == inputs {
            true => self.inputs,
            false => &self.inputs[part * inputs..][..inputs],
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepRecord {
    index: usize,
    time: f64,
    length: f64,
    sub_steps: usize,
    inputs: Vec<f64>,
    parameters: Vec<f64>,
}

impl Default for StepRecord {
    fn default() -> Self {
        StepRecord {
            index: 0,
            time: 0.0,
            length: 0.0,
            sub_steps: 1,
            inputs: Vec::new(),
            parameters: Vec::new(),
        }
    }
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
        self.sub_steps = step.sub_steps;
        self.inputs.clear();
        self.inputs.extend_from_slice(step.inputs);
        self.parameters.clear();
        self.parameters.extend_from_slice(step.parameters);
    }

    /// The step that is kept; the start of a sequence where none was.
    pub fn step(&self) -> Step<'_> {
        let StepRecord { index, time, length, sub_steps, inputs, parameters } = self;
        Step {
            index: *index,
            time: *time,
            length: *length,
            sub_step: 0,
            sub_steps: *sub_steps,
            inputs,
            parameters,
        }
    }
}
