//! What filters take noise to be.

use serde::{Deserialize, Serialize};

/// The densities in weights and objective.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Densities {
    /// Gaussian with the true mean and covariance, whatever the noise.
    Gaussian,
    /// Those of the noise family itself.
    Exact,
}
