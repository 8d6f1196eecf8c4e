//! One step of a bank whose proposal draws by rows: every filter is resampled, drawn and weighed piece by piece, while the piece is in a cache.
//!
//! Where a piece ends depends on the number of particles alone, so that any number of threads draws the same numbers.

use motes_models::batch::{Rows, with_scratch};
use motes_models::{StateSpaceModel, Stream};
use rand::{Rng, SeedableRng};

use crate::weights::{BLOCK, WeightBlocks};
use crate::workers::{Pieces, Workers};
use crate::{FilterSettings, LogWeights, RowPast, RowProposal, WeightFault};

/// Particles of small filters that are drawn together.
const TOGETHER: usize = 256;
/// Particles that a thread would rather do itself than hand on.
const GRAIN: usize = 256;

/// What all filters of a step share.
pub(crate) struct Step<'a, M: ?Sized> {
    pub(crate) proposal: &'a dyn RowProposal<M>,
    pub(crate) model: &'a M,
    pub(crate) settings: FilterSettings,
    pub(crate) time: usize,
    pub(crate) measurement: &'a [f64],
    /// The states of the step before.
    pub(crate) previous: &'a [f64],
}

/// Consecutive filters of a bank, each with its place in every slice.
pub(crate) struct Filters<'a> {
    /// The number of the first in the bank.
    pub(crate) first: usize,
    pub(crate) streams: &'a mut [Stream],
    pub(crate) weights: &'a mut [LogWeights],
    /// Whether each has ancestors that were drawn; the rows of one that has not are their own.
    pub(crate) resampled: &'a mut [bool],
    pub(crate) outcomes: &'a mut [Outcome],
    pub(crate) ancestors: &'a mut [usize],
    pub(crate) states: &'a mut [f64],
}

/// What a filter's step leads to.
#[derive(Clone)]
pub(crate) struct Outcome {
    /// The effective sample size before weighing.
    pub(crate) ess_before: f64,
    /// What the log-evidence grows by.
    pub(crate) increment: Result<f64, WeightFault>,
}

impl Pieces for Filters<'_> {
    fn count(&self) -> usize {
        self.streams.len()
    }

    fn split(self, filters: usize) -> (Self, Self) {
        let (rows, values) =
            (self.ancestors.len() / self.count() * filters, self.states.len() / self.count() * filters);
        let (streams, later_streams) = self.streams.split_at_mut(filters);
        let (weights, later_weights) = self.weights.split_at_mut(filters);
        let (resampled, later_resampled) = self.resampled.split_at_mut(filters);
        let (outcomes, later_outcomes) = self.outcomes.split_at_mut(filters);
        let (ancestors, later_ancestors) = self.ancestors.split_at_mut(rows);
        let (states, later_states) = self.states.split_at_mut(values);
        let later = Filters {
            first: self.first + filters,
            streams: later_streams,
            weights: later_weights,
            resampled: later_resampled,
            outcomes: later_outcomes,
            ancestors: later_ancestors,
            states: later_states,
        };
        (Filters { first: self.first, streams, weights, resampled, outcomes, ancestors, states }, later)
    }
}

