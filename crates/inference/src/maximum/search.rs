//! Searches for the maximum of a likelihood: from the prior to the bulk of the posterior, then uphill on quadratics that are like its estimates nearby.

use motes_models::Seed;
use serde::{Deserialize, Serialize};

use super::height::height;
use super::hill::Hill;
use super::iterated::Swarms;
use super::iterated_profile::iterated_profile;
use super::point::Maximum;
use super::profile::{Profile, profile};
use super::settings::MaximumSettings;
use crate::error::FitError;
use crate::likelihood::{Estimator, Likelihood};
use crate::normal_fit::NormalFit;
use crate::population::Population;
use crate::prior_draw::{DrawNumber, PriorDraw};
use crate::settings::EstimatorChoice;
use crate::tuning::tune;

/// Rounds of a search uphill.
const ROUNDS: usize = 8;

/// How far the last quadratics of an exact likelihood reach, in units of the spread.
const EXACT_REACHES: [f64; 3] = [0.5, 0.3, 0.3];

/// How far those of estimates reach, which have particles by the factor of [`LAST`]: their mean is lower than the log-likelihood by half of their variance, which is not the same everywhere.
const REACHES: [f64; 2] = [1.0, 0.7];

/// The estimates of the log-likelihood at a maximum have particles by this factor, and are so many.
const LAST: (usize, usize) = (8, 64);

/// A maximum is the same as the best one if its log-likelihood is this close.
const CLOSE: f64 = 0.5;

/// Searches from draws of the prior, and profiles around the best of what they found, search by search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaximumSearch {
    settings: MaximumSettings,
    seed: u64,
    /// The swarms of iterated filtering; none yet, or where it is not that.
    swarms: Swarms,
    found: Vec<Maximum>,
    profiles: Vec<Profile>,
    possible: f64,
    /// The first draw at which the likelihood was 0, and the number of its search.
    impossible: Option<(u64, DrawNumber)>,
}

impl MaximumSearch {
    /// Before the first search.
    pub fn new(settings: MaximumSettings, seed: u64) -> Self {
        MaximumSearch {
            settings,
            seed,
            swarms: Swarms::default(),
            found: Vec::new(),
            profiles: Vec::new(),
            possible: 0.0,
            impossible: None,
        }
    }

    /// The number of searches and profiles that are done, and that of all.
    pub fn progress(&self, dimension: usize) -> (usize, usize) {
        let profiled = self.settings.profiled.as_ref().map_or(dimension, Vec::len);
        let starts = self.settings.starts;
        let (found, searches) = match self.settings.iterated {
            Some(settings) => self.swarms.progress(starts, settings),
            None => (self.found.len(), starts),
        };
        (found + self.profiles.len(), searches + profiled)
    }

