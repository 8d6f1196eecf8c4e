//! Searches for the maximum of a likelihood: from the prior to the bulk of the posterior, then uphill on quadratics that are like its estimates nearby.

use motes_models::Seed;
use serde::{Deserialize, Serialize};

use super::height::height;
use super::hill::Hill;
use super::iterated::Swarms;
use super::iterated_profile::iterated_profile;
use super::point::{Maximum, Profile};
use super::profile::profile;
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

/// Where the likelihood is exact a search goes on for so many rounds at most. One that gains less than this makes the next reach half as far, and one that would reach less than that far is left out.
const SETTLED: (usize, f64, f64) = (60, 0.01, 0.1);

/// How far the last quadratics of an exact likelihood reach, in units of the spread.
const EXACT_REACHES: [f64; 3] = [0.5, 0.3, 0.3];

/// How far those of estimates reach, which have particles by the factor of [`LAST`]: their mean is lower than the log-likelihood by half of their variance, which is not the same everywhere.
const REACHES: [f64; 2] = [1.0, 0.7];

/// The estimates of the log-likelihood at a maximum have particles by this factor, and are so many.
const LAST: (usize, usize) = (8, 64);

/// The same of iterated filtering.
const OF_SWARM: (usize, usize) = (4, 16);

/// A search came as high as the best one if its log-likelihood is this close, by estimates and by exact values.
const CLOSE: f64 = 0.5;
const EXACTLY_CLOSE: f64 = 0.05;

/// Searches from draws of the prior, and profiles around the best of what they found, search by search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaximumSearch {
    settings: MaximumSettings,
    seed: u64,
    /// The swarms of iterated filtering; none yet, or where it is not that.
    swarms: Swarms,
    found: Vec<Maximum>,
    /// The best of them with an estimate of its own: that by which it is the best has luck in it.
    best: Option<Maximum>,
    profiles: Vec<Profile>,
    /// The sum over searches of the share of draws from the prior at which the likelihood is not 0.
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
            best: None,
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
        (found + usize::from(self.best.is_some()) + self.profiles.len(), searches + 1 + profiled)
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
        self.best.as_ref().or_else(|| self.highest())
    }

    fn highest(&self) -> Option<&Maximum> {
        self.found.iter().max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))
    }

    /// The searches that came as high as the best one.
    pub fn agreeing(&self) -> impl Iterator<Item = &Maximum> {
        let best = self.highest();
        let is_close = move |found: &&Maximum| {
            best.is_some_and(|best| {
                let error = found.standard_error.hypot(best.standard_error);
                let close = if error == 0.0 { EXACTLY_CLOSE } else { CLOSE.max(3.0 * error) };
                best.log_likelihood - found.log_likelihood <= close
            })
        };
        self.found.iter().filter(is_close)
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
        match self.settings.iterated {
            Some(_) => 1.0,
            None => self.possible / self.found.len().max(1) as f64,
        }
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
            return Ok(());
        }
        if self.found.len() < self.settings.starts {
            let number = self.found.len() as u64;
            let (found, possible, impossible) = self.search(likelihood, &seed.nth(number))?;
            self.possible += possible;
            if self.impossible.is_none() {
                self.impossible = impossible.map(|draw| (number, draw));
            }
            self.found.push(found);
        } else if self.best.is_none() {
            let Some(mut best) = self.highest().cloned() else { return Err(FitError::Nothing) };
            let estimates = if iterated.is_some() { OF_SWARM } else { LAST };
            (best.log_likelihood, best.standard_error) =
                height(likelihood, &best.v, best.estimator, estimates, &seed.child("best"))?;
            self.best = Some(best);
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
        let hill = match likelihood.estimators()[estimator.index].is_exact {
            true => settled(likelihood, hill, estimator, &seed.child("settled"))?,
            false => hill,
        };
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

/// A search on an exact likelihood that goes on until it gains nothing more: never down, and less far where quadratics do not fit.
fn settled<L: Likelihood>(
    likelihood: &L,
    hill: Hill,
    estimator: Estimator,
    seed: &Seed,
) -> Result<Hill, L::Error> {
    let (rounds, least, nearest) = SETTLED;
    let mut reach = 1.0;
    let mut height = likelihood.log_likelihood(&hill.centre, estimator, seed)?;
    let (mut centre, mut spread) = (hill.centre, hill.spread);
    for round in 0..rounds {
        let mut next = Hill::new(centre.clone(), spread.iter().map(|value| reach * value).collect());
        next.climb(likelihood, estimator, &seed.nth(round as u64))?;
        let here = likelihood.log_likelihood(&next.centre, estimator, seed)?;
        let gain = here - height;
        if gain > 0.0 {
            (height, centre, spread) = (here, next.centre, next.spread);
        }
        if gain.is_nan() || gain < least {
            reach *= 0.5;
            if reach < nearest {
                break;
            }
        }
    }
    Ok(Hill::new(centre, spread))
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
