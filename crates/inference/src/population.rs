//! Starts in the bulk of the posterior: sequential Monte Carlo over parameters from the prior, through powers of the likelihood (Del Moral, Doucet and Jasra, 2006).

use motes_models::Seed;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::chain::{Member, Moves};
use crate::error::FitError;
use crate::likelihood::{Estimator, Likelihood};
use crate::log_mean::LogMean;
use crate::normal_fit::{NormalFit, log_prior};
use crate::parallel::map_on_threads;
use crate::prior_draw::{DrawNumber, PriorDraw};
use crate::settings::EstimatorChoice;

/// Moves of each member at each power.
const MOVES: usize = 4;

/// The share of steps of the walk that are to be made.
const ACCEPTANCE: f64 = 0.25;

/// The number of particles at first.
const PARTICLES: usize = 64;

/// An estimator of fewer particles is not asked.
pub(crate) const FEWEST_PARTICLES: usize = 8;

/// The most there are; fits begin where more would be needed to tell.
const MOST_PARTICLES: usize = 8192;

/// Members of which the variance of log ẑ is asked.
const ASKED: usize = 4;

/// Estimates of each of them.
const ESTIMATES: usize = 6;

/// Above this variance of `β log ẑ`, moves hardly leave lucky estimates.
const MOST_VARIANCE: f64 = 2.0;

/// Positions on their way from the prior, at power 0, to the posterior, at power 1.
///
/// They are starts of chains, which forget them: their distribution is that of the posterior only about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Population {
    members: Vec<Member>,
    power: f64,
    step: u64,
    scale: f64,
    estimator: Estimator,
    /// Whether the estimator was asked for, and no other is to take its place.
    is_fixed: bool,
    /// The share of draws from the prior at which the likelihood is not 0.
    possible: f64,
    /// The first draw at which it is.
    impossible: Option<DrawNumber>,
}

impl Population {
    /// Draws from the prior. An estimator that was asked for stays; else the exact one does, if there is one, and where there is none the first is the one at the
    /// beginning.
    pub(crate) fn new<L: Likelihood>(
        likelihood: &L,
        asked: Option<EstimatorChoice>,
        seed: &Seed,
    ) -> Result<Self, L::Error> {
        let exact = likelihood.estimators().iter().position(|cost| cost.is_exact);
        let (index, is_fixed) = match asked {
            Some(EstimatorChoice::Estimator(estimator)) => (estimator.index, true),
            _ => (exact.unwrap_or(0), false),
        };
        let d = likelihood.dimension();
        let count = 64.max(16 * d);
        let estimator = Estimator { index, particles: PARTICLES };
        let members = map_on_threads(&vec![(); count], |number, ()| {
            let PriorDraw { v, seed, .. } = PriorDraw::of(d, (number as u64, estimator), seed);
            let log_likelihood = likelihood.log_likelihood(&v, estimator, &seed)?;
            Ok(Member { v, log_likelihood })
        });
        let members = members.into_iter().collect::<Result<Vec<Member>, L::Error>>()?;
        let is_possible = |member: &Member| member.log_likelihood > f64::NEG_INFINITY;
        let possible = members.iter().filter(|member| is_possible(member)).count();
        let impossible =
            members.iter().position(|member| !is_possible(member)).map(|at| (at as u64, estimator));
        let (possible, scale) = (possible as f64 / count as f64, 2.38 / (d as f64).sqrt());
        Ok(Population { members, power: 0.0, step: 0, scale, estimator, is_fixed, possible, impossible })
    }

    /// The share of draws from the prior at which the likelihood is not 0.
    pub(crate) fn possible(&self) -> f64 {
        self.possible
    }

    /// The first draw from the prior at which it is; `seed` is that of [`Population::new`].
    pub(crate) fn impossible(&self, seed: &Seed) -> Option<PriorDraw> {
        Some(PriorDraw::of(self.members.first()?.v.len(), self.impossible?, seed))
    }

