//! The training loop.

use std::ops::ControlFlow;

use motes_models::{Measurements, StateGradients, Stream};
use motes_proposals::{Learnable, Workspace};
use serde::Serialize;

use crate::fit::check_fit;
use crate::rollout::{draw_and_differentiate, in_step};
use crate::{Adam, AdamConfig, GradientFlow, Objective, TrainError};

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
    /// Gradient steps, each on the whole sequence.
    pub steps: usize,
    /// The optimiser.
    pub adam: AdamConfig,
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
            adam: AdamConfig::paper(),
        }
    }

    fn check(&self) -> Result<(), TrainError> {
        self.gradient.check()?;
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
    /// The loss (minus the objective) before each step.
    pub losses: Vec<f64>,
}

/// Trains `proposal` for `model` on one sequence of measurements.
///
/// The noise of each step is drawn from `stream`, so the same stream gives the same weights. `observe` is called with
/// the number and the loss of each step, and ends training early by breaking. The history then has fewer losses than
/// `config.steps`. The last weights are kept.
///
/// A sequence may be shorter than an unrolled proposal's horizon. The networks of later times then keep their weights.
/// [`Training`] is the same step by step.
///
/// # Errors
/// - [`TrainError::Setting`] or [`TrainError::Model`] for bad input, before anything is changed.
/// - [`TrainError::Diverged`] if the loss, or the last gradient, is not finite.
/// - [`TrainError::Proposal`] if the proposal fails.
pub fn train(
    proposal: &mut dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
    config: &TrainConfig,
    stream: &mut Stream,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<History, TrainError> {
    let mut training = Training::new(proposal, model, measurements, config, stream)?;
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
    measurements: &'a Measurements,
    config: TrainConfig,
    pub(crate) adam: Adam,
    /// Memory for the next step; new if the last one failed.
    workspace: Option<Workspace>,
    pub(crate) stream: &'a mut Stream,
    pub(crate) history: History,
}

impl<'a> Training<'a> {
    /// A training before its first step. It draws its noise from `stream`.
    ///
    /// # Errors
    /// [`TrainError::Setting`] or [`TrainError::Model`] for bad input.
    pub fn new(
        proposal: &dyn Learnable,
        model: &'a dyn StateGradients,
        measurements: &'a Measurements,
        config: &TrainConfig,
        stream: &'a mut Stream,
    ) -> Result<Self, TrainError> {
        let adam = Adam::new(&config.adam)?;
        config.check()?;
        check_fit(proposal, model, measurements, config.particles)?;
        let history = History::default();
        Ok(Training { model, measurements, config: *config, adam, workspace: None, stream, history })
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
    /// [`TrainError::Diverged`] or [`TrainError::Proposal`], as [`train`]; [`TrainError::Optimiser`] for another proposal than before.
    /// A gradient that is not finite shows in the next step, and after the last step at once. A caller who stops earlier asks
    /// [`Training::check_weights`].
    pub fn step(&mut self, proposal: &mut dyn Learnable) -> Result<f64, TrainError> {
        let TrainConfig { objective, gradient, particles, .. } = self.config;
        let step = self.history.losses.len();
        let workspace = self.workspace.take().unwrap_or_else(|| Workspace::new(proposal.parameters()));
        let (model, measurements, stream) = (self.model, self.measurements, &mut *self.stream);
        let (value, mut workspace) = draw_and_differentiate(
            proposal,
            model,
            measurements,
            objective,
            gradient,
            particles,
            stream,
            workspace,
        )
        .map_err(in_step(step, self.history.losses.last().copied()))?;
        let loss = -value;
        if !loss.is_finite() {
            return Err(TrainError::Diverged { step, loss });
        }
        self.history.losses.push(loss);
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
        self.adam.step(proposal.parameters_mut(), &mut workspace)?;
        self.workspace = Some(workspace);
        Ok(loss)
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
