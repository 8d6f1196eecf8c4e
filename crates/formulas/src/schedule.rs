//! The steps of a sequence, as a model has them where nobody gives others.

use motes_models::{Step, StepRecord};

/// The most sub-steps that a step can have.
pub const MOST_SUB_STEPS: usize = 1_000_000;

/// The steps of a sequence, one after another. A sequence that is longer goes on with those behind the first one again.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule(Vec<StepRecord>);

impl Schedule {
    /// The schedule of these steps; none where there is no step.
    pub fn new(steps: Vec<StepRecord>) -> Option<Self> {
        (!steps.is_empty()).then_some(Schedule(steps))
    }

    /// How many steps it has.
    pub fn steps(&self) -> &[StepRecord] {
        &self.0
    }

    /// The step of an index.
    pub(crate) fn step_of_index(&self, index: usize) -> Step<'_> {
        let again = self.0.len() - 1;
        let at = match index {
            0 => 0,
            _ if again == 0 => 0,
            _ => 1 + (index - 1) % again,
        };
        Step { index, ..self.0[at].step() }
    }
}
