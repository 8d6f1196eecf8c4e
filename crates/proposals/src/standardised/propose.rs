//! A standardised family in a filter.

use motes_models::{StateSpaceModel, Stream};
use motes_smc::{Conditional, Past, Proposal, ProposalError};

use super::{Frame, Scratch, Standardised};
use crate::family::Family;

impl<M: StateSpaceModel + ?Sized, F: Family + Proposal<M>> Proposal<M> for Standardised<F> {
    type Memory = F::Memory;
    type Conditional<'a>
        = InFrame<'a, F::Conditional<'a>>
    where
        F: 'a,
        M: 'a;

    fn initial_memory(&self, particles: usize) -> F::Memory {
        self.proposal.initial_memory(particles)
    }

    fn memory_per_particle(&self) -> usize {
        self.proposal.memory_per_particle()
    }

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        memory: &mut F::Memory,
    ) -> Result<Self::Conditional<'a>, ProposalError> {
        let (n, m) = (self.proposal.state_dim(), self.proposal.measurement_dim());
        ProposalError::unless_same("the state dimension N", n, model.state_dim())?;
        ProposalError::unless_same("the measurement dimension M", m, past.measurement.len())?;
        let Standardised { proposal, config, scratch: Scratch { inputs, origins, outputs } } = self;
        let frame = config.frames.at(past.time)?;
        frame.enter(&past, inputs, origins);
        Ok(InFrame {
            inner: proposal.condition(model, inputs.past(&past), memory)?,
            frame,
            log_volume: frame.log_volume(),
            origins,
            outputs,
        })
    }
}

/// The conditional of a [`Standardised`] family.
pub struct InFrame<'a, C> {
    inner: C,
    frame: &'a Frame,
    log_volume: f64,
    origins: &'a [f64],
    outputs: &'a mut Vec<f64>,
}

impl<C: Conditional> Conditional for InFrame<'_, C> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        self.inner.sample(streams, states, log_density);
        self.frame.leave(self.origins, states);
        log_density.iter_mut().for_each(|log| *log -= self.log_volume);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        let deviations = self.frame.output.deviations.iter().cycle();
        self.outputs.clear();
        self.outputs.extend(
            states
                .iter()
                .zip(self.origins)
                .zip(deviations)
                .map(|((state, origin), deviation)| (state - origin) / deviation),
        );
        self.inner.log_density(self.outputs, log_density);
        log_density.iter_mut().for_each(|log| *log -= self.log_volume);
    }
}
