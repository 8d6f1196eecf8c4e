//! The marginal likelihood by importance sampling.

use motes_models::LN_2PI;
use serde::{Deserialize, Serialize};

use crate::log_mean::LogMean;

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
        let mean = LogMean::of(log_weights);
        let standard_error = mean.standard_error()?;
        let constant = -0.5 * dimension as f64 * LN_2PI;
        (mean.effective() >= EFFECTIVE)
            .then_some(MarginalLikelihood { log: mean.log() + constant, standard_error })
    }
}
