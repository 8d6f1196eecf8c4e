//! The steps of sequences, as a model has them where nobody gives others.

use std::ops::Range;

use motes_models::{Step, StepRecord};

/// The most sub-steps that a step can have.
pub const MOST_SUB_STEPS: usize = 1_000_000;

/// The steps of sequences, one after another.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    steps: Vec<StepRecord>,
    /// The ranges of sequences that end; none where one goes on for ever.
    sequences: Vec<Range<usize>>,
}

impl Schedule {
    /// The schedule of one sequence, which goes on with the steps behind the first one again; none where there is no step.
    pub fn endless(steps: Vec<StepRecord>) -> Option<Self> {
        (!steps.is_empty()).then_some(Schedule { steps, sequences: vec![] })
    }

    /// The schedule of several sequences, longer ones first; none where there is no step.
    pub fn of_sequences(mut sequences: Vec<Vec<StepRecord>>) -> Option<Self> {
        sequences.retain(|steps| !steps.is_empty());
        // Who asks for the first two steps finds them in one sequence, if any has so many.
        sequences.sort_by_key(|steps| std::cmp::Reverse(steps.len()));
        let mut end = 0;
        let ranges = sequences.iter().map(|steps| {
            end += steps.len();
            end - steps.len()..end
        });
        let ranges = ranges.collect();
        let steps: Vec<StepRecord> = sequences.into_iter().flatten().collect();
        (!steps.is_empty()).then_some(Schedule { steps, sequences: ranges })
    }

    /// All steps.
    pub fn steps(&self) -> &[StepRecord] {
        &self.steps
    }

    /// The ranges of steps that are sequences which end; none where one goes on for ever.
    pub fn sequences(&self) -> &[Range<usize>] {
        &self.sequences
    }

    /// The step of an index: behind the last one those after the first come again.
    pub fn step_of_index(&self, index: usize) -> Step<'_> {
        if let Some(step) = self.steps.get(index).filter(|_| !self.sequences.is_empty()) {
            return step.step();
        }
        let again = self.steps.len() - 1;
        let at = match index {
            0 => 0,
            _ if again == 0 => 0,
            _ => 1 + (index - 1) % again,
        };
        Step { index, ..self.steps[at].step() }
    }
}
