//! The training loop.

use std::ops::ControlFlow;

use motes_models::batch::there_is_memory_for;
use motes_models::{Measurements, StateGradients, Stream};
use motes_proposals::{Learnable, Workspace};
use serde::Serialize;

use crate::adam::AdamSteps;
use crate::gradient_flow::GradientFlow;
use crate::rollout::{draw_and_pull, in_step};
use crate::{Objective, TrainError};

/// The settings of Adam.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AdamConfig {
    /// Step size.
    pub learning_rate: f64,
    /// Forgetting factor of the gradient's mean.
    pub beta_1: f64,
    /// Forgetting factor of its square's mean.
    pub beta_2: f64,
    /// Added to the root in the denominator.
    pub epsilon: f64,
}

impl AdamConfig {
    /// The paper's: learning rate 0.001, forgetting factors 0.9 and 0.999; ε is Adam's usual 1e-8.
    pub fn paper() -> Self {
        AdamConfig { learning_rate: 1e-3, beta_1: 0.9, beta_2: 0.999, epsilon: 1e-8 }
    }
}

/// The settings of training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrainConfig {
    /// What is maximised.
    pub objective: Objective,
    /// How far back in time its gradient reaches.
    pub gradient: GradientFlow,
    /// The largest norm of all gradients taken together: a longer one is shortened to it. `None` leaves them as they are.
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
        let AdamConfig { learning_rate, beta_1, beta_2, epsilon } = self.adam;
        let positive = |value: f64| value > 0.0 && value.is_finite();
        // The optimiser computes in 32 bits: what rounds to 1 or to 0 there is as bad as 1 or 0.
        let forgetting = |value: f64| (0.0..1.0).contains(&(value as f32));
        let checks = [
            (
                positive(f64::from(learning_rate as f32)),
                "the learning rate",
                format!("{learning_rate:?}"),
                "positive and finite in 32 bits",
            ),
            (
                forgetting(beta_1),
                "Adam's first forgetting factor",
                beta_1.to_string(),
                "at least 0 and below 1",
            ),
            (
                forgetting(beta_2),
                "Adam's second forgetting factor",
                beta_2.to_string(),
                "at least 0 and below 1",
            ),
            (
                positive(f64::from(epsilon as f32)),
                "Adam's epsilon",
                format!("{epsilon:?}"),
                "positive and finite in 32 bits",
            ),
        ];
        self.gradient.check()?;
        let clip_norm = self.clip_norm.unwrap_or(1.0);
        let checks = checks.into_iter().chain([(
            positive(clip_norm),
            "the largest norm of the gradient",
            clip_norm.to_string(),
            "positive and finite",
        )]);
        for (fine, name, value, expected) in checks {
            if !fine {
                return Err(TrainError::Setting { name, value, expected });
            }
        }
        Ok(())
    }
}

/// What happened in training.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// The loss (minus the objective) before each step.
    pub losses: Vec<f64>,
}

/// Trains `proposal` for `model` on one sequence of measurements.
///
/// The noise of each step is drawn from `stream`, so the same stream gives the same weights. `observe` is called with
/// the number and the loss of each step and ends training early by breaking; the history then has fewer losses than
/// `config.steps`. The last weights are kept. A sequence shorter than an unrolled proposal's horizon leaves the networks of later
/// times as they are. [`Training`] is the same step by step.
///
/// # Errors
/// [`TrainError::Setting`] or [`TrainError::Model`] for bad input, before anything is changed; [`TrainError::Diverged`] if
/// the loss, or the last gradient, is not finite; [`TrainError::Proposal`] if the proposal fails.
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

/// A training in progress: one step at a time, and put aside and [taken up again](Training::resume) between two of them.
pub struct Training<'a> {
    model: &'a dyn StateGradients,
    measurements: &'a Measurements,
    config: TrainConfig,
    pub(crate) adam: AdamSteps,
    /// Memory for the next step; new if the last one failed.
    workspace: Option<Workspace>,
    pub(crate) stream: &'a mut Stream,
    pub(crate) history: History,
}

impl<'a> Training<'a> {
    /// Before the first step; noise will be drawn from `stream`.
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
        config.check()?;
        check_fit(proposal, model, measurements, config.particles)?;
        let adam = AdamSteps::new(&config.adam);
        let history = History::default();
        Ok(Training { model, measurements, config: *config, adam, workspace: None, stream, history })
    }

    /// What has happened so far.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// What has happened, when there is nothing more to come.
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
    /// [`TrainError::Diverged`] or [`TrainError::Proposal`], as [`train`]. A gradient that is not finite shows in the next step, after the last
    /// of the settings' steps at once; who stops earlier can ask [`Training::check_weights`].
    pub fn step(&mut self, proposal: &mut dyn Learnable) -> Result<f64, TrainError> {
        let TrainConfig { objective, gradient, particles, .. } = self.config;
        let step = self.history.losses.len();
        let workspace = self.workspace.take().unwrap_or_else(|| Workspace::new(proposal.parameters()));
        let (model, measurements, stream) = (self.model, self.measurements, &mut *self.stream);
        let (value, mut workspace) =
            draw_and_pull(proposal, model, measurements, objective, gradient, particles, stream, workspace)
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
        self.adam.step(proposal.parameters_mut(), &mut workspace);
        self.workspace = Some(workspace);
        Ok(loss)
    }

    /// Whether the weights are fit for use, whatever the gradient of the last step was.
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

pub(crate) fn check_fit(
    proposal: &dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
    particles: usize,
) -> Result<(), TrainError> {
    measurements.check_width(model.measurement_dim())?;
    let differs =
        |name, found: usize, expected| TrainError::Setting { name, value: found.to_string(), expected };
    for (name, value) in [
        ("the number of particles K", particles),
        ("the number of measurements T", measurements.len()),
        ("the model's state dimension N", model.state_dim()),
    ] {
        if value == 0 {
            return Err(differs(name, value, "at least 1"));
        }
    }
    // States of all times and their derivatives; what networks keep of them comes on top.
    let values =
        particles.checked_mul(measurements.len()).and_then(|rows| rows.checked_mul(model.state_dim()));
    if !values.and_then(|values| values.checked_mul(2)).is_some_and(there_is_memory_for) {
        return Err(differs(
            "the number of particles K",
            particles,
            "as many as there is memory for at all times",
        ));
    }
    if proposal.state_dim() != model.state_dim() {
        return Err(differs("the proposal's state dimension", proposal.state_dim(), "that of the model"));
    }
    if proposal.measurement_dim() != model.measurement_dim() {
        let found = proposal.measurement_dim();
        return Err(differs("the proposal's measurement dimension", found, "that of the model"));
    }
    if proposal.horizon().is_some_and(|horizon| horizon < measurements.len()) {
        let name = "the number of measurements T";
        return Err(differs(name, measurements.len(), "at most the horizon of the unrolled proposal"));
    }
    Ok(())
}
