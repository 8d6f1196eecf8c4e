//! The shape of a covariance.

use serde::{Deserialize, Serialize};

/// The shape of a covariance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Covariance {
    /// Any, by its Cholesky factor: `N(N+1)/2` numbers.
    Full,
    /// Any correlations by its Cholesky factor, the same for all particles of a time, and each particle's own scales: `N` numbers for each, and
    /// `N(N−1)/2` for all.
    ///
    /// For states of many coordinates: a network that emits `N(N+1)/2` numbers has more weights than can be learned in seconds.
    Shared,
    /// Coordinates of `u` are independent: `N` numbers.
    Diagonal,
}
