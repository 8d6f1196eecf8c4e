//! What a fit found.

use motes_inference::{MarginalLikelihood, ParameterSummary};
use serde::{Deserialize, Serialize};

use super::draws::FitParameters;
use crate::warning::Warning;

/// The draws of a chain, in order.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PosteriorChain {
    /// The values of the `D` parameters at each draw, one draw after the other.
    pub values: Vec<f64>,
    /// The estimate of the log-likelihood at each draw.
    pub log_evidence: Vec<f64>,
}

/// The posterior of parameters by draws.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PosteriorFit {
    /// The names of the `D` parameters.
    pub names: Vec<String>,
    /// The draws of each chain, as many of each.
    pub chains: Vec<PosteriorChain>,
    /// What they say of each parameter.
    pub parameters: Vec<ParameterSummary>,
    /// The log-likelihood at the posterior's mean: `log` of the average of some estimates.
    pub log_likelihood: f64,
    /// Its standard error; 0 where it is exact.
    pub log_likelihood_error: f64,
    /// `log p(y)`, the likelihood averaged over the prior; none where the draws do not tell.
    pub marginal_likelihood: Option<MarginalLikelihood>,
    /// The shares of moves that were made: of the random walk, and of those that are drawn independently.
    pub acceptance: [f64; 2],
    /// The estimator of the likelihood, as `--proposal` names it.
    pub proposal: String,
    /// Its number of particles.
    pub particles: usize,
    /// The variance of its log-likelihood near the posterior's mean; NaN where it was not asked.
    pub variance: f64,
    /// Quantiles of the prior of each parameter, in the middles of intervals of equal probability; none of a share of a dirichlet.
    pub prior_quantiles: Vec<Vec<f64>>,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

impl PosteriorFit {
    /// The number of draws of each chain.
    pub fn draws(&self) -> usize {
        self.chains.first().map_or(0, |chain| chain.log_evidence.len())
    }

    /// The values of the parameters (`D`) at a draw of a chain.
    pub fn values(&self, chain: usize, draw: usize) -> &[f64] {
        let d = self.names.len();
        &self.chains[chain].values[draw * d..(draw + 1) * d]
    }

    /// The draws of a parameter, by chain.
    pub fn of_parameter(&self, parameter: usize) -> Vec<Vec<f64>> {
        let d = self.names.len();
        let of_chain =
            |chain: &PosteriorChain| chain.values.iter().skip(parameter).step_by(d).copied().collect();
        self.chains.iter().map(of_chain).collect()
    }

    /// All draws, for [`FitParameters::spread`].
    pub fn draw_values(&self) -> FitParameters {
        let d = self.names.len();
        let of_chain =
            |chain: &PosteriorChain| chain.values.chunks(d).map(<[f64]>::to_vec).collect::<Vec<_>>();
        let values = self.chains.iter().flat_map(of_chain).collect();
        FitParameters { names: self.names.clone(), values, set: vec![], is_maximum: false }
    }

    /// The mean of each parameter.
    pub fn means(&self) -> Vec<(String, f64)> {
        self.names.iter().cloned().zip(self.parameters.iter().map(|summary| summary.mean)).collect()
    }

    /// The share of all moves that were made, where half of them are of either kind.
    pub fn acceptance_of_all(&self) -> f64 {
        0.5 * (self.acceptance[0] + self.acceptance[1])
    }
}
