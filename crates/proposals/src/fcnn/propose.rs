//! The fully connected proposal in a filter.

use motes_models::StateSpaceModel;
use motes_smc::{Past, Proposal, ProposalError};

use super::Fcnn;
use crate::GaussianBatch;
use crate::backend::to_host;

impl<M: StateSpaceModel + ?Sized> Proposal<M> for Fcnn {
    type Memory = ();
    type Conditional<'a>
        = &'a mut GaussianBatch
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        _memory: &mut (),
    ) -> Result<&'a mut GaussianBatch, ProposalError> {
        let (found, expected) = (self.state_dim, model.state_dim());
        if found != expected {
            return Err(ProposalError::Mismatch { what: "the state dimension N", found, expected });
        }
        let shape = [past.particles, self.state_dim + self.measurement_dim];
        let inputs = self.parameters.compute().tensor(&self.inputs(&past)?, shape);
        let weights = self.parameters.tensors();
        let means = to_host(self.means[past.time].forward(weights, inputs.clone()))?;
        let representations = to_host(self.representation.forward(weights, inputs))?;
        let lowers = self.covariance()?.factors(&representations)?;
        self.conditional = GaussianBatch::new(self.state_dim, means, lowers);
        Ok(&mut self.conditional)
    }
}
