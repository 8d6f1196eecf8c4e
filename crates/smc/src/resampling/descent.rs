//! Ancestors block by block: any thread can find where the offspring of a block of weights begins and ends.

use motes_models::batch::with_scratch;
use motes_models::{Stream, fill_standard_exponential};
use pulp::{Simd, WithSimd};

use super::ranks::{SortedPoints, among_regular, among_strata, descend};
use crate::parallel::{Pieces, Threads};
use crate::streams::{block_stream, key};
use crate::weights::{BLOCK, LANES, combined};

/// Blocks that a thread would rather do itself than hand on.
const GRAIN: usize = 2;

/// Increasing points on `[0, count]` that choose ancestors.
#[derive(Clone, Copy)]
pub(super) enum Points<'a> {
    /// `k + offset`.
    Regular { offset: f64 },
    /// `k + offsets[k]`.
    Strata { offsets: &'a [f64] },
    /// Sorted uniform ones, up to `most` of them another time.
    Sorted { spacings: Spacings<'a>, most: usize },
}

impl Points<'_> {
    /// How many of `count` points lie below a value.
    fn rank(&self, value: f64, count: usize) -> usize {
        match self {
            Points::Regular { offset } => among_regular(value, *offset, count),
            Points::Strata { offsets } => among_strata(value, offsets),
            Points::Sorted { spacings, .. } => spacings.rank(value),
        }
    }
}

/// `count` sorted uniform points on `[0, count]`: partial sums of exponential spacings, in units of the whole sum over `count`.
#[derive(Clone, Copy)]
pub(super) struct Spacings<'a> {
    /// Partial sums within each block.
    partial: &'a [f64],
    /// The sum of the blocks before each.
    before: &'a [f64],
    /// What makes sums points.
    scale: f64,
}

impl<'a> Spacings<'a> {
    /// Numbers of scratch for `count` points.
    pub(super) fn scratch(count: usize) -> usize {
        count + 1 + (count + 1).div_ceil(BLOCK)
    }

    /// Draws them, each block from a stream of its own if there are several.
    pub(super) fn draw(count: usize, stream: &mut Stream, scratch: &'a mut [f64], threads: Threads) -> Self {
        let blocks = (count + 1).div_ceil(BLOCK);
        let (partial, before) = scratch[..Spacings::scratch(count)].split_at_mut(count + 1);
        if blocks == 1 {
            fill_standard_exponential(stream, partial);
            before[0] = accumulate(partial);
        } else {
            let key = key(stream);
            threads.share(Parts { first: 0, partial, sums: before }, GRAIN, &|parts: Parts<'_>| {
                let blocks = parts.partial.chunks_mut(BLOCK).zip(parts.sums);
                for (block, (partial, sum)) in (parts.first..).zip(blocks) {
                    fill_standard_exponential(&mut block_stream(key, block), partial);
                    *sum = accumulate(partial);
                }
            });
        }
        let mut whole = 0.0;
        for sum in before.iter_mut() {
            whole += std::mem::replace(sum, whole);
        }
        Spacings { partial: &partial[..count], before, scale: count as f64 / whole }
    }

    #[inline(always)]
    fn point(&self, k: usize) -> f64 {
        (self.partial[k] + self.before[k / BLOCK]) * self.scale
    }

    fn rank(&self, value: f64) -> usize {
        let (mut low, mut high) = (0, self.partial.len());
        while low < high {
            let middle = low.midpoint(high);
            if self.point(middle) < value {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// Makes spacings their partial sums and returns the whole.
fn accumulate(spacings: &mut [f64]) -> f64 {
    let mut sum = 0.0;
    for spacing in spacings {
        sum += *spacing;
        *spacing = sum;
    }
    sum
}

/// Blocks of spacings and their sums.
struct Parts<'a> {
    first: usize,
    partial: &'a mut [f64],
    sums: &'a mut [f64],
}

impl Pieces for Parts<'_> {
    fn count(&self) -> usize {
        self.sums.len()
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let (partial, later_partial) = self.partial.split_at_mut((blocks * BLOCK).min(self.partial.len()));
        let (sums, later_sums) = self.sums.split_at_mut(blocks);
        (
            Parts { first: self.first, partial, sums },
            Parts { first: self.first + blocks, partial: later_partial, sums: later_sums },
        )
    }
}

/// Fills `ancestors` by weights that sum to anything positive, of particles the first of which is row `first`.
pub(super) fn draw(
    weights: &[f64],
    first: usize,
    points: Points<'_>,
    ancestors: &mut [usize],
    threads: Threads,
) {
    let count = ancestors.len();
    with_scratch(weights.len().div_ceil(BLOCK).max(1) + 1, |before| {
        before[0] = 0.0;
        // What weights sum up to before each block, as multiples of what a point stands for.
        let mut whole = 0.0;
        for (before, weights) in before.iter_mut().zip(weights.chunks(BLOCK)) {
            *before = whole;
            whole += pulp::Arch::new().dispatch(Sum(weights));
        }
        let blocks = before.len() - 1;
        before[blocks] = whole;
        let descent = Descent {
            weights,
            before,
            // Points behind what is left by rounding are the last block's that has a weight.
            last: before[..blocks].partition_point(|before| *before < whole),
            scale: count as f64 / whole,
            points,
            row: first,
            count,
        };
        threads.share(
            Blocks { descent: &descent, blocks: 0..blocks, start: 0, ancestors },
            GRAIN,
            &Blocks::fill,
        );
    });
}

/// The sum of weights.
struct Sum<'a>(&'a [f64]);

