//! The posterior of parameters by chains, stage by stage.

use motes_models::Seed;
use serde::{Deserialize, Serialize};

use crate::chain::{Kernel, Member, Mover, Moves, Round};
use crate::diagnostics::{ParameterSummary, r_hat};
use crate::error::FitError;
use crate::likelihood::{Estimator, Likelihood};
use crate::marginal::MarginalLikelihood;
use crate::normal_fit::NormalFit;
use crate::parallel::map_on_threads;
use crate::population::{Population, mean_variance};
use crate::prior_draw::PriorDraw;
use crate::settings::{EstimatorChoice, PosteriorSettings};
use crate::tuning::{Tuned, tune};

/// Moves of a chain in a round.
const MOVES: usize = 100;

/// Rounds of the warm-up: at least, and at most.
const WARM_UP: [usize; 2] = [8, 40];

/// The round of the warm-up after which particles are counted once more.
const TUNED_AGAIN: usize = 4;

/// The warm-up ends where R̂ of its second half is below this.
const WARM: f64 = 1.05;

/// Positions at which estimators are tuned.
const ASKED: usize = 4;

/// Estimates from which the variance at the centre is known at the end.
const ESTIMATES: usize = 50;

/// The share of draws that are added before the gates are looked at again.
const MORE: f64 = 0.1;

/// Where a fit stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// Positions go from the prior to the posterior.
    Starting,
    /// The kernel of the chains is learned.
    WarmUp,
    /// Draws are kept.
    Sampling,
    /// All is done.
    Done,
}

/// Draws from the posterior of parameters, `p(θ | y)`, by particle Markov chain Monte Carlo: exact for any number of particles.
///
/// [`Posterior::advance`] does a piece of the work. Between two pieces it is a value that can be written down; a fit that goes on from there ends with the same
/// bytes, on any number of threads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Posterior {
    settings: PosteriorSettings,
    seed: u64,
    stage: Stage,
    population: Population,
    estimator: Estimator,
    /// The variance of `log ẑ` near the centre.
    variance: f64,
    kernel: Kernel,
    /// Where each chain is.
    here: Vec<Member>,
    /// The positions of each chain: in the warm-up those of the warm-up, then those that are kept.
    draws: Vec<Vec<Member>>,
    rounds: usize,
    /// The number of kept draws at which the gates are looked at next.
    next_look: usize,
    walk: Moves,
    independent: Moves,
    log_weights: Vec<f64>,
}

impl Posterior {
    /// Draws starts from the prior.
    ///
    /// # Errors
    /// [`FitError::Nothing`] if there is no parameter or no chain, [`FitError::Impossible`] if the likelihood is 0 at every draw, [`FitError::Likelihood`] as it
    /// says.
    pub fn new<L: Likelihood>(
        likelihood: &L,
        settings: PosteriorSettings,
        seed: u64,
    ) -> Result<Self, FitError<L::Error>> {
        let d = likelihood.dimension();
        if d == 0 || settings.chains == 0 || likelihood.estimators().is_empty() {
            return Err(FitError::Nothing);
        }
        let root = Seed::from_u64(seed).child("fit");
        let population = Population::new(likelihood, settings.estimator, &root)?;
        population.refuse_impossible(&root)?;
        Ok(Posterior {
            settings,
            seed,
            stage: Stage::Starting,
            estimator: population.estimator(),
            population,
            variance: f64::NAN,
            kernel: Kernel { normal: NormalFit::standard(d), scale: 2.38 / (d as f64).sqrt() },
            here: Vec::new(),
            draws: vec![Vec::new(); settings.chains],
            rounds: 0,
            next_look: 0,
            walk: Moves::default(),
            independent: Moves::default(),
            log_weights: Vec::new(),
        })
    }

    /// Where it stands.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// The share of draws from the prior at which the likelihood is not 0.
    pub fn possible(&self) -> f64 {
        self.population.possible()
    }

