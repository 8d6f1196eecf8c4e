//! Log-weights: one value that knows its normalised weights, effective sample size and log-sum.

use pulp::{Simd, WithSimd};
use thiserror::Error;

use motes_models::elementary::exp;

use crate::workers::{Pieces, Workers};

/// Why a set of log-weights cannot be normalised.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WeightFault {
    /// A log-weight is NaN or +∞.
    #[error("particle {particle} has the log-weight {value}")]
    NotANumber {
        /// Index of the particle.
        particle: usize,
        /// Its log-weight.
        value: f64,
    },
    /// Every weight is zero.
    #[error("all weights are zero")]
    AllZero,
}

/// Particles whose weights are summed up together, while they are in the nearest cache.
pub(crate) const BLOCK: usize = 1024;

/// The log-weights of `K` particles, normalised: `Σ_k exp(log W_k) = 1`.
#[derive(Debug, Clone, PartialEq)]
pub struct LogWeights {
    log: Vec<f64>,
    normalised: Vec<f64>,
    effective_sample_size: f64,
    /// Whether all weights are equal whatever is stored, until they are updated.
    equal: bool,
    /// Of each block of weights, in the midst of an update.
    blocks: Vec<Sums>,
}

impl LogWeights {
    /// `K` equal weights.
    pub fn uniform(particles: usize) -> Self {
        let zeros = vec![0.0; particles];
        let mut weights = LogWeights {
            log: zeros.clone(),
            normalised: zeros,
            effective_sample_size: 0.0,
            equal: false,
            blocks: vec![Sums::default(); particles.div_ceil(BLOCK)],
        };
        weights.reset();
        weights
    }

    /// Makes all weights equal again, as resampling does.
    pub fn reset(&mut self) {
        let particles = self.log.len() as f64;
        self.log.fill(-particles.ln());
        self.normalised.fill(1.0 / particles);
        self.effective_sample_size = particles;
    }

    /// [`LogWeights::reset`] of weights that nobody looks at before the next update.
    pub(crate) fn reset_until_update(&mut self) {
        self.effective_sample_size = self.log.len() as f64;
        self.equal = true;
    }

    /// Multiplies each normalised weight by `exp(increment)`, normalises again, and returns the logarithm of
    /// the sum before that: `log Σ_k W_k exp(increment_k)`.
    ///
    /// Over a filter's steps these sums add up to an estimate of the log-evidence whose exponential is
    /// unbiased, however seldom the filter resamples; it is right because the weights `W_k` of the step
    /// before are in it.
    ///
    /// # Errors
    /// [`WeightFault`] if an increment is NaN or +∞ or if no weight is left; the weights are then unusable.
    ///
    /// # Panics
    /// If there is not one increment for each particle.
    pub fn update(&mut self, increments: &[f64]) -> Result<f64, WeightFault> {
        assert_eq!(increments.len(), self.log.len(), "one increment for each particle");
        let mut blocks = self.blocks();
        for increments in increments.chunks(BLOCK) {
            let (mut block, others) = blocks.split(1);
            block.multiply(increments);
            blocks = others;
        }
        self.normalise(&Workers::none())
    }

