//! Potentials of whole sequences, learned beside a proposal.

use std::ops::ControlFlow;

use motes_models::Seed;
use motes_proposals::{Backend, Family, SequencePotentials, SequencePotentialsConfig};
use motes_train::{LearnObjective, PotentialLearnConfig, TrainError, learn_potentials};

use super::options::LearnOptions;
use crate::error::MotesError;
use crate::learned::{PotentialNotes, shape_of};
use crate::model::LearnableModel;

/// Whether potentials are learned: from simulations, for a model that says how its states are made of noise.
pub(super) fn learns_potentials(model: &dyn LearnableModel, options: &LearnOptions) -> bool {
    options.objective == LearnObjective::Inclusive && model.has_gradients() && model.noise_space().is_some()
}

/// Learns potentials; none where simulated sequences leave the numbers again and again. `proceed` is asked after each update, with how many of how many are done.
///
/// # Errors
/// [`MotesError::Interrupted`] if `proceed` says so, and as [`learn_potentials`].
pub(super) fn potentials(
    model: &dyn LearnableModel,
    options: &LearnOptions,
    seed: &Seed,
    proceed: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<Option<(SequencePotentials, PotentialNotes)>, MotesError> {
    let settings = PotentialLearnConfig {
        horizon: options.steps,
        seconds: options.seconds,
        ..PotentialLearnConfig::new()
    };
    let seed = seed.child("potentials");
    let config = SequencePotentialsConfig::default();
    let mut potentials = SequencePotentials::create(
        &config,
        &shape_of(model),
        0,
        Backend::Native.into(),
        &seed.child("weights"),
    )?;
    let mut is_stopped = false;
    let learned = learn_potentials(&mut potentials, model, &settings, &seed, |done, _| {
        let asked = proceed(done, settings.steps);
        is_stopped = asked.is_break();
        asked
    });
    if is_stopped {
        return Err(MotesError::Interrupted);
    }
    match learned {
        // One-step proposals learn from sequences that end early; potentials need whole ones.
        Err(TrainError::Setting { .. }) => Ok(None),
        learned => {
            let learned = learned?;
            let gain = learned.best_gain();
            Ok(Some((potentials, PotentialNotes { updates: learned.steps, seconds: learned.seconds, gain })))
        }
    }
}
