//! Training the proposal of a unit.

use std::time::Instant;

use motes_cli::status;
use motes_proposals::{Backend, Family, Learnable};
use motes_train::{AdamConfig, GradientFlow, History, TrainConfig, TrainError, Training};

use super::run::Run;
use crate::checkpoint::{Checkpoint, Saved};
use crate::config::{self, Gradient};
use crate::provenance::Provenance;
use crate::unit_error::{UnitError, failed};

impl Run<'_> {
    /// Draws initial weights and trains them on the problem's measurements.
    pub(super) fn train<F: Family + Learnable>(
        self,
        family: &F::Config,
        config: &TrainConfig,
        backend: Backend,
    ) -> Result<TrainingResult<F>, UnitError> {
        let (model, seed) = (&*self.problem.model, self.unit.own_seed());
        let (horizon, weights) = (self.unit.system.horizon(), seed.child("weights"));
        let mut proposal =
            F::create(family, &self.problem.shape, horizon, backend.into(), &weights).map_err(failed)?;
        let mut stream = seed.child("training").stream();
        let measurements = &self.problem.trajectory.measurements;
        let mut training =
            Training::new(&proposal, model, measurements, config, &mut stream).map_err(failed)?;
        let mut checkpoint = self.checkpoints.map(|checkpoints| checkpoints.of(&self.unit.key()));
        let (mut seconds_before, mut earlier) = (0.0, vec![]);
        if let Some(Saved { seconds, provenances, training: bytes }) =
            checkpoint.as_ref().and_then(Checkpoint::read)
        {
            match training.resume(&mut proposal, &bytes) {
                Ok(()) => (seconds_before, earlier) = (seconds, provenances),
                Err(error) => status(&format!("{error}; the training begins anew")),
            }
        }
        let start = Instant::now();
        let seconds = || seconds_before + start.elapsed().as_secs_f64();
        loop {
            let stopping = self.interrupt.check().is_break();
            // A training that is finished is followed by filters, which may take long, too.
            if let Some(checkpoint) = &mut checkpoint
                && checkpoint.is_due(stopping || training.is_finished())
            {
                match training.checkpoint(&proposal) {
                    Ok(bytes) => checkpoint.write(seconds(), &earlier, &bytes).map_err(UnitError::NotKept)?,
                    // The next step will say so, as it does where there are no checkpoints.
                    Err(TrainError::Diverged { .. }) => {}
                    Err(error) => return Err(failed(error)),
                }
            }
            if stopping {
                return Err(UnitError::Interrupted);
            }
            if training.is_finished() {
                break;
            }
            training.step(&mut proposal).map_err(failed)?;
        }
        let history = training.into_history();
        Ok(TrainingResult { proposal, history, seconds: seconds(), earlier })
    }
}

/// A training that has ended.
pub(super) struct TrainingResult<F> {
    pub(super) proposal: F,
    pub(super) history: History,
    /// How long it took, all parts of it.
    pub(super) seconds: f64,
    /// What computed all parts but the last, one after the other.
    pub(super) earlier: Vec<Provenance>,
}

pub(super) fn train_config(training: &config::Training, particles: usize, steps: usize) -> TrainConfig {
    TrainConfig {
        objective: training.objective,
        gradient: match (training.gradient, training.gradient_window) {
            (Gradient::Truncated, Some(window)) => GradientFlow::Truncated { window },
            _ => GradientFlow::Full,
        },
        clip_norm: training.clip_norm,
        particles,
        steps,
        sequences_per_step: 1,
        adam: AdamConfig {
            learning_rate: training.learning_rate,
            beta_1: training.beta_1,
            beta_2: training.beta_2,
            epsilon: training.epsilon,
        },
        schedule: training.schedule.unwrap_or_default(),
        weight_penalty: training.weight_penalty.unwrap_or(0.0),
        dropout: training.dropout.unwrap_or(0.0),
    }
}
