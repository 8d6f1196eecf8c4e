//! A Gaussian family in a filter.

use motes_models::StateSpaceModel;
use motes_smc::{Past, Proposal, ProposalError};

use super::{GaussianBatch, GaussianProposal, Hidden, Networks};
use crate::plain::Library;
use crate::{native, plain};

impl<M: StateSpaceModel + ?Sized, F: Networks, Config: Clone> Proposal<M> for GaussianProposal<F, Config> {
    type Memory = Hidden;
    type Conditional<'a>
        = &'a mut GaussianBatch
    where
        F: 'a,
        Config: 'a,
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
        let GaussianProposal { networks, parameters, conditional, representations, inference, .. } = self;
        let values = past.particles * self.state_dim;
        representations.resize(values, 0.0);
        let (means, lowers) = conditional.places(self.state_dim, past.particles);
        let hidden = &mut memory.values;
        match Library::of(parameters) {
            None => native::infer(networks, parameters, &past, hidden, inference, means, representations),
            Some(library) => {
                plain::infer(&library, networks, parameters, &past, hidden, means, representations)?;
            }
        }
        covariance.factor(representations, lowers)?;
        Ok(conditional)
    }
}
