#![doc = include_str!("../README.md")]

mod chain;
mod diagnostics;
mod error;
mod likelihood;
mod marginal;
mod maximum;
mod normal_fit;
mod parallel;
mod population;
mod posterior;
mod settings;
mod tuning;

pub use chain::Moves;
pub use diagnostics::{ParameterSummary, r_hat};
pub use error::FitError;
pub use likelihood::{Estimator, EstimatorCost, Likelihood};
pub use marginal::MarginalLikelihood;
pub use maximum::{Interval, Maximum, MaximumSearch, MaximumSettings};
pub use posterior::{Posterior, Stage};
pub use settings::{EstimatorChoice, PosteriorSettings};
