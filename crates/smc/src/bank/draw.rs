//! One step of a bank: every filter is resampled, drawn and weighed block by block, while the block is in a cache.
//!
//! Where a block ends depends on the number of particles and on the proposal alone, so that any number of threads draws the same numbers.

use std::ops::Range;
use std::sync::Mutex;

use motes_models::batch::{LANES, Rows, by_widest_vectors, with_scratch};
use motes_models::{StateSpaceModel, Step, Stream};

use super::filters::{Fault, Filters, Outcome};
use super::scratches::Scratches;
use super::settings::FilterSettings;
use crate::memory::{MemoryRows, ParticleMemory};
use crate::parallel::{Pieces, Threads};
use crate::proposal::{Conditional, Context, Proposal};
use crate::proposal_error::ProposalError;
use crate::proposals::{Defensive, Transition};
use crate::streams::{block_stream, key};
use crate::weights::{BLOCK, WeightBlocks};

/// What all filters of a step share but for their proposal.
pub(super) struct Common<'a, M: ?Sized> {
    pub(super) model: &'a M,
    pub(super) settings: FilterSettings,
    pub(super) step: Step<'a>,
    /// `y_t`, of which some may be missing.
    pub(super) entries: &'a [Option<f64>],
    /// `y_t`; empty where some of it is missing.
    pub(super) measurement: &'a [f64],
    /// The states of the step before.
    pub(super) previous: &'a [f64],
}

impl<M: StateSpaceModel + ?Sized> Common<'_, M> {
    /// `log p(y_t | x_t)` of what is there of the measurement, at each of `R` states (`R×N`): 0, and nothing is asked of the model, where nothing was measured.
    fn log_likelihoods(&self, states: &[f64], out: &mut [f64]) -> Result<(), Fault> {
        if self.entries.iter().all(Option::is_none) {
            out.fill(0.0);
            return Ok(());
        }
        self.model.log_likelihoods(&self.step, states, self.entries, out).map_err(Fault::Model)
    }
}

/// A step of all filters.
pub(super) struct BankStep<'a, M: ?Sized, P: Proposal<M>> {
    pub(super) proposal: &'a P,
    pub(super) common: Common<'a, M>,
    pub(super) scratches: &'a Scratches<P::Scratch>,
}

/// The memory of consecutive particles of a proposal.
pub(super) type Memory<'m, M, P> = <<P as Proposal<M>>::Memory as ParticleMemory>::Rows<'m>;

