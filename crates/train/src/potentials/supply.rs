//! Sequences to learn from.

use motes_models::{ModelError, OwnModel, OwnSteps, Seed};
use motes_proposals::{PathBatch, PotentialStandards, StepFeatures};
use rand::RngExt;

use super::settings::PotentialLearnConfig;
use crate::TrainError;

/// How often sequences are drawn again of which one leaves the numbers.
const TRIES: u64 = 20;

/// One measurement in so many is missing of a sequence with gaps.
const MISSING: f64 = 0.2;

/// `sequences` whole sequences that the model draws for itself.
///
/// # Errors
/// [`TrainError::Simulations`] if of each try one sequence leaves the numbers.
pub(super) fn drawn<M: OwnModel + ?Sized>(
    model: &M,
    sequences: usize,
    config: &PotentialLearnConfig,
    standards: &PotentialStandards,
    seed: &Seed,
) -> Result<PathBatch, TrainError> {
    for number in 0..TRIES {
        let seed = seed.nth(number);
        let mut gaps = seed.child("gaps").stream();
        let has_gaps: Vec<bool> = (0..sequences).map(|_| gaps.random::<f64>() < config.with_gaps).collect();
        let (mut batch, mut features) = (PathBatch::default(), StepFeatures::default());
        let mut steps = own_steps(model, sequences, config.horizon, &seed.child("sequences"))?;
        for _ in 0..config.horizon {
            let Some(step) = steps.advance() else { break };
            let is_missing: Vec<bool> = (0..sequences).map(|_| gaps.random::<f64>() < MISSING).collect();
            batch.add(model, &step, |at| has_gaps[at] && is_missing[at], standards, &mut features);
        }
        if steps.lost() == 0 && batch.steps() > 0 {
            return Ok(batch);
        }
    }
    Err(TrainError::Simulations { tries: TRIES })
}

/// The units of measurements and states over `sequences` sequences; those that leave the numbers count until then.
///
/// # Errors
/// [`TrainError::Model`] for a model that cannot be simulated.
pub(super) fn standards<M: OwnModel + ?Sized>(
    model: &M,
    sequences: usize,
    config: &PotentialLearnConfig,
    seed: &Seed,
) -> Result<PotentialStandards, TrainError> {
    let (mut measurements, mut states) = (Vec::new(), Vec::new());
    let mut steps = own_steps(model, sequences, config.horizon, seed)?;
    for _ in 0..config.horizon {
        let Some(step) = steps.advance() else { break };
        measurements.extend_from_slice(step.measurements);
        states.extend_from_slice(step.states);
    }
    Ok(PotentialStandards::of_rows(&measurements, model.measurement_dim(), &states, model.state_dim()))
}

/// Sequences side by side, in a window of one of the model's own sequences where it has these.
fn own_steps<'m, M: OwnModel + ?Sized>(
    model: &'m M,
    sequences: usize,
    horizon: usize,
    seed: &Seed,
) -> Result<OwnSteps<'m, M>, ModelError> {
    let steps = OwnSteps::new(model, sequences, seed)?;
    Ok(if model.own_sequences().is_empty() { steps } else { steps.in_window(horizon) })
}
