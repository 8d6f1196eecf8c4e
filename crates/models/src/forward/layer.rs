//! The states of one time, before and after what is measured then.

use std::collections::HashMap;

use super::error::ForwardError;
use super::probabilities::StateProbabilities;
use super::system::{FiniteSystem, Limits};
use crate::Step;

/// The states after a sub-step: as they are predicted, and given the measurement, if there is one then.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// `p(x | y)` of all measurements before.
    pub predicted: StateProbabilities,
    /// The same of the measurement at this time, too, for the same states; where nothing is measured, it is what is predicted.
    pub filtered: Vec<f64>,
}

impl Layer {
    /// `p(x | y)` of all measurements up to this time.
    pub fn belief(&self) -> StateProbabilities {
        let predicted = &self.predicted;
        StateProbabilities::of(predicted.width(), predicted.states().to_vec(), self.filtered.clone())
    }
}

/// A state by its bits, by which states are told apart; −0 is 0.
pub(super) fn key(state: &[f64]) -> Vec<u64> {
    state.iter().map(|value| (value + 0.0).to_bits()).collect()
}

/// Where each state stands among others.
pub(super) fn places(states: &StateProbabilities) -> HashMap<Vec<u64>, usize> {
    states.iter().enumerate().map(|(number, (state, _))| (key(state), number)).collect()
}

/// The states that a sub-step leads to from those of a belief, or those of the start where there is none.
pub(super) fn next(
    model: &(impl FiniteSystem + ?Sized),
    part: &Step<'_>,
    before: Option<&StateProbabilities>,
    limits: Limits,
) -> Result<StateProbabilities, ForwardError> {
    let n = model.state_dim();
    let mut ways = limits.ways;
    let mut known: HashMap<Vec<u64>, usize> = HashMap::new();
    let (mut states, mut probabilities): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let (mut wrong, mut is_full) = (None, false);
    let mut from = |previous: Option<&[f64]>, own: f64| {
        let found = model.branches(part, previous, &mut ways, &mut |state, probability| {
            if state.iter().any(|value| !value.is_finite()) {
                wrong.get_or_insert_with(|| state.to_vec());
                return;
            }
            match known.get(&key(state)) {
                Some(number) => probabilities[*number] += own * probability,
                None if probabilities.len() == limits.states => is_full = true,
                None => {
                    known.insert(key(state), probabilities.len());
                    states.extend_from_slice(state);
                    probabilities.push(own * probability);
                }
            }
        });
        match (&wrong, is_full) {
            (Some(state), _) => {
                let previous = previous.map(<[f64]>::to_vec);
                Err(ForwardError::NotANumber { previous, state: state.clone() })
            }
            (None, true) => Err(ForwardError::TooManyStates(limits.states)),
            (None, false) => found.map_err(|error| match error {
                ForwardError::TooManyWays(_) => ForwardError::TooManyWays(limits.ways),
                error => error,
            }),
        }
    };
    match before {
        None => from(None, 1.0)?,
        Some(before) => before
            .iter()
            .filter(|(_, probability)| *probability > 0.0)
            .try_for_each(|(state, probability)| from(Some(state), probability))?,
    }
    Ok(StateProbabilities::of(n, states, probabilities))
}
