//! The bootstrap proposal: the model's own transition.

use motes_models::{StateSpaceModel, Step, Stream};

use crate::proposal::{Conditional, Context, Proposal};
use crate::proposal_error::ProposalError;

/// `q(x_t | x_{t−1}, y_t) = p(x_t | x_{t−1})`, blind to the measurement; weights are likelihoods.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bootstrap;

impl<M: StateSpaceModel + ?Sized> Proposal<M> for Bootstrap {
    type Memory = ();
    type Scratch = ();
    type Conditional<'a>
        = Transition<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        _model: &M,
        _step: &Step<'_>,
        _measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        Ok(true)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        (): &'a mut (),
    ) -> Result<Transition<'a, M>, ProposalError> {
        Ok(Transition { model, context })
    }
}

/// `p(x_t | x_{t−1})`, or `p(x_0)` where there is no past.
pub struct Transition<'a, M: ?Sized> {
    model: &'a M,
    context: Context<'a>,
}

impl<'a, M: StateSpaceModel + ?Sized> Transition<'a, M> {
    /// That of the particles in `context`.
    pub fn new(model: &'a M, context: Context<'a>) -> Self {
        Transition { model, context }
    }
}

impl<M: StateSpaceModel + ?Sized> Conditional for Transition<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], _log_density: &mut [f64]) {
        self.model.sample_states(&self.context.step, self.context.previous, streams, states);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        match self.model.density() {
            Some(density) => {
                density.log_densities(&self.context.step, self.context.previous, states, log_density);
            }
            None => log_density.fill(f64::NAN),
        }
    }

    fn is_transition(&self) -> bool {
        true
    }
}
