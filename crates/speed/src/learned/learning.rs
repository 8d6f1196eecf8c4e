//! Gradient steps of the inclusive objective: what `motes_train::learn` does between two simulations.

use std::ops::ControlFlow;

use motes_models::ModelShape;
use motes_models::equations::Equations;
use motes_proposals::{Amortised, Backend, Parametric, Stage, Times, Workspace, load};
use motes_train::{Adam, LearnConfig, learn};

use super::folder::batches;
use crate::folder::seed;
use crate::task::{Answer, LearnTask};
use crate::work::Work;

pub(super) struct Learning<M> {
    model: M,
    task: LearnTask,
    proposal: Amortised,
    /// Encoded before any step is timed, for us and for others.
    batches: Vec<Stage>,
    adam: Adam,
    workspace: Option<Workspace>,
    /// Loss and gradient norm of the first batch, at the weights that were given.
    at_first: (f64, f64),
}

impl<M: Equations> Learning<M> {
    pub(super) fn of(model: M, task: &LearnTask) -> Result<Self, String> {
        let proposal: Amortised =
            load(&task.folder, &model, &ModelShape::of(&model), Backend::Native.into()).map_err(told)?;
        let batches = batches(&proposal, &model).map_err(told)?;
        let mut learning = Learning {
            adam: Adam::new(&LearnConfig::new().adam).map_err(told)?,
            model,
            task: task.clone(),
            workspace: None,
            proposal,
            batches,
            at_first: (f64::NAN, f64::NAN),
        };
        let (loss, mut workspace) = learning.differentiate(0)?;
        learning.at_first = (loss, workspace.gradients().norm());
        Ok(learning)
    }

    fn differentiate(&mut self, batch: usize) -> Result<(f64, Workspace), String> {
        let memory = self.workspace.take().unwrap_or_else(|| Workspace::new(self.proposal.parameters()));
        let batch = &self.batches[batch % self.batches.len()];
        let floor = LearnConfig::new().floor;
        let (gain, found) =
            self.proposal.differentiate_gain(Times::Later, batch, floor, memory).map_err(told)?;
        Ok((-gain, found))
    }

    fn step(&mut self, batch: usize) -> Result<(), String> {
        let (_, mut found) = self.differentiate(batch)?;
        let gradients = found.gradients();
        let (norm, largest) = (gradients.norm(), LearnConfig::new().clip_norm);
        if norm > largest {
            gradients.scale(largest / norm);
        }
        self.adam.step(self.proposal.parameters_mut(), &mut found).map_err(told)?;
        self.workspace = Some(found);
        Ok(())
    }

    /// All of it: simulations, steps for both networks, validation.
    fn learn(&self) -> Result<(), String> {
        let config = LearnConfig { steps: self.task.steps, ..LearnConfig::new() };
        let mut proposal = self.proposal.clone();
        let proceed = |_, _| ControlFlow::Continue(());
        learn(&mut proposal, &self.model, &[], &config, &seed().child("learn"), proceed)
            .map(|_| ())
            .map_err(told)
    }
}

impl<M: Equations> Work for Learning<M> {
    fn check(&mut self) -> Result<Answer, String> {
        let (loss, norm) = self.at_first;
        Ok(Answer { loss: Some(loss), gradient_norm: Some(norm), ..Answer::default() })
    }

    fn run(&mut self) -> Result<(), String> {
        match self.task.simulates {
            true => self.learn(),
            false => (0..self.task.steps).try_for_each(|step| self.step(step)),
        }
    }
}

fn told(error: impl ToString) -> String {
    error.to_string()
}
