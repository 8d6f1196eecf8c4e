//! What chains say of a parameter.

use serde::{Deserialize, Serialize};

use super::autocovariance::{Variances, effective_sample_size, variances};
use super::ranks::{folded, normal_scores, quantile, sorted};

/// The posterior of a parameter by its draws, and how far they can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ParameterSummary {
    /// The mean of all draws.
    pub mean: f64,
    /// Their standard deviation.
    pub sd: f64,
    /// Their quantile at 5 %.
    pub q05: f64,
    /// Their median.
    pub q50: f64,
    /// Their quantile at 95 %.
    pub q95: f64,
    /// The larger one of the rank-normalised split R̂ of the draws and of their distances from the median; NaN where chains stand still.
    pub rhat: f64,
    /// The effective number of draws for the centre of the distribution.
    pub ess_bulk: f64,
    /// The effective number for its quantiles at 5 and 95 %.
    pub ess_tail: f64,
    /// The Monte Carlo standard error of the mean.
    pub mcse: f64,
}

impl ParameterSummary {
    /// That of the draws of chains of one length; none of fewer than four draws each.
    pub fn of(chains: &[Vec<f64>]) -> Option<Self> {
        let length = chains.first()?.len();
        if length < 4 || chains.iter().any(|chain| chain.len() != length) {
            return None;
        }
        let halves = halves(chains);
        let all = sorted(chains);
        let count = all.len() as f64;
        let mean = all.iter().sum::<f64>() / count;
        let sd = (all.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
        let [q05, q50, q95] = [0.05, 0.5, 0.95].map(|probability| quantile(&all, probability));
        let below = |limit: f64| -> f64 {
            let indicators = |chain: &Vec<f64>| chain.iter().map(|x| f64::from(*x <= limit)).collect();
            effective_sample_size(&halves.iter().map(indicators).collect::<Vec<Vec<f64>>>())
        };
        Some(ParameterSummary {
            mean,
            sd,
            q05,
            q50,
            q95,
            rhat: r_hat(chains),
            ess_bulk: effective_sample_size(&normal_scores(&halves)),
            ess_tail: below(q05).min(below(q95)),
            mcse: sd / effective_sample_size(&halves).sqrt(),
        })
    }
}

/// The rank-normalised split R̂ of chains of one length, at least four draws each: the larger one of that of the draws and of that of their distances from the
/// median. 1 where chains agree; NaN where all draws are the same.
pub fn r_hat(chains: &[Vec<f64>]) -> f64 {
    let halves = halves(chains);
    let of = |chains: &[Vec<f64>]| {
        let Variances { within, total } = variances(&normal_scores(chains));
        (total / within).sqrt()
    };
    of(&halves).max(of(&folded(&halves)))
}

/// Each chain as its first and its second half; the middle one of an odd number of draws is in none.
fn halves(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let of_chain = |chain: &Vec<f64>| {
        let half = chain.len() / 2;
        [chain[..half].to_vec(), chain[chain.len() - half..].to_vec()]
    };
    chains.iter().flat_map(of_chain).collect()
}
