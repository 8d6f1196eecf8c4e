//! The training loop.

use std::ops::ControlFlow;

use motes_models::{StateGradients, Stream};
use motes_proposals::{Learnable, Workspace};
use serde::Serialize;

use crate::data::Batch;
use crate::dropout::Dropout;
use crate::fit::check_measurements;
use crate::gradient_sum::GradientSum;
use crate::penalty::{add_penalty, check_penalty};
use crate::rollout::{draw_and_differentiate, in_step};
use crate::{Adam, AdamConfig, GradientFlow, Objective, Schedule, TrainError, TrainingData};

/// The settings of training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrainConfig {
    /// What is maximised.
    pub objective: Objective,
    /// How far back in time its gradient reaches.
    pub gradient: GradientFlow,
    /// The largest Euclidean norm of the gradient of all weights. A longer gradient is scaled down to it. `None` never scales.
    pub clip_norm: Option<f64>,
    /// `K`, particles drawn in each step.
    pub particles: usize,
    /// Gradient steps, each on whole sequences.
    pub steps: usize,
    /// How many sequences a step takes, or all if there are fewer. Its objective is the mean of theirs; particles are drawn for each.
    pub sequences_per_step: usize,
    /// The optimiser.
    pub adam: AdamConfig,
    /// How its learning rate changes from step to step.
    #[serde(skip_serializing_if = "Schedule::is_constant")]
    pub schedule: Schedule,
    /// `λ`: a penalty of `λ/2 Σ w²` over the weights is added to the loss; the losses of a [`History`] are without it.
    #[serde(skip_serializing_if = "is_zero")]
    pub weight_penalty: f64,
    /// `p`: the probability that a step leaves out a hidden unit. Units of [`Psi`](motes_proposals::Psi) cannot be left out: it would be singular. Of a recurrent
    /// network, what the layer above and the outputs read is left out; what a layer remembers is not.
    #[serde(skip_serializing_if = "is_zero")]
    pub dropout: f64,
}

/// Whether a setting is at its default, at which it is not written.
fn is_zero(setting: &f64) -> bool {
    *setting == 0.0
}

impl TrainConfig {
    /// The paper's: 200 steps of Adam on the log-likelihood of the model, with `K` particles and full gradients.
    pub fn paper(particles: usize) -> Self {
        TrainConfig {
            objective: Objective::LogLikelihood,
            gradient: GradientFlow::Full,
            clip_norm: None,
            particles,
            steps: 200,
            sequences_per_step: 1,
            adam: AdamConfig::paper(),
            schedule: Schedule::Constant,
            weight_penalty: 0.0,
            dropout: 0.0,
        }
    }

    fn check(&self) -> Result<(), TrainError> {
        self.gradient.check()?;
        check_penalty(self.weight_penalty)?;
        if self.sequences_per_step == 0 {
            let name = "the number of sequences in a step";
            return Err(TrainError::Setting { name, value: "0".into(), expected: "at least 1" });
        }
        match self.clip_norm {
            Some(largest) if !(largest > 0.0 && largest.is_finite()) => Err(TrainError::Setting {
                name: "the largest norm of the gradient",
                value: largest.to_string(),
                expected: "positive and finite",
            }),
            _ => Ok(()),
        }
    }
}

/// The course of a training.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// The loss (minus the objective) before each step, on the sequences of that step.
    pub losses: Vec<f64>,
}

/// Trains `proposal` for `model` on `data`: one sequence of measurements, many, or new ones in each step.
///
/// All that is random is drawn from `stream`, so the same stream gives the same weights: which units a step leaves out, which sequences it takes, and then, for one after another,
/// the sequence if it is new, and the noise of its particles. `observe` is called with
/// the number and the loss of each step, and ends training early by breaking. The history then has fewer losses than
/// `config.steps`. The last weights are kept.
///
/// A sequence may be shorter than an unrolled proposal's horizon. The networks of later times then keep their weights.
/// [`Training`] is the same step by step.
///
/// # Errors
/// - [`TrainError::Setting`], [`TrainError::Model`] or, of many sequences, [`TrainError::Recording`] for bad input, before anything is changed.
///   New sequences are looked at in their step.
/// - [`TrainError::Diverged`] if the loss, or the last gradient, is not finite.
/// - [`TrainError::Proposal`] if the proposal fails.
pub fn train<'a>(
    proposal: &mut dyn Learnable,
    model: &dyn StateGradients,
    data: impl Into<TrainingData<'a>>,
    config: &TrainConfig,
    stream: &mut Stream,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<History, TrainError> {
    let data: TrainingData<'a> = data.into();
    let mut training = Training::new(proposal, model, data, config, stream)?;
    while !training.is_finished() {
        let step = training.history.losses.len();
        let loss = training.step(proposal)?;
        if observe(step, loss).is_break() {
            training.check_weights(proposal)?;
            break;
        }
    }
    Ok(training.history)
}

/// A training in progress, one step at a time.
///
/// Between two steps it gives a [checkpoint](Training::checkpoint), from which another [goes on](Training::resume).
pub struct Training<'a> {
    model: &'a dyn StateGradients,
    data: TrainingData<'a>,
    config: TrainConfig,
    pub(crate) adam: Adam,
    dropout: Option<Dropout>,
    /// Memory for the next step; new if the last one failed.
    workspace: Option<Workspace>,
    /// Memory for the gradients of all sequences of a step but the last; new if it was not needed or the last step failed.
    sum: Option<GradientSum>,
    pub(crate) stream: &'a mut Stream,
    pub(crate) history: History,
}