    /// The first draw from the prior at which it is; none where it is at none.
    pub fn impossible(&self) -> Option<PriorDraw> {
        self.population.impossible(&self.root())
    }

    /// What all random numbers come from.
    fn root(&self) -> Seed {
        Seed::from_u64(self.seed).child("fit")
    }

    /// The power of the likelihood up to which positions have come from the prior.
    pub fn power(&self) -> f64 {
        self.population.power()
    }

    /// The estimator of the likelihood that chains use.
    pub fn estimator(&self) -> Estimator {
        self.estimator
    }

    /// The variance of its `log ẑ` near the centre of the posterior; NaN before it is known.
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// The moves of the random walk, and those that start from nowhere, of kept draws.
    pub fn moves(&self) -> [Moves; 2] {
        [self.walk, self.independent]
    }

    /// The number of chains.
    pub fn chains(&self) -> usize {
        self.draws.len()
    }

    /// The number of kept draws of each chain.
    pub fn kept(&self) -> usize {
        if matches!(self.stage, Stage::Sampling | Stage::Done) { self.draws[0].len() } else { 0 }
    }

    /// What it is sampled with.
    pub fn settings(&self) -> &PosteriorSettings {
        &self.settings
    }

    /// The kept draws of a chain: positions, and the estimate of the log-likelihood at each.
    pub fn draws(&self, chain: usize) -> impl Iterator<Item = (&[f64], f64)> {
        let kept = if self.kept() == 0 { &[] } else { self.draws[chain].as_slice() };
        kept.iter().map(|member| (member.v.as_slice(), member.log_likelihood))
    }

    /// `log p(y)` by the positions that were drawn independently; none where they do not tell.
    pub fn marginal_likelihood(&self) -> Option<MarginalLikelihood> {
        MarginalLikelihood::of(&self.log_weights, self.here.first()?.v.len())
    }

    /// The kept draws of coordinate `i`, by chain.
    pub fn coordinate(&self, i: usize) -> Vec<Vec<f64>> {
        (0..self.draws.len()).map(|chain| self.draws(chain).map(|(v, _)| v[i]).collect()).collect()
    }

    /// Does the next piece of work; nothing where all is done.
    ///
    /// # Errors
    /// [`FitError::Likelihood`] as the likelihood says; the fit is then as it was before.
    pub fn advance<L: Likelihood>(&mut self, likelihood: &L) -> Result<(), FitError<L::Error>> {
        let seed = self.root();
        match self.stage {
            Stage::Starting if self.population.power() < 1.0 => {
                let mut population = self.population.clone();
                population.advance(likelihood, &seed)?;
                self.population = population;
            }
            Stage::Starting => self.start(likelihood, &seed.child("starts"))?,
            Stage::WarmUp => self.warm_up(likelihood, &seed.child("warm-up"))?,
            Stage::Sampling => self.sample(likelihood, &seed.child("sampling"))?,
            Stage::Done => {}
        }
        Ok(())
    }

    /// Chooses the estimator, and starts chains at members of the population.
    fn start<L: Likelihood>(&mut self, likelihood: &L, seed: &Seed) -> Result<(), L::Error> {
        let members = self.population.members();
        let positions: Vec<&[f64]> = members.iter().map(|member| member.v.as_slice()).collect();
        let asked: Vec<&[f64]> = spread(&positions, ASKED);
        let tuned = self.tuned(likelihood, &asked, self.population.estimator(), seed)?;
        let starts: Vec<Vec<f64>> =
            spread(&positions, self.settings.chains).iter().map(|v| v.to_vec()).collect();
        let normal = NormalFit::of(&positions).unwrap_or_else(|| self.kernel.normal.clone());
        self.here = estimated(likelihood, &starts, tuned.estimator, &seed.child("chains"))?;
        (self.estimator, self.variance) = (tuned.estimator, tuned.variance);
        self.kernel.normal = normal;
        self.stage = Stage::WarmUp;
        Ok(())
    }

