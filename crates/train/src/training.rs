//! The training loop.

use std::ops::ControlFlow;

use motes_models::{Measurements, StateGradients, Stream};
use motes_proposals::Learnable;

use crate::adam::AdamSteps;
use crate::rollout::{in_step, rollout};
use crate::{Objective, TrainError};

/// The settings of Adam.
#[derive(Debug, Clone, Copy, PartialEq)]
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainConfig {
    /// What is maximised.
    pub objective: Objective,
    /// `K`, particles drawn in each step.
    pub particles: usize,
    /// Gradient steps, each on the whole sequence.
    pub steps: usize,
    /// The optimiser.
    pub adam: AdamConfig,
}

impl TrainConfig {
    /// The paper's: 200 steps of Adam on the log-likelihood of the model, with `K` particles.
    pub fn paper(particles: usize) -> Self {
        TrainConfig { objective: Objective::LogLikelihood, particles, steps: 200, adam: AdamConfig::paper() }
    }

    fn check(&self) -> Result<(), TrainError> {
        let AdamConfig { learning_rate, beta_1, beta_2, epsilon } = self.adam;
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let forgetting = |value: f64| (0.0..1.0).contains(&value);
        let checks = [
            (self.particles > 0, "the number of particles K", self.particles.to_string(), "at least 1"),
            (positive(learning_rate), "the learning rate", learning_rate.to_string(), "positive and finite"),
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
            (positive(epsilon), "Adam's epsilon", epsilon.to_string(), "positive and finite"),
        ];
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
/// the number and the loss of each step, and may stop training. The last weights are kept.
///
/// # Errors
/// [`TrainError::Setting`] or [`TrainError::Model`] for bad input, before anything is changed; [`TrainError::Diverged`] if
/// the loss is not finite; [`TrainError::Proposal`] if the proposal fails; [`TrainError::Stopped`] if `observe` breaks.
pub fn train(
    proposal: &mut dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
    config: &TrainConfig,
    stream: &mut Stream,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<History, TrainError> {
    config.check()?;
    measurements.check_width(model.measurement_dim())?;
    check_fit(proposal, model, measurements)?;
    let mut adam = AdamSteps::new(&config.adam, proposal.parameters().len());
    let mut history = History::default();
    for step in 0..config.steps {
        let drawn = rollout(proposal, model, measurements, config.objective, config.particles, stream)
            .map_err(in_step(step))?;
        let loss = -drawn.objective;
        if !loss.is_finite() {
            return Err(TrainError::Diverged { step, loss });
        }
        history.losses.push(loss);
        adam.step(proposal.parameters_mut(), &drawn.gradients);
        if observe(step, loss).is_break() {
            return Err(TrainError::Stopped { steps: step + 1 });
        }
    }
    Ok(history)
}

fn check_fit(
    proposal: &dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
) -> Result<(), TrainError> {
    let differs =
        |name, found: usize, expected| TrainError::Setting { name, value: found.to_string(), expected };
    if proposal.state_dim() != model.state_dim() {
        return Err(differs("the proposal's state dimension", proposal.state_dim(), "that of the model"));
    }
    if proposal.measurement_dim() != model.measurement_dim() {
        let found = proposal.measurement_dim();
        return Err(differs("the proposal's measurement dimension", found, "that of the model"));
    }
    if proposal.horizon().is_some_and(|horizon| horizon < measurements.len()) {
        let name = "the number of measurements";
        return Err(differs(name, measurements.len(), "at most the horizon of the unrolled proposal"));
    }
    Ok(())
}