impl<'a> Training<'a> {
    /// A training before its first step. It draws all that is random from `stream`.
    ///
    /// # Errors
    /// [`TrainError::Setting`], [`TrainError::NoHiddenUnits`], [`TrainError::Model`] or [`TrainError::Recording`] for bad input.
    pub fn new<'d: 'a>(
        proposal: &dyn Learnable,
        model: &'a dyn StateGradients,
        data: impl Into<TrainingData<'d>>,
        config: &TrainConfig,
        stream: &'a mut Stream,
    ) -> Result<Self, TrainError> {
        let adam = Adam::new(&config.adam)?;
        config.check()?;
        let data = data.into();
        data.check(proposal, model, config.particles)?;
        let dropout = Dropout::new(config.dropout, proposal)?;
        let history = History::default();
        Ok(Training {
            model,
            data,
            config: *config,
            adam,
            dropout,
            workspace: None,
            sum: None,
            stream,
            history,
        })
    }

    /// The losses so far.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// The losses, at the end of the training.
    pub fn into_history(self) -> History {
        self.history
    }

    /// Whether all steps of the settings have been taken.
    pub fn is_finished(&self) -> bool {
        self.history.losses.len() >= self.config.steps
    }

    /// Takes one step with `proposal`, the same at each step, and returns the loss before it.
    ///
    /// # Errors
    /// [`TrainError::Diverged`] or [`TrainError::Proposal`], as [`train`]; [`TrainError::Optimiser`] for another proposal than before,
    /// [`TrainError::Model`] or [`TrainError::Setting`] for a new sequence that cannot be had or does not fit.
    /// A gradient that is not finite shows in the next step, and after the last step at once. A caller who stops earlier asks
    /// [`Training::check_weights`].
    pub fn step(&mut self, proposal: &mut dyn Learnable) -> Result<f64, TrainError> {
        let step = self.history.losses.len();
        // The mask comes from the stream of all that is random, whose position is all that a checkpoint needs; without dropout nothing is drawn for it.
        if let Some(dropout) = &mut self.dropout {
            dropout.leave_out(proposal.parameters_mut(), self.stream);
        }
        let found = self.mean_over_batch(proposal, step);
        if let Some(dropout) = &self.dropout {
            dropout.put_back(proposal.parameters_mut())?;
        }
        let (value, mut workspace) = found?;
        let loss = -value;
        if !loss.is_finite() {
            return Err(TrainError::Diverged { step, loss });
        }
        self.history.losses.push(loss);
        if let Some(dropout) = &self.dropout {
            dropout.pull_back(&mut workspace);
        }
        add_penalty(self.config.weight_penalty, proposal, &mut workspace);
        // A gradient that is not finite shows in the next step's loss; after the last there is none.
        if self.config.clip_norm.is_some() || self.is_finished() {
            let gradients = workspace.gradients();
            let norm = gradients.norm();
            if !norm.is_finite() {
                return Err(TrainError::Diverged { step, loss: norm });
            }
            if let Some(largest) = self.config.clip_norm
                && norm > largest
            {
                gradients.scale(largest / norm);
            }
        }
        let progress = step as f64 / self.config.steps as f64;
        self.adam.set_learning_rate(self.config.adam.learning_rate * self.config.schedule.share(progress));
        self.adam.step(proposal.parameters_mut(), &mut workspace)?;
        self.workspace = Some(workspace);
        Ok(loss)
    }

    /// The mean objective of the sequences that `step` takes, with minus its gradient in the workspace.
    fn mean_over_batch(
        &mut self,
        proposal: &dyn Learnable,
        step: usize,
    ) -> Result<(f64, Workspace), TrainError> {
        let TrainConfig { objective, gradient, particles, sequences_per_step, .. } = self.config;
        let parameters = proposal.parameters();
        let (workspace, mut sum) = (self.workspace.take(), self.sum.take());
        let mut workspace = workspace.unwrap_or_else(|| Workspace::new(parameters));
        if !workspace.fits(parameters) {
            return Err(TrainError::Optimiser { what: "the gradients of earlier steps" });
        }
        let batch = self.data.choose(sequences_per_step, self.stream);
        let (count, mut total) = (batch.len(), 0.0);
        for at in 0..count {
            if at > 0 {
                let none = || GradientSum::none(parameters.len(), parameters.values().len());
                sum.get_or_insert_with(none).take(&mut workspace);
            }
            let measurements = batch.get(at, self.stream)?;
            if matches!(batch, Batch::Fresh(..)) {
                check_measurements(proposal, self.model, &measurements, particles)?;
            }
            let (value, used) = draw_and_differentiate(
                proposal,
                self.model,
                &measurements,
                objective,
                gradient,
                particles,
                self.stream,
                workspace,
            )
            .map_err(in_step(step, self.history.losses.last().copied()))?;
            (total, workspace) = (total + value, used);
            if !total.is_finite() {
                break;
            }
        }
        if let Some(sum) = &mut sum {
            sum.mean_into(&mut workspace, count);
        }
        self.sum = sum;
        Ok((total / count as f64, workspace))
    }

    /// Refuses weights that are not finite, which the last step may have left.
    ///
    /// # Errors
    /// [`TrainError::Diverged`] if they are not all finite.
    pub fn check_weights(&self, proposal: &dyn Learnable) -> Result<(), TrainError> {
        let step = self.history.losses.len().saturating_sub(1);
        match proposal.parameters().values().are_finite() {
            true => Ok(()),
            false => Err(TrainError::Diverged { step, loss: f64::NAN }),
        }
    }

    pub(crate) fn steps(&self) -> usize {
        self.config.steps
    }
}
