//! The interface of a sampling distribution: prepare it for a step, condition blocks of particles, draw from them or ask their density.

use motes_models::batch::Rows;
use motes_models::{Step, Stream};

use crate::memory::ParticleMemory;
use crate::proposal_error::ProposalError;

/// What the distributions of a block of `R` particles are conditioned on.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// The step to the state that is to be drawn.
    pub step: Step<'a>,
    /// `x_{t−1}` of each particle, picked from all by resampling; `None` at the first step, where there is no past.
    pub previous: Option<Rows<'a>>,
    /// `R`, the number of particles.
    pub particles: usize,
}

impl<'a> Context<'a> {
    /// That of `particles` particles whose previous states (`R×N`, row-major) lie one after another.
    pub fn new(step: Step<'a>, previous: Option<&'a [f64]>, particles: usize) -> Self {
        let rows = |states: &'a [f64]| Rows::all(states, states.len() / particles.max(1));
        Context { step, previous: previous.map(rows), particles }
    }
}

/// A sampling distribution `q(x_t | x_{0:t−1}, y_{0:t})` for particles of a model of type `Model`.
///
/// A step takes three moves. [`Proposal::prepare`] computes what is the same for all particles. [`Proposal::condition`] computes what depends on
/// the past of a block of particles (a network runs here); blocks are independent, and threads share them. The [`Conditional`] that comes back
/// is drawn from, or asked its density at any point. Mixtures and tests therefore need nothing special of a proposal.
pub trait Proposal<Model: ?Sized>: Sync {
    /// What a particle carries from step to step beside its state; `()` for a Markov proposal.
    type Memory: ParticleMemory;

    /// What conditioning a block computes in. A filter keeps one for each block that is worked on at the same time.
    type Scratch: Default + Send;

    /// The distributions of a block's `x_t` once the past is known.
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

    /// The fewest particles that it likes to be conditioned on at once: so many of a bank's small filters share a block. A filter of at most 1024
    /// particles is never cut, a larger one is cut into blocks of 1024.
    fn block(&self) -> usize {
        256
    }

    /// Whether it has distributions for a step; where it has none, as one that was learned for steps of another number of draws, a filter draws from the transition.
    fn is_for_step(&self, _model: &Model, _step: &Step<'_>) -> bool {
        true
    }

    /// Whether it knows what comes later. It is then asked at every step, also where nothing is measured or no time passes.
    fn looks_ahead(&self) -> bool {
        false
    }

    /// Where weights after step `index` have a part of what comes later, the logarithm of this part at each of `K` rows of states (`K×N`) into `out` (`K`): what to take off where weights
    /// shall say what is known until then. `false`, the default, says that they have none.
    fn log_look_ahead(&self, _model: &Model, _index: usize, _states: &[f64], _out: &mut [f64]) -> bool {
        false
    }

    /// Computes what all particles of a step have in common, from the entries of `y_t` (`M`), some of which may be missing. `false` says that the proposal has no
    /// distribution for a measurement with such gaps: a filter then draws from the transition.
    ///
    /// # Errors
    /// [`ProposalError`] if the proposal does not fit the model, or is past its horizon.
    fn prepare(
        &mut self,
        model: &Model,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError>;

    /// Conditions each distribution of a block on its past and on the measurement that the proposal was prepared for, and advances the
    /// block's memory.
    ///
    /// # Errors
    /// [`ProposalError`] if the proposal does not fit the context or fails numerically.
    fn condition<'a>(
        &'a self,
        model: &'a Model,
        context: Context<'a>,
        memory: <Self::Memory as ParticleMemory>::Rows<'_>,
        scratch: &'a mut Self::Scratch,
    ) -> Result<Self::Conditional<'a>, ProposalError>;

    /// Prepares for a measurement without gaps (`M` numbers) and conditions a batch in one call, for who asks a proposal without a filter.
    ///
    /// # Errors
    /// As [`Proposal::prepare`] and [`Proposal::condition`].
    fn condition_batch<'a>(
        &'a mut self,
        model: &'a Model,
        context: Context<'a>,
        measurement: &[f64],
        memory: &mut Self::Memory,
        scratch: &'a mut Self::Scratch,
    ) -> Result<Self::Conditional<'a>, ProposalError> {
        let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
        self.prepare(model, &context.step, &entries)?;
        self.condition(model, context, memory.rows(), scratch)
    }
}

/// `q(x_t | past)` of each of `R` particles.
pub trait Conditional {
    /// Draws a state for each particle into `states` (`R×N`) and writes `log q` of it into `log_density` (`R`).
    ///
    /// The particles are split evenly over `streams`, one for each filter in a bank and in its order. Where
    /// [`Conditional::is_transition`] holds, `log_density` may be left as it was: ask [`Conditional::log_density`] for it.
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]);

    /// Draws as [`Conditional::sample`] the same numbers where nobody asks for `log q`; what is then in `unasked` (`R`) means nothing.
    fn sample_states(&mut self, streams: &mut [Stream], states: &mut [f64], unasked: &mut [f64]) {
        self.sample(streams, states, unasked);
    }

    /// Writes `log q` at the given `states` (`R×N`) into `log_density` (`R`); −∞ outside the support, NaN where it cannot
    /// be computed (a filter then stops with the particle named).
    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]);

    /// Draws as [`Conditional::sample`], and writes `log p(y|x) + log p(x|x') − log q(x|x', y)` into `log_weights` (`R`), where that has a closed
    /// form that is cheaper than its terms. `false`, the default, says that it has none, and nothing was drawn.
    fn sample_weighted(
        &mut self,
        _streams: &mut [Stream],
        _states: &mut [f64],
        _log_weights: &mut [f64],
    ) -> bool {
        false
    }

    /// Draws a state for each particle into `states` (`R×N`) by its noise, and writes `log p(v) − log q(v | x', y)` of the noise into `log_ratios` (`R`), where `q` has the
    /// given share of the noise's own distribution (that of the proposal where none is given). `false`, the default, says that it draws states, which are weighed by
    /// their densities; nothing was drawn then.
    fn sample_by_noise(
        &mut self,
        _share: Option<f64>,
        _streams: &mut [Stream],
        _states: &mut [f64],
        _log_ratios: &mut [f64],
    ) -> bool {
        false
    }

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

    fn sample_weighted(
        &mut self,
        streams: &mut [Stream],
        states: &mut [f64],
        log_weights: &mut [f64],
    ) -> bool {
        (**self).sample_weighted(streams, states, log_weights)
    }

    fn sample_by_noise(
        &mut self,
        share: Option<f64>,
        streams: &mut [Stream],
        states: &mut [f64],
        log_ratios: &mut [f64],
    ) -> bool {
        (**self).sample_by_noise(share, streams, states, log_ratios)
    }

    fn is_transition(&self) -> bool {
        (**self).is_transition()
    }
}