impl<M: StateSpaceModel + ?Sized, P: Proposal<M>> BankStep<'_, M, P> {
    /// Draws and weighs all filters, each of which is resampled before if `resamples`.
    pub(super) fn advance<'m>(
        &self,
        filters: Filters<'_, Memory<'m, M, P>>,
        resamples: bool,
        threads: Threads,
    ) {
        let k = self.common.settings.particles;
        if k <= BLOCK {
            let each = self.group();
            let groups = Groups { filters, each };
            return threads.share(groups, 1, &|groups: Groups<'_, _>| {
                self.advance_small(groups.filters, resamples);
            });
        }
        let mut rest = filters;
        while rest.count() > 0 {
            let (mut filter, others) = rest.split(1);
            if resamples {
                filter.resample(&self.common.settings, threads);
            }
            self.advance_large(filter, threads);
            rest = others;
        }
    }

    /// How many small filters are drawn together: by the proposal and the number of particles alone, so that no result depends on threads.
    fn group(&self) -> usize {
        (self.proposal.block().min(BLOCK) / self.common.settings.particles).max(1)
    }

    /// Filters of one block each, or less.
    fn advance_small<'m>(&self, filters: Filters<'_, Memory<'m, M, P>>, resamples: bool) {
        let k = self.common.settings.particles;
        let together = self.group().min(filters.count());
        let mut scratch = self.scratches.take();
        with_scratch(together * k, |increments| {
            let mut rest = filters;
            while rest.count() > 0 {
                let count = together.min(rest.count());
                let (mut filters, others) = rest.split(count);
                if resamples {
                    filters.resample(&self.common.settings, Threads::One);
                }
                let Filters { first, streams, weights, resampled, outcomes, ancestors, states, memory } =
                    filters;
                let ancestors = resampled.contains(&true).then_some(&*ancestors);
                let increments = &mut increments[..streams.len() * k];
                let block = Block { rows: first * k..first * k + increments.len(), ancestors, memory };
                let drawn = self.draw(block, streams, states, increments, &mut scratch);
                let filters = weights.iter_mut().zip(increments.chunks_exact(k)).zip(outcomes);
                for ((weights, increments), outcome) in filters {
                    let ess_before = weights.effective_sample_size();
                    let increment = match &drawn {
                        Ok(()) => weights.update(increments).map_err(Fault::Weights),
                        Err(fault) => Err(fault.clone()),
                    };
                    *outcome = Outcome { ess_before, increment };
                }
                rest = others;
            }
        });
        self.scratches.put(scratch);
    }

    /// A filter of several blocks. Each has a stream of its own: that of a key that the filter's stream gives, with the block's number
    /// as nonce.
    fn advance_large<'m>(&self, filter: Filters<'_, Memory<'m, M, P>>, threads: Threads) {
        let Filters { first, streams, weights, resampled, outcomes, ancestors, states, memory } = filter;
        let (stream, weights, outcome) = (&mut streams[0], &mut weights[0], &mut outcomes[0]);
        let (first, ancestors) =
            (first * self.common.settings.particles, resampled[0].then_some(&*ancestors));
        let ess_before = weights.effective_sample_size();
        let (key, width) = (key(stream), self.common.model.state_dim());
        // The first fault in the order of the blocks, whichever thread finds it.
        let fault: Mutex<Option<(usize, Fault)>> = Mutex::new(None);
        let blocks = DrawnBlocks { first: 0, width, states, weights: weights.blocks(), memory };
        threads.share(blocks, 1, &|blocks: DrawnBlocks<'_, _>| {
            let mut scratch = self.scratches.take();
            with_scratch(BLOCK, |increments| {
                let mut rest = blocks;
                while rest.count() > 0 {
                    let (DrawnBlocks { first: block, states, mut weights, memory, .. }, others) =
                        rest.split(1);
                    let increments = &mut increments[..states.len() / width];
                    let start = block * BLOCK;
                    let ancestors = ancestors.map(|ancestors| &ancestors[start..start + increments.len()]);
                    let mut stream = [block_stream(key, block)];
                    let rows = first + start..first + start + increments.len();
                    let block_of_rows = Block { rows, ancestors, memory };
                    match self.draw(block_of_rows, &mut stream, states, increments, &mut scratch) {
                        Ok(()) => weights.multiply(increments),
                        Err(found) => {
                            let mut fault = fault.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                            if fault.as_ref().is_none_or(|(earlier, _)| block < *earlier) {
                                *fault = Some((block, found));
                            }
                        }
                    }
                    rest = others;
                }
            });
            self.scratches.put(scratch);
        });
        let fault = fault.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        let increment = match fault {
            Some((_, fault)) => Err(fault),
            None => weights.normalise(threads).map_err(Fault::Weights),
        };
        *outcome = Outcome { ess_before, increment };
    }

    /// Draws a block and writes `log p(y|x) + log p(x|x') − log q` of each particle, which has a finite state unless it weighs nothing.
    fn draw(
        &self,
        block: Block<'_, Memory<'_, M, P>>,
        streams: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
        scratch: &mut P::Scratch,
    ) -> Result<(), Fault> {
        let first = block.rows.start;
        self.draw_and_weigh(block, streams, states, increments, scratch)?;
        self.check_states(first, states, increments)
    }

    fn draw_and_weigh(
        &self,
        block: Block<'_, Memory<'_, M, P>>,
        streams: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
        scratch: &mut P::Scratch,
    ) -> Result<(), Fault> {
        let Block { rows, ancestors, memory } = block;
        let Common { model, step, previous, .. } = self.common;
        let (first, width) = (rows.start, model.state_dim());
        let previous = (step.index > 0).then(|| match ancestors {
            None => Rows::all(&previous[rows.start * width..rows.end * width], width),
            Some(ancestors) => Rows::picked(previous, width, ancestors),
        });
        let context = Context { step, previous, particles: rows.len() };
        let conditioned = self.proposal.condition(model, context, memory, scratch);
        let mut conditional = conditioned.map_err(|error| Fault::Proposal(error.in_batch(first)))?;
        // A mixture of the transition with itself is no other.
        if conditional.is_transition() {
            drop(conditional);
            return self.draw_from_transition(context, streams, states, increments);
        }
        let asked = self.common.settings.defensive_weight;
        let defensive = asked.filter(|weight| *weight > 0.0);
        if defensive.is_none() && conditional.sample_weighted(streams, states, increments) {
            return Ok(());
        }
        with_scratch(2 * increments.len(), |terms| {
            let (transitions, likelihoods) = terms.split_at_mut(increments.len());
            if conditional.sample_by_noise(asked, streams, states, increments) {
                self.common.log_likelihoods(states, likelihoods)?;
                increments.iter_mut().zip(&*likelihoods).for_each(|(ratio, likelihood)| *ratio += likelihood);
                return Ok(());
            }
            if model.density().is_none() {
                return Err(Fault::Proposal(ProposalError::NoDensity));
            }
            let mut transition = Transition::new(model, context);
            match defensive {
                Some(weight) => {
                    let mut mixture = Defensive { base: conditional, transition, weight };
                    mixture.draw(streams, states, increments, transitions);
                }
                None => {
                    conditional.sample(streams, states, increments);
                    transition.log_density(states, transitions);
                }
            }
            self.common.log_likelihoods(states, likelihoods)?;
            for (increment, (likelihood, transition)) in
                increments.iter_mut().zip(likelihoods.iter().zip(&*transitions))
            {
                // A state that cannot be reached weighs nothing, whatever its measurement would be.
                *increment = match *transition == f64::NEG_INFINITY {
                    true => f64::NEG_INFINITY,
                    false => likelihood + transition - *increment,
                };
            }
            Ok(())
        })
    }

    /// Draws from the transition, whose density cancels in the weight: in one pass with the likelihood where the model can.
    fn draw_from_transition(
        &self,
        context: Context<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
    ) -> Result<(), Fault> {
        let Common { model, step, measurement, .. } = self.common;
        if let (Some(previous), Some(propagator), false) =
            (context.previous, model.propagator(), measurement.is_empty())
        {
            propagator.propagate(&step, previous, measurement, streams, states, increments);
            return Ok(());
        }
        Transition::new(model, context).sample(streams, states, increments);
        self.common.log_likelihoods(states, increments)
    }

    /// Refuses states that are not finite, unless they weigh nothing: no measurement need tell. `first` is the row of the first in the bank.
    fn check_states(&self, first: usize, states: &[f64], increments: &[f64]) -> Result<(), Fault> {
        if are_finite(states) {
            return Ok(());
        }
        let width = self.common.model.state_dim();
        let weighs = |at: usize| increments[at / width] > f64::NEG_INFINITY;
        match states.iter().enumerate().find(|(at, value)| !value.is_finite() && weighs(*at)) {
            None => Ok(()),
            Some((at, value)) => {
                Err(Fault::State { row: first + at / width, coordinate: at % width, value: *value })
            }
        }
    }
}

