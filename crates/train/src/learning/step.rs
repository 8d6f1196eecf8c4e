//! One gradient step of learning once: dropout around the gradient, the penalty, a norm that is bounded, Adam.

use motes_models::{Seed, Stream};
use motes_proposals::{Amortised, Parametric, Workspace};

use super::settings::LearnConfig;
use crate::dropout::Dropout;
use crate::penalty::add_penalty;
use crate::{Adam, AdamConfig, Schedule, TrainError};

/// The learning rate after a new beginning, as a share of that before.
const SHORTER: f64 = 0.25;

/// What steps are taken with.
pub(super) struct Stepper {
    adam: Adam,
    dropout: Option<Dropout>,
    /// Masks of dropout come from it, and nothing else does.
    masks: Stream,
    workspace: Option<Workspace>,
    penalty: f64,
    clip_norm: f64,
    adam_config: AdamConfig,
}

impl Stepper {
    pub(super) fn new(
        config: &LearnConfig,
        proposal: &Amortised,
        training: &Seed,
    ) -> Result<Self, TrainError> {
        Ok(Stepper {
            adam: Adam::new(&config.adam)?,
            dropout: Dropout::new(config.dropout, proposal)?,
            masks: training.child("dropout").stream(),
            workspace: Some(Workspace::new(proposal.parameters())),
            penalty: config.weight_penalty,
            clip_norm: config.clip_norm,
            adam_config: config.adam,
        })
    }

    /// Sets the learning rate for a share of all progress: it falls to 0 along half a cosine.
    pub(super) fn set_progress(&mut self, progress: f64) {
        self.adam.set_learning_rate(self.adam_config.learning_rate * Schedule::Cosine.share(progress));
    }

    /// Forgets the moments of all steps so far; the next ones are a quarter as long.
    pub(super) fn begin_again(&mut self) -> Result<(), TrainError> {
        self.adam_config.learning_rate *= SHORTER;
        self.adam = Adam::new(&self.adam_config)?;
        Ok(())
    }

    /// Leaves out hidden units until [`Stepper::finish`] puts them back.
    pub(super) fn begin(&mut self, proposal: &mut Amortised) {
        if let Some(dropout) = &mut self.dropout {
            dropout.leave_out(proposal.parameters_mut(), &mut self.masks);
        }
    }

    /// Differentiates a loss at the weights that [`Stepper::begin`] left, and takes the step. What was maximised comes back; nothing if
    /// it or the gradient is not finite, and no weight has changed then.
    pub(super) fn finish(
        &mut self,
        proposal: &mut Amortised,
        differentiate: impl FnOnce(&Amortised, Workspace) -> Result<(f64, Workspace), TrainError>,
    ) -> Result<Option<f64>, TrainError> {
        let memory = self.workspace.take().unwrap_or_else(|| Workspace::new(proposal.parameters()));
        let found = differentiate(proposal, memory);
        if let Some(dropout) = &self.dropout {
            dropout.put_back(proposal.parameters_mut())?;
        }
        let (value, mut workspace) = found?;
        if let Some(dropout) = &self.dropout {
            dropout.pull_back(&mut workspace);
        }
        add_penalty(self.penalty, proposal, &mut workspace);
        let gradients = workspace.gradients();
        let norm = gradients.norm();
        let is_finite = value.is_finite() && norm.is_finite();
        if is_finite {
            if norm > self.clip_norm {
                gradients.scale(self.clip_norm / norm);
            }
            self.adam.step(proposal.parameters_mut(), &mut workspace)?;
        }
        self.workspace = Some(workspace);
        Ok(is_finite.then_some(value))
    }
}
