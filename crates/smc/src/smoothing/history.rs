//! What a filter was at each time.

use std::ops::Deref;

use motes_models::batch::there_is_memory_for;
use motes_models::{StateSpaceModel, StepRecord};

use super::error::SmoothingError;
use crate::filter::ParticleFilter;
use crate::proposal::Proposal;

/// The particles, weights and ancestors of a filter at each time from `t = 0` on, recorded after each step. It takes `T·K·(N + 2)` numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FilterHistory {
    pub(crate) generations: Vec<Generation>,
}

/// The particles of one time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Generation {
    /// The step that they were drawn in.
    pub(crate) step: StepRecord,
    /// `K×N`.
    pub(crate) states: Vec<f64>,
    /// Logarithms of the normalised weights, `K`.
    pub(crate) log_weights: Vec<f64>,
    /// The particle of the time before that each was drawn from, `K`; nothing where no trajectories are to be drawn.
    pub(crate) ancestors: Vec<usize>,
    /// The logarithms of what weights have of later measurements ([`Proposal::log_look_ahead`]), `K`; nothing where they have none.
    pub(crate) look_ahead: Vec<f64>,
}

impl Generation {
    /// What the weight of a particle has of later measurements.
    pub(super) fn log_look_ahead(&self, particle: usize) -> f64 {
        self.look_ahead.get(particle).copied().unwrap_or(0.0)
    }

    /// The state (`N`) of a particle.
    pub(crate) fn state(&self, particle: usize, width: usize) -> &[f64] {
        &self.states[particle * width..][..width]
    }
}

impl FilterHistory {
    /// Nothing yet.
    pub fn new() -> Self {
        FilterHistory::default()
    }

    /// Keeps what the filter is after its last step.
    ///
    /// # Errors
    /// [`SmoothingError::Skipped`] if the filter has not taken one step more than are kept, and [`SmoothingError::Memory`] if there is none for it; nothing was
    /// kept then.
    pub fn record<D, P>(&mut self, filter: &ParticleFilter<D, P>) -> Result<(), SmoothingError>
    where
        D: Deref<Target: StateSpaceModel>,
        P: Proposal<D::Target>,
    {
        self.check_next(filter.time())?;
        let (states, log_weights) = (filter.particles(), filter.weights().log());
        let numbers = states.len() + 2 * log_weights.len();
        if !there_is_memory_for(numbers) {
            return Err(SmoothingError::Memory { numbers });
        }
        let step = StepRecord::of(&filter.bank().last_step());
        let mut look_ahead = vec![0.0; log_weights.len()];
        if !filter.bank().log_look_ahead(&mut look_ahead) {
            look_ahead = Vec::new();
        }
        self.generations.push(Generation {
            step,
            states: states.to_vec(),
            log_weights: log_weights.to_vec(),
            ancestors: filter.ancestors().to_vec(),
            look_ahead,
        });
        Ok(())
    }

    /// Whether a filter of so many steps is the next to be kept.
    fn check_next(&self, steps: usize) -> Result<(), SmoothingError> {
        match steps == self.len() + 1 {
            true => Ok(()),
            false => Err(SmoothingError::Skipped { steps, kept: self.len() }),
        }
    }

    /// Whether trajectories of `width` coordinates can be drawn.
    pub(super) fn check(&self, width: usize) -> Result<(), SmoothingError> {
        let mut before = None;
        for (time, Generation { states, log_weights, ancestors, .. }) in self.generations.iter().enumerate() {
            let particles = log_weights.len();
            let have_states = particles.checked_mul(width) == Some(states.len());
            let have_ancestors = before.is_none_or(|before| {
                ancestors.len() == particles && ancestors.iter().all(|ancestor| *ancestor < before)
            });
            if !have_states || !have_ancestors {
                return Err(SmoothingError::OtherFilter { time });
            }
            before = Some(particles);
        }
        Ok(())
    }

    /// `T`, the number of times kept.
    pub fn len(&self) -> usize {
        self.generations.len()
    }

    /// Whether nothing is kept.
    pub fn is_empty(&self) -> bool {
        self.generations.is_empty()
    }
}
