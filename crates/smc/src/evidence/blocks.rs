//! What small filters beside a filter say of the variance of its log-evidence, block by block of steps.

use serde::{Deserialize, Serialize};

/// Steps of a block: errors of a step show in the evidence of about so many later ones.
const BLOCK_STEPS: usize = 32;

/// The effective particles that each small filter must be able to expect where the filter has reached the peak of a likelihood: with fewer it misses the
/// peak, and its evidence does not scale with its size.
const LEAST_EXPECTED: f64 = 2.0;

/// One filter of `K` particles beside `R` small ones of `K/ρ`.
///
/// The variance of a log-evidence is in proportion to one over the number of particles, and so is its bias, `−½` of the variance. In a block of steps in which
/// the filter's evidence grew by `e` and that of the small ones by `e_1 … e_R`, with mean `ē` and sample variance `s²`, there are therefore two estimates of
/// the filter's variance `v`:
///
/// - `s²/ρ`, with `R − 1` degrees of freedom;
/// - `(e − ē − ½(ρ − 1)v)² / (1 + ρ/R)`, with one; the `v` in the bias is that of the ancestry.
///
/// Their average by degrees of freedom is added up over blocks. Not judged is a block in which small filters must miss what the filter has reached: where it
/// had fewer than `2ρ` effective particles at a step, and yet its largest log-weights had an upper end; or one of them collapsed. The variance by
/// ancestry stands in there.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Blocks {
    /// `ρ` and `R`.
    ratio: f64,
    small: usize,
    /// The variance of all blocks that are over.
    variance: f64,
    present: Block,
}

/// The block that goes on.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Block {
    steps: usize,
    increment: f64,
    /// Of each small filter.
    small: Vec<f64>,
    is_out_of_reach: bool,
    /// The variance by ancestry before the block, and now.
    ancestry: [f64; 2],
}

impl Blocks {
    /// For a filter with `ratio` times the particles of each of `small` filters.
    pub(super) fn new(ratio: f64, small: usize) -> Self {
        let mut blocks = Blocks { ratio, small, ..Blocks::default() };
        blocks.begin(0.0);
        blocks
    }

    fn begin(&mut self, ancestry: f64) {
        self.present.steps = 0;
        self.present.increment = 0.0;
        self.present.small.clear();
        self.present.small.resize(self.small, 0.0);
        self.present.is_out_of_reach = false;
        self.present.ancestry = [ancestry; 2];
    }

    /// Whether small filters miss a peak that leaves so many effective particles to the filter.
    pub(super) fn would_miss(&self, effective: f64) -> bool {
        effective < LEAST_EXPECTED * self.ratio
    }

    /// Takes in a step: by how much the log-evidence of the filter and of the small ones grew, whether the latter miss a peak that the filter has reached, and
    /// the filter's variance by ancestry of all steps up to this one.
    pub(super) fn step(
        &mut self,
        increment: f64,
        small: impl Iterator<Item = f64>,
        is_out_of_reach: bool,
        ancestry: f64,
    ) {
        if self.present.steps == BLOCK_STEPS {
            self.variance += self.variance_of_present();
            self.begin(self.present.ancestry[1]);
        }
        let block = &mut self.present;
        block.steps += 1;
        block.increment += increment;
        block.small.iter_mut().zip(small).for_each(|(sum, increment)| *sum += increment);
        block.is_out_of_reach |= is_out_of_reach;
        block.ancestry[1] = ancestry;
    }

    /// What the present block adds.
    fn variance_of_present(&self) -> f64 {
        let (block, count) = (&self.present, self.small as f64);
        let by_ancestry = block.ancestry[1] - block.ancestry[0];
        let is_judged = self.small > 0
            && !block.is_out_of_reach
            && block.small.iter().all(|increment| increment.is_finite());
        if !is_judged {
            return by_ancestry;
        }
        let mean = block.small.iter().sum::<f64>() / count;
        let squares: f64 = block.small.iter().map(|increment| (increment - mean).powi(2)).sum();
        let excess = block.increment - mean - 0.5 * (self.ratio - 1.0) * by_ancestry;
        let of_difference = excess * excess / (1.0 + self.ratio / count);
        (squares / self.ratio + of_difference) / count
    }

    /// The variance of the log-evidence after all steps so far.
    pub(super) fn variance(&self) -> f64 {
        self.variance + if self.present.steps > 0 { self.variance_of_present() } else { 0.0 }
    }
}
