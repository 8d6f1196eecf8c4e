//! Whether chains have converged, and how much their draws tell: Vehtari, Gelman, Simpson, Carpenter and Bürkner (2021), “Rank-normalization, folding, and
//! localization: an improved R̂ for assessing convergence of MCMC”.

mod autocovariance;
mod ranks;
mod summary;

pub use summary::{ParameterSummary, r_hat};
