//! A Gaussian family in a filter.

use motes_models::StateSpaceModel;
use motes_smc::{Past, Proposal, ProposalError};

use super::{GaussianBatch, GaussianProposal, Hidden, Known, Networks};
use crate::affine::Weights;
use crate::backend::to_host;

impl<M: StateSpaceModel + ?Sized, F: Networks, Config: Clone> Proposal<M> for GaussianProposal<F, Config> {
    type Memory = Hidden;
    type Conditional<'a>
        = &'a mut GaussianBatch
    where
        F: 'a,
        Config: 'a,
        M: 'a;

    fn initial_memory(&self, particles: usize) -> Hidden {
        Hidden::zeros(self.parameters.compute(), particles, &self.networks.hidden_widths())
    }

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        memory: &mut Hidden,
    ) -> Result<&'a mut GaussianBatch, ProposalError> {
        ProposalError::unless_same("the state dimension N", self.state_dim, model.state_dim())?;
        let (previous, measurement) = self.known(&past)?;
        let known = Known { previous, measurement, hidden: &memory.tensors };
        let emission =
            self.networks.forward(&mut Weights::plain(self.parameters.tensors()), past.time, known);
        memory.tensors = emission.hidden;
        let means = to_host(emission.means)?;
        let lowers = self.covariance()?.factors(&to_host(emission.representations)?)?;
        self.conditional = GaussianBatch::new(self.state_dim, means, lowers);
        Ok(&mut self.conditional)
    }
}