    /// Which one that is.
    pub(crate) fn impossible_number(&self) -> Option<DrawNumber> {
        self.impossible
    }

    /// Why there is nothing to go on from, where no draw is possible.
    pub(crate) fn refuse_impossible<E>(&self, seed: &Seed) -> Result<(), FitError<E>> {
        match self.impossible(seed).filter(|_| self.possible == 0.0) {
            Some(draw) => Err(FitError::Impossible(Box::new(draw))),
            None => Ok(()),
        }
    }

    pub(crate) fn power(&self) -> f64 {
        self.power
    }

    pub(crate) fn estimator(&self) -> Estimator {
        self.estimator
    }

    /// Members, the last of them after moves at power 1.
    pub(crate) fn members(&self) -> &[Member] {
        &self.members
    }

    /// Goes on to the next power.
    pub(crate) fn advance<L: Likelihood>(&mut self, likelihood: &L, seed: &Seed) -> Result<(), L::Error> {
        let seed = seed.child("power").nth(self.step);
        self.step += 1;
        let next = self.next_power();
        self.resample(next - self.power, &seed);
        self.power = next;
        self.pay_for_estimates(likelihood, &seed)?;
        self.rejuvenate(likelihood, &seed)
    }

    /// The largest power at which half of the members are effective.
    fn next_power(&self) -> f64 {
        let is_enough = |more: f64| {
            let log_weights = self.members.iter().map(|member| more * member.log_likelihood);
            LogMean::of(&log_weights.collect::<Vec<f64>>()).effective()
                >= 0.5 * self.members.len() as f64 * self.possible
        };
        let left = 1.0 - self.power;
        if is_enough(left) {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, left);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_enough(middle) { low = middle } else { high = middle }
        }
        // Something is gained by each step, however far the likelihoods are apart.
        self.power + low.max(1e-12)
    }

    /// Draws members by their likelihoods to the power `more`, systematically.
    fn resample(&mut self, more: f64, seed: &Seed) {
        let log_weights = self.members.iter().map(|member| more * member.log_likelihood);
        let weights = LogMean::of(&log_weights.collect::<Vec<f64>>());
        let count = self.members.len() as f64;
        let offset = seed.child("resampling").stream().random::<f64>();
        let (mut sum, mut drawn) = (0.0, Vec::with_capacity(self.members.len()));
        for (member, weight) in self.members.iter().zip(weights.shares()) {
            sum += weight * count;
            while (drawn.len() as f64 + offset) < sum && drawn.len() < self.members.len() {
                drawn.push(member.clone());
            }
        }
        // The sum of all weights is 1 but for rounding.
        while let (true, Some(last)) = (drawn.len() < self.members.len(), drawn.last()) {
            drawn.push(last.clone());
        }
        self.members = drawn;
    }

    /// An estimator that costs more where estimates differ so much that moves would hardly leave lucky ones: the one that differs least of those that twice the particles
    /// would pay for.
    fn pay_for_estimates<L: Likelihood>(&mut self, likelihood: &L, seed: &Seed) -> Result<(), L::Error> {
        if likelihood.estimators()[self.estimator.index].is_exact {
            return Ok(());
        }
        let each = self.members.len() / ASKED;
        let asked: Vec<&[f64]> =
            self.members.iter().step_by(each).take(ASKED).map(|member| member.v.as_slice()).collect();
        let variance = mean_variance(likelihood, &asked, self.estimator, ESTIMATES, &seed.child("variance"))?;
        let is_enough = self.power * self.power * variance <= MOST_VARIANCE;
        if is_enough || self.estimator.particles >= MOST_PARTICLES {
            return Ok(());
        }
        self.estimator = self.better(likelihood, &asked, &seed.child("estimators"))?;
        let again = map_on_threads(&self.members, |number, member| {
            let seed = seed.child("again").nth(number as u64);
            let log_likelihood = likelihood.log_likelihood(&member.v, self.estimator, &seed)?;
            Ok(Member { v: member.v.clone(), log_likelihood })
        });
        let again = again.into_iter().collect::<Result<Vec<Member>, L::Error>>()?;
        if again.iter().any(|member| member.log_likelihood > f64::NEG_INFINITY) {
            self.members = again;
        }
        Ok(())
    }

    /// The estimator of the least variance at some members, at the cost of twice the particles that there are.
    fn better<L: Likelihood>(
        &self,
        likelihood: &L,
        asked: &[&[f64]],
        seed: &Seed,
    ) -> Result<Estimator, L::Error> {
        let costs = likelihood.estimators();
        let more = Estimator { particles: 2 * self.estimator.particles, ..self.estimator };
        if self.is_fixed || costs.len() == 1 {
            return Ok(more);
        }
        let budget = costs[more.index].of(more.particles);
        let (mut best, mut least) = (more, f64::INFINITY);
        for (index, cost) in costs.iter().enumerate() {
            let particles = cost.particles_for(budget);
            if particles < FEWEST_PARTICLES {
                continue;
            }
            let estimator = Estimator { index, particles };
            let seed = seed.nth(index as u64);
            let variance = mean_variance(likelihood, asked, estimator, ESTIMATES, &seed)?;
            if variance < least {
                (best, least) = (estimator, variance);
            }
        }
        Ok(best)
    }

    /// Moves of a random walk that leave the present power as it is.
    fn rejuvenate<L: Likelihood>(&mut self, likelihood: &L, seed: &Seed) -> Result<(), L::Error> {
        let positions: Vec<&[f64]> = self.members.iter().map(|member| member.v.as_slice()).collect();
        let normal = NormalFit::of(&positions).unwrap_or_else(|| NormalFit::standard(likelihood.dimension()));
        let moved = map_on_threads(&self.members, |number, member| {
            let seed = seed.child("moves").nth(number as u64);
            let (mut here, mut stream, mut moves) = (member.clone(), seed.stream(), Moves::default());
            for at in 0..MOVES {
                let v = normal.walk(&here.v, self.scale, &mut stream);
                let chance = stream.random::<f64>().ln();
                let log_likelihood = likelihood.log_likelihood(&v, self.estimator, &seed.nth(at as u64))?;
                let target = |v: &[f64], log_likelihood: f64| self.power * log_likelihood + log_prior(v);
                let is_made = chance < target(&v, log_likelihood) - target(&here.v, here.log_likelihood);
                moves.count(is_made);
                if is_made {
                    here = Member { v, log_likelihood };
                }
            }
            Ok((here, moves))
        });
        let moved = moved.into_iter().collect::<Result<Vec<(Member, Moves)>, L::Error>>()?;
        let mut moves = Moves::default();
        moved.iter().for_each(|(_, of_member)| moves.add(*of_member));
        self.members = moved.into_iter().map(|(member, _)| member).collect();
        self.scale *= (2.0 * (moves.acceptance() - ACCEPTANCE)).exp();
        Ok(())
    }
}

/// The mean over positions of the variance of `log ẑ` over estimates; infinite where most estimates of a position are 0.
pub(crate) fn mean_variance<L: Likelihood>(
    likelihood: &L,
    positions: &[&[f64]],
    estimator: Estimator,
    estimates: usize,
    seed: &Seed,
) -> Result<f64, L::Error> {
    let all: Vec<(usize, usize)> =
        (0..positions.len()).flat_map(|at| (0..estimates).map(move |number| (at, number))).collect();
    let found = map_on_threads(&all, |_, &(at, number)| {
        likelihood.log_likelihood(positions[at], estimator, &seed.nth(at as u64).nth(number as u64))
    });
    let found = found.into_iter().collect::<Result<Vec<f64>, L::Error>>()?;
    let variance = |values: &[f64]| {
        if values.contains(&f64::NEG_INFINITY) {
            return f64::INFINITY;
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
    };
    Ok(found.chunks(estimates).map(variance).sum::<f64>() / positions.len() as f64)
}
