//! The linearised distributions of a block of particles: draws and densities.

use motes_models::Stream;
use motes_models::equations::Linearise;

use super::noise::NoiseBatch;
use super::precision_batch::PrecisionBatch;
use super::scratch::LinearisedScratch;
use crate::proposal::{Conditional, Context};
use crate::proposals::bootstrap::Transition;

/// The Gaussians of a block of particles, each with its own mean and precision, of states or of their noise; or their transitions.
pub struct LinearisedBatch<'a, M: ?Sized> {
    pub(super) model: &'a M,
    pub(super) context: Context<'a>,
    pub(super) scratch: &'a mut LinearisedScratch,
    pub(super) of: Of,
}

/// What is Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Of {
    /// Nothing: particles are drawn from the transition.
    Transition,
    /// States.
    States,
    /// So many draws, with a share of their own distribution.
    Noise { draws: usize, share: f64 },
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
        match self.of {
            Of::States => self.gaussians().sample(streams, states, log_densities),
            Of::Transition | Of::Noise { .. } => self.transition().sample(streams, states, log_densities),
        }
    }

    fn log_density(&mut self, states: &[f64], log_densities: &mut [f64]) {
        match self.of {
            Of::States => self.gaussians().log_density(states, log_densities),
            Of::Transition | Of::Noise { .. } => self.transition().log_density(states, log_densities),
        }
    }

    fn sample_by_noise(
        &mut self,
        share: Option<f64>,
        streams: &mut [Stream],
        states: &mut [f64],
        log_ratios: &mut [f64],
    ) -> bool {
        let (Of::Noise { draws, share: own }, Some(model)) = (self.of, self.model.noise_space()) else {
            return false;
        };
        let mut batch = NoiseBatch {
            model,
            context: self.context,
            states: self.model.state_dim(),
            draws,
            scratch: self.scratch,
        };
        batch.sample(share.unwrap_or(own), streams, states, log_ratios);
        true
    }

    fn is_transition(&self) -> bool {
        self.of == Of::Transition
    }
}