/// Whether all numbers are finite, by a pass without branches.
fn are_finite(numbers: &[f64]) -> bool {
    by_widest_vectors(
        #[inline(always)]
        || {
            let (rows, rest) = numbers.as_chunks::<LANES>();
            let mut sums = [0.0; LANES];
            // What is not finite is no number when it is multiplied by 0.
            for row in rows {
                sums.iter_mut().zip(row).for_each(|(sum, number)| *sum += number * 0.0);
            }
            sums.iter().chain(rest).all(|number| number.is_finite())
        },
    )
}

/// Which particles are drawn together.
struct Block<'a, R> {
    /// Their rows in the bank.
    rows: Range<usize>,
    /// The row of each one's ancestor; their own rows if there are none.
    ancestors: Option<&'a [usize]>,
    memory: R,
}

/// Consecutive small filters, in groups that are drawn together.
struct Groups<'a, R> {
    filters: Filters<'a, R>,
    each: usize,
}

impl<R: MemoryRows> Pieces for Groups<'_, R> {
    fn count(&self) -> usize {
        self.filters.count().div_ceil(self.each)
    }

    fn split(self, groups: usize) -> (Self, Self) {
        let Groups { filters, each } = self;
        let (first, others) = filters.split(groups * each);
        (Groups { filters: first, each }, Groups { filters: others, each })
    }
}

/// Consecutive blocks of a filter.
struct DrawnBlocks<'a, R> {
    /// The number of the first.
    first: usize,
    width: usize,
    states: &'a mut [f64],
    weights: WeightBlocks<'a>,
    memory: R,
}

impl<R: MemoryRows> Pieces for DrawnBlocks<'_, R> {
    fn count(&self) -> usize {
        self.weights.count()
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let DrawnBlocks { first, width, states, weights, memory } = self;
        let particles = (blocks * BLOCK).min(states.len() / width);
        let (states, later_states) = states.split_at_mut(particles * width);
        let (weights, later_weights) = weights.split(blocks);
        let (memory, later_memory) = memory.split(particles);
        let later = first + blocks;
        (
            DrawnBlocks { first, width, states, weights, memory },
            DrawnBlocks {
                first: later,
                width,
                states: later_states,
                weights: later_weights,
                memory: later_memory,
            },
        )
    }
}
