//! Many independent particle filters on the same measurements, advanced as one batch.

mod advance;
mod settings;

use std::ops::Deref;

use motes_models::{Seed, StateSpaceModel, Stream};

use crate::blocks::Outcome;
use crate::diagnosis::{WeightDiagnosis, tail_index};
use crate::proposals::Defensive;
use crate::weights::BLOCK;
use crate::workers::Workers;
use crate::{FilterError, LogWeights, Proposal};
pub use settings::FilterSettings;

/// `B` independent filters of `K` particles each, with one model, one proposal and one sequence of measurements.
///
/// The model is held by anything that points to one: `&model` for a moment, `Arc<Model>` for a service that keeps filter and
/// model together. Each filter draws from its own stream, so a bank gives each of its filters what it would get alone
/// (to the last bit with designed proposals; networks may round otherwise in larger batches).
/// Between two steps the bank shows particles and weights as they are before resampling, which is when estimates
/// are to be taken; resampling happens at the start of the next step.
pub struct FilterBank<D: Deref, P: Proposal<D::Target>> {
    model: D,
    proposal: P,
    settings: FilterSettings,
    defensive: Option<Defensive>,
    streams: Vec<Stream>,
    time: usize,
    states: Vec<f64>,
    previous: Vec<f64>,
    memory: P::Memory,
    weights: Vec<LogWeights>,
    log_evidence: Vec<f64>,
    ancestors: Vec<usize>,
    resampled: Vec<bool>,
    outcomes: Vec<Outcome>,
    increments: Vec<f64>,
    log_likelihoods: Vec<f64>,
    log_transitions: Vec<f64>,
    workers: Workers,
    failure: Option<FilterError>,
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// Prepares `filters` filters; filter `b` draws from the stream of `seed.nth(b)`.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if there is no filter or no particle, or a setting is out of range.
    pub fn new(
        model: D,
        proposal: P,
        settings: FilterSettings,
        filters: usize,
        seed: &Seed,
    ) -> Result<Self, FilterError> {
        settings.check_bank(filters, model.state_dim(), proposal.memory_per_particle())?;
        FilterBank::with_streams(model, proposal, settings, seed.streams(filters))
    }

    /// Prepares one filter for each of the given streams.
    ///
    /// # Errors
    /// As [`FilterBank::new`].
    pub fn with_streams(
        model: D,
        proposal: P,
        settings: FilterSettings,
        streams: Vec<Stream>,
    ) -> Result<Self, FilterError> {
        let (filters, n) = (streams.len(), model.state_dim());
        let (rows, values) = settings.check_bank(filters, n, proposal.memory_per_particle())?;
        Ok(FilterBank {
            memory: proposal.initial_memory(rows),
            model,
            proposal,
            settings,
            defensive: settings.defensive_weight.map(Defensive::new),
            workers: Workers::none(),
            streams,
            time: 0,
            states: vec![0.0; values],
            previous: vec![0.0; values],
            weights: vec![LogWeights::uniform(settings.particles); filters],
            log_evidence: vec![0.0; filters],
            ancestors: (0..rows).collect(),
            resampled: vec![false; filters],
            outcomes: vec![Outcome { ess_before: 0.0, increment: Ok(0.0) }; filters],
            increments: vec![0.0; rows],
            log_likelihoods: vec![0.0; rows],
            log_transitions: vec![0.0; rows],
            failure: None,
        })
    }

    /// Lets `threads` threads work on each step where the proposal allows it, as the designed ones do, and there are particles enough;
    /// [`FilterBank::run`] needs fewer of them for that. When the bank is dropped its threads sleep until another asks for as
    /// many. Results are the same bytes for any number.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if `threads` is 0 or more than the system can start.
    pub fn with_threads(mut self, threads: usize) -> Result<Self, FilterError> {
        self.workers = Workers::new(threads, self.increments.len(), self.scratch())?;
        Ok(self)
    }

    /// As many numbers as a step may need at once: points and ranks of a filter's resampling, and a block of particles, are the
    /// largest there is.
    fn scratch(&self) -> usize {
        3 * self.settings.particles + BLOCK * self.model.state_dim()
    }

    /// `B`, the number of filters.
    pub fn filters(&self) -> usize {
        self.streams.len()
    }

    /// How many steps have been taken.
    pub fn time(&self) -> usize {
        self.time
    }

    /// The particles of one filter, row-major `K×N`, as they are before resampling.
    pub fn particles(&self, filter: usize) -> &[f64] {
        let values = self.settings.particles * self.model.state_dim();
        &self.states[filter * values..(filter + 1) * values]
    }

    /// The weights of one filter's particles.
    pub fn weights(&self, filter: usize) -> &LogWeights {
        &self.weights[filter]
    }

    /// For each particle of the whole bank (`B·K`), the row it descends from in the step before; itself where its
    /// filter did not resample.
    pub fn ancestors(&self) -> &[usize] {
        &self.ancestors
    }

    /// What every particle of the bank carries beside its state.
    pub fn memory(&self) -> &P::Memory {
        &self.memory
    }

    /// What the weights of the last step say about how far they can be trusted.
    ///
    /// The tail index is that of `W_{t−1} p(y|x) p(x|x') / q`, of all filters together; it takes a pass over all of them.
    pub fn diagnosis(&self) -> WeightDiagnosis {
        let weights = self.weights.iter().zip(&self.outcomes).flat_map(|(weights, outcome)| {
            let increment = *outcome.increment.as_ref().unwrap_or(&f64::NAN);
            weights.log().iter().map(move |log| log + increment)
        });
        let sizes = self.weights.iter().map(LogWeights::effective_sample_size);
        WeightDiagnosis {
            time: self.time.saturating_sub(1),
            particles: self.settings.particles,
            effective_sample_size: sizes.sum::<f64>() / self.weights.len() as f64,
            tail_index: tail_index(&weights.collect::<Vec<f64>>()),
        }
    }

    /// The estimate of `log p(y_{0:t})` by one filter; its exponential is unbiased.
    pub fn log_evidence(&self, filter: usize) -> f64 {
        self.log_evidence[filter]
    }

    /// One filter's estimate of `E[x_t | y_{0:t}]`, `Σ_k W_k x_k`, into `mean` (`N`).
    ///
    /// # Panics
    /// If there is no such filter or `mean` has not `N` places.
    pub fn mean(&self, filter: usize, mean: &mut [f64]) {
        assert_eq!(mean.len(), self.model.state_dim(), "the mean has N coordinates");
        self.weights[filter].mean(self.particles(filter), mean);
    }
}
