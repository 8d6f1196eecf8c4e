//! Training the proposal of a unit.

use std::time::Instant;

use motes_proposals::{Backend, Family};
use motes_train::{AdamConfig, GradientFlow, History, Objective, TrainConfig, Training};

use super::{Run, UnitError, failed};
use crate::checkpoint::Checkpoint;
use crate::config;
use crate::say::news;

impl Run<'_> {
    /// Draws initial weights and trains them on the problem's measurements; the last value is the seconds that training took.
    pub(super) fn train<F: Family>(
        self,
        family: &F::Config,
        config: &TrainConfig,
        backend: config::Backend,
    ) -> Result<(F, History, f64), UnitError> {
        let backend = match backend {
            config::Backend::Native => Backend::Native,
            config::Backend::Flex => Backend::Flex,
            config::Backend::Ndarray => Backend::NdArray,
        };
        let (model, seed) = (&*self.problem.model, self.unit.own_seed());
        let (horizon, weights) = (self.unit.system.horizon(), seed.child("weights"));
        let mut proposal = F::create(family, model, horizon, backend.into(), &weights).map_err(failed)?;
        let mut stream = seed.child("training").stream();
        let measurements = &self.problem.trajectory.measurements;
        let mut training =
            Training::new(&proposal, model, measurements, config, &mut stream).map_err(failed)?;
        let mut checkpoint =
            self.evaluator.checkpoints.as_ref().map(|units| Checkpoint::of(units, &self.unit.key()));
        let mut earlier = 0.0;
        if let Some((seconds, bytes)) = checkpoint.as_ref().and_then(Checkpoint::read) {
            match training.resume(&mut proposal, &bytes) {
                Ok(()) => earlier = seconds,
                Err(error) => news(&format!("{error}; the training begins anew")),
            }
        }
        let start = Instant::now();
        let seconds = || earlier + start.elapsed().as_secs_f64();
        loop {
            let stopping = self.interrupt.check().is_break();
            // A training that is finished is followed by filters, which may take long, too.
            if let Some(checkpoint) = &mut checkpoint
                && checkpoint.is_due(stopping || training.is_finished())
            {
                let bytes = training.suspend(&proposal).map_err(failed)?;
                checkpoint.write(seconds(), &bytes).map_err(UnitError::NotKept)?;
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
        Ok((proposal, history, seconds()))
    }
}

pub(super) fn train_config(training: &config::Training, particles: usize, steps: usize) -> TrainConfig {
    TrainConfig {
        objective: match training.objective {
            config::Objective::LogLikelihood => Objective::LogLikelihood,
            config::Objective::Literal => Objective::Literal,
            config::Objective::Elbo => Objective::Elbo,
        },
        gradient: match (training.gradient, training.gradient_window) {
            (config::Gradient::Truncated, Some(window)) => GradientFlow::Truncated { window },
            _ => GradientFlow::Full,
        },
        clip_norm: training.clip_norm,
        particles,
        steps,
        adam: AdamConfig {
            learning_rate: training.learning_rate,
            beta_1: training.beta_1,
            beta_2: training.beta_2,
            epsilon: training.epsilon,
        },
    }
}
