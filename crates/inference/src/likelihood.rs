//! What parameters are fitted to.

use motes_models::Seed;
use serde::{Deserialize, Serialize};

/// The likelihood of data as a function of `D` parameters, or an unbiased estimate of it.
///
/// Parameters are positions `v` in ℝᴰ, whose prior is `N(0, I)`: each parameter is a quantile of its prior, `θ = F⁻¹(Φ(v))`. So every prior with a quantile
/// function is covered, parameters stay within their support, and no density of a transformation is needed.
pub trait Likelihood: Sync {
    /// Why it cannot be had at all; a likelihood of 0 is none.
    type Error: Send;

    /// `D`, the number of parameters.
    fn dimension(&self) -> usize;

    /// The estimators that there are, at least one.
    fn estimators(&self) -> &[EstimatorCost];

    /// `log ẑ(θ(v))` where the expectation of ẑ is the likelihood: an independent estimate for each seed, −∞ where it is 0.
    ///
    /// # Errors
    /// Those of the implementation.
    fn log_likelihood(&self, v: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, Self::Error>;

    /// The filter of the data whose particles have parameters of their own, if there is one.
    fn perturbed(&self) -> Option<&dyn PerturbedLikelihood<Error = Self::Error>> {
        None
    }

    /// What is reported of a position, and what chains have to agree about: the values of parameters, or `v` itself.
    fn reported(&self, v: &[f64]) -> Vec<f64> {
        v.to_vec()
    }
}

/// A filter of the data whose particles have parameters of their own, which go a random walk: what iterated filtering takes.
pub trait PerturbedLikelihood: Sync {
    /// That of the likelihood.
    type Error: Send;

    /// The estimator that filters alike, its place in [`Likelihood::estimators`].
    fn estimator(&self) -> usize;

    /// Takes the positions of a swarm (`K×D`) through the data, perturbed and resampled on the way.
    ///
    /// # Errors
    /// Those of the implementation.
    fn pass(&self, positions: &mut [f64], walk: RandomWalk<'_>, seed: &Seed) -> Result<(), Self::Error>;

    /// The standard deviation of each coordinate's walk at `v` if its spread is 1 and it has no directions.
    fn steps(&self, v: &[f64]) -> Vec<f64> {
        vec![1.0; v.len()]
    }
}

/// How parameters are perturbed in a pass through data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomWalk<'a> {
    /// The standard deviation of a coordinate's walk over all rows, were it as fast as at the first one. What `x_0` alone depends on goes it all at the start.
    pub spread: f64,
    /// `L` (`D×D`, row after row), if coordinates walk together: a step has the covariance `L Lᵀ` by the square of the spread.
    pub directions: Option<&'a [f64]>,
    /// By how much it is slower at the last row.
    pub cooling: f64,
    /// The coordinate that stays as it is, if one does.
    pub fixed: Option<usize>,
}

/// What an estimator costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatorCost {
    /// The work of a particle, in any unit that the estimators of a likelihood share; it is counted, never measured by a clock.
    pub per_particle: f64,
    /// The work of an estimate besides, however few particles there are.
    pub fixed: f64,
    /// Whether it is the likelihood itself, whatever the number of particles.
    pub is_exact: bool,
}

impl EstimatorCost {
    /// The work of an estimate with so many particles.
    pub fn of(&self, particles: usize) -> f64 {
        self.fixed + self.per_particle * particles as f64
    }

    /// The number of particles that so much work pays for.
    pub(crate) fn particles_for(&self, work: f64) -> usize {
        ((work - self.fixed) / self.per_particle).max(0.0) as usize
    }
}

/// One of a likelihood's estimators.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Estimator {
    /// Its place in [`Likelihood::estimators`].
    pub index: usize,
    /// `K`, the number of particles; without meaning where it is exact.
    pub particles: usize,
}