    /// The estimator that was asked for, or the best one; `before` is the one until now.
    fn tuned<L: Likelihood>(
        &self,
        likelihood: &L,
        asked: &[&[f64]],
        before: Estimator,
        seed: &Seed,
    ) -> Result<Tuned, L::Error> {
        match self.settings.estimator {
            Some(EstimatorChoice::Estimator(estimator)) => Ok(Tuned { estimator, variance: f64::NAN }),
            chosen => {
                let mut tuned = tune(likelihood, asked, before, &seed.child("tuning"))?;
                if let Some(EstimatorChoice::Particles(particles)) = chosen {
                    tuned =
                        Tuned { estimator: Estimator { particles, ..tuned.estimator }, variance: f64::NAN };
                }
                Ok(tuned)
            }
        }
    }

    /// A round of all chains.
    fn round<L: Likelihood>(
        &self,
        likelihood: &L,
        seed: &Seed,
        moves: usize,
    ) -> Result<Vec<Round>, L::Error> {
        let mover = Mover { likelihood, estimator: self.estimator, kernel: &self.kernel };
        let seed = seed.nth(self.rounds as u64);
        let rounds =
            map_on_threads(&self.here, |chain, here| mover.round(here, moves, &seed.nth(chain as u64)));
        rounds.into_iter().collect()
    }

    fn warm_up<L: Likelihood>(&mut self, likelihood: &L, seed: &Seed) -> Result<(), L::Error> {
        let rounds = self.round(likelihood, seed, MOVES)?;
        let mut here: Vec<Member> = rounds.iter().filter_map(|round| round.members.last().cloned()).collect();
        let mut draws = self.draws.clone();
        let (mut walk, mut independent) = (Moves::default(), Moves::default());
        for (draws, round) in draws.iter_mut().zip(rounds) {
            draws.extend(round.members);
            walk.add(round.walk);
            independent.add(round.independent);
        }
        let done = self.rounds + 1;
        // The first half is forgotten: it still knows where it started.
        let half = draws[0].len() / 2;
        let recent: Vec<&[f64]> =
            draws.iter().flat_map(|draws| &draws[half..]).map(|member| member.v.as_slice()).collect();
        let mut kernel = self.kernel.clone();
        if let Some(normal) = NormalFit::of(&recent) {
            kernel.normal = normal;
        }
        kernel.scale *= ((walk.acceptance() - acceptance(self.variance)) * 2.0 / (done as f64).sqrt()).exp();
        let (mut estimator, mut variance) = (self.estimator, self.variance);
        let is_warm = (0..recent[0].len()).all(|i| {
            let of_chain = |draws: &Vec<Member>| draws[half..].iter().map(|member| member.v[i]).collect();
            r_hat(&draws.iter().map(of_chain).collect::<Vec<Vec<f64>>>()) < WARM
        });
        let is_last = done >= WARM_UP[1] || (done >= WARM_UP[0] && is_warm);
        if done == TUNED_AGAIN || is_last {
            let seed = seed.child("tuned again").nth(done as u64);
            if !is_last {
                let tuned = self.tuned(likelihood, &spread(&recent, ASKED), estimator, &seed)?;
                (estimator, variance) = (tuned.estimator, tuned.variance);
                let positions: Vec<Vec<f64>> = here.iter().map(|member| member.v.clone()).collect();
                here = estimated(likelihood, &positions, estimator, &seed.child("chains"))?;
            } else if !likelihood.estimators()[estimator.index].is_exact {
                variance = mean_variance(likelihood, &[kernel.normal.mean()], estimator, ESTIMATES, &seed)?;
            }
        }
        (self.here, self.draws, self.kernel) = (here, draws, kernel);
        (self.estimator, self.variance, self.rounds) = (estimator, variance, done);
        if is_last {
            self.draws.iter_mut().for_each(Vec::clear);
            self.stage = Stage::Sampling;
            self.rounds = 0;
        }
        Ok(())
    }

