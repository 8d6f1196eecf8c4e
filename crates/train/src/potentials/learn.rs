//! Gradient steps on fresh sequences, judged by others.

use std::ops::ControlFlow;
use std::sync::mpsc::sync_channel;
use std::time::Instant;

use motes_models::{OwnModel, Seed};
use motes_proposals::{Parametric, SequenceBatch, SequencePotentials, Workspace};

use super::settings::PotentialLearnConfig;
use super::supply::{drawn, standards};
use crate::{Adam, Schedule, TrainError};

/// Sequences by which units are found, and by which weights are judged.
const STANDARDISING: usize = 64;
const VALIDATION: usize = 64;

/// What came of learning.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedPotentials {
    /// Steps that were taken.
    pub steps: usize,
    /// The gain on validation sequences after so many steps, in nats for a step of a sequence.
    pub validation: Vec<(usize, f64)>,
    /// How long it took.
    pub seconds: f64,
}

impl LearnedPotentials {
    /// The gain of the weights that were kept.
    pub fn best_gain(&self) -> f64 {
        self.validation.iter().map(|(_, gain)| *gain).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Learns potentials of any sequence of `model` from sequences that it draws for itself, by maximising the mean of `log ψ_t(x_t) − log Z_t(x_{t−1})`: the inclusive Kullback–Leibler
/// divergence from the model's own path, given all measurements, but for its sign and a constant.
///
/// The weights with the best gain on validation sequences are kept. A step whose gain or gradient is not finite ends learning. The same seed gives the same weights, unless there is a
/// budget in seconds. `observe` is shown each step with the last figure of validation, and ends learning by breaking.
///
/// # Errors
/// - [`TrainError::Setting`] for bad settings, and for a model whose simulations overflow.
/// - [`TrainError::Model`] for a model that cannot be simulated.
/// - [`TrainError::Networks`] if the networks fail.
pub fn learn_potentials<M: OwnModel + ?Sized>(
    potentials: &mut SequencePotentials,
    model: &M,
    config: &PotentialLearnConfig,
    seed: &Seed,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<LearnedPotentials, TrainError> {
    config.check()?;
    let mut adam = Adam::new(&config.adam)?;
    let started = Instant::now();
    potentials.set_standards(&standards(model, STANDARDISING, config, &seed.child("standards"))?)?;
    let units = potentials.standards();
    let held_out = drawn(model, VALIDATION, config, &units, &seed.child("validation"))?;
    let mut last = potentials.gain(&held_out)?;
    let mut learned = LearnedPotentials { steps: 0, validation: vec![(0, last)], seconds: 0.0 };
    let mut best = (last, potentials.parameters().values().clone());
    let mut memory = [0, 1, 2].map(|_| Workspace::new(potentials.parameters()));
    std::thread::scope(|scope| -> Result<(), TrainError> {
        // One batch is used while the next is simulated.
        let (sender, supplies) = sync_channel::<Result<SequenceBatch, TrainError>>(1);
        let (training, units) = (seed.child("training"), &units);
        scope.spawn(move || {
            let batch = |number| drawn(model, config.sequences, config, units, &training.nth(number));
            (0_u64..).take_while(|&number| sender.send(batch(number)).is_ok()).count()
        });
        for step in 0..config.steps {
            let by_steps = step as f64 / config.steps as f64;
            let elapsed = config.seconds.map_or(0.0, |seconds| started.elapsed().as_secs_f64() / seconds);
            let progress = by_steps.max(elapsed);
            if progress >= 1.0 {
                break;
            }
            let Ok(batch) = supplies.recv() else { break };
            let (gain, found) = potentials.differentiate_gain(&batch?, memory)?;
            memory = found;
            let norm = memory.iter_mut().map(|part| part.gradients().norm().powi(2)).sum::<f64>().sqrt();
            if !gain.is_finite() || !norm.is_finite() {
                break;
            }
            adam.set_learning_rate(config.adam.learning_rate * Schedule::Cosine.share(progress));
            for part in &mut memory {
                if norm > config.clip_norm {
                    part.gradients().scale(config.clip_norm / norm);
                }
                adam.step(potentials.parameters_mut(), part)?;
            }
            learned.steps = step + 1;
            if (step + 1) % config.validate_every == 0 || step + 1 == config.steps {
                last = potentials.gain(&held_out)?;
                learned.validation.push((step + 1, last));
                if last > best.0 {
                    best = (last, potentials.parameters().values().clone());
                }
            }
            if observe(step, last).is_break() {
                break;
            }
        }
        Ok(())
    })?;
    *potentials.parameters_mut().values_mut() = best.1;
    learned.seconds = started.elapsed().as_secs_f64();
    Ok(learned)
}