    /// The weights in blocks, each to be multiplied once before [`LogWeights::normalise`].
    pub(crate) fn blocks(&mut self) -> WeightBlocks<'_> {
        let equal = self.equal.then(|| -(self.log.len() as f64).ln());
        WeightBlocks { equal, log: &mut self.log, weights: &mut self.normalised, sums: &mut self.blocks }
    }

    /// Ends an update of all blocks, as [`LogWeights::update`].
    pub(crate) fn normalise(&mut self, workers: &Workers) -> Result<f64, WeightFault> {
        self.equal = false;
        let whole = pulp::Arch::new().dispatch(Together(&self.blocks));
        if !whole.number {
            let fault = self.log.iter().position(|log| log.is_nan() || *log == f64::INFINITY);
            let particle = fault.unwrap_or_default();
            return Err(WeightFault::NotANumber { particle, value: self.log[particle] });
        }
        if whole.largest == f64::NEG_INFINITY {
            return Err(WeightFault::AllZero);
        }
        self.effective_sample_size = whole.sum * whole.sum / whole.sum_of_squares;
        let log_sum = whole.largest + whole.sum.ln();
        workers.share(self.blocks(), GRAIN, &|blocks: WeightBlocks<'_>| {
            let parts = blocks.log.chunks_mut(BLOCK).zip(blocks.weights.chunks_mut(BLOCK));
            for ((log, weights), sums) in parts.zip(blocks.sums) {
                pulp::Arch::new().dispatch(Shift { log, weights, log_sum, sums, whole: &whole });
            }
        });
        Ok(log_sum)
    }

    /// The weighted mean `Σ_k W_k x_k` of `states` (`K×N`), into `mean` (`N`).
    pub(crate) fn mean(&self, states: &[f64], mean: &mut [f64]) {
        pulp::Arch::new().dispatch(Mean { weights: &self.normalised, states, mean });
    }

    /// `log W_k`.
    pub fn log(&self) -> &[f64] {
        &self.log
    }

    /// `W_k`, summing to 1.
    pub fn normalised(&self) -> &[f64] {
        &self.normalised
    }

    /// `K_eff = 1 / Σ_k W_k²`, between 1 and `K` (the paper's equation "Keff").
    pub fn effective_sample_size(&self) -> f64 {
        self.effective_sample_size
    }

    /// Number of particles, `K`.
    pub fn len(&self) -> usize {
        self.log.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.log.is_empty()
    }
}

/// Blocks of weights that a thread would rather do itself than hand on.
const GRAIN: usize = 8;

/// Consecutive blocks of weights in the midst of an update.
pub(crate) struct WeightBlocks<'a> {
    /// What every log-weight is, if not what is stored.
    equal: Option<f64>,
    log: &'a mut [f64],
    weights: &'a mut [f64],
    sums: &'a mut [Sums],
}

impl WeightBlocks<'_> {
    /// Adds increments to the log-weights of a single block, and leaves its weights as multiples of the largest of them.
    pub(crate) fn multiply(&mut self, increments: &[f64]) {
        let update = Update { equal: self.equal, log: self.log, weights: self.weights, increments };
        self.sums[0] = pulp::Arch::new().dispatch(update);
    }
}

impl Pieces for WeightBlocks<'_> {
    fn count(&self) -> usize {
        self.sums.len()
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let rows = (blocks * BLOCK).min(self.log.len());
        let (log, later_log) = self.log.split_at_mut(rows);
        let (weights, later_weights) = self.weights.split_at_mut(rows);
        let (sums, later_sums) = self.sums.split_at_mut(blocks);
        (
            WeightBlocks { equal: self.equal, log, weights, sums },
            WeightBlocks { equal: self.equal, log: later_log, weights: later_weights, sums: later_sums },
        )
    }
}

/// What one needs to know of weights to normalise them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sums {
    /// The largest log-weight.
    largest: f64,
    /// Whether each is a number below +∞.
    number: bool,
    /// Of the weights as multiples of the largest.
    sum: f64,
    sum_of_squares: f64,
}

impl Default for Sums {
    /// Of no weights.
    fn default() -> Self {
        Sums { largest: f64::NEG_INFINITY, number: true, sum: 0.0, sum_of_squares: 0.0 }
    }
}

impl Sums {
    /// Of these weights and others.
    #[inline(always)]
    fn with(self, other: &Sums) -> Sums {
        let largest = self.largest.max(other.largest);
        let (mine, others) = (multiple(self.largest, largest), multiple(other.largest, largest));
        Sums {
            largest,
            number: self.number && other.number,
            sum: mine * self.sum + others * other.sum,
            sum_of_squares: mine * mine * self.sum_of_squares + others * others * other.sum_of_squares,
        }
    }
}

/// What multiples of `part` are to be multiplied by to be multiples of `largest`, both of them logarithms.
#[inline(always)]
fn multiple(part: f64, largest: f64) -> f64 {
    // Where all weights are zero there is nothing to scale.
    if part == largest { 1.0 } else { exp(part - largest) }
}

