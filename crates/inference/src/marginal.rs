//! The marginal likelihood by importance sampling.

use serde::{Deserialize, Serialize};

/// An estimate of `log p(y)`, the likelihood averaged over the prior.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MarginalLikelihood {
    /// `log p̂(y)`; p̂ is unbiased.
    pub log: f64,
    /// The standard error of `log`.
    pub standard_error: f64,
}

/// Weights that are effective as fewer draws than this do not tell.
const EFFECTIVE: f64 = 30.0;

impl MarginalLikelihood {
    /// That of `log w = log ẑ(θ) + log p(v) − log q(v)` of independent draws of q, `log p` without its constant. None where too few of them count.
    pub(crate) fn of(log_weights: &[f64], dimension: usize) -> Option<Self> {
        let largest = log_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !largest.is_finite() {
            return None;
        }
        let n = log_weights.len() as f64;
        let [mut sum, mut squares] = [0.0; 2];
        for log_weight in log_weights {
            let weight = (log_weight - largest).exp();
            sum += weight;
            squares += weight * weight;
        }
        let effective = sum * sum / squares;
        let constant = -0.5 * dimension as f64 * motes_models::LN_2PI;
        let log = largest + (sum / n).ln() + constant;
        // The coefficient of variation of the mean.
        let standard_error = ((1.0 / effective - 1.0 / n).max(0.0)).sqrt();
        (effective >= EFFECTIVE).then_some(MarginalLikelihood { log, standard_error })
    }
}