impl Filters<'_> {
    /// Draws ancestors of every filter for which the rule says so, and makes the weights of these equal.
    pub(crate) fn resample(&mut self, settings: &FilterSettings, workers: &Workers) {
        let k = settings.particles;
        for (at, weights) in self.weights.iter_mut().enumerate() {
            let ancestors = &mut self.ancestors[at * k..(at + 1) * k];
            let row = (self.first + at) * k;
            if settings.resample_when.is_due(weights.effective_sample_size(), k) {
                let stream = &mut self.streams[at];
                settings.resampling.draw_rows(weights.normalised(), row, stream, ancestors, workers);
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

impl<M: StateSpaceModel + ?Sized> Step<'_, M> {
    /// Resamples, draws and weighs all filters.
    pub(crate) fn advance(&self, filters: Filters<'_>, workers: &Workers) {
        let k = self.settings.particles;
        if k <= BLOCK {
            return workers.share(filters, GRAIN.div_ceil(k), &|filters| self.advance_small(filters));
        }
        let mut rest = filters;
        while rest.count() > 0 {
            let (filter, others) = rest.split(1);
            self.advance_large(filter, workers);
            rest = others;
        }
    }

    /// Filters of one block each.
    fn advance_small(&self, filters: Filters<'_>) {
        let k = self.settings.particles;
        let together = (TOGETHER / k).max(1);
        with_scratch(together * k, |increments| {
            let mut rest = filters;
            while rest.count() > 0 {
                let count = together.min(rest.count());
                let (mut filters, others) = rest.split(count);
                if self.time > 0 {
                    filters.resample(&self.settings, &Workers::none());
                }
                let Filters { first, streams, weights, resampled, outcomes, ancestors, states } = filters;
                let ancestors = resampled.contains(&true).then_some(&*ancestors);
                let increments = &mut increments[..streams.len() * k];
                self.draw(first * k, ancestors, streams, states, increments);
                for ((weights, increments), outcome) in
                    weights.iter_mut().zip(increments.chunks_exact(k)).zip(outcomes)
                {
                    let ess_before = weights.effective_sample_size();
                    *outcome = Outcome { ess_before, increment: weights.update(increments) };
                }
                rest = others;
            }
        });
    }

    /// A filter of several blocks. Each has a stream of its own: that of a key that the filter's stream gives, with the block's number
    /// as nonce.
    fn advance_large(&self, mut filter: Filters<'_>, workers: &Workers) {
        if self.time > 0 {
            filter.resample(&self.settings, workers);
        }
        let Filters { first, streams, weights, resampled, outcomes, ancestors, states } = filter;
        let first = first * self.settings.particles;
        for ((stream, weights), (resampled, outcome)) in
            streams.iter_mut().zip(weights).zip(resampled.iter().zip(outcomes))
        {
            let ess_before = weights.effective_sample_size();
            let (key, width) = (key(stream), self.model.state_dim());
            let blocks = DrawnBlocks { first: 0, width, states: &mut *states, weights: weights.blocks() };
            workers.share(blocks, GRAIN.div_ceil(BLOCK), &|blocks: DrawnBlocks<'_>| {
                with_scratch(BLOCK, |increments| {
                    let mut rest = blocks;
                    while rest.count() > 0 {
                        let (DrawnBlocks { first: block, states, mut weights, .. }, others) = rest.split(1);
                        let increments = &mut increments[..states.len() / width];
                        let rows = block * BLOCK..block * BLOCK + increments.len();
                        let ancestors = resampled.then(|| &ancestors[rows.clone()]);
                        let mut stream = [block_stream(key, block)];
                        self.draw(first + rows.start, ancestors, &mut stream, states, increments);
                        weights.multiply(increments);
                        rest = others;
                    }
                });
            });
            *outcome = Outcome { ess_before, increment: weights.normalise(workers) };
        }
    }

    /// Draws particles from row `at` of the bank on, each from its own row of the step before if there are no ancestors.
    fn draw(
        &self,
        at: usize,
        ancestors: Option<&[usize]>,
        streams: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
    ) {
        let (width, particles) = (self.model.state_dim(), increments.len());
        let previous = (self.time > 0).then(|| match ancestors {
            None => Rows::all(&self.previous[at * width..(at + particles) * width], width),
            Some(ancestors) => Rows::picked(self.previous, width, ancestors),
        });
        let past = RowPast { time: self.time, measurement: self.measurement, previous };
        self.proposal.draw(self.model, past, streams, states, increments);
    }
}

/// Consecutive blocks of a filter.
struct DrawnBlocks<'a> {
    /// The number of the first.
    first: usize,
    width: usize,
    states: &'a mut [f64],
    weights: WeightBlocks<'a>,
}

impl Pieces for DrawnBlocks<'_> {
    fn count(&self) -> usize {
        self.weights.count()
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let DrawnBlocks { first, width, states, weights } = self;
        let values = (blocks * BLOCK * width).min(states.len());
        let (states, later_states) = states.split_at_mut(values);
        let (weights, later_weights) = weights.split(blocks);
        (
            DrawnBlocks { first, width, states, weights },
            DrawnBlocks { first: first + blocks, width, states: later_states, weights: later_weights },
        )
    }
}

/// A key for the streams of one step's blocks.
pub(crate) fn key(stream: &mut Stream) -> [u8; 32] {
    let mut key = [0; 32];
    stream.fill_bytes(&mut key);
    key
}

/// The stream of one block.
pub(crate) fn block_stream(key: [u8; 32], block: usize) -> Stream {
    let mut stream = Stream::from_seed(key);
    stream.set_stream(block as u64);
    stream
}