impl WithSimd for Sum<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> f64 {
        let (whole, rest) = self.0.as_chunks::<LANES>();
        let mut sums = [0.0; LANES];
        for weights in whole {
            for i in 0..LANES {
                sums[i] += weights[i];
            }
        }
        sums[..rest.len()].iter_mut().zip(rest).for_each(|(sum, weight)| *sum += weight);
        combined(&sums, |a, b| a + b)
    }
}

/// What all blocks share.
struct Descent<'a> {
    weights: &'a [f64],
    before: &'a [f64],
    /// The number of blocks up to the last with a positive weight.
    last: usize,
    scale: f64,
    points: Points<'a>,
    /// The number of the first weight.
    row: usize,
    count: usize,
}

impl Descent<'_> {
    /// Where the offspring of a block begins.
    fn start(&self, block: usize) -> usize {
        match block {
            0 => 0,
            _ if block >= self.last => self.count,
            _ => self.points.rank(self.before[block] * self.scale, self.count),
        }
    }
}

/// Consecutive blocks of weights and their offspring.
struct Blocks<'a> {
    descent: &'a Descent<'a>,
    blocks: std::ops::Range<usize>,
    /// The number of the first ancestor.
    start: usize,
    ancestors: &'a mut [usize],
}

impl Pieces for Blocks<'_> {
    fn count(&self) -> usize {
        self.blocks.len()
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let Blocks { descent, blocks: all, start, ancestors } = self;
        let middle = all.start + blocks;
        let end = descent.start(middle).clamp(start, start + ancestors.len());
        let (ancestors, later) = ancestors.split_at_mut(end - start);
        (
            Blocks { descent, blocks: all.start..middle, start, ancestors },
            Blocks { descent, blocks: middle..all.end, start: end, ancestors: later },
        )
    }
}

impl Blocks<'_> {
    fn fill(self) {
        let mut rest = self;
        while rest.blocks.len() > 1 {
            let (one, others) = rest.split(1);
            one.fill_block();
            rest = others;
        }
        rest.fill_block();
    }

    /// The offspring of a single block.
    fn fill_block(self) {
        let Blocks { descent, blocks, start, ancestors } = self;
        let Descent { before, scale, count, .. } = *descent;
        let at = blocks.start * BLOCK;
        let weights = &descent.weights[at..descent.weights.len().min(at + BLOCK)];
        let (row, before, after) = (descent.row + at, before[blocks.start], before[blocks.start + 1]);
        match descent.points {
            Points::Regular { offset } => {
                let rank = |sum: f64| among_regular(sum * scale, offset, count).saturating_sub(start);
                descend(weights, row, before, rank, ancestors);
            }
            Points::Strata { offsets } => {
                let rank = |sum: f64| among_strata(sum * scale, offsets).saturating_sub(start);
                descend(weights, row, before, rank, ancestors);
            }
            // As much scratch as the worst block could need, so that a thread allocates it once.
            Points::Sorted { spacings, most } => with_scratch(SortedPoints::scratch(most), |scratch| {
                let here = ancestors.len();
                // One point in each unit on average, so that finding a rank takes no search.
                let unit = here as f64 / ((after - before) * scale);
                let origin = before * scale;
                for (point, k) in scratch[..here].iter_mut().zip(start..) {
                    *point = ((spacings.point(k) - origin) * unit).max(0.0);
                }
                let sorted = SortedPoints::new(scratch, here);
                let rank = |sum: f64| sorted.rank((sum * scale - origin) * unit);
                descend(weights, row, before, rank, ancestors);
            }),
        }
    }
}