/// The sums of all blocks, in their order, whoever summed them.
struct Together<'a>(&'a [Sums]);

impl WithSimd for Together<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Sums {
        match self.0 {
            [] => Sums::default(),
            [first, others @ ..] => {
                let mut sums = *first;
                for other in others {
                    sums = sums.with(other);
                }
                sums
            }
        }
    }
}

/// Adds increments to log-weights, and leaves `exp(log w_k − maxⱼ log w_j)`.
struct Update<'a> {
    equal: Option<f64>,
    log: &'a mut [f64],
    weights: &'a mut [f64],
    increments: &'a [f64],
}

/// Partial sums that are kept side by side; their number fixes the order of additions on any machine.
pub(crate) const LANES: usize = 32;
/// So many at a time at the end: not fewer, because a compiler that unrolls a loop forgets vectors.
const FEW: usize = 16;

impl WithSimd for Update<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Sums {
        let Update { equal, log, weights, increments } = self;
        let (mut largest, mut number) = ([f64::NEG_INFINITY; LANES], [1.0; LANES]);
        match equal {
            Some(equal) => {
                for (log, increment) in log.iter_mut().zip(increments) {
                    *log = equal + increment;
                }
            }
            None => {
                for (log, increment) in log.iter_mut().zip(increments) {
                    *log += increment;
                }
            }
        }
        let (whole, rest) = log.as_chunks::<LANES>();
        let (few, rest) = rest.as_chunks::<FEW>();
        let mut last = [f64::NEG_INFINITY; FEW];
        last[..rest.len()].copy_from_slice(rest);
        for log in whole {
            compare(log, &mut largest, &mut number);
        }
        for log in few {
            compare(log, &mut largest, &mut number);
        }
        compare(&last, &mut largest, &mut number);
        let largest = combined(&largest, |a, b| if a > b { a } else { b });
        let number = number == [1.0; LANES];

        let (mut sum, mut sum_of_squares) = ([0.0; LANES], [0.0; LANES]);
        let (whole_weights, rest_weights) = weights.as_chunks_mut::<LANES>();
        let (few_weights, rest_weights) = rest_weights.as_chunks_mut::<FEW>();
        for (log, weights) in whole.iter().zip(whole_weights) {
            exponentiate(log, largest, weights, &mut sum, &mut sum_of_squares);
        }
        for (log, weights) in few.iter().zip(few_weights) {
            exponentiate(log, largest, weights, &mut sum, &mut sum_of_squares);
        }
        let mut last_weights = [0.0; FEW];
        exponentiate(&last, largest, &mut last_weights, &mut sum, &mut sum_of_squares);
        rest_weights.copy_from_slice(&last_weights[..rest_weights.len()]);
        let (sum, sum_of_squares) = (combined(&sum, |a, b| a + b), combined(&sum_of_squares, |a, b| a + b));
        Sums { largest, number, sum, sum_of_squares }
    }
}

/// All lanes in one, in few steps that wait for each other.
#[inline(always)]
pub(crate) fn combined(lanes: &[f64; LANES], with: impl Fn(f64, f64) -> f64) -> f64 {
    let mut few = [0.0; 8];
    for i in 0..8 {
        few[i] = with(with(lanes[i], lanes[i + 8]), with(lanes[i + 16], lanes[i + 24]));
    }
    let [a, b, c, d, e, f, g, h] = few;
    with(with(with(a, e), with(b, f)), with(with(c, g), with(d, h)))
}

#[inline(always)]
fn compare<const L: usize>(log: &[f64; L], largest: &mut [f64; LANES], number: &mut [f64; LANES]) {
    for i in 0..L {
        largest[i] = if log[i] > largest[i] { log[i] } else { largest[i] };
        number[i] = if log[i] < f64::INFINITY { number[i] } else { 0.0 };
    }
}

