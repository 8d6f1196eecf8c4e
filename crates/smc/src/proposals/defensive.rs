//! The defensive mixture: any proposal, made safe by a share of the transition.

use motes_models::{StateSpaceModel, Stream};
use rand::RngExt;

use super::bootstrap::Transition;
use crate::{Conditional, FilterError, Past, Proposal, ProposalError};

/// `(1 − α) q(x_t | past, y_t) + α p(x_t | x_{t−1})`.
///
/// The transition weighs at most `p(y_t | x_t)/α` against it, so the weights are bounded wherever the likelihood
/// is, however badly `q` covers the target (Hesterberg 1995). Each particle first chooses its component; its density is
/// the mixture's, exactly.
#[derive(Debug, Clone)]
pub struct Defensive<P> {
    proposal: P,
    weight: f64,
    scratch: Scratch,
}

#[derive(Debug, Clone, Default)]
struct Scratch {
    states: Vec<f64>,
    log_density: Vec<f64>,
}

impl<P> Defensive<P> {
    /// Mixes `proposal` with the transition, which gets the given weight `α`.
    ///
    /// # Errors
    /// [`FilterError::Setting`] unless `0 < α < 1`.
    pub fn new(proposal: P, weight: f64) -> Result<Self, FilterError> {
        if !(weight > 0.0 && weight < 1.0) {
            return Err(FilterError::Setting {
                name: "the transition's weight in a defensive mixture",
                value: weight.to_string(),
                expected: "between 0 and 1, both excluded",
            });
        }
        Ok(Defensive { proposal, weight, scratch: Scratch::default() })
    }
}

impl<M: StateSpaceModel + ?Sized, P: Proposal<M>> Proposal<M> for Defensive<P> {
    type Memory = P::Memory;
    type Conditional<'a>
        = Mixture<'a, M, P::Conditional<'a>>
    where
        Self: 'a,
        M: 'a;

    fn initial_memory(&self, particles: usize) -> P::Memory {
        self.proposal.initial_memory(particles)
    }

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        memory: &mut P::Memory,
    ) -> Result<Self::Conditional<'a>, ProposalError> {
        self.scratch.states.resize(past.particles * model.state_dim(), 0.0);
        self.scratch.log_density.resize(past.particles, 0.0);
        Ok(Mixture {
            base: self.proposal.condition(model, past, memory)?,
            transition: Transition { model, past },
            weight: self.weight,
            scratch: &mut self.scratch,
        })
    }
}

/// The conditional of a [`Defensive`] proposal.
pub struct Mixture<'a, M: ?Sized, C> {
    base: C,
    transition: Transition<'a, M>,
    weight: f64,
    scratch: &'a mut Scratch,
}

impl<M: StateSpaceModel + ?Sized, C: Conditional> Conditional for Mixture<'_, M, C> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let width = self.transition.model.state_dim();
        // Both components draw for every particle: their streams then advance by the same amount whatever is
        // chosen, and a bank stays one batch.
        self.base.sample(streams, states, log_density);
        self.transition.sample(streams, &mut self.scratch.states, log_density);
        let block = self.transition.past.particles / streams.len().max(1);
        let rows = states.chunks_exact_mut(width).zip(self.scratch.states.chunks_exact(width));
        for (row, (state, safe)) in rows.enumerate() {
            if streams[row / block].random::<f64>() < self.weight {
                state.copy_from_slice(safe);
            }
        }
        self.log_density(states, log_density);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        self.base.log_density(states, log_density);
        self.transition.log_density(states, &mut self.scratch.log_density);
        let (log_base, log_safe) = ((1.0 - self.weight).ln(), self.weight.ln());
        for (base, safe) in log_density.iter_mut().zip(&self.scratch.log_density) {
            let (a, b) = (*base + log_base, safe + log_safe);
            let largest = a.max(b);
            if largest > f64::NEG_INFINITY {
                *base = largest + ((a - largest).exp() + (b - largest).exp()).ln();
            }
        }
    }
}
