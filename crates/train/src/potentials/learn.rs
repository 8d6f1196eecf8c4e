//! Gradient steps on fresh sequences, judged by others.

use std::ops::ControlFlow;
use std::sync::mpsc::sync_channel;
use std::time::Instant;

use motes_models::{OwnModel, Seed};
use motes_proposals::{LearnedPotentials, Parametric, PathBatch, Workspace};

use super::settings::PotentialLearnConfig;
use super::supply::PathSource;
use crate::{Adam, Schedule, TrainError};

/// Sequences by which weights are judged.
const VALIDATION: usize = 64;

/// The gain, in nats for a step, that learning comes to within its patience or ends.
const LEAST_GAIN: f64 = 0.01;

/// What came of learning.
#[derive(Debug, Clone, PartialEq)]
pub struct PotentialHistory {
    /// Steps that were taken.
    pub steps: usize,
    /// The gains on validation sequences after so many steps, in nats for a step of a sequence: of potentials that see all measurements, and of those that see that of their step.
    pub validation: Vec<(usize, [f64; 2])>,
    /// How long it took.
    pub seconds: f64,
}

impl PotentialHistory {
    /// The gains of the weights that were kept.
    pub fn best_gains(&self) -> [f64; 2] {
        let best = self.validation.iter().max_by(|(_, a), (_, b)| sum(*a).total_cmp(&sum(*b)));
        best.map_or([f64::NAN; 2], |(_, gains)| *gains)
    }
}

/// By what weights are chosen.
fn sum([ahead, now]: [f64; 2]) -> f64 {
    ahead + now
}

/// The Euclidean norm of gradients in several parts.
fn norm(parts: &mut [Workspace]) -> f64 {
    parts.iter_mut().map(|part| part.gradients().norm().powi(2)).sum::<f64>().sqrt()
}

/// Learns potentials of any sequence of a model, or of several, from sequences that they draw for themselves, by maximising the mean of `log ψ_t(x_t) − log Z_t(x_{t−1})`: the inclusive Kullback–Leibler
/// divergence from the model's own path, given all measurements, but for its sign and a constant.
///
/// Potentials that see the measurement of their step alone are learned from the same sequences, by networks of their own.
///
/// The weights with the best sum of gains on validation sequences are kept. A step whose gain or gradient is not finite ends learning. The same seed gives the same weights, unless there is a
/// budget in seconds. `observe` is shown each step with the last figure of validation, and ends learning by breaking.
///
/// # Errors
/// - [`TrainError::Setting`] for bad settings, [`TrainError::Simulations`] for a model whose simulations overflow.
/// - [`TrainError::Model`] for a model that cannot be simulated.
/// - [`TrainError::Networks`] if the networks fail.
pub fn learn_potentials<M: OwnModel + ?Sized>(
    potentials: &mut LearnedPotentials,
    source: PathSource<'_, M>,
    config: &PotentialLearnConfig,
    seed: &Seed,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<PotentialHistory, TrainError> {
    config.check()?;
    let mut adam = Adam::new(&config.adam)?;
    let started = Instant::now();
    let source = source.prepared(config.horizon)?;
    match source.standards() {
        Some(standards) => potentials.set_standards(standards)?,
        None => potentials.standardise_each_model(config.horizon),
    }
    let held_out = source.drawn(VALIDATION, config, &seed.child("validation"))?;
    let mut last = potentials.gains(&held_out)?;
    let mut learned = PotentialHistory { steps: 0, validation: vec![(0, last)], seconds: 0.0 };
    let mut best = (sum(last), potentials.parameters().values().clone());
    let mut memory = [0, 1, 2, 3].map(|_| Workspace::new(potentials.parameters()));
    std::thread::scope(|scope| -> Result<(), TrainError> {
        // One batch is used while the next is simulated.
        let (sender, supplies) = sync_channel::<Result<PathBatch, TrainError>>(1);
        let (training, source) = (seed.child("training"), &source);
        scope.spawn(move || {
            let batch = |number| source.drawn(config.sequences, config, &training.nth(number));
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
            let (gains, found) = potentials.differentiate_gains(&batch?, memory)?;
            memory = found;
            // What sees all measurements and what sees those of a step share no weight.
            let (ahead, now) = memory.split_at_mut(3);
            let norms = [norm(ahead), norm(now)];
            if !sum(gains).is_finite() || !sum(norms).is_finite() {
                break;
            }
            adam.set_learning_rate(config.adam.learning_rate * Schedule::Cosine.share(progress));
            for (parts, norm) in [ahead, now].into_iter().zip(norms) {
                for part in parts {
                    if norm > config.clip_norm {
                        part.gradients().scale(config.clip_norm / norm);
                    }
                    adam.step(potentials.parameters_mut(), part)?;
                }
            }
            learned.steps = step + 1;
            if (step + 1) % config.validate_every == 0 || step + 1 == config.steps {
                last = potentials.gains(&held_out)?;
                learned.validation.push((step + 1, last));
                if sum(last) > best.0 {
                    best = (sum(last), potentials.parameters().values().clone());
                }
            }
            let has_failed = step + 1 >= config.patience && best.0 < LEAST_GAIN;
            if has_failed || observe(step, sum(last)).is_break() {
                break;
            }
        }
        Ok(())
    })?;
    *potentials.parameters_mut().values_mut() = best.1;
    learned.seconds = started.elapsed().as_secs_f64();
    Ok(learned)
}
