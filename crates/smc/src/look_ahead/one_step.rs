//! Potentials on-line: of one step, from its measurement alone.

use motes_models::equations::Linearise;
use motes_models::{Step, StepRecord};

use super::ahead::{StepAhead, StepMemory, step_by};
use super::batch::LookAheadBatch;
use super::component::PotentialComponent;
use super::error::LookAheadError;
use super::recorded::RecordedStep;
use super::scratch::LookAheadScratch;
use crate::proposal::{Context, Proposal};
use crate::proposal_error::ProposalError;

/// What says of a step, when its measurement is there, which states are likely: once for all particles.
pub trait StepPotentials<M: ?Sized>: Sync {
    /// The quadratics of the potential of a step with this measurement (`M`), at least one.
    ///
    /// # Errors
    /// [`ProposalError`] if they cannot be had.
    fn components(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<Vec<PotentialComponent>, ProposalError>;
}

/// Draws noise by a potential `ψ_t` that sees `y_t` alone: from `N(v; 0, I) ψ̃_t(v; x_{t−1}) / Z̃_t(x_{t−1})`, with the weight `p(y_t | x_t) Z̃_t(x_{t−1}) / ψ̃_t(v_t; x_{t−1})`.
///
/// Particles evaluate quadratics, and whatever emits these runs once for each step.
#[derive(Debug, Clone)]
pub struct ByPotential<P> {
    source: P,
    prepared: Option<StepAhead>,
    memory: StepMemory,
}

impl<P> ByPotential<P> {
    /// By these potentials.
    pub fn new(source: P) -> Self {
        ByPotential { source, prepared: None, memory: StepMemory::default() }
    }
}

fn refused(time: usize, error: &LookAheadError) -> ProposalError {
    ProposalError::Measurement { time, reason: error.to_string() }
}

impl<M: Linearise + ?Sized, P: StepPotentials<M>> Proposal<M> for ByPotential<P> {
    type Memory = ();
    type Scratch = LookAheadScratch;
    type Conditional<'a>
        = LookAheadBatch<'a, M>
    where
        Self: 'a,
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        let noise_space = model.noise_space().ok_or(ProposalError::NoDensity)?;
        let components = self.source.components(model, step, measurement)?;
        // Nothing but this step: a filter that goes on from a checkpoint finds the same.
        let near = components.first().filter(|_| step.index > 0).map(|component| component.centre.as_slice());
        let recorded = RecordedStep { step: StepRecord::of(step), measurement: measurement.to_vec() };
        let found = step_by((model, noise_space), recorded, near, &components, &mut self.memory);
        self.prepared = Some(found.map_err(|error| refused(step.index, &error))?);
        Ok(true)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        scratch: &'a mut LookAheadScratch,
    ) -> Result<LookAheadBatch<'a, M>, ProposalError> {
        let time = context.step.index;
        let noise_space = model.noise_space().ok_or(ProposalError::NoDensity)?;
        match &self.prepared {
            Some(now) if now.step.step().index == time => {
                Ok(LookAheadBatch { model, noise_space, context, now, next: None, is_alone: true, scratch })
            }
            _ => Err(ProposalError::NotPrepared { time }),
        }
    }
}
