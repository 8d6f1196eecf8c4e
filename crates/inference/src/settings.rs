//! What a fit is made with.

use serde::{Deserialize, Serialize};

use crate::likelihood::Estimator;

/// What a posterior is sampled with; [`PosteriorSettings::default`] is what `motes fit` takes where nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PosteriorSettings {
    /// The number of chains, at least one.
    pub chains: usize,
    /// The draws of each chain that are kept; none where it goes on until the gates hold, or [`PosteriorSettings::most_draws`] are drawn.
    pub draws: Option<usize>,
    /// The most draws of each chain where no number is given.
    pub most_draws: usize,
    /// The effective sample size that each parameter is to have, in the bulk and in the tails.
    pub effective: f64,
    /// What R̂ of each parameter is to be below.
    pub rhat: f64,
    /// An estimator of the likelihood in the place of that which is found.
    pub estimator: Option<EstimatorChoice>,
}

/// What is chosen of an estimator beforehand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum EstimatorChoice {
    /// Its number of particles alone; which one is found.
    Particles(usize),
    /// All of it.
    Estimator(Estimator),
}

impl Default for PosteriorSettings {
    fn default() -> Self {
        PosteriorSettings {
            chains: 4,
            draws: None,
            most_draws: 20_000,
            effective: 400.0,
            rhat: 1.01,
            estimator: None,
        }
    }
}