    /// The coordinate whose profile is sought next; none where all are there.
    fn next_profile(&self, dimension: usize) -> Option<usize> {
        let place = self.profiles.len();
        match &self.settings.profiled {
            Some(profiled) => profiled.get(place).copied(),
            None => (place < dimension).then_some(place),
        }
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

    /// The log-likelihood where each search ended, in their order.
    pub fn log_likelihoods(&self) -> impl Iterator<Item = f64> {
        self.found.iter().map(|found| found.log_likelihood)
    }

    /// The number of searches that have ended.
    pub fn searches(&self) -> usize {
        self.found.len()
    }

    /// The profile of each parameter of which it was asked, as far as they are there.
    pub fn profiles(&self) -> &[Profile] {
        &self.profiles
    }

    /// The share of draws from the prior at which the likelihood is not 0.
    pub fn possible(&self) -> f64 {
        self.possible
    }

    /// The first draw from the prior at which it is; none where it was at none.
    pub fn impossible(&self) -> Option<PriorDraw> {
        let (number, draw) = self.impossible?;
        Some(PriorDraw::of(self.best()?.v.len(), draw, &self.root().nth(number)))
    }

    /// What all random numbers come from.
    fn root(&self) -> Seed {
        Seed::from_u64(self.seed).child("maximum")
    }

    /// Does the next search, or finds the next profile; nothing where all is done.
    ///
    /// # Errors
    /// [`FitError::Nothing`] if there is no parameter, no search, or no filter, particle or pass for iterated filtering where it is asked for, [`FitError::Impossible`] if the likelihood is 0 at every draw, [`FitError::Likelihood`] as it
    /// says; the search is then as it was before.
    pub fn advance<L: Likelihood>(&mut self, likelihood: &L) -> Result<(), FitError<L::Error>> {
        let d = likelihood.dimension();
        if d == 0 || self.settings.starts == 0 || likelihood.estimators().is_empty() {
            return Err(FitError::Nothing);
        }
        let seed = self.root();
        let iterated = match (self.settings.iterated, likelihood.perturbed()) {
            (None, _) => None,
            (Some(settings), Some(perturbed)) if settings.particles > 0 && settings.passes > 0 => {
                Some((settings, perturbed))
            }
            (Some(_), _) => return Err(FitError::Nothing),
        };
        if let (Some((settings, perturbed)), false) = (iterated, self.swarms.are_done()) {
            let (count, seed) = (self.settings.starts, seed.child("iterated"));
            self.swarms.advance(likelihood, perturbed, settings, &mut self.found, count, &seed)?;
            self.possible = 1.0;
            return Ok(());
        }
        if self.found.len() < self.settings.starts {
            let number = self.found.len() as u64;
            let (found, possible, impossible) = self.search(likelihood, &seed.nth(number))?;
            self.possible += possible / self.settings.starts as f64;
            if self.impossible.is_none() {
                self.impossible = impossible.map(|draw| (number, draw));
            }
            self.found.push(found);
        } else if let (Some(at), Some(best)) = (self.next_profile(d), self.best()) {
            let seed = seed.child("interval").nth(at as u64);
            let level = self.settings.level;
            let profile = match iterated {
                Some((settings, perturbed)) => {
                    iterated_profile(likelihood, perturbed, best, at, (settings, level), &seed)?
                }
                None => profile(likelihood, best, at, level, &seed)?,
            };
            self.profiles.push(profile);
        }
        Ok(())
    }

    fn search<L: Likelihood>(
        &self,
        likelihood: &L,
        seed: &Seed,
    ) -> Result<(Maximum, f64, Option<DrawNumber>), FitError<L::Error>> {
        let mut population = Population::new(likelihood, self.settings.estimator, seed)?;
        population.refuse_impossible(seed)?;
        let (possible, impossible) = (population.possible(), population.impossible_number());
        while population.power() < 1.0 {
            population.advance(likelihood, seed)?;
        }
        let positions: Vec<&[f64]> = population.members().iter().map(|member| member.v.as_slice()).collect();
        let each = positions.len().div_ceil(4);
        let asked: Vec<&[f64]> = positions.iter().step_by(each).copied().collect();
        let estimator = match self.settings.estimator {
            Some(EstimatorChoice::Estimator(estimator)) => estimator,
            chosen => {
                let before = population.estimator();
                let tuned = tune(likelihood, &asked, before, &seed.child("tuning"))?.estimator;
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
        let Hill { mut centre, spread, .. } = hill;
        let (many, reaches) = match likelihood.estimators()[estimator.index].is_exact {
            true => (estimator, EXACT_REACHES.as_slice()),
            false => (Estimator { particles: estimator.particles * LAST.0, ..estimator }, REACHES.as_slice()),
        };
        centre = refined(likelihood, centre, (&spread, reaches), many, &seed.child("refined"))?;
        let (log_likelihood, standard_error) =
            height(likelihood, &centre, estimator, LAST, &seed.child("last"))?;
        let found = Maximum { v: centre, log_likelihood, standard_error, spread, estimator };
        Ok((found, possible, impossible))
    }
}

/// The maximum to more digits: what quadratics leave out falls with the square of their reach.
fn refined<L: Likelihood>(
    likelihood: &L,
    mut centre: Vec<f64>,
    (spread, reaches): (&[f64], &[f64]),
    estimator: Estimator,
    seed: &Seed,
) -> Result<Vec<f64>, L::Error> {
    for (round, reach) in reaches.iter().enumerate() {
        let mut hill = Hill::new(centre, spread.iter().map(|value| reach * value).collect());
        hill.climb(likelihood, estimator, &seed.nth(round as u64))?;
        centre = hill.centre;
    }
    Ok(centre)
}
