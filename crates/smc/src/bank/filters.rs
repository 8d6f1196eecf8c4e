//! Consecutive filters of a bank with their places in everything that a step changes, and their resampling.

use motes_models::{ModelError, Stream};

use super::settings::FilterSettings;
use crate::memory::MemoryRows;
use crate::parallel::{Pieces, Threads};
use crate::proposal_error::ProposalError;
use crate::weights::{BLOCK, LogWeights, WeightFault};

/// Particles that a thread would rather resample itself than hand on.
const GRAIN: usize = 1024;

/// Consecutive filters of a bank, each with its place in every slice.
pub(super) struct Filters<'a, R> {
    /// The number of the first in the bank.
    pub(super) first: usize,
    pub(super) streams: &'a mut [Stream],
    pub(super) weights: &'a mut [LogWeights],
    /// Whether each has ancestors that were drawn; the rows of one that has not are their own.
    pub(super) resampled: &'a mut [bool],
    pub(super) outcomes: &'a mut [Outcome],
    pub(super) ancestors: &'a mut [usize],
    pub(super) states: &'a mut [f64],
    pub(super) memory: R,
}

/// What a filter's step leads to.
#[derive(Debug, Clone)]
pub(super) struct Outcome {
    /// The effective sample size before weighing.
    pub(super) ess_before: f64,
    /// What the log-evidence grows by.
    pub(super) increment: Result<f64, Fault>,
}

/// Why a filter's step failed.
#[derive(Debug, Clone)]
pub(super) enum Fault {
    Weights(WeightFault),
    Proposal(ProposalError),
    Model(ModelError),
    /// A coordinate of the particle at this row of the bank is not finite.
    State {
        row: usize,
        coordinate: usize,
        value: f64,
    },
}

impl<R: MemoryRows> Pieces for Filters<'_, R> {
    fn count(&self) -> usize {
        self.streams.len()
    }

    fn split(self, filters: usize) -> (Self, Self) {
        let each = self.ancestors.len() / self.count();
        let values = self.states.len() / self.count() * filters;
        let (streams, later_streams) = self.streams.split_at_mut(filters);
        let (weights, later_weights) = self.weights.split_at_mut(filters);
        let (resampled, later_resampled) = self.resampled.split_at_mut(filters);
        let (outcomes, later_outcomes) = self.outcomes.split_at_mut(filters);
        let (ancestors, later_ancestors) = self.ancestors.split_at_mut(each * filters);
        let (states, later_states) = self.states.split_at_mut(values);
        let (memory, later_memory) = self.memory.split(each * filters);
        let later = Filters {
            first: self.first + filters,
            streams: later_streams,
            weights: later_weights,
            resampled: later_resampled,
            outcomes: later_outcomes,
            ancestors: later_ancestors,
            states: later_states,
            memory: later_memory,
        };
        let first = self.first;
        (Filters { first, streams, weights, resampled, outcomes, ancestors, states, memory }, later)
    }
}

impl<'a> Filters<'a, ()> {
    /// The same with what their particles carry.
    pub(super) fn with_memory<R>(self, memory: R) -> Filters<'a, R> {
        let Filters { first, streams, weights, resampled, outcomes, ancestors, states, memory: () } = self;
        Filters { first, streams, weights, resampled, outcomes, ancestors, states, memory }
    }

    /// [`Filters::resample`], shared by threads.
    pub(super) fn resample_all(&mut self, settings: &FilterSettings, threads: Threads) {
        if settings.particles > BLOCK {
            return self.resample(settings, threads);
        }
        let all = Filters {
            first: self.first,
            streams: self.streams,
            weights: self.weights,
            resampled: self.resampled,
            outcomes: self.outcomes,
            ancestors: self.ancestors,
            states: self.states,
            memory: (),
        };
        let grain = GRAIN.div_ceil(settings.particles);
        threads.share(all, grain, &|mut filters: Filters<'_, ()>| filters.resample(settings, Threads::One));
    }
}

impl<R> Filters<'_, R> {
    /// Draws ancestors of every filter for which the rule says so, and makes the weights of these equal.
    pub(super) fn resample(&mut self, settings: &FilterSettings, threads: Threads) {
        let k = settings.particles;
        for (at, weights) in self.weights.iter_mut().enumerate() {
            let ancestors = &mut self.ancestors[at * k..(at + 1) * k];
            let row = (self.first + at) * k;
            if settings.resample_when.is_due(weights.effective_sample_size(), k) {
                let stream = &mut self.streams[at];
                settings.resampling.draw_rows(weights.normalised(), row, stream, ancestors, threads);
                weights.reset_until_update();
                self.resampled[at] = true;
            } else if std::mem::take(&mut self.resampled[at]) {
                for (ancestor, row) in ancestors.iter_mut().zip(row..) {
                    *ancestor = row;
                }
            }
        }
    }
}
