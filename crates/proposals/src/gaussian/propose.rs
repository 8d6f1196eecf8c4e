//! A Gaussian family in a filter.

use motes_models::StateSpaceModel;
use motes_smc::{Past, Proposal, ProposalError};

use super::batch::GaussianBatch;
use super::hidden::Hidden;
use super::networks::GaussianNetworks;
use super::proposal::GaussianProposal;
use crate::settings::of_networks;

impl<M: StateSpaceModel + ?Sized, F: GaussianNetworks> Proposal<M> for GaussianProposal<F> {
    type Memory = Hidden;
    type Conditional<'a>
        = &'a mut GaussianBatch
    where
        F: 'a,
        M: 'a;

    fn initial_memory(&self, particles: usize) -> Hidden {
        let precision = self.parameters.compute().precision;
        Hidden::zeros(precision, particles, &self.networks.hidden_widths())
    }

    fn memory_per_particle(&self) -> usize {
        Hidden::per_particle(self.parameters.compute().precision, &self.networks.hidden_widths())
    }

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        memory: &mut Hidden,
    ) -> Result<&'a mut GaussianBatch, ProposalError> {
        ProposalError::unless_same("the state dimension N", self.state_dim, model.state_dim())?;
        self.check(&past)?;
        let covariance = self.covariance()?;
        let inputs = self.inputs(&past);
        let GaussianProposal { networks, parameters, conditional, representations, inference, .. } = self;
        representations.resize(past.particles * self.state_dim, 0.0);
        let (means, lowers) = conditional.places(self.state_dim, past.particles);
        let outputs = &mut [means, representations.as_mut_slice()];
        inference.run(networks, parameters, &inputs, &mut memory.slices(), outputs).map_err(of_networks)?;
        covariance.factor(representations, lowers)?;
        Ok(conditional)
    }
}
