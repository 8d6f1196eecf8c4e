//! The bootstrap proposal: the model's own transition.

use motes_models::{StateSpaceModel, Stream};

use crate::{Conditional, Past, Proposal, ProposalError, RowPast, RowProposal};

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

    fn by_rows(
        &mut self,
        _model: &M,
        _time: usize,
        _measurement: &[f64],
    ) -> Result<Option<&dyn RowProposal<M>>, ProposalError> {
        Ok(Some(self))
    }
}

impl<M: StateSpaceModel + ?Sized> RowProposal<M> for Bootstrap {
    fn draw(
        &self,
        model: &M,
        past: RowPast<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
    ) {
        let RowPast { time, measurement, previous } = past;
        // Transition and proposal cancel: the likelihood is all that is left.
        match previous {
            Some(previous) => model.propagate(time, previous, measurement, streams, states, increments),
            None => {
                model.sample_initials(streams, states);
                model.log_likelihoods(time, states, measurement, increments);
            }
        }
    }

    fn is_transition(&self) -> bool {
        true
    }
}

/// `p(x_t | x_{t−1})`, or `p(x_0)` where there is no past.
pub struct Transition<'a, M: ?Sized> {
    pub(crate) model: &'a M,
    pub(crate) past: Past<'a>,
}

impl<M: StateSpaceModel + ?Sized> Conditional for Transition<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], _log_density: &mut [f64]) {
        match self.past.previous {
            None => self.model.sample_initials(streams, states),
            Some(previous) => {
                self.model.sample_transitions(self.past.time, previous, streams, states);
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
