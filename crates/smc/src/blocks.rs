//! How a bank's particles are cut into blocks, each with a random stream of its own, and drawn block by block.
//!
//! The cut depends on the number of particles alone, so that any number of threads draws the same numbers.

use motes_models::batch::with_scratch;
use motes_models::{StateSpaceModel, Stream};
use rand::{Rng, SeedableRng};

use crate::workers::Workers;
use crate::{Past, RowProposal};

/// Particles of one filter that draw from one stream.
const BLOCK: usize = 1024;
/// Particles that are drawn and weighed together: few enough to stay in the nearest cache in between.
const BATCH: usize = 256;
/// Below so many particles another thread takes longer to wake than to help.
const GRAIN: usize = 2048;

/// The streams of the blocks of one step.
///
/// A filter of up to 1024 particles is one block and draws from its own stream. A larger one takes a key from its stream
/// at each step, and each of its blocks has the stream of that key with its own number as nonce.
pub(crate) struct Blocks {
    particles: usize,
    in_filter: usize,
    streams: Vec<Stream>,
}

impl Blocks {
    pub(crate) fn new(particles: usize, filters: &[Stream]) -> Self {
        let in_filter = particles.div_ceil(BLOCK);
        let streams = if in_filter == 1 { Vec::new() } else { Vec::with_capacity(filters.len() * in_filter) };
        Blocks { particles, in_filter, streams }
    }

    /// One stream for each block of the bank.
    fn streams<'a>(&'a mut self, filters: &'a mut [Stream]) -> &'a mut [Stream] {
        if self.in_filter == 1 {
            return filters;
        }
        self.streams.clear();
        for filter in filters {
            let mut key = [0; 32];
            filter.fill_bytes(&mut key);
            for block in 0..self.in_filter as u64 {
                let mut stream = Stream::from_seed(key);
                stream.set_stream(block);
                self.streams.push(stream);
            }
        }
        &mut self.streams
    }

    /// Draws every particle of the bank.
    pub(crate) fn draw<M: StateSpaceModel + ?Sized>(
        &mut self,
        step: &Step<'_, M>,
        filters: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
    ) {
        let cut = Cut { particles: self.particles, in_filter: self.in_filter };
        let part = Part { first: 0, cut, streams: self.streams(filters), states, increments };
        part.draw(step);
    }
}

/// What all blocks of a step share.
pub(crate) struct Step<'a, M: ?Sized> {
    pub(crate) proposal: &'a dyn RowProposal<M>,
    pub(crate) model: &'a M,
    pub(crate) workers: &'a Workers,
    pub(crate) time: usize,
    pub(crate) measurement: &'a [f64],
    /// The states of the step before, `None` at the first.
    pub(crate) previous: Option<&'a [f64]>,
    /// The row of `previous` that each particle descends from; `None` if each from its own.
    pub(crate) ancestors: Option<&'a [usize]>,
}

/// Where blocks begin.
#[derive(Clone, Copy)]
struct Cut {
    particles: usize,
    in_filter: usize,
}

impl Cut {
    /// The first row of a block.
    fn row(self, block: usize) -> usize {
        block / self.in_filter * self.particles + block % self.in_filter * BLOCK
    }
}

/// Blocks one after another.
struct Part<'a> {
    /// The number of the first block in the bank.
    first: usize,
    cut: Cut,
    streams: &'a mut [Stream],
    states: &'a mut [f64],
    increments: &'a mut [f64],
}

impl Part<'_> {
    fn draw<M: StateSpaceModel + ?Sized>(self, step: &Step<'_, M>) {
        let blocks = self.streams.len();
        if blocks == 1 || step.workers.threads() == 1 || self.increments.len() < 2 * GRAIN {
            return self.draw_here(step);
        }
        let (left, right) = self.split(blocks / 2, step.model.state_dim());
        step.workers.join(|| left.draw(step), || right.draw(step));
    }

    /// The first `blocks` blocks, and the others.
    fn split<'b>(self, blocks: usize, width: usize) -> (Part<'b>, Part<'b>)
    where
        Self: 'b,
    {
        let rows = self.cut.row(self.first + blocks) - self.cut.row(self.first);
        let (left_streams, right_streams) = self.streams.split_at_mut(blocks);
        let (left_states, right_states) = self.states.split_at_mut(rows * width);
        let (left_increments, right_increments) = self.increments.split_at_mut(rows);
        let part =
            |first, streams, states, increments| Part { first, cut: self.cut, streams, states, increments };
        (
            part(self.first, left_streams, left_states, left_increments),
            part(self.first + blocks, right_streams, right_states, right_increments),
        )
    }

    fn draw_here<M: StateSpaceModel + ?Sized>(self, step: &Step<'_, M>) {
        let Part { first, cut, streams, mut states, mut increments } = self;
        let mut at = cut.row(first);
        let mut draw = |streams: &mut [Stream], rows: usize| {
            let (now, later) = std::mem::take(&mut states).split_at_mut(rows * step.model.state_dim());
            let (weighed, unweighed) = std::mem::take(&mut increments).split_at_mut(rows);
            step.draw(at, streams, now, weighed);
            (states, increments) = (later, unweighed);
            at += rows;
        };
        let together = BATCH / cut.particles;
        if together > 1 {
            for streams in streams.chunks_mut(together) {
                draw(streams, streams.len() * cut.particles);
            }
        } else {
            for (block, stream) in (first..).zip(streams) {
                let mut left = cut.row(block + 1) - cut.row(block);
                while left > 0 {
                    let rows = left.min(BATCH);
                    draw(std::slice::from_mut(stream), rows);
                    left -= rows;
                }
            }
        }
    }
}

impl<M: StateSpaceModel + ?Sized> Step<'_, M> {
    fn past<'b>(&'b self, previous: Option<&'b [f64]>, particles: usize) -> Past<'b> {
        Past { time: self.time, previous, measurement: self.measurement, particles }
    }

    /// Draws the particles from row `at` of the bank on.
    fn draw(&self, at: usize, streams: &mut [Stream], states: &mut [f64], increments: &mut [f64]) {
        let (width, particles) = (self.model.state_dim(), increments.len());
        match (self.previous, self.ancestors) {
            (None, _) => {
                self.proposal.draw(self.model, self.past(None, particles), streams, states, increments)
            }
            (Some(previous), None) => {
                let previous = &previous[at * width..(at + particles) * width];
                self.proposal.draw(
                    self.model,
                    self.past(Some(previous), particles),
                    streams,
                    states,
                    increments,
                );
            }
            (Some(previous), Some(ancestors)) => with_scratch(particles * width, |gathered| {
                gather(previous, width, &ancestors[at..at + particles], gathered);
                self.proposal.draw(
                    self.model,
                    self.past(Some(gathered), particles),
                    streams,
                    states,
                    increments,
                );
            }),
        }
    }
}

/// Copies the rows named by `ancestors`, one after another.
pub(crate) fn gather(states: &[f64], width: usize, ancestors: &[usize], gathered: &mut [f64]) {
    for (row, &ancestor) in gathered.chunks_exact_mut(width).zip(ancestors) {
        row.copy_from_slice(&states[ancestor * width..(ancestor + 1) * width]);
    }
}
