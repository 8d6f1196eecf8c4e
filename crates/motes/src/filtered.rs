//! What filters made of data.

use motes_smc::{Verdict, WeightReport, error_of_variance, variance_of_error};
use serde::{Deserialize, Serialize};

use crate::estimate::{Estimate, Forecast};
use crate::warning::Warning;

/// What filters made of data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Filtered {
    /// The estimate of each row of the data, in their order.
    pub estimates: Vec<Estimate>,
    /// What is predicted after the last measurement of each series.
    pub forecasts: Vec<Vec<Forecast>>,
    /// The log-evidence of each series.
    pub log_evidence_per_series: Vec<f64>,
    /// Its standard error, the root of its mean square error; none where it is not checked, or of too few particles to tell, and 0 where the log-evidence is exact.
    pub standard_error_per_series: Vec<Option<f64>>,
    /// The exact log-evidence of each series by the Kalman filter, where the model is linear and Gaussian and filters are checked.
    pub exact_log_evidence_per_series: Vec<Option<f64>>,
    /// What the weights of all steps say.
    pub weights: WeightReport,
    /// The least effective sample size of all steps; none without particles.
    pub least_ess: Option<f64>,
    /// Reasons not to trust the estimates.
    pub warnings: Vec<Warning>,
    /// What a bootstrap filter beside that of each series says; none where none ran.
    pub opinions: Vec<Option<Verdict>>,
    /// The particles of each row, in the order of the data, where they were to be kept ([`FilterOptions::keep_particles`](crate::FilterOptions::keep_particles)).
    pub particles: Vec<WeightedParticles>,
}

/// The particles of a row, weighted by its measurement, before any are resampled.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WeightedParticles {
    /// Their states (`K×N`).
    pub states: Vec<f64>,
    /// Their weights (`K`), whose sum is 1.
    pub weights: Vec<f64>,
}

impl Filtered {
    /// The log-evidence of all series together.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence_per_series.iter().sum()
    }

    /// Its standard error: series are independent, so their variances add up, and their biases do. None if a series has none.
    pub fn standard_error(&self) -> Option<f64> {
        let errors = self.standard_error_per_series.iter().copied();
        let variance: Option<f64> = errors.map(|error| error.map(variance_of_error)).sum();
        variance.map(error_of_variance)
    }
}
