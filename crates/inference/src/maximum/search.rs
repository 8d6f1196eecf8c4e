//! Searches for the maximum of a likelihood: from the prior to the bulk of the posterior, then uphill on quadratics that are like its estimates nearby.

use motes_models::Seed;
use serde::{Deserialize, Serialize};

use super::hill::Hill;
use super::point::Maximum;
use super::profile::{Interval, profile};
use super::settings::MaximumSettings;
use crate::error::FitError;
use crate::likelihood::{Estimator, Likelihood};
use crate::normal_fit::NormalFit;
use crate::parallel::map;
use crate::population::Population;
use crate::settings::EstimatorChoice;
use crate::tuning::tune;

/// Rounds of a search uphill.
const ROUNDS: usize = 8;

/// The estimates of the log-likelihood at a maximum have particles by this factor, and are so many.
const LAST: (usize, usize) = (8, 64);

/// A maximum is the same as the best one if its log-likelihood is this close.
const CLOSE: f64 = 0.5;

/// Searches from draws of the prior, and intervals around the best of what they found, search by search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaximumSearch {
    settings: MaximumSettings,
    seed: u64,
    found: Vec<Maximum>,
    intervals: Vec<Interval>,
    possible: f64,
}

impl MaximumSearch {
    /// Before the first search.
    pub fn new(settings: MaximumSettings, seed: u64) -> Self {
        MaximumSearch { settings, seed, found: Vec::new(), intervals: Vec::new(), possible: 0.0 }
    }

    /// The number of searches and intervals that are done, and that of all.
    pub fn progress(&self, dimension: usize) -> (usize, usize) {
        (self.found.len() + self.intervals.len(), self.settings.starts + dimension)
    }

    /// Whether all is done.
    pub fn is_done(&self, dimension: usize) -> bool {
        let (done, all) = self.progress(dimension);
        done == all
    }

    /// The best of what searches found; none before the first one has ended.
    pub fn best(&self) -> Option<&Maximum> {
        self.found.iter().max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))
    }

    /// How many searches came as high as the best one.
    pub fn agreeing(&self) -> usize {
        let Some(best) = self.best() else { return 0 };
        let is_close = |found: &&Maximum| {
            let error = found.standard_error.hypot(best.standard_error);
            best.log_likelihood - found.log_likelihood <= CLOSE.max(3.0 * error)
        };
        self.found.iter().filter(is_close).count()
    }

    /// The number of searches that have ended.
    pub fn searches(&self) -> usize {
        self.found.len()
    }

    /// The interval of each parameter, once they are there.
    pub fn intervals(&self) -> &[Interval] {
        &self.intervals
    }

    /// The share of draws from the prior at which the likelihood is not 0.
    pub fn possible(&self) -> f64 {
        self.possible
    }

    /// Does the next search, or finds the next interval; nothing where all is done.
    ///
    /// # Errors
    /// [`FitError::Nothing`] if there is no parameter or no search, [`FitError::Impossible`] if the likelihood is 0 at every draw, [`FitError::Likelihood`] as it
    /// says; the search is then as it was before.
    pub fn advance<L: Likelihood>(&mut self, likelihood: &L) -> Result<(), FitError<L::Error>> {
        let d = likelihood.dimension();
        if d == 0 || self.settings.starts == 0 || likelihood.estimators().is_empty() {
            return Err(FitError::Nothing);
        }
        let seed = Seed::from_u64(self.seed).child("maximum");
        if self.found.len() < self.settings.starts {
            let number = self.found.len() as u64;
            let (found, possible) = self.search(likelihood, &seed.nth(number))?;
            self.possible += possible / self.settings.starts as f64;
            self.found.push(found);
        } else if self.intervals.len() < d
            && let Some(best) = self.best()
        {
            let at = self.intervals.len();
            let seed = seed.child("interval").nth(at as u64);
            let interval = profile(likelihood, best, at, self.settings.level, &seed)?;
            self.intervals.push(interval);
        }
        Ok(())
    }

    fn search<L: Likelihood>(
        &self,
        likelihood: &L,
        seed: &Seed,
    ) -> Result<(Maximum, f64), FitError<L::Error>> {
        let exact = likelihood.estimators().iter().position(|cost| cost.is_exact);
        let index = match self.settings.estimator {
            Some(EstimatorChoice::Estimator(estimator)) => estimator.index,
            _ => exact.unwrap_or(0),
        };
        let mut population = Population::new(likelihood, index, seed)?;
        if population.possible() == 0.0 {
            return Err(FitError::Impossible);
        }
        while population.power() < 1.0 {
            population.advance(likelihood, seed)?;
        }
        let positions: Vec<&[f64]> = population.members().iter().map(|member| member.v.as_slice()).collect();
        let each = positions.len().div_ceil(4);
        let asked: Vec<&[f64]> = positions.iter().step_by(each).copied().collect();
        let estimator = match self.settings.estimator {
            Some(EstimatorChoice::Estimator(estimator)) => estimator,
            chosen => {
                let particles = population.estimator().particles;
                let tuned = tune(likelihood, &asked, particles, &seed.child("tuning"))?.estimator;
                match chosen {
                    Some(EstimatorChoice::Particles(particles)) => Estimator { particles, ..tuned },
                    _ => tuned,
                }
            }
        };
        let normal = NormalFit::of(&positions).unwrap_or_else(|| NormalFit::standard(likelihood.dimension()));
        let mut hill = Hill::new(normal.mean().to_vec(), normal.lower().to_vec());
        for round in 0..ROUNDS {
            hill.climb(likelihood, estimator, &seed.child("round").nth(round as u64))?;
        }
        let Hill { centre, spread, .. } = hill;
        let (log_likelihood, standard_error) = at(likelihood, &centre, estimator, &seed.child("last"))?;
        let found = Maximum { v: centre, log_likelihood, standard_error, spread, estimator };
        Ok((found, population.possible()))
    }
}

/// The log-likelihood at a point, by many estimates with many particles, and its standard error.
fn at<L: Likelihood>(
    likelihood: &L,
    v: &[f64],
    estimator: Estimator,
    seed: &Seed,
) -> Result<(f64, f64), L::Error> {
    if likelihood.estimators()[estimator.index].is_exact {
        return Ok((likelihood.log_likelihood(v, estimator, seed)?, 0.0));
    }
    let estimator = Estimator { particles: estimator.particles * LAST.0, ..estimator };
    let numbers: Vec<u64> = (0..LAST.1 as u64).collect();
    let found = map(&numbers, &|number| likelihood.log_likelihood(v, estimator, &seed.nth(*number)));
    let found = found.into_iter().collect::<Result<Vec<f64>, L::Error>>()?;
    let largest = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let ratios: Vec<f64> = found.iter().map(|value| (value - largest).exp()).collect();
    let n = ratios.len() as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Ok((largest + mean.ln(), (variance / n).sqrt() / mean))
}
