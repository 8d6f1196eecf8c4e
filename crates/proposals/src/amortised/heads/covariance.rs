//! The shape of a covariance.

use serde::{Deserialize, Serialize};

/// The shape of a covariance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Covariance {
    /// Any, by its Cholesky factor: `N(N+1)/2` numbers.
    Full,
    /// Coordinates of `u` are independent: `N` numbers.
    Diagonal,
}
