//! Why there is no fit.

use thiserror::Error;

use crate::prior_draw::PriorDraw;

/// Why there is no fit; `E` is the error of the likelihood.
#[derive(Debug, Error, PartialEq)]
pub enum FitError<E> {
    /// There is no parameter, no chain, no estimator, or no filter for what was asked for.
    #[error("there is nothing to fit")]
    Nothing,
    /// The likelihood is 0 at every draw from the prior; this is the first one.
    #[error("the likelihood is 0 at every draw from the prior")]
    Impossible(Box<PriorDraw>),
    /// The likelihood cannot be had.
    #[error(transparent)]
    Likelihood(#[from] E),
}
