//! Log-weights: one value that knows its normalised weights, effective sample size and log-sum.

use thiserror::Error;

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
    effective_sample_size: f64,
}

impl LogWeights {
    /// `K` equal weights.
    pub fn uniform(particles: usize) -> Self {
        let mut weights = LogWeights { log: vec![0.0; particles], effective_sample_size: 0.0 };
        weights.reset();
        weights
    }

    /// Makes all weights equal again, as resampling does.
    pub fn reset(&mut self) {
        let particles = self.log.len() as f64;
        self.log.fill(-particles.ln());
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
        let mut largest = f64::NEG_INFINITY;
        for (particle, (log, increment)) in self.log.iter_mut().zip(increments).enumerate() {
            *log += increment;
            if log.is_nan() || *log == f64::INFINITY {
                return Err(WeightFault::NotANumber { particle, value: *log });
            }
            largest = largest.max(*log);
        }
        if largest == f64::NEG_INFINITY {
            return Err(WeightFault::AllZero);
        }
        let (mut sum, mut sum_of_squares) = (0.0, 0.0);
        for log in &self.log {
            let weight = (log - largest).exp();
            sum += weight;
            sum_of_squares += weight * weight;
        }
        self.effective_sample_size = sum * sum / sum_of_squares;
        let log_sum = largest + sum.ln();
        for log in &mut self.log {
            *log -= log_sum;
        }
        Ok(log_sum)
    }

    /// `log W_k`.
    pub fn log(&self) -> &[f64] {
        &self.log
    }

    /// `W_k`, summing to 1.
    pub fn normalised(&self) -> impl ExactSizeIterator<Item = f64> {
        self.log.iter().map(|log| log.exp())
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
        assert!(weights.normalised().zip(expected).all(|(w, e)| (w - e).abs() < 1e-15));
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
            assert!((weights.normalised().sum::<f64>() - 1.0).abs() < 1e-9);
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
