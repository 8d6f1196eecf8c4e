//! Log-weights: one value that knows its normalised weights, effective sample size and log-sum.

use pulp::{Simd, WithSimd};
use thiserror::Error;

use motes_models::elementary::exp;

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

/// The log-weights of `K` particles, normalised: `Σ_k exp(log W_k) = 1`.
#[derive(Debug, Clone, PartialEq)]
pub struct LogWeights {
    log: Vec<f64>,
    normalised: Vec<f64>,
    effective_sample_size: f64,
}

impl LogWeights {
    /// `K` equal weights.
    pub fn uniform(particles: usize) -> Self {
        let zeros = vec![0.0; particles];
        let mut weights = LogWeights { log: zeros.clone(), normalised: zeros, effective_sample_size: 0.0 };
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
        let LogWeights { log, normalised, .. } = self;
        let Sums { largest, number, sum, sum_of_squares } =
            pulp::Arch::new().dispatch(Update { log, normalised, increments });
        if !number {
            let fault = self.log.iter().position(|log| log.is_nan() || *log == f64::INFINITY);
            let particle = fault.unwrap_or_default();
            return Err(WeightFault::NotANumber { particle, value: self.log[particle] });
        }
        if largest == f64::NEG_INFINITY {
            return Err(WeightFault::AllZero);
        }
        self.effective_sample_size = sum * sum / sum_of_squares;
        let log_sum = largest + sum.ln();
        let scale = 1.0 / sum;
        for (log, weight) in self.log.iter_mut().zip(&mut self.normalised) {
            *log -= log_sum;
            *weight *= scale;
        }
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

/// Adds increments to log-weights, and leaves `exp(log w_k − maxⱼ log w_j)`.
struct Update<'a> {
    log: &'a mut [f64],
    normalised: &'a mut [f64],
    increments: &'a [f64],
}

/// What one needs to know of weights to normalise them.
struct Sums {
    largest: f64,
    /// Whether each is a number below +∞.
    number: bool,
    sum: f64,
    sum_of_squares: f64,
}

/// Partial sums that are kept side by side; their number fixes the order of additions on any machine.
const LANES: usize = 32;

impl WithSimd for Update<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Sums {
        let (mut largest, mut number) = ([f64::NEG_INFINITY; LANES], [1.0; LANES]);
        let mut raise = |log: &mut [f64; LANES], increments: &[f64; LANES]| {
            for i in 0..LANES {
                let value = log[i] + increments[i];
                log[i] = value;
                largest[i] = if value > largest[i] { value } else { largest[i] };
                number[i] = if value < f64::INFINITY { number[i] } else { 0.0 };
            }
        };
        let (log, last_log) = self.log.as_chunks_mut::<LANES>();
        let (increments, last_increments) = self.increments.as_chunks::<LANES>();
        for (log, increments) in log.iter_mut().zip(increments) {
            raise(log, increments);
        }
        let (mut padded_log, mut padded) = ([f64::NEG_INFINITY; LANES], [0.0; LANES]);
        padded_log[..last_log.len()].copy_from_slice(last_log);
        padded[..last_log.len()].copy_from_slice(last_increments);
        raise(&mut padded_log, &padded);
        last_log.copy_from_slice(&padded_log[..last_log.len()]);
        let largest = largest.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let number = number == [1.0; LANES];

        let (mut sum, mut sum_of_squares) = ([0.0; LANES], [0.0; LANES]);
        let mut exponentiate = |weights: &mut [f64; LANES], log: &[f64; LANES]| {
            for i in 0..LANES {
                let weight = exp(log[i] - largest);
                weights[i] = weight;
                sum[i] += weight;
                sum_of_squares[i] = weight.mul_add(weight, sum_of_squares[i]);
            }
        };
        let (weights, last_weights) = self.normalised.as_chunks_mut::<LANES>();
        for (weights, log) in weights.iter_mut().zip(log.iter()) {
            exponentiate(weights, log);
        }
        exponentiate(&mut padded, &padded_log);
        last_weights.copy_from_slice(&padded[..last_weights.len()]);
        Sums { largest, number, sum: sum.iter().sum(), sum_of_squares: sum_of_squares.iter().sum() }
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
