//! Why there is no fit.

use thiserror::Error;

/// Why there is no fit; `E` is the error of the likelihood.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum FitError<E> {
    /// There is no parameter, no chain, or no estimator.
    #[error("there is nothing to fit")]
    Nothing,
    /// The likelihood is 0 at every draw from the prior.
    #[error("the likelihood is 0 at every draw from the prior")]
    Impossible,
    /// The likelihood cannot be had.
    #[error(transparent)]
    Likelihood(#[from] E),
}
