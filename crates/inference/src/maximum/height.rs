//! The log-likelihood at a point.

use motes_models::Seed;

use crate::likelihood::{Estimator, Likelihood};
use crate::log_mean::LogMean;
use crate::parallel::map_on_threads;

/// The log-likelihood at a point by so many estimates, with particles by a factor, and its standard error; 0 where it is exact.
pub(super) fn height<L: Likelihood>(
    likelihood: &L,
    v: &[f64],
    estimator: Estimator,
    (factor, estimates): (usize, usize),
    seed: &Seed,
) -> Result<(f64, f64), L::Error> {
    if likelihood.estimators()[estimator.index].is_exact {
        return Ok((likelihood.log_likelihood(v, estimator, seed)?, 0.0));
    }
    let estimator = Estimator { particles: estimator.particles * factor, ..estimator };
    let found = map_on_threads(&vec![(); estimates], |number, ()| {
        likelihood.log_likelihood(v, estimator, &seed.nth(number as u64))
    });
    let mean = LogMean::of(&found.into_iter().collect::<Result<Vec<f64>, L::Error>>()?);
    Ok((mean.log(), mean.standard_error().unwrap_or(f64::NAN)))
}
