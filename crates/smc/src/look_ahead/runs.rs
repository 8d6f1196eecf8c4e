//! Runs of steps that are alike.

use std::ops::Range;

use motes_models::batch::LANES;
use motes_models::equations::{Draw, Linearise};

use super::error::LookAheadError;
use super::recorded::RecordedStep;

/// Steps in a row about whose states a model is asked together: alike, and with the same entries measured. There are no more than a tile has lanes.
#[derive(Debug, Clone)]
pub(super) struct Run {
    /// Which steps.
    pub(super) steps: Range<usize>,
    /// What each of them draws.
    pub(super) draws: Vec<Draw>,
}

/// Cuts a sequence that is as one of the model is into runs.
///
/// # Errors
/// [`LookAheadError`] if the model has no map of noise, there is no step, or one does not fit.
pub(super) fn runs_of<M: Linearise + ?Sized>(
    model: &M,
    recorded: &[RecordedStep],
) -> Result<Vec<Run>, LookAheadError> {
    let noise_space = model.noise_space().ok_or(LookAheadError::NoNoise)?;
    if recorded.is_empty() {
        return Err(LookAheadError::Empty);
    }
    let width = model.measurement_dim();
    let mut runs: Vec<Run> = Vec::new();
    for (index, RecordedStep { step, measurement }) in recorded.iter().enumerate() {
        let (step, wrong) =
            (step.step(), |what, found, expected| Err(LookAheadError::Step { index, what, found, expected }));
        if step.index != index {
            return wrong("its index", step.index, index);
        }
        if measurement.len() != width {
            return wrong("the number of entries of its measurement", measurement.len(), width);
        }
        let belongs = |run: &Run| {
            let first = &recorded[run.steps.start];
            let mut entries = first.measurement.iter().zip(measurement);
            run.steps.len() < LANES
                && entries.all(|(one, other)| one.is_some() == other.is_some())
                && noise_space.are_alike(&first.step.step(), &step)
        };
        match runs.last_mut().filter(|run| belongs(run)) {
            Some(run) => run.steps.end = index + 1,
            None => runs.push(Run { steps: index..index + 1, draws: noise_space.draws(&step) }),
        }
    }
    Ok(runs)
}

/// What each step of a sequence with these runs draws.
pub(super) fn draws_of_all(runs: &[Run]) -> impl Iterator<Item = &[Draw]> {
    runs.iter().flat_map(|run| run.steps.clone().map(|_| run.draws.as_slice()))
}
