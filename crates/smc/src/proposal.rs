//! The interface of a sampling distribution: condition it on the past, then draw from it or ask its density.

use motes_models::Stream;
use motes_models::batch::Rows;
use thiserror::Error;

use crate::ParticleMemory;

/// What a proposal is conditioned on at one step, for a batch of `R` particles.
#[derive(Debug, Clone, Copy)]
pub struct Past<'a> {
    /// `t`, the time of the state to be drawn.
    pub time: usize,
    /// `x_{t−1}`, row-major `R×N`; `None` at `t = 0`, where there is no past.
    pub previous: Option<&'a [f64]>,
    /// `y_t`, `M` numbers, the same for every particle.
    pub measurement: &'a [f64],
    /// `R`, the number of particles.
    pub particles: usize,
}

/// Why a proposal could not be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProposalError {
    /// A proposal that has its own parameters for each time was stepped past the last of them.
    #[error("this proposal is unrolled over {horizon} times and was asked for time {time}")]
    PastHorizon {
        /// The number of times it knows, `T`.
        horizon: usize,
        /// The time it was asked for.
        time: usize,
    },
    /// The proposal does not fit the model it is used with.
    #[error("{what} is {found} in the proposal and {expected} in the model")]
    Mismatch {
        /// What differs.
        what: &'static str,
        /// The proposal's value.
        found: usize,
        /// The model's value.
        expected: usize,
    },
    /// A setting is outside its range.
    #[error("{name} is {value}; it must be {expected}")]
    Setting {
        /// Which setting.
        name: &'static str,
        /// The value found, as text.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// The proposal works on the graph of a system, and the model has none.
    #[error("the model has no graph, which a graph network needs: see ModelShape::on_graph")]
    NoGraph,
    /// The units in which a proposal's networks work cannot be had from simulations of the system.
    #[error("the frames of a standardised proposal cannot be had: {reason}")]
    Frames {
        /// Why not.
        reason: String,
    },
    /// A matrix that must be invertible is not, in floating point.
    #[error("the matrix {matrix} at time {time} is singular: log|det| is {log_abs_det}")]
    Singular {
        /// Which matrix.
        matrix: String,
        /// The time it belongs to.
        time: usize,
        /// The logarithm of its absolute determinant.
        log_abs_det: f64,
    },
    /// What computes the proposal's networks failed.
    #[error("the compute backend failed: {reason}")]
    Backend {
        /// What it said.
        reason: String,
    },
    /// A computation failed although its input was valid.
    #[error("{computation} failed for particle {particle}: {reason}")]
    Numerical {
        /// What was being computed.
        computation: &'static str,
        /// Row of the particle in its batch.
        particle: usize,
        /// Why it failed.
        reason: String,
    },
}

impl ProposalError {
    /// Refuses a proposal in which `what` is not what it is in the model.
    ///
    /// # Errors
    /// [`ProposalError::Mismatch`] if the two differ.
    pub fn unless_same(what: &'static str, found: usize, expected: usize) -> Result<(), Self> {
        if found == expected { Ok(()) } else { Err(ProposalError::Mismatch { what, found, expected }) }
    }
}

/// A sampling distribution `q(x_t | x_{0:t−1}, y_{0:t})` for particles of a model of type `Model`.
///
/// Using one takes two moves: [`Proposal::condition`] computes whatever depends on the past (a network runs
/// here, once), and the [`Conditional`] that comes back is drawn from, or asked its density at any point.
/// Mixtures and tests therefore need nothing special of a proposal.
pub trait Proposal<Model: ?Sized> {
    /// What a particle carries from step to step beside its state; `()` for a Markov proposal.
    type Memory: ParticleMemory;

    /// The distribution of `x_t` once the past is known. It may borrow the proposal's scratch space.
    type Conditional<'a>: Conditional
    where
        Self: 'a,
        Model: 'a;

    /// The memory of `particles` particles before the first step.
    fn initial_memory(&self, particles: usize) -> Self::Memory;

    /// How many numbers of 64 bits the memory keeps of each particle, with what it needs to move them. A filter asks, to refuse more
    /// particles than there is memory for.
    fn memory_per_particle(&self) -> usize {
        0
    }

    /// Conditions each particle's distribution on its past and on `y_t`, and advances its memory.
    ///
    /// # Errors
    /// [`ProposalError`] if the proposal does not fit the model, is past its horizon, or fails numerically.
    fn condition<'a>(
        &'a mut self,
        model: &'a Model,
        past: Past<'a>,
        memory: &mut Self::Memory,
    ) -> Result<Self::Conditional<'a>, ProposalError>;

    /// The same distributions for this step as ones that can be drawn from in any parts, several at once: a filter then never forms
    /// the batch as a whole. `None`, the default, for a proposal that has a memory or wants its batch whole, as networks do.
    ///
    /// # Errors
    /// As [`Proposal::condition`].
    fn by_rows(
        &mut self,
        _model: &Model,
        _time: usize,
        _measurement: &[f64],
    ) -> Result<Option<&dyn RowProposal<Model>>, ProposalError> {
        Ok(None)
    }
}

/// What a [`RowProposal`] draws from, for `R` particles.
#[derive(Debug, Clone, Copy)]
pub struct RowPast<'a> {
    /// `t`, the time of the state to be drawn.
    pub time: usize,
    /// `y_t`, `M` numbers.
    pub measurement: &'a [f64],
    /// `x_{t−1}` of each particle, picked from all by resampling; `None` at `t = 0`.
    pub previous: Option<Rows<'a>>,
}

/// A proposal that needs nothing of a particle but its previous state, and no scratch of its own.
pub trait RowProposal<Model: ?Sized>: Sync {
    /// Draws a state for each of the `R` particles in `past` into `states` (`R×N`), and writes what
    /// its weight is multiplied by, `log p(y|x) + log p(x|x') − log q(x|x', y)`, into `increments` (`R`).
    ///
    /// The particles are split evenly over `streams`, in order; what a stream gives to its particles does not depend on the others.
    fn draw(
        &self,
        model: &Model,
        past: RowPast<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
    );

    /// Whether this is the model's own `p(x_t | x_{t−1})`.
    fn is_transition(&self) -> bool {
        false
    }
}

/// `q(x_t | past)` of each of `R` particles.
pub trait Conditional {
    /// Draws a state for each particle into `states` (`R×N`) and writes `log q` of it into `log_density` (`R`).
    ///
    /// The particles are split evenly over `streams`, one for each filter in a bank and in its order. Where
    /// [`Conditional::is_transition`] holds, `log_density` may be left as it was: ask [`Conditional::log_density`] for it.
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]);

    /// Writes `log q` at the given `states` (`R×N`) into `log_density` (`R`); −∞ outside the support, NaN where it cannot
    /// be computed (a filter then stops with the particle named).
    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]);

    /// Whether this is the model's own `p(x_t | x_{t−1})`, so that both cancel in the weight and neither is
    /// evaluated.
    fn is_transition(&self) -> bool {
        false
    }
}

impl<C: Conditional + ?Sized> Conditional for &mut C {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        (**self).sample(streams, states, log_density);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        (**self).log_density(states, log_density);
    }

    fn is_transition(&self) -> bool {
        (**self).is_transition()
    }
}
