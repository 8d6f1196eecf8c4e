//! A standardised family in a filter.

use motes_models::batch::Rows;
use motes_models::{StateSpaceModel, Step, Stream};
use motes_smc::{Conditional, Context, ParticleMemory, Proposal, ProposalError};

use super::family::{Prepared, Standardised};
use super::frame::Frame;
use crate::family::Family;

/// What conditioning a block of particles computes in.
#[derive(Default)]
pub struct StandardisedScratch<S> {
    inner: S,
    /// `ξ_{t−1}`, `R×N`.
    inputs: Vec<f64>,
    /// `o + P ξ_{t−1} + B υ_t`, `R×N`.
    origins: Vec<f64>,
    /// States in the units of the outputs, `R×N`.
    outputs: Vec<f64>,
}

impl<M: StateSpaceModel + ?Sized, F: Family + Proposal<M>> Proposal<M> for Standardised<F> {
    type Memory = F::Memory;
    type Scratch = StandardisedScratch<F::Scratch>;
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

    fn block(&self) -> usize {
        self.proposal.block()
    }

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        self.prepared = None;
        let (n, m) = (self.proposal.state_dim(), self.proposal.measurement_dim());
        ProposalError::unless_same("the state dimension N", n, model.state_dim())?;
        ProposalError::unless_same("the measurement dimension M", m, measurement.len())?;
        let Some(measurement) = measurement.iter().copied().collect::<Option<Vec<f64>>>() else {
            return Ok(false);
        };
        let (measurement, origin) = self.config.frames.at(step.index)?.of_measurement(&measurement);
        let measurement: Vec<Option<f64>> = measurement.into_iter().map(Some).collect();
        let is_prepared = self.proposal.prepare(model, step, &measurement)?;
        self.prepared = Some(Prepared { time: step.index, origin });
        Ok(is_prepared)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        memory: <F::Memory as ParticleMemory>::Rows<'_>,
        scratch: &'a mut Self::Scratch,
    ) -> Result<Self::Conditional<'a>, ProposalError> {
        let Context { step, previous, particles, .. } = context;
        let time = step.index;
        let prepared = self.prepared.as_ref().filter(|prepared| prepared.time == time);
        let Some(Prepared { origin, .. }) = prepared else {
            return Err(ProposalError::NotPrepared { time });
        };
        let frame = self.config.frames.at(time)?;
        let StandardisedScratch { inner, inputs, origins, outputs } = scratch;
        frame.of_previous(previous, particles, origin, (&mut *inputs, &mut *origins));
        let previous = previous.map(|_| Rows::all(inputs, origin.len()));
        let context = Context { step, previous, particles };
        let inner = self.proposal.condition(model, context, memory, inner)?;
        Ok(InFrame { inner, frame, log_volume: frame.log_volume(), origins, outputs })
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
