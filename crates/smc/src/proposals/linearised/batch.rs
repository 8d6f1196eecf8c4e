//! The linearised distributions of a block of particles: draws and densities.

use motes_models::Stream;
use motes_models::equations::Linearise;

use super::precision_batch::PrecisionBatch;
use super::scratch::LinearisedScratch;
use crate::proposal::{Conditional, Context};
use crate::proposals::bootstrap::Transition;

/// The Gaussians of a block of particles, each with its own mean and precision; or their transitions.
pub struct LinearisedBatch<'a, M: ?Sized> {
    pub(super) model: &'a M,
    pub(super) context: Context<'a>,
    pub(super) scratch: &'a mut LinearisedScratch,
    pub(super) sees_measurements: bool,
}

impl<M: Linearise + ?Sized> LinearisedBatch<'_, M> {
    fn gaussians(&mut self) -> PrecisionBatch<'_> {
        PrecisionBatch { width: self.model.state_dim(), gaussians: self.scratch }
    }

    fn transition(&self) -> Transition<'_, M> {
        Transition::new(self.model, self.context)
    }
}

impl<M: Linearise + ?Sized> Conditional for LinearisedBatch<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_densities: &mut [f64]) {
        match self.sees_measurements {
            true => self.gaussians().sample(streams, states, log_densities),
            false => self.transition().sample(streams, states, log_densities),
        }
    }

    fn log_density(&mut self, states: &[f64], log_densities: &mut [f64]) {
        match self.sees_measurements {
            true => self.gaussians().log_density(states, log_densities),
            false => self.transition().log_density(states, log_densities),
        }
    }

    fn is_transition(&self) -> bool {
        !self.sees_measurements
    }
}
