//! A bank of filters: what it holds, and how it is made.

use std::ops::Deref;

use motes_models::{Seed, StateSpaceModel, StepRecord, Stream, check_model, duplicate};

use super::filters::Outcome;
use super::scratches::Scratches;
use super::settings::FilterSettings;
use crate::error::FilterError;
use crate::proposal::Proposal;
use crate::weights::{BLOCK, LogWeights};

/// `B` independent filters of `K` particles each, with one model, one proposal and one sequence of measurements.
///
/// The model is held by anything that points to one: `&model` for a moment, `Arc<Model>` for a service that keeps filter and
/// model together. Each filter draws from its own stream, so a bank gives each of its filters what it would get alone
/// (to the last bit with designed proposals; networks may round otherwise in larger batches).
/// Between two steps the bank shows particles and weights as they are before resampling, which is when estimates
/// are to be taken; resampling happens at the start of the next step.
///
/// Large filters and large banks share the threads of the rayon pool that they are stepped in, or of the global one. To have a filter on so
/// many threads, step it inside of a pool of as many (`ThreadPool::install`); results are the same bytes for any number.
///
/// A clone goes its own way from where the bank is: it steps without measurements to forecast, say, and the bank goes on. Both draw the same
/// numbers from there on.
pub struct FilterBank<D: Deref, P: Proposal<D::Target>> {
    pub(crate) model: D,
    pub(super) proposal: P,
    pub(super) settings: FilterSettings,
    pub(super) streams: Vec<Stream>,
    pub(super) time: usize,
    /// The last step that was begun.
    pub(super) last: StepRecord,
    pub(super) states: Vec<f64>,
    pub(super) previous: Vec<f64>,
    pub(super) memory: P::Memory,
    pub(super) weights: Vec<LogWeights>,
    pub(super) log_evidence: Vec<f64>,
    pub(super) ancestors: Vec<usize>,
    pub(super) resampled: Vec<bool>,
    pub(super) outcomes: Vec<Outcome>,
    pub(super) scratches: Scratches<P::Scratch>,
    pub(super) failure: Option<FilterError>,
    pub(super) keeps_collapsed: bool,
    /// Room for a measurement, with and without its gaps.
    pub(super) entries: Vec<Option<f64>>,
    pub(super) whole: Vec<f64>,
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// Prepares `filters` filters; filter `b` draws from the stream of `seed.nth(b)`.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if there is no filter or no particle, or a setting is out of range; [`FilterError::Model`] for a model without states
    /// or measurements.
    pub fn new(
        model: D,
        proposal: P,
        settings: FilterSettings,
        filters: usize,
        seed: &Seed,
    ) -> Result<Self, FilterError> {
        // Before there are so many streams.
        settings.check_bank(filters, model.state_dim(), proposal.memory_per_particle())?;
        FilterBank::with_streams(model, proposal, settings, seed.streams(filters))
    }

    /// The proposal, to be changed between two steps.
    pub(crate) fn proposal_mut(&mut self) -> &mut P {
        &mut self.proposal
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
        check_model(&*model)?;
        let (filters, n) = (streams.len(), model.state_dim());
        let (rows, values) = settings.check_bank(filters, n, proposal.memory_per_particle())?;
        Ok(FilterBank {
            memory: proposal.initial_memory(rows),
            model,
            proposal,
            settings,
            streams,
            time: 0,
            last: StepRecord::default(),
            states: vec![0.0; values],
            previous: vec![0.0; values],
            weights: vec![LogWeights::uniform(settings.particles); filters],
            log_evidence: vec![0.0; filters],
            ancestors: (0..rows).collect(),
            resampled: vec![false; filters],
            outcomes: vec![Outcome { ess_before: 0.0, increment: Ok(0.0) }; filters],
            scratches: Scratches::default(),
            failure: None,
            keeps_collapsed: false,
            entries: Vec::new(),
            whole: Vec::new(),
        })
    }

    /// The same bank, in which a filter all of whose weights are zero is no error: its estimate of the evidence is 0 and stays 0, so its
    /// [`log_evidence`](FilterBank::log_evidence) is −∞, which is what tells it from others. The others go on as they would alone.
    ///
    /// An estimate of 0 is as unbiased as any other. Particles and weights of a collapsed filter mean nothing any more.
    #[must_use]
    pub fn keeping_collapsed(self) -> Self {
        FilterBank { keeps_collapsed: true, ..self }
    }

    /// As many numbers as a step may need at once: points and ranks of a filter's resampling, and a block of particles, are the
    /// largest there is.
    pub(super) fn scratch(&self) -> usize {
        3 * self.settings.particles + BLOCK * self.model.state_dim()
    }
}

impl<D: Deref + Clone, P: Proposal<D::Target, Memory: Clone> + Clone> Clone for FilterBank<D, P> {
    fn clone(&self) -> Self {
        FilterBank {
            model: self.model.clone(),
            proposal: self.proposal.clone(),
            settings: self.settings,
            streams: self.streams.iter().map(duplicate).collect(),
            time: self.time,
            last: self.last.clone(),
            states: self.states.clone(),
            previous: self.previous.clone(),
            memory: self.memory.clone(),
            weights: self.weights.clone(),
            log_evidence: self.log_evidence.clone(),
            ancestors: self.ancestors.clone(),
            resampled: self.resampled.clone(),
            outcomes: self.outcomes.clone(),
            scratches: self.scratches.clone(),
            failure: self.failure.clone(),
            keeps_collapsed: self.keeps_collapsed,
            entries: Vec::new(),
            whole: Vec::new(),
        }
    }
}
