//! Log-weights: one value that knows its normalised weights, effective sample size and log-sum.

mod quantiles;
mod stored;
mod sums;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::parallel::{Pieces, Threads};
pub(crate) use sums::{LANES, combined};
use sums::{Mean, Shift, Sums, Together, Update};

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

/// Particles whose weights are summed up together, while they are in the nearest cache, and resampled on one thread.
pub(crate) const BLOCK: usize = 1024;

/// The log-weights of `K` particles, normalised: `Σ_k exp(log W_k) = 1`.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(into = "stored::StoredWeights", try_from = "stored::StoredWeights")]
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
        self.normalise(Threads::One)
    }

    /// The weights in blocks, each to be multiplied once before [`LogWeights::normalise`].
    pub(crate) fn blocks(&mut self) -> WeightBlocks<'_> {
        let equal = self.equal.then(|| -(self.log.len() as f64).ln());
        WeightBlocks { equal, log: &mut self.log, weights: &mut self.normalised, sums: &mut self.blocks }
    }

    /// Ends an update of all blocks, as [`LogWeights::update`].
    pub(crate) fn normalise(&mut self, threads: Threads) -> Result<f64, WeightFault> {
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
        threads.share(self.blocks(), GRAIN, &|blocks: WeightBlocks<'_>| {
            let parts = blocks.log.chunks_mut(BLOCK).zip(blocks.weights.chunks_mut(BLOCK));
            for ((log, weights), sums) in parts.zip(blocks.sums) {
                pulp::Arch::new().dispatch(Shift { log, weights, log_sum, sums, whole: &whole });
            }
        });
        Ok(log_sum)
    }

    /// The weighted mean `Σ_k W_k x_k` of `states` (`K×N`), into `mean` (`N`); a particle without weight has no part in it, wherever it is.
    pub(crate) fn mean(&self, states: &[f64], mean: &mut [f64]) {
        pulp::Arch::new().dispatch(Mean { weights: &self.normalised, states, mean });
        if mean.iter().all(|mean| mean.is_finite()) {
            return;
        }
        mean.fill(0.0);
        let rows = self.normalised.iter().zip(states.chunks_exact(mean.len()));
        for (weight, row) in rows.filter(|(weight, _)| **weight > 0.0) {
            mean.iter_mut().zip(row).for_each(|(mean, value)| *mean += weight * value);
        }
    }

    /// Weighted quantiles of one number `x_k` of each particle (`K` of them): for each probability `p` the smallest value that particles with a
    /// weight of at least `p` together do not exceed. A particle without weight has no part in it; NaN where none has weight.
    ///
    /// # Panics
    /// If a probability is not between 0 and 1, or there is not one value for each particle.
    pub fn quantiles(&self, values: impl Iterator<Item = f64>, probabilities: &[f64]) -> Vec<f64> {
        let values: Vec<f64> = values.collect();
        assert_eq!(values.len(), self.len(), "one value for each particle");
        for probability in probabilities {
            assert!((0.0..=1.0).contains(probability), "{probability} is no probability");
        }
        quantiles::quantiles(&values, &self.normalised, probabilities)
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

/// Whether all weights are the same; how they were summed up does not matter.
impl PartialEq for LogWeights {
    fn eq(&self, other: &Self) -> bool {
        self.log == other.log && self.normalised == other.normalised
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_weight_changes_nothing() {
        let dead = f64::NEG_INFINITY;
        let mut weights = LogWeights::uniform(3);
        weights.update(&[0.0, dead, 0.0]).unwrap();
        // Its state has run away since.
        let evidence = weights.update(&[1.0, f64::NAN, 3.0]).unwrap();
        let mut alone = LogWeights::uniform(2);
        assert!((evidence - alone.update(&[1.0, 3.0]).unwrap()).abs() < 1e-15);
        assert_eq!(weights.log()[1], dead);
        for state in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            let (mut mean, mut expected) = ([0.0; 2], [0.0; 2]);
            weights.mean(&[1.0, 2.0, state, 7.0, 5.0, 6.0], &mut mean);
            alone.mean(&[1.0, 2.0, 5.0, 6.0], &mut expected);
            assert!(mean.iter().zip(expected).all(|(mean, expected)| (mean - expected).abs() < 1e-12));
        }
        let found = weights.update(&[f64::NAN, 0.0, 0.0]);
        assert!(matches!(found, Err(WeightFault::NotANumber { particle: 0, .. })));
    }

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
    fn weights_that_were_reset_are_equal_ones() {
        let mut weights = LogWeights::uniform(3);
        weights.update(&[0.0, 1.0, 2.0]).unwrap();
        assert_ne!(weights, LogWeights::uniform(3));
        weights.reset();
        assert_eq!(weights, LogWeights::uniform(3));
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