    fn sample<L: Likelihood>(&mut self, likelihood: &L, seed: &Seed) -> Result<(), L::Error> {
        let most = self.settings.draws.unwrap_or(self.settings.most_draws);
        let moves = MOVES.min(most - self.draws[0].len());
        let rounds = self.round(likelihood, seed, moves)?;
        self.rounds += 1;
        self.here = rounds
            .iter()
            .zip(&self.here)
            .map(|(round, here)| round.members.last().unwrap_or(here).clone())
            .collect();
        for (draws, round) in self.draws.iter_mut().zip(rounds) {
            draws.extend(round.members);
            self.walk.add(round.walk);
            self.independent.add(round.independent);
            self.log_weights.extend(round.log_weights);
        }
        let kept = self.draws[0].len();
        if kept >= most {
            self.stage = Stage::Done;
        } else if self.settings.draws.is_none() && kept >= self.next_look {
            self.next_look = kept + (MORE * kept as f64).ceil() as usize;
            if self.gates_hold(likelihood) {
                self.stage = Stage::Done;
            }
        }
        Ok(())
    }

    /// Ends it with the draws that are there; at least a round of them must be.
    pub fn finish(&mut self) -> bool {
        if self.kept() >= MOVES {
            self.stage = Stage::Done;
        }
        self.stage == Stage::Done
    }

    /// Whether each reported value has the effective sample size and the R̂ that were asked for. These are not those of positions: distances from a median, of which R̂ is one, change
    /// with the scale.
    pub fn gates_hold<L: Likelihood>(&self, likelihood: &L) -> bool {
        let of_chain = |chain: &Vec<Member>| -> Vec<Vec<f64>> {
            chain.iter().map(|member| likelihood.reported(&member.v)).collect()
        };
        let chains: Vec<Vec<Vec<f64>>> = self.draws.iter().map(of_chain).collect();
        let count = chains.first().and_then(|chain| chain.first()).map_or(0, Vec::len);
        let of_value = |at: usize| -> Vec<Vec<f64>> {
            chains.iter().map(|chain| chain.iter().map(|values| values[at]).collect()).collect()
        };
        let holds = |summary: ParameterSummary| {
            let effective = summary.ess_bulk.min(summary.ess_tail);
            summary.rhat < self.settings.rhat && effective >= self.settings.effective
        };
        count > 0 && (0..count).all(|at| ParameterSummary::of(&of_value(at)).is_some_and(holds))
    }
}

/// The share of steps of a walk that are to be made: 0.234 of an exact likelihood, and less where estimates have a variance (their part is `2Φ(−σ/√2)`).
fn acceptance(variance: f64) -> f64 {
    const EXACT: f64 = 0.234;
    let sd = if variance.is_finite() { variance.max(0.0).sqrt() } else { 1.3 };
    EXACT * 2.0 * motes_models::equations::Scalar::normal_cdf(-sd / std::f64::consts::SQRT_2)
}

/// Some positions of many, evenly spread.
fn spread<'v>(positions: &[&'v [f64]], count: usize) -> Vec<&'v [f64]> {
    (0..count).map(|at| positions[(2 * at + 1) * positions.len() / (2 * count)]).collect()
}

/// Positions with estimates of their own.
fn estimated<L: Likelihood>(
    likelihood: &L,
    positions: &[Vec<f64>],
    estimator: Estimator,
    seed: &Seed,
) -> Result<Vec<Member>, L::Error> {
    let members = map_on_threads(positions, |number, v| {
        let log_likelihood = likelihood.log_likelihood(v, estimator, &seed.nth(number as u64))?;
        Ok(Member { v: v.clone(), log_likelihood })
    });
    members.into_iter().collect()
}
