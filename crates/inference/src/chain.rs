//! A chain of particle Metropolis–Hastings moves (Andrieu, Doucet and Holenstein, 2010).

use motes_models::{Seed, Stream};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::likelihood::{Estimator, Likelihood};
use crate::normal_fit::{NormalFit, log_prior};

/// The share of moves that do not start from where the chain is.
const INDEPENDENT: f64 = 0.5;

/// A position with its estimate of the likelihood, which is kept until the chain leaves it: so the chain is exact whatever the estimate's variance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Member {
    pub(crate) v: Vec<f64>,
    pub(crate) log_likelihood: f64,
}

/// Where moves go: half of them are steps of a random walk, half are drawn from a multivariate t distribution that is like the posterior.
///
/// Independent moves forget at once where the normal distribution is a good likeness, as it is of most posteriors in these coordinates; the walk goes wherever
/// it is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Kernel {
    pub(crate) normal: NormalFit,
    /// What steps of the walk are multiplied by.
    pub(crate) scale: f64,
}

/// How many moves were tried, and how many were made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Moves {
    /// All that were tried.
    pub tried: u64,
    /// Those that were made.
    pub made: u64,
}

impl Moves {
    /// The share that was made; NaN of none.
    pub fn acceptance(self) -> f64 {
        self.made as f64 / self.tried as f64
    }

    pub(crate) fn add(&mut self, other: Moves) {
        self.tried += other.tried;
        self.made += other.made;
    }

    pub(crate) fn count(&mut self, is_made: bool) {
        self.tried += 1;
        self.made += u64::from(is_made);
    }
}

/// What a chain did in a round.
pub(crate) struct Round {
    /// Where it was after each move.
    pub(crate) members: Vec<Member>,
    pub(crate) walk: Moves,
    pub(crate) independent: Moves,
    /// `log ẑ(θ) + log p(v) − log q(v)` of each position that was drawn independently, whether it was taken or not.
    pub(crate) log_weights: Vec<f64>,
}

/// What a chain moves by.
pub(crate) struct Mover<'a, L> {
    pub(crate) likelihood: &'a L,
    pub(crate) estimator: Estimator,
    pub(crate) kernel: &'a Kernel,
}

impl<L: Likelihood> Mover<'_, L> {
    /// So many moves from `start`, with random numbers of `seed`.
    pub(crate) fn round(&self, start: &Member, moves: usize, seed: &Seed) -> Result<Round, L::Error> {
        let (mut here, mut stream) = (start.clone(), seed.child("moves").stream());
        let seeds = seed.child("likelihood");
        let mut round = Round {
            members: Vec::with_capacity(moves),
            walk: Moves::default(),
            independent: Moves::default(),
            log_weights: Vec::new(),
        };
        for at in 0..moves {
            self.advance(&mut here, &mut stream, &seeds.nth(at as u64), &mut round)?;
            round.members.push(here.clone());
        }
        Ok(round)
    }

    fn advance(
        &self,
        here: &mut Member,
        stream: &mut Stream,
        seed: &Seed,
        round: &mut Round,
    ) -> Result<(), L::Error> {
        let Kernel { normal, scale } = self.kernel;
        let is_independent = stream.random::<f64>() < INDEPENDENT;
        let v = match is_independent {
            true => normal.sample_student(stream),
            false => normal.walk(&here.v, *scale, stream),
        };
        let chance = stream.random::<f64>().ln();
        let log_likelihood = self.likelihood.log_likelihood(&v, self.estimator, seed)?;
        let target = |v: &[f64], log_likelihood: f64| log_likelihood + log_prior(v);
        let is_made = match is_independent {
            true => {
                let weight = |v: &[f64], log_likelihood: f64| {
                    target(v, log_likelihood) - normal.log_density_student(v)
                };
                let there = weight(&v, log_likelihood);
                round.log_weights.push(there);
                chance < there - weight(&here.v, here.log_likelihood)
            }
            false => chance < target(&v, log_likelihood) - target(&here.v, here.log_likelihood),
        };
        match is_independent {
            true => round.independent.count(is_made),
            false => round.walk.count(is_made),
        }
        if is_made {
            *here = Member { v, log_likelihood };
        }
        Ok(())
    }
}
