//! Parameters of state-space models from data: posteriors by particle Markov chain Monte Carlo, maxima of likelihoods that are estimated, and how far chains can be
//! trusted.
//!
//! A [`Likelihood`] is the exact one or an unbiased estimate of it, such as the evidence of a particle filter. [`Posterior`] and [`MaximumSearch`] do a piece of work at a
//! time, and can be written down between two pieces.

mod chain;
mod diagnostics;
mod error;
mod likelihood;
mod log_mean;
mod marginal;
mod maximum;
mod normal_fit;
mod parallel;
mod population;
mod posterior;
mod prior_draw;
mod settings;
mod tuning;

pub use chain::Moves;
pub use diagnostics::{ParameterSummary, r_hat};
pub use error::FitError;
pub use likelihood::{Estimator, EstimatorCost, Likelihood, PerturbedLikelihood, RandomWalk};
pub use log_mean::LogMean;
pub use marginal::MarginalLikelihood;
pub use maximum::{IteratedSettings, Maximum, MaximumSearch, MaximumSettings, Profile, ProfilePoint};
pub use parallel::map_on_threads;
pub use posterior::{Posterior, Stage};
pub use prior_draw::PriorDraw;
pub use settings::{EstimatorChoice, PosteriorSettings};
