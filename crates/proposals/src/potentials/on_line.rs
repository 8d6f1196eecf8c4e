//! Potentials of steps as their measurements arrive.

use std::fmt;
use std::sync::Arc;

use motes_models::{OwnModel, Step};
use motes_smc::{ByPotential, PotentialComponent, ProposalError, StepPotentials};

use super::learned::LearnedPotentials;
use super::standards::PotentialStandards;
use super::step_memory::StepMemory;

/// Learned potentials as a filter takes them on-line.
#[derive(Clone)]
pub struct OnLinePotentials {
    potentials: Arc<LearnedPotentials>,
    standards: PotentialStandards,
    memory: StepMemory,
}

impl OnLinePotentials {
    /// The proposal of a filter of `model` that takes measurements as they come.
    ///
    /// # Errors
    /// As [`LearnedPotentials::standards`].
    pub fn proposal<M: OwnModel + ?Sized>(
        potentials: Arc<LearnedPotentials>,
        model: &M,
    ) -> Result<ByPotential<Self>, ProposalError> {
        let standards = potentials.standards(model)?;
        Ok(ByPotential::new(OnLinePotentials { potentials, standards, memory: StepMemory::default() }))
    }
}

impl fmt::Debug for OnLinePotentials {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("OnLinePotentials").finish_non_exhaustive()
    }
}

impl<M: OwnModel + ?Sized> StepPotentials<M> for OnLinePotentials {
    fn components(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<Vec<PotentialComponent>, ProposalError> {
        self.potentials.components_now(model, step, measurement, &self.standards, &mut self.memory)
    }
}
