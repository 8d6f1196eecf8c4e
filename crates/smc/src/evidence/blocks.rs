//! What small filters beside a filter say of the variance of its log-evidence, block by block of steps.

use serde::{Deserialize, Serialize};

/// Steps of a block: errors of a step show in the evidence of about so many later ones.
const BLOCK_STEPS: usize = 32;

/// The effective particles that each small filter must be able to expect where the filter has reached the peak of a likelihood: with fewer it misses the
/// peak, and its evidence does not scale with its size.
const LEAST_EXPECTED: f64 = 2.0;

/// The least exponent by which variances are taken to fall with the number of particles.
const LEAST_EXPONENT: f64 = 0.3;

/// One filter of `K` particles beside `R` small ones of `K/ρ`.
///
/// For large `K` the variance of a log-evidence is in proportion to `1/K`, and its bias is `−½` of the variance. Where particles hardly reach what the
/// measurements ask for it falls more slowly, as `K^−α`. The ancestry of the particles shows it: with `a` the variance by ancestry of the filter and `ā` the mean
/// of that of the small ones, both up to the end of a block, `α = log(ā/a) / log ρ`, from 0.3 to 1.
///
/// In a block of steps in which the filter's evidence grew by `e` and that of the small ones by `e_1 … e_R`, with mean `ē` and sample variance `s²`, there are
/// two estimates of the filter's variance `v`, with `r = ρ^α`:
///
/// - `s²/r`, with `R − 1` degrees of freedom;
/// - `(e − ē − ½(ρ − 1)a)² / (1 + r/R)`, with one.
///
/// Their average by degrees of freedom, or the first where it is larger, is added up over blocks. Not judged is a block in which small filters must miss what the
/// filter has reached: where it had fewer than `2ρ` effective particles at a step, and yet its largest log-weights had an upper end; or one of them collapsed. The variance by
/// ancestry stands in there.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Blocks {
    /// `ρ` and `R`.
    ratio: f64,
    small: usize,
    /// Of all blocks that are over.
    sums: Sums,
    present: Block,
}

/// What blocks add up to.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Sums {
    /// By small filters, or by ancestry where these cannot judge.
    variance: f64,
    /// `a` and `ā` of all.
    ancestry: [f64; 2],
}

/// The block that goes on.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Block {
    steps: usize,
    increment: f64,
    /// Of each small filter.
    small: Vec<f64>,
    is_out_of_reach: bool,
    /// `a` and `ā` of all steps before the block, and now.
    ancestry: [[f64; 2]; 2],
}

impl Blocks {
    /// For a filter with `ratio` times the particles of each of `small` filters.
    pub(super) fn new(ratio: f64, small: usize) -> Self {
        let mut blocks = Blocks { ratio, small, ..Blocks::default() };
        blocks.begin([0.0; 2]);
        blocks
    }

    fn begin(&mut self, ancestry: [f64; 2]) {
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
    /// the variances by ancestry, `a` and `ā`, of all steps up to this one.
    pub(super) fn step(
        &mut self,
        increment: f64,
        small: impl Iterator<Item = f64>,
        is_out_of_reach: bool,
        ancestry: [f64; 2],
    ) {
        if self.present.steps == BLOCK_STEPS {
            self.sums = self.sums_with_present();
            self.begin(self.present.ancestry[1]);
        }
        let block = &mut self.present;
        block.steps += 1;
        block.increment += increment;
        block.small.iter_mut().zip(small).for_each(|(sum, increment)| *sum += increment);
        block.is_out_of_reach |= is_out_of_reach;
        block.ancestry[1] = ancestry;
    }

    /// The sums with what the present block adds.
    fn sums_with_present(&self) -> Sums {
        let (block, count, mut sums) = (&self.present, self.small as f64, self.sums);
        let [own, of_small] = [0, 1].map(|which| block.ancestry[1][which] - block.ancestry[0][which]);
        sums.ancestry[0] += own;
        sums.ancestry[1] += of_small;
        let is_judged = self.small > 0
            && !block.is_out_of_reach
            && block.small.iter().all(|increment| increment.is_finite());
        if !is_judged {
            sums.variance += own;
            return sums;
        }
        let exponent = (sums.ancestry[1] / sums.ancestry[0]).ln() / self.ratio.ln();
        // Where nothing varies there is nothing to scale.
        let exponent = if exponent.is_nan() { 1.0 } else { exponent.clamp(LEAST_EXPONENT, 1.0) };
        let scale = self.ratio.powf(exponent);
        let mean = block.small.iter().sum::<f64>() / count;
        let squares = block.small.iter().map(|increment| (increment - mean).powi(2)).sum::<f64>();
        let excess = block.increment - mean - 0.5 * (self.ratio - 1.0) * own;
        let by_spread = squares / (count - 1.0) / scale;
        let by_excess = excess * excess / (1.0 + scale / count);
        sums.variance += by_spread.max(((count - 1.0) * by_spread + by_excess) / count);
        sums
    }

    /// The variance of the log-evidence after all steps so far.
    pub(super) fn variance(&self) -> f64 {
        let sums = if self.present.steps > 0 { self.sums_with_present() } else { self.sums };
        sums.variance
    }
}