#[inline(always)]
fn exponentiate<const L: usize>(
    log: &[f64; L],
    largest: f64,
    weights: &mut [f64; L],
    sum: &mut [f64; LANES],
    sum_of_squares: &mut [f64; LANES],
) {
    for i in 0..L {
        let weight = exp(log[i] - largest);
        weights[i] = weight;
        sum[i] += weight;
        sum_of_squares[i] = weight.mul_add(weight, sum_of_squares[i]);
    }
}

/// Makes multiples of a block's largest weight normalised ones.
struct Shift<'a> {
    log: &'a mut [f64],
    weights: &'a mut [f64],
    log_sum: f64,
    sums: &'a Sums,
    whole: &'a Sums,
}

impl WithSimd for Shift<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for log in self.log {
            *log -= self.log_sum;
        }
        let scale = multiple(self.sums.largest, self.whole.largest) / self.whole.sum;
        for weight in self.weights {
            *weight *= scale;
        }
    }
}

/// `Σ_k W_k x_k`.
struct Mean<'a> {
    weights: &'a [f64],
    states: &'a [f64],
    mean: &'a mut [f64],
}

impl WithSimd for Mean<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let width = self.mean.len();
        self.mean.fill(0.0);
        let (weights, last_weights) = self.weights.as_chunks::<4>();
        let mut rows = self.states.chunks_exact(4 * width);
        // Four particles at a time, so that the mean is not read and written for each.
        for (weights, rows) in weights.iter().zip(&mut rows) {
            let (a, rest) = rows.split_at(width);
            let (b, rest) = rest.split_at(width);
            let (c, d) = rest.split_at(width);
            for i in 0..width {
                let first = weights[0].mul_add(a[i], weights[1] * b[i]);
                let second = weights[2].mul_add(c[i], weights[3] * d[i]);
                self.mean[i] += first + second;
            }
        }
        for (weight, row) in last_weights.iter().zip(rows.remainder().chunks_exact(width)) {
            for (mean, value) in self.mean.iter_mut().zip(row) {
                *mean = weight.mul_add(*value, *mean);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worked_by_hand() {
        let mut weights = LogWeights::uniform(4);
        assert_eq!(weights.effective_sample_size(), 4.0);
        // W = ¼ each times (1, 2, 3, 2): the sum is 2, the weights ⅛, ¼, ⅜, ¼.
        let log_sum = weights.update(&[1.0_f64.ln(), 2.0_f64.ln(), 3.0_f64.ln(), 2.0_f64.ln()]).unwrap();
        assert!((log_sum - 2.0_f64.ln()).abs() < 1e-15);
        let expected = [0.125, 0.25, 0.375, 0.25];
        assert!(weights.normalised().iter().zip(expected).all(|(w, e)| (w - e).abs() < 1e-15));
        assert!((weights.effective_sample_size() - 64.0 / 18.0).abs() < 1e-14);
        // A second update without resampling starts from those weights, not from ¼ each.
        let log_sum = weights.update(&[8.0_f64.ln(), 0.0, 0.0, f64::NEG_INFINITY]).unwrap();
        assert!((log_sum - (1.0_f64 + 0.25 + 0.375).ln()).abs() < 1e-15);
    }

    #[test]
    fn extreme_increments_neither_overflow_nor_underflow() {
        for shift in [-1e5, 1e5] {
            let mut weights = LogWeights::uniform(2);
            let log_sum = weights.update(&[shift, shift + 3.0_f64.ln()]).unwrap();
            assert!((log_sum - shift - 2.0_f64.ln()).abs() < 1e-9);
            assert!((weights.normalised().iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn faults_are_named() {
        let update = |increments: &[f64]| LogWeights::uniform(2).update(increments).unwrap_err();
        assert!(matches!(update(&[0.0, f64::NAN]), WeightFault::NotANumber { particle: 1, .. }));
        assert!(matches!(update(&[f64::INFINITY, 0.0]), WeightFault::NotANumber { particle: 0, .. }));
        assert_eq!(update(&[f64::NEG_INFINITY; 2]), WeightFault::AllZero);
    }
}
