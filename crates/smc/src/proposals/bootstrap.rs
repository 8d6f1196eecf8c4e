//! The bootstrap proposal: the model's own transition.

use motes_models::{StateSpaceModel, Stream};

use crate::{Conditional, Past, Proposal, ProposalError, particles_by_stream};

/// `q(x_t | x_{t−1}, y_t) = p(x_t | x_{t−1})`, blind to the measurement; weights are likelihoods.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bootstrap;

impl<M: StateSpaceModel + ?Sized> Proposal<M> for Bootstrap {
    type Memory = ();
    type Conditional<'a>
        = Transition<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        _memory: &mut (),
    ) -> Result<Transition<'a, M>, ProposalError> {
        Ok(Transition { model, past })
    }
}

/// `p(x_t | x_{t−1})`, or `p(x_0)` where there is no past.
pub struct Transition<'a, M: ?Sized> {
    pub(crate) model: &'a M,
    pub(crate) past: Past<'a>,
}

impl<M: StateSpaceModel + ?Sized> Conditional for Transition<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], _log_density: &mut [f64]) {
        let (width, time) = (self.model.state_dim(), self.past.time);
        let mut row = 0;
        for (stream, states) in particles_by_stream(streams, states, width, self.past.particles) {
            for state in states.chunks_exact_mut(width) {
                match self.past.previous {
                    None => self.model.sample_initial(stream, state),
                    Some(previous) => {
                        let previous = &previous[row * width..(row + 1) * width];
                        self.model.sample_transition(time, previous, stream, state);
                    }
                }
                row += 1;
            }
        }
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        match self.past.previous {
            None => self.model.log_initials(states, log_density),
            Some(previous) => self.model.log_transitions(self.past.time, previous, states, log_density),
        }
    }

    fn is_transition(&self) -> bool {
        true
    }
}
